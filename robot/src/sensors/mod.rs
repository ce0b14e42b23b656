//! The range sensors of the robot, as everybody knows them who uses their readings: how many readings
//! there are, where each of them looks, and how far.
//!
//! What a reading is worth is the business of those who use it: the simulator's noise, the filter's
//! likelihood, the memory's doubts.

mod laser;
mod signal;
mod sonar;

pub use laser::{LASER_READINGS, laser_direction_rad, laser_reading};
pub use signal::{Signal, Signals};
pub use sonar::{SONAR_CONE_RAD, SONAR_RANGE_M, SONARS, sonar_direction_rad, sonar_ring_deg};

use serde::{Deserialize, Serialize};

/// What measures distances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum RangeSensor {
    /// A ring of cones: an echo comes from somewhere on an arc.
    #[default]
    Sonar,
    /// A half turn of rays: each ends at a surface.
    Laser,
}
