//! Sensors that a robot has and that tell nothing.

use serde::{Deserialize, Serialize};

/// Which of its sensors a robot knows to have failed: nothing is to be expected of them. What is off has not failed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct FailedSensors {
    /// All sonars.
    pub sonars: bool,
    /// The laser range finder.
    pub laser: bool,
    /// The camera.
    pub camera: bool,
}

impl FailedSensors {
    /// Which there are, by name, and whether each has failed.
    pub fn by_name(self) -> [(&'static str, bool); 3] {
        [("sonars", self.sonars), ("laser", self.laser), ("camera", self.camera)]
    }
}
