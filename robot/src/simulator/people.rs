//! People who walk to and fro.

use super::model::SimulatorModel;
use super::state::SimulatorState;
use crate::geometry::{Point, distance_m};
use crate::world::Person;
use serde::{Deserialize, Serialize};

/// A person is a disc of this radius.
pub const PERSON_RADIUS_M: f64 = 0.25;

/// Where a person is on the path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Walker {
    /// The middle of the disc.
    pub at_in_map: Point,
    /// Index of the path point walked to.
    pub next: usize,
    /// Whether the path is walked from first to last, or back.
    pub forth: bool,
    /// Whether the person stands against the robot, having run into it.
    pub touching: bool,
    /// How long the person has been waiting for the robot.
    pub waiting_us: u64,
}

impl Walker {
    pub(super) fn new(person: &Person) -> Self {
        Self { at_in_map: person.path[0], next: 1, forth: true, touching: false, waiting_us: 0 }
    }

    /// Where the person is after walking `way_m` along the path.
    fn walked(&self, path: &[Point], mut way_m: f64) -> Walker {
        let mut walker = self.clone();
        // A path of one spot would never use up the way; the bound ends the walk.
        for _ in 0..2 * path.len() {
            let target = path[walker.next];
            let left_m = distance_m(walker.at_in_map, target);
            if left_m > way_m {
                walker.at_in_map += (target - walker.at_in_map) * (way_m / left_m);
                break;
            }
            way_m -= left_m;
            walker.at_in_map = target;
            walker.pass(path.len());
        }
        walker
    }

    /// Goes on to the point after the one reached.
    fn pass(&mut self, points: usize) {
        if self.forth && self.next + 1 == points || !self.forth && self.next == 0 {
            self.forth = !self.forth;
        }
        self.next = if self.forth { self.next + 1 } else { self.next - 1 };
    }

    /// Goes back to the point come from.
    fn turn_back(&mut self) {
        self.next = if self.forth { self.next - 1 } else { self.next + 1 };
        self.forth = !self.forth;
    }

    fn wait(&mut self, step_us: u64, patience_us: u64) {
        self.waiting_us += step_us;
        if self.waiting_us >= patience_us {
            self.waiting_us = 0;
            self.turn_back();
        }
    }
}

impl SimulatorModel {
    /// Every person walks one step, but waits where the robot stands in the way, and after a while
    /// turns back: robot and person would otherwise wait for each other in a doorway for ever.
    pub(super) fn walk(&self, state: &mut SimulatorState) {
        let settings = &self.settings;
        let robot = state.robot_in_map.point();
        let touch_m = settings.robot_radius_m + PERSON_RADIUS_M;
        for (walker, person) in state.people.iter_mut().zip(&self.world.people) {
            let walked = walker.walked(&person.path, person.speed_mps * settings.step_s());
            let before_m = distance_m(walker.at_in_map, robot);
            let after_m = distance_m(walked.at_in_map, robot);
            let clear = after_m >= touch_m + settings.person_stop_distance_m;
            if after_m >= touch_m && (clear || after_m > before_m) {
                *walker = Walker { touching: false, waiting_us: 0, ..walked };
                continue;
            }
            if !walker.touching && settings.person_stop_distance_m <= 0.0 {
                walker.touching = true;
                state.contacts.run_into += 1;
            }
            walker.wait(settings.step_us, settings.person_patience_us);
        }
    }
}
