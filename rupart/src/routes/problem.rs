//! A route that is asked for.

use super::travel_times::TravelTimes;
use crate::places::{PlaceId, Places};
use crate::route::{Route, Stop};

/// From where to where a route is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct RouteProblem {
    /// Where the robot is.
    pub start: Stop,
    /// Where it is to go.
    pub goal: Stop,
    /// The known place the start counts as.
    pub start_place: PlaceId,
    /// The known place the goal counts as.
    pub goal_place: PlaceId,
    /// What the way from the start to each place is expected to take, as short as can be.
    pub(super) least_from_start_s: Vec<f64>,
    /// What the way from each place to the goal is expected to take, as short as can be.
    pub(super) least_to_goal_s: Vec<f64>,
}

impl RouteProblem {
    /// O(places).
    pub fn new(places: &Places, times: &TravelTimes, start: Stop, goal: Stop) -> Self {
        let (start_place, goal_place) = (start.closest(places), goal.closest(places));
        let least_s = |to: PlaceId| places.ids().map(|from| times.least_expected_s(places, from, to)).collect();
        Self {
            start,
            goal,
            start_place,
            goal_place,
            least_from_start_s: least_s(start_place),
            least_to_goal_s: least_s(goal_place),
        }
    }

    /// What a route from the start to the goal over known places is expected to take, as short as can be.
    pub fn least_s(&self) -> f64 {
        self.least_from_start_s[self.goal_place.index()]
    }

    /// A route between the known places, with the start and the goal themselves.
    pub(super) fn with_ends(&self, mut route: Route) -> Route {
        for (end, at) in [(self.start, 0), (self.goal, 1)] {
            if end.known().is_none() {
                let (stop, step) = if at == 0 { (0, 0) } else { (route.stops.len(), route.times_s.len()) };
                if !route.stops.is_empty() {
                    route.times_s.insert(step, None);
                }
                route.stops.insert(stop, end);
            }
        }
        route
    }
}
