//! Nothing a plan does hangs or crashes the program: limits, depth, growth, memory.

mod depth;
mod growth;
mod limits;
mod memory;
