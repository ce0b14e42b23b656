//! Landmarks: sheets on walls whose places are known.
//!
//! The camera finds them (`vision::wall_marks`), and the filter takes a sighting as one more beam
//! (`localization::landmark`). A robot that localizes by landmarks alone sets its odometry right at them (`landmarks`
//! of the crate `rupart`).

use super::marker::MarkerColour;
use crate::geometry::{Point, Pose, Vector};
use serde::{Deserialize, Serialize};

/// A sheet of a bright colour that hangs on a wall, upright. The robot's map has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Landmark {
    /// Its name, as plans use it.
    pub name: String,
    /// The middle of the sheet, on the face of its wall, and where it faces.
    pub pose_in_map: Pose,
    /// Along the wall.
    pub width_m: f64,
    /// From its lower edge to its upper one.
    pub height_m: f64,
    /// The lower edge, over the floor.
    pub bottom_m: f64,
    /// Its colour.
    pub colour: MarkerColour,
}

impl Landmark {
    /// Away from its wall, of unit length.
    pub fn facing(&self) -> Vector {
        let (sin, cos) = libm::sincos(self.pose_in_map.heading_rad);
        Vector::new(cos, sin)
    }

    /// Its left and its right edge, to who faces its wall.
    pub fn edges_in_map(&self) -> [Point; 2] {
        let facing = self.facing();
        let right = Vector::new(-facing.y, facing.x) * (self.width_m / 2.0);
        [self.pose_in_map.point() - right, self.pose_in_map.point() + right]
    }
}
