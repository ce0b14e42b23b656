//! Which valves a form asks for while it holds which others, through calls.

mod conflict;
mod request;
mod search;

pub(super) use request::{SeenValve, ValveConflict, ValveNeed, ValveRequest};
pub(super) use search::{Summaries, summarize, summarize_forms};
