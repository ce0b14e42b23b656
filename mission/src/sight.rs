//! What can be told of a robot from outside, where it really is included: no plan sees any of it.

use rpl_protocol::remote_host::HostRecord;
use rpl_robot::geometry::{Point, Pose, Velocity};
use serde::Serialize;

/// What can be seen of a robot from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// Where it is; none if its host is another process, which does not tell.
    pub robot_in_map: Option<Pose>,
    /// Where it believes it is.
    pub estimate_in_map: Pose,
    /// How sure it is of that, from 0 to 1.
    pub certainty: f64,
    /// How fast it moves, by its wheels; none before its first step.
    pub velocity: Option<Velocity>,
    /// Charge of its battery, from 0 to 1; none before its first step.
    pub battery: Option<f64>,
}

/// What a robot did on the whole.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Account {
    /// How often it moved into something it could see; none, here and below, if its host is another
    /// process, which does not tell.
    pub contacts: Option<u32>,
    /// How often it moved into something none of its sensors could see.
    pub contacts_unseen: Option<u32>,
    /// How often a person ran into it.
    pub contacts_by_people: Option<u32>,
    /// How far it drove; with a host in another process, by its odometry.
    pub distance_m: f64,
    /// How it went with a host in another process.
    pub host: Option<HostRecord>,
}

impl Account {
    /// That of a robot that has done nothing yet.
    pub const NOTHING: Self =
        Self { contacts: Some(0), contacts_unseen: Some(0), contacts_by_people: Some(0), distance_m: 0.0, host: None };
}

/// Where the robot may be: a probability for each cell, `cells[row][column]`, row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct PositionBelief {
    /// Edge of a cell.
    pub resolution_m: f64,
    /// Lower left corner of cell (0, 0).
    pub origin_in_map: Point,
    /// Cells along x.
    pub columns: usize,
    /// Summed over headings; the sum of all is 1.
    pub cells: Vec<f64>,
}
