//! The heap: pairs, strings, cells, closures, hash tables, vectors and failures in slabs of their own.

mod captured;
mod entries;
mod equality;
mod frozen;
mod key;
mod merge;
mod pairs;
mod record;
mod spine;
mod store;
mod table;
mod text;
mod vector;

pub use captured::Captured;
pub use key::{Key, KeyPart, MAX_KEY_PARTS};
pub use merge::{SortStep, sort_state, sort_state_bytes};
pub use pairs::{PAIR, Pairs};
pub use spine::Spine;
pub use store::{Closure, Heap, HeapMarks};
pub use table::{Entry, Table, table_entry};
pub use text::Text;
pub use vector::{Vector, vector_elements};
