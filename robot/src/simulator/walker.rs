//! One person.

use super::company::Company;
use super::orca::Disc;
use crate::geometry::{Point, Vector};
use serde::{Deserialize, Serialize};

/// A person is a disc of this radius.
pub const PERSON_RADIUS_M: f64 = 0.25;

/// How far ahead they avoid walls; longer than the time between two looks, so that nobody ever
/// walks into one.
pub(super) const WALL_HORIZON_S: f64 = 0.4;

/// The fastest of them.
pub(super) const FASTEST_MPS: f64 = 2.5;

/// Walls farther off need not be minded.
pub(super) const FARTHEST_WALL_M: f64 = PERSON_RADIUS_M + FASTEST_MPS * WALL_HORIZON_S;

/// They turn to the right of where they want to walk by this tangent, so that two who meet head on do
/// not stop in front of each other.
const KEEP_RIGHT: f64 = 0.05;

/// The least distance that counts as getting nearer.
const PROGRESS_M: f64 = 0.1;

/// Where a person is, and where to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Walker {
    /// The middle of the disc.
    pub at_in_map: Point,
    /// Chosen at the last look.
    pub velocity_mps: Vector,
    /// Wanted on a free way.
    pub(super) speed_mps: f64,
    /// The path's point, or the destination, that is walked to.
    pub(super) goal: usize,
    /// Whether a path is walked from first to last, or back.
    pub(super) forth: bool,
    /// The spot on the way to the goal that is walked to in a straight line.
    pub(super) spot_in_map: Point,
    /// The least way that was left to the goal.
    pub(super) least_left_m: f64,
    /// When that was.
    pub(super) nearer_at_us: u64,
    pub(super) rests_until_us: u64,
    /// Where the person stays beside the robot; none of somebody who goes his own ways.
    pub(super) company: Option<Company>,
    /// Whether the person stands against the robot, having run into it.
    pub touching: bool,
}

impl Walker {
    /// Somebody who stands at a point and is to walk to the goal.
    pub(super) fn at(at_in_map: Point, speed_mps: f64, goal: usize) -> Self {
        Self {
            at_in_map,
            velocity_mps: Vector::zeros(),
            speed_mps,
            goal,
            forth: true,
            spot_in_map: at_in_map,
            least_left_m: f64::INFINITY,
            nearer_at_us: 0,
            rests_until_us: 0,
            company: None,
            touching: false,
        }
    }

    /// The body.
    pub(super) fn disc(&self) -> Disc {
        Disc { at_in_map: self.at_in_map, velocity_mps: self.velocity_mps, radius_m: PERSON_RADIUS_M }
    }

    /// The velocity towards the spot that is walked to, on a free way.
    pub(super) fn wanted_mps(&self) -> Vector {
        let way = self.spot_in_map - self.at_in_map;
        let length_m = way.norm_squared().sqrt();
        if length_m == 0.0 {
            return way;
        }
        (way + Vector::new(way.y, -way.x) * KEEP_RIGHT) * (self.speed_mps / length_m)
    }

    /// Begins to walk to another goal.
    pub(super) fn walk_to(&mut self, goal: usize, now_us: u64) {
        self.goal = goal;
        self.spot_in_map = self.at_in_map;
        self.least_left_m = f64::INFINITY;
        self.nearer_at_us = now_us;
    }

    /// Goes on to the point after the one reached.
    pub(super) fn pass(&mut self, points: usize, now_us: u64) {
        if self.forth && self.goal + 1 == points || !self.forth && self.goal == 0 {
            self.forth = !self.forth;
        }
        self.walk_to(if self.forth { self.goal + 1 } else { self.goal - 1 }, now_us);
    }

    /// Goes back to the point come from.
    pub(super) fn turn_back(&mut self, now_us: u64) {
        self.forth = !self.forth;
        self.walk_to(if self.forth { self.goal + 1 } else { self.goal - 1 }, now_us);
    }

    /// Whether the way left has not become less for long.
    pub(super) fn is_stuck(&mut self, left_m: f64, now_us: u64, patience_us: u64) -> bool {
        if left_m < self.least_left_m - PROGRESS_M {
            self.least_left_m = left_m;
            self.nearer_at_us = now_us;
        }
        now_us - self.nearer_at_us >= patience_us
    }
}
