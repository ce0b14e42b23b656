//! The library, expression by expression.

mod behaviours;
mod constructs;
mod documentation;
mod evaluate;
mod expansion;
mod foresight;
mod hygiene;
mod lists;
mod macros;
mod many_names;
mod many_warnings;
mod numbers;
mod own_texts;
mod parallel;
mod queues;
mod quorums;
mod text;
mod vectors;
