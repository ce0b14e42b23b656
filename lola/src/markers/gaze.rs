//! Where the camera is turned.

use super::eye::MarkerEye;
use crate::feature::Side;
use rpl_robot::sensors::CameraView;
use rpl_robot::vision::PanControl;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// What is to be seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Gaze {
    /// Both sides of a hallway, now the left and now the right.
    Both,
    /// One side of a hallway.
    Side(Side),
    /// All around, from one end of the pan unit's range to the other.
    Around,
}

impl Gaze {
    /// The rows of an image that are looked at: all that show floor within three metres on the way; all in a
    /// look around, where a door may be at the other end of a room.
    ///
    /// # Deviation
    /// The paper looks at one third of the image, to save time. Two thirds also show the floor beside the
    /// robot, where a box no longer hides a marker behind it, and cost a few microseconds.
    pub fn rows(self, view: &CameraView) -> Range<usize> {
        match self {
            Self::Both | Self::Side(_) => view.rows / 3..view.rows,
            Self::Around => 0..view.rows,
        }
    }
}

/// A side is looked at in this angle to the axis of the hallway: its floor is in the image from three metres
/// ahead until the robot is beside it.
const ASIDE_RAD: f64 = 45.0 / 180.0 * std::f64::consts::PI;

/// The camera is where it is to be.
const THERE_RAD: f64 = 4.0 / 180.0 * std::f64::consts::PI;

/// In a look around it turns so fast that everything is in three images.
const AROUND_RADPS: f64 = 1.4;

/// What turns the camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct GazeControl {
    control: PanControl,
    /// Of both sides, the one that is looked at now.
    side: Side,
    /// The wanted turning speed.
    pub pan_radps: f64,
    /// How often an end of the pan unit's range was reached.
    pub looks_around: u32,
}

impl Default for GazeControl {
    fn default() -> Self {
        Self { control: PanControl::default(), side: Side::Left, pan_radps: 0.0, looks_around: 0 }
    }
}

impl GazeControl {
    /// One step; the axis of the hallway is given as seen from the robot, 0 where none is known.
    pub fn step(&mut self, eye: &MarkerEye<'_>, gaze: Gaze, axis_rad: f64, pan_rad: f64) {
        let wanted_rad = match gaze {
            Gaze::Side(side) => axis_rad + side.sign() * ASIDE_RAD,
            Gaze::Both => {
                let wanted_rad = axis_rad + self.side.sign() * ASIDE_RAD;
                if (wanted_rad - pan_rad).abs() < THERE_RAD {
                    self.side = self.side.other();
                }
                axis_rad + self.side.sign() * ASIDE_RAD
            }
            Gaze::Around => {
                self.pan_radps = self.around(eye.camera.pan_range_rad, pan_rad);
                return;
            }
        };
        self.pan_radps = self.control.speed_radps(eye.camera, wanted_rad, pan_rad, eye.step_s);
    }

    /// The speed of a look around, which turns back at the ends.
    fn around(&mut self, range_rad: f64, pan_rad: f64) -> f64 {
        if self.side.sign() * pan_rad >= range_rad - THERE_RAD {
            self.side = self.side.other();
            self.looks_around += 1;
        }
        self.side.sign() * AROUND_RADPS
    }
}
