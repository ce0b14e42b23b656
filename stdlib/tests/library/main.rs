//! The library, expression by expression.

mod behaviours;
mod constructs;
mod documentation;
mod evaluate;
mod expansion;
mod foresight;
mod lists;
mod many_names;
mod numbers;
mod own_texts;
mod quorums;
mod text;
mod vectors;
