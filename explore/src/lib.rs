//! Runs tried in every order of what is ready at the same time.
//!
//! A run is a value, and what it chooses is a list of deviations from the usual order
//! ([`rpl_runtime::state::schedule`]). The search ([`search`]) goes by their number, so that the first finding
//! ([`finding`]) has the shortest story ([`story`]); a state that was seen ([`rpl_runtime::run::canonical`]) is not
//! searched again, so that plans that never end come to an end here. A schedule is kept as a text
//! ([`schedule_text`]).

pub mod finding;
pub mod schedule_text;
pub mod search;
pub mod story;
