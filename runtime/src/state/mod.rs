//! Records: what a run consists of.

pub mod active_time;
pub mod block;
pub mod failure;
pub mod fluent;
pub mod heap;
pub mod limits;
pub mod line;
pub mod machine;
pub mod memory;
pub mod output;
pub mod priorities;
pub mod registers;
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
