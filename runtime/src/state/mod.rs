//! The records a run consists of. Each has the operations that keep it whole, and no others: what a
//! plan makes of them is in [`crate::step`].

pub mod activation;
pub mod active_time;
pub(crate) mod block;
pub mod failure;
pub mod figures;
pub mod fluent;
pub mod heap;
pub mod limits;
pub mod line;
pub mod machine;
pub mod measures;
pub(crate) mod memory;
pub mod mixed;
pub mod output;
pub mod priorities;
pub mod projected;
pub mod quotient;
pub mod registers;
pub mod schedule;
pub mod scratch;
pub mod slab;
pub mod small_set;
pub mod stack;
pub mod stall;
pub mod task;
pub mod tasks;
pub mod time;
pub mod timers;
pub mod trace;
pub mod value;
pub mod valve;
pub mod valve_line;
pub mod valve_place;
