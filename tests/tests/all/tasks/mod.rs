//! Tasks: constructs that make them, acting on them, their failures, policies and priorities.

mod constructs;
mod failures;
mod foresight;
mod life;
mod policies;
mod quorum;
mod revision;
