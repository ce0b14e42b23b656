//! End to end: plan text in, output or trace out. One program for all of it, since linking takes longer
//! than compiling; `cargo test -p rpl-tests valves` runs what has the word in its path.

mod architecture;
mod book;
mod bounds;
mod disturbed;
mod language;
mod mission;
mod runs;
mod tasks;
mod valves;
mod waiting;
