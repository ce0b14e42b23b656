//! The heap: pairs, strings, cells, closures, hash tables, vectors and failures in slabs of their own.

mod captured;
mod equality;
mod key;
mod record;
mod spine;
mod store;
mod vector;

pub use captured::Captured;
pub use key::{Key, KeyPart, MAX_KEY_PARTS, table_entry};
pub use spine::Spine;
pub use store::{Closure, Heap, HeapMarks, PAIR, Table};
pub use vector::{Vector, vector_elements};
