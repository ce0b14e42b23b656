//! What a run is shown as: events and failures as lines, causes, drawings.
//!
//! Read in this order: `event_line`; `situation`, `why` and `revision_story` (causes); `whereabouts`,
//! `map` and `documentation`; `projection` and `service` (tables); `failure_report` and `summary` (the end); then
//! `figures`, with `choice_figures` and `place_figures`.

pub mod choice_figures;
pub mod documentation;
pub mod event_line;
pub mod failure_report;
pub mod figures;
pub mod map;
pub mod place_figures;
pub mod projection;
mod revision_story;
pub mod service;
pub mod situation;
pub mod summary;
pub mod whereabouts;
pub mod why;
