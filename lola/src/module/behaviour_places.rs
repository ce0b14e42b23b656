//! Where its behaviours stand in the table.

/// Their places in the table.
pub(super) const DIRECTION_FOLLOW: usize = 0;
pub(super) const WALL_FOLLOW: usize = 1;
pub(super) const GOAL_SEEK: usize = 2;
pub(super) const REGISTRATION: usize = 3;
pub(super) const FEATURE_DETECTION: usize = 4;
pub(super) const MARKER_DETECTION: usize = 5;
