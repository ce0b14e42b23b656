//! People who gather about the robot and walk along with it, as visitors of a museum do.

use super::company::Company;
use super::model::SimulatorModel;
use super::state::SimulatorState;
use super::walker::{PERSON_RADIUS_M, Walker};
use crate::geometry::{Point, Pose, Vector, distance_m};

/// From farther they come by the ways that people walk, from nearer straight ahead.
const NEAR_M: f64 = 5.0;

/// They look so far ahead on these ways.
const AHEAD_M: f64 = 1.0;

/// A spot counts as taken from here: who walked on would only tread on the spot.
const AT_SPOT_M: f64 = 0.3;

/// Angles that are tried to put a person beside the robot.
const TRIES: usize = 12;

/// Steps in which the floor between the robot and a spot is looked at.
const LOOK_M: f64 = 0.1;

impl SimulatorModel {
    /// From now on the people of the crowd stay around the robot, and those for whom there is room stand there at
    /// once. Tells how many stay around it. O(people² + people · bodies).
    pub fn gather(&self, state: &mut SimulatorState) -> usize {
        let first = self.world.people.len();
        for index in first..state.people.len() {
            let company = Company::of(index - first);
            // The sides in turn, so that as many stand on the left as on the right.
            let sides = |angle| {
                let [left, right] = company.spots_in_map(state.robot_in_map, angle);
                if index % 2 == 0 { [left, right] } else { [right, left] }
            };
            let spot = (0..TRIES).flat_map(sides).find(|&spot| self.has_room(state, index, spot));
            let walker = &mut state.people[index];
            walker.company = Some(company);
            if let Some(spot) = spot {
                (walker.at_in_map, walker.spot_in_map, walker.velocity_mps) = (spot, spot, Vector::zeros());
            }
        }
        state.people.len() - first
    }

    /// Whether a person can stand at a spot that nothing on the floor lies before, seen from the robot.
    fn has_room(&self, state: &SimulatorState, index: usize, spot: Point) -> bool {
        let Some(crowd) = &self.crowd else { return false };
        let robot = state.robot_in_map.point();
        let steps = libm::ceil(distance_m(robot, spot) / LOOK_M).max(1.0);
        let mut along = (0..=steps as usize).map(|step| robot + (spot - robot) * (step as f64 / steps));
        let mut others = state.people.iter().enumerate().filter(|(other, _)| *other != index);
        let mut solids = self.solids.iter().filter(|solid| state.is_there(solid.origin));
        along.all(|at| crowd.is_open(at))
            && distance_m(robot, spot) >= self.robot().radius_m + PERSON_RADIUS_M
            && others.all(|(_, other)| distance_m(other.at_in_map, spot) >= 2.0 * PERSON_RADIUS_M)
            && solids.all(|solid| solid.outline.distance_m(spot) >= PERSON_RADIUS_M)
    }

    /// Where somebody who stays beside the robot walks to; none if he is there.
    pub(super) fn spot_of(&self, walker: &Walker, company: Company, robot_in_map: Pose) -> Option<Point> {
        let spot = company.nearer_spot_in_map(robot_in_map, walker.at_in_map);
        let robot = robot_in_map.point();
        match &self.crowd {
            Some(crowd) if distance_m(walker.at_in_map, robot) > NEAR_M.max(company.distance_m) => {
                Some(crowd.spot_ahead(crowd.nearest(robot), walker.at_in_map, AHEAD_M))
            }
            Some(_) | None => (distance_m(walker.at_in_map, spot) > AT_SPOT_M).then_some(spot),
        }
    }
}
