//! The gripper, and the things it can take.

use crate::description::GripperDescription;
use crate::geometry::{Point, Pose, distance_m};
use crate::world;
use rpl_random::Stream;
use serde::{Deserialize, Serialize};

/// What the gripper is asked to begin. It can be repeated while the gripper moves.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum GripperCommand {
    /// Go on as before.
    #[default]
    None,
    /// Take the thing of this name; ignored while something is held.
    Grasp(String),
    /// Let go; ignored while open.
    Release,
}

/// How the gripper stands, as the robot perceives it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum GripperMotion {
    /// Open and at rest.
    Open,
    /// Closing or opening.
    Moving,
    /// Closed: around a thing, or around nothing after a grasp that failed.
    Closed,
}

/// What the robot perceives of its gripper.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct GripperStatus {
    /// How it stands.
    pub motion: GripperMotion,
    /// The thing in it.
    pub holding: Option<String>,
}

/// A thing that can be carried, and what has become of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ItemState {
    /// Its name.
    pub name: String,
    /// Where it is.
    pub at: ItemPlace,
    /// How often the robot has put it down.
    pub put_down: u32,
}

/// Where a thing is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum ItemPlace {
    /// At a point of the map.
    Point(Point),
    /// In the gripper.
    Held,
}

/// The gripper of a robot, and where it is.
#[derive(Clone, Copy)]
pub(super) struct Hand<'r> {
    pub gripper: &'r GripperDescription,
    pub robot_in_map: Pose,
    pub robot_radius_m: f64,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum GripperPhase {
    Open,
    Grasping { name: String, until_us: u64 },
    Closed,
    Releasing { until_us: u64 },
}

/// The gripper with all things of the world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gripper {
    phase: GripperPhase,
    /// All things; at most one is held.
    pub items: Vec<ItemState>,
}

impl Default for Gripper {
    fn default() -> Self {
        Self { phase: GripperPhase::Open, items: Vec::new() }
    }
}

impl Gripper {
    pub(super) fn open_among(items: &[world::Item]) -> Self {
        let lying =
            |item: &world::Item| ItemState { name: item.name.clone(), at: ItemPlace::Point(item.at), put_down: 0 };
        Self { phase: GripperPhase::Open, items: items.iter().map(lying).collect() }
    }

    /// The thing in the gripper.
    pub fn holding(&self) -> Option<&str> {
        self.items.iter().find(|item| item.at == ItemPlace::Held).map(|item| item.name.as_str())
    }

    pub(super) fn status(&self) -> GripperStatus {
        let motion = match self.phase {
            GripperPhase::Open => GripperMotion::Open,
            GripperPhase::Grasping { .. } | GripperPhase::Releasing { .. } => GripperMotion::Moving,
            GripperPhase::Closed => GripperMotion::Closed,
        };
        GripperStatus { motion, holding: self.holding().map(str::to_owned) }
    }

    pub(super) fn step(&mut self, hand: Hand<'_>, stream: &mut Stream, command: &GripperCommand, now_us: u64) {
        self.begin(hand.gripper, command, now_us);
        match &self.phase {
            GripperPhase::Grasping { name, until_us } if *until_us <= now_us => {
                let name = name.clone();
                self.phase = GripperPhase::Closed;
                self.close_on(hand, stream, &name);
            }
            GripperPhase::Releasing { until_us } if *until_us <= now_us => {
                let fails = stream.chance(hand.gripper.release_failure_probability);
                self.phase = if fails { GripperPhase::Closed } else { GripperPhase::Open };
                if !fails {
                    self.put_down(hand);
                }
            }
            GripperPhase::Open
            | GripperPhase::Closed
            | GripperPhase::Grasping { .. }
            | GripperPhase::Releasing { .. } => {}
        }
    }

    fn begin(&mut self, gripper: &GripperDescription, command: &GripperCommand, now_us: u64) {
        let at_rest = matches!(self.phase, GripperPhase::Open | GripperPhase::Closed);
        match command {
            GripperCommand::Grasp(name) if at_rest && self.holding().is_none() => {
                self.phase = GripperPhase::Grasping { name: name.clone(), until_us: now_us + gripper.grasp_us };
            }
            GripperCommand::Release if self.phase == GripperPhase::Closed => {
                self.phase = GripperPhase::Releasing { until_us: now_us + gripper.release_us };
            }
            GripperCommand::None | GripperCommand::Grasp(_) | GripperCommand::Release => {}
        }
    }

    fn close_on(&mut self, hand: Hand<'_>, stream: &mut Stream, name: &str) {
        let robot = hand.robot_in_map.point();
        let fails = stream.chance(hand.gripper.grasp_failure_probability);
        let within_reach = |item: &&mut ItemState| match item.at {
            ItemPlace::Point(point) => item.name == name && distance_m(point, robot) <= hand.gripper.reach_m,
            ItemPlace::Held => false,
        };
        if let Some(item) = self.items.iter_mut().find(within_reach)
            && !fails
        {
            item.at = ItemPlace::Held;
        }
    }

    fn put_down(&mut self, hand: Hand<'_>) {
        let ahead = hand.robot_in_map.transform(Point::new(hand.robot_radius_m + 0.15, 0.0));
        for item in self.items.iter_mut().filter(|item| item.at == ItemPlace::Held) {
            item.at = ItemPlace::Point(ahead);
            item.put_down += 1;
        }
    }
}
