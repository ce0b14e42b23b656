//! Everything that changes during a simulation, as one value.

use super::gripper::Gripper;
use super::odometry::OdometryBias;
use super::pan::Pan;
use super::percept::SensorStreams;
use super::walker::Walker;
use crate::geometry::Pose;
use crate::world::{Object, SolidOrigin};
use rpl_random::Stream;
use serde::{Deserialize, Serialize};

/// One random stream per consumer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Streams {
    /// Noise of the sensors.
    pub sensors: SensorStreams,
    /// Drift of the odometry.
    pub odometry: Stream,
    /// Success of the gripper.
    pub gripper: Stream,
    /// Where people of the crowd walk.
    pub people: Stream,
}

/// Touches so far, each counted once from the first touch until body and thing part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Contacts {
    /// The robot moved into something one of its sensors could see, and could have stopped before it.
    pub caused: u32,
    /// The robot moved into something none of its sensors could see, or its sonars had failed.
    pub unseen: u32,
    /// A person ran into the robot, or stepped, shut a door or put something so near before it that it
    /// could not stop.
    pub run_into: u32,
}

/// Somebody who came by himself so near before the moving robot that it could not stop in time: a touch of him is not
/// the robot's doing as long as it does all it can.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct SteppedBefore {
    /// `people[person]`.
    pub person: usize,
    /// From then on it must brake: it has seen him, and a command has taken effect.
    pub brakes_from_us: u64,
}

/// The simulated robot and its world at one moment. It belongs to the model it was started on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SimulatorState {
    /// Time since the start.
    pub time_us: u64,
    /// Where the robot really is.
    pub robot_in_map: Pose,
    /// Speed ahead.
    pub translation_mps: f64,
    /// Turning speed, counter-clockwise.
    pub rotation_radps: f64,
    /// Where dead reckoning says the robot is.
    pub odometry_in_odom: Pose,
    pub(super) odometry_bias: OdometryBias,
    /// Whether each of the world's doors is open.
    pub doors_open: Vec<bool>,
    /// Whether each of the world's objects has been taken away.
    pub objects_removed: Vec<bool>,
    /// Objects that were put into the world after the start.
    pub objects_added: Vec<Object>,
    /// The people with paths in the order of the world, then the crowd.
    pub people: Vec<Walker>,
    /// The gripper and the things it can take.
    pub gripper: Gripper,
    /// Where the camera is turned to.
    pub pan: Pan,
    /// Charge of the battery, from 0 to 1.
    pub battery: f64,
    /// What people have sent to the robot, word by word.
    pub messages: Vec<Vec<String>>,
    /// How many of them the robot has been given.
    pub(super) messages_given: usize,
    /// The sonars have failed until this time.
    pub sonars_fail_until_us: u64,
    /// The wheels are held until this time.
    pub wheels_held_until_us: u64,
    /// Until then a touch of a door, or of what was put into the world, is not the robot's doing.
    pub(super) sudden_until_us: u64,
    /// The person who has stepped before the robot, if it brakes since then as hard as it can.
    pub(super) stepped_before: Option<SteppedBefore>,
    /// Whether the body rests against something.
    pub touching: bool,
    /// Touches so far.
    pub contacts: Contacts,
    /// Way the robot has driven.
    pub distance_driven_m: f64,
    /// Random streams.
    pub streams: Streams,
    /// Decides what depends on places: which surfaces a sonar misses from where, and how light it is there.
    pub(super) place_seed: u64,
}

impl SimulatorState {
    /// The messages the robot has not been given yet; it has them now.
    pub(super) fn unread_messages(&mut self) -> Vec<Vec<String>> {
        let unread = self.messages.get(self.messages_given..).unwrap_or_default().to_vec();
        self.messages_given = self.messages.len();
        unread
    }

    /// Whether a body of the world file is where the file says.
    pub(super) fn is_there(&self, origin: SolidOrigin) -> bool {
        match origin {
            SolidOrigin::Wall => true,
            SolidOrigin::Door(index) => !self.doors_open[index],
            SolidOrigin::Object(index) => !self.objects_removed[index],
        }
    }
}
