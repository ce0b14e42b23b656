//! The documents: what they show is true, and every clause has its test.

mod clauses;
mod documentation;
mod formatting;
mod schemas;
mod tables;
