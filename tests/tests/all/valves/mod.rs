//! Valves: the rules one by one, and small programs compared with a model of the rules.

mod model;
mod places;
mod rules;
