//! Whether a robot has room where a world has it start.

use super::solid::SolidOrigin;
use super::{Rect, World};
use crate::file_text::Finding;
use crate::geometry::Vector;

/// The robot has no room at the start of a world.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("the start is in the way of {of}")]
pub struct StartTaken {
    /// What is there.
    pub of: String,
    /// Of the robot.
    pub robot_radius_m: f64,
}

impl StartTaken {
    /// With its place in the text of the world file.
    pub fn in_file(&self, file: &str, text: &str) -> Finding {
        let help = format!("leave {} m around the start free, that is the robot's radius", self.robot_radius_m);
        Finding::in_toml(file, text, None, "start", &self.to_string(), &help)
    }
}

impl World {
    /// Looks whether a robot has room at the start; a world is read without knowing of a robot, and what
    /// is too narrow for one is wide enough for another.
    ///
    /// # Errors
    /// Something stands there.
    pub fn room_at_start(&self, robot_radius_m: f64) -> Result<(), StartTaken> {
        let start = self.start_in_map.point();
        let in_the_way = self.solids().into_iter().find(|solid| {
            let there = match solid.origin {
                SolidOrigin::Door(index) => !self.doors[index].open,
                SolidOrigin::Wall | SolidOrigin::Object(_) => true,
            };
            there && solid.outline.distance_m(start) < robot_radius_m
        });
        let Rect { min, max } = self.bounds();
        let reach = Vector::new(robot_radius_m, robot_radius_m);
        let is_inside = Rect { min: min + reach, max: max - reach }.contains(start);
        match in_the_way {
            Some(solid) => Err(StartTaken { of: self.called(solid.origin), robot_radius_m }),
            None if is_inside => Ok(()),
            None => Err(StartTaken { of: "the edge of the world".to_owned(), robot_radius_m }),
        }
    }
}
