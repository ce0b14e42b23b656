//! Valves: the rules one by one, and small programs compared with a model of the rules.

mod circles;
mod clean_ups;
mod hooks;
mod model;
mod places;
mod rules;
