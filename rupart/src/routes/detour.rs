//! The way round what blocks a route and is in no map.

use super::travel_times::TravelTimes;
use super::underway::Underway;
use crate::places::{PlaceId, Places};
use crate::route::{Route, Stop};
use rpl_robot::geometry::{Point, Vector, distance_m};
use rpl_robot::planning::PlannerModel;
use serde::{Deserialize, Serialize};

/// How much of what was heard is remembered, the latest.
const MOST_HEARD: usize = 2_000;

/// Where the robot got no further counts as shut this far to either side of the way, as near before its rim: what
/// the sonars hear of a chair may leave a gap that it did not find through.
const SHUT_M: f64 = 0.9;
const BEFORE_RIM_M: f64 = 0.1;

/// As densely as the map's cells lie.
const APART_M: f64 = 0.05;

/// A detour is for a robot that is still about where it was made.
const STILL_THERE_M: f64 = 1.0;

/// What the robot was blocked by since it last came to the end of a route, and how it gets on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Blockage {
    heard_in_map: Vec<Point>,
    detour: Option<Detour>,
}

/// A way on the map around all that.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Detour {
    from_in_map: Point,
    goal: PlaceId,
    /// From where the robot was blocked to the goal.
    pub route: Route,
    /// The same from the last known place before: where another robot would have to turn off.
    pub to_keep: Option<Route>,
}

/// Where the robot gets no further.
pub struct BlockedAt<'a> {
    /// For ways on the map.
    pub planner: &'a PlannerModel,
    /// The places of the route.
    pub places: &'a Places,
    /// How long stretches take.
    pub times: &'a TravelTimes,
    /// Of the circle that holds the robot.
    pub robot_radius_m: f64,
    /// Where the robot stands.
    pub robot_in_map: Point,
    /// What it has heard lately.
    pub heard_in_map: Vec<Point>,
}

impl BlockedAt<'_> {
    /// A bar across the way to the short-term goal.
    fn shut_in_map(&self, underway: &Underway) -> Vec<Point> {
        let ahead = underway.next_in_map().and_then(|goal| (goal - self.robot_in_map).try_normalize(f64::EPSILON));
        let Some(ahead) = ahead else { return Vec::new() };
        let middle_in_map = self.robot_in_map + ahead * (self.robot_radius_m + BEFORE_RIM_M);
        let left = Vector::new(-ahead.y, ahead.x);
        let steps = libm::round(SHUT_M / APART_M) as i32;
        (-steps..=steps).map(|step| middle_in_map + left * (f64::from(step) * APART_M)).collect()
    }

    /// Round all that, from here, or from the known place before where the robot stands too near to it.
    fn detour(&self, underway: &Underway, heard_in_map: &[Point]) -> Option<Detour> {
        let goal = underway.route.stops.last()?.known()?;
        let round = self.planner.cost_to_go_around(self.places.at_in_map(goal), heard_in_map);
        let way = |from_in_map: Point| {
            round.cost_m(from_in_map)?;
            let corners = round.path(from_in_map)?;
            let inner = corners.get(1..corners.len().checked_sub(1)?).unwrap_or(&[]);
            Some(inner.iter().map(|&corner| Stop::At(corner)).chain([Stop::Known(goal)]).collect::<Vec<_>>())
        };
        let from_before = underway.before().and_then(|before| {
            let stops = way(self.places.at_in_map(before))?;
            Some(Route::new(std::iter::once(Stop::Known(before)).chain(stops).collect()))
        });
        let route = way(self.robot_in_map).map(Route::new).or_else(|| from_before.clone())?;
        Some(Detour { from_in_map: self.robot_in_map, goal, route, to_keep: from_before })
    }
}

impl Blockage {
    /// A route got the robot no further here. What came of it: the part that was driven, in which the stretch it was given
    /// up on counts what was spent on it and what going round takes longer. None if that is not one between known
    /// places. Cost: a pass over the cells of the map.
    pub fn note(&mut self, underway: &Underway, at: BlockedAt<'_>) -> Option<Route> {
        self.heard_in_map.extend(at.shut_in_map(underway));
        self.heard_in_map.extend(&at.heard_in_map);
        self.heard_in_map.drain(..self.heard_in_map.len().saturating_sub(MOST_HEARD));
        self.detour = at.detour(underway, &self.heard_in_map);
        let longer_s = self.detour.as_ref().map_or(0.0, |detour| {
            let first_m = distance_m(detour.route.stops[0].at_in_map(at.places), at.robot_in_map);
            let round_s = at.times.expected_s(first_m) + at.times.of_route_s(at.places, &detour.route);
            (round_s - at.times.of_route_s(at.places, &underway.rest())).max(0.0)
        });
        underway.given_up(longer_s)
    }

    /// The way round to a goal, if the robot was blocked here on its way there.
    pub fn detour(&self, robot_in_map: Point, to: PlaceId) -> Option<&Detour> {
        let is_here = |detour: &&Detour| distance_m(detour.from_in_map, robot_in_map) < STILL_THERE_M;
        self.detour.as_ref().filter(|detour| detour.goal == to).filter(is_here)
    }
}
