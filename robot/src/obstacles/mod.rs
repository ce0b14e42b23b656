//! What the robot has found out about obstacles by its own sensors, in `odom` unless said otherwise.
//!
//! Read in this order: `memory` (what was seen lately), `sonar_views` (where the sound passed),
//! `laser_scan` (what a scan shows of surfaces), `log_odds` and `learned_map` (all that was seen since
//! the start); then what relates that to a map: `alignment` (where it fits), `doorways` (which doors
//! were found closed).

mod alignment;
mod doorways;
mod laser_scan;
mod learned_map;
mod log_odds;
mod memory;
mod sonar_views;

pub use alignment::{aligned, aligned_in_narrow};
pub use doorways::{DoorMemory, Doorway, barriers};
pub use laser_scan::{is_seen, points_in_base, smoothed};
pub use learned_map::LearnedMap;
pub use log_odds::Confidence;
pub use memory::{ObstacleMemory, RememberedPoint};
