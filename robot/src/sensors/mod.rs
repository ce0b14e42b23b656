//! The sensors of a robot, as everybody knows them who uses their readings: how many readings there are,
//! where each of them looks, and how far.
//!
//! What a reading is worth is the business of those who use it: the simulator's noise, the filter's
//! likelihood, the memory's doubts.

mod camera;
mod failed;
mod laser;
mod sectors;
mod signal;
mod sonar;

pub use camera::{CameraImage, CameraReading, CameraView, Pixel, Rgb, Sight};
pub use failed::FailedSensors;
pub use laser::{LaserScan, LaserScanner};
pub use sectors::Sectors;
pub use signal::{Signal, Signals};
pub use sonar::{SonarApex, SonarArray, SonarLayout, SonarMount, SonarScan};

use serde::{Deserialize, Serialize};

/// What measures distances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum RangeSensor {
    /// A ring of cones: an echo comes from somewhere on an arc.
    #[default]
    Sonar,
    /// A fan of rays: each ends at a surface.
    Laser,
}

/// The range sensors that a robot has.
#[derive(Clone, Debug, PartialEq)]
pub struct RangeSensors {
    /// The sonars.
    pub sonars: Option<SonarArray>,
    /// The laser range finder.
    pub laser: Option<LaserScanner>,
}

impl RangeSensors {
    /// The one that sees most sharply.
    pub fn sharpest(&self) -> RangeSensor {
        if self.laser.is_some() { RangeSensor::Laser } else { RangeSensor::Sonar }
    }
}
