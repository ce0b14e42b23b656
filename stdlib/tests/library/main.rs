//! The library, expression by expression.

mod behaviours;
mod constructs;
mod documentation;
mod evaluate;
mod foresight;
mod hygiene;
mod lists;
mod macros;
mod numbers;
mod own_texts;
mod parallel;
mod queues;
mod text;
mod vectors;
