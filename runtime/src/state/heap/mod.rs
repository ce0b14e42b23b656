//! The heap: pairs, strings, cells, closures, hash tables and failures in slabs of their own.

mod equality;
mod key;
mod record;
mod spine;
mod store;

pub use key::{Key, KeyPart, MAX_KEY_PAIRS, table_entry};
pub use spine::Spine;
pub use store::{Closure, Heap, HeapMarks, PAIR, Table};
