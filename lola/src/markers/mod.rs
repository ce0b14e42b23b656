//! Markers beside doors, seen by the camera before the robot is beside them: each is kept in `odom` until it
//! is far behind (Gutierrez-Osuna and Luo, "Vision").
//!
//! Read in this order: `gaze` (where the camera is turned), `tracks` (which sightings are one marker).

pub mod calibration;
mod eye;
mod gaze;
mod tracks;

pub use eye::MarkerEye;
pub use gaze::Gaze;
pub use tracks::SeenMarker;

use gaze::GazeControl;
use rpl_robot::geometry::Pose;
use rpl_robot::sensors::CameraReading;
use rpl_robot::simulator::CameraCommand;
use rpl_robot::vision::floor_sightings;
use serde::{Deserialize, Serialize};
use tracks::Tracks;

/// The markers that were seen so far, and where the camera is turned to see more.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MarkerDetection {
    gaze: GazeControl,
    tracks: Tracks,
}

impl MarkerDetection {
    /// Takes in what the camera told in a step in which the odometry was here; the hallway's axis, if one is
    /// known, is what the gaze keeps to. Cost: where there is an image, that of
    /// [`floor_sightings`]; else nothing.
    pub fn take_in(
        &mut self,
        eye: &MarkerEye<'_>,
        gaze: Gaze,
        axis_in_odom_rad: Option<f64>,
        robot_in_odom: Pose,
        reading: &CameraReading,
    ) {
        if let Some(image) = &reading.image {
            let view = &eye.camera.view;
            let rows = gaze.rows(view);
            let pan_in_odom = robot_in_odom.compose(Pose::new(0.0, 0.0, reading.pan_rad));
            let sightings = floor_sightings(eye.mark, view, image, rows.clone());
            self.tracks.take_in(view, rows, pan_in_odom, &sightings);
        }
        let axis_rad = axis_in_odom_rad.map_or(0.0, |axis_rad| axis_rad - robot_in_odom.heading_rad);
        self.gaze.step(eye, gaze, axis_rad, reading.pan_rad);
    }

    /// What the camera is to do in the next step.
    pub fn command(&self) -> CameraCommand {
        CameraCommand { pan_radps: self.gaze.pan_radps }
    }

    /// The markers that are sure, in the order in which they were first seen.
    pub fn markers(&self) -> impl Iterator<Item = &SeenMarker> {
        self.tracks.markers()
    }

    /// How often the camera has come to the end of a look around.
    pub fn looks_around(&self) -> u32 {
        self.gaze.looks_around
    }
}
