//! How long stretches take: as cases measured it, else as the map lets expect.

use crate::places::{PlaceId, Places, Stretch, Way, shortest_way};
use crate::route::Route;

/// What took longer than at this pace was held up there, and tells nothing of other stretches.
const SLOWEST_PACE: f64 = 2.0;

/// How long stretches take.
#[derive(Clone, Debug, PartialEq)]
pub struct TravelTimes {
    /// What a robot drives where nothing holds it up: no stretch takes less time than this lets expect.
    pub speed_mps: f64,
    /// How long the measured stretches took, for each second they take at least: the median of those that
    /// took at most [`SLOWEST_PACE`] times as long, at least 1. As much is expected of the others, or what is known would always seem slower than what is
    /// not.
    pub pace: f64,
    /// By the number of the stretch; none where no case has one.
    measured_s: Vec<Option<f64>>,
}

impl TravelTimes {
    /// As the map lets expect.
    pub fn of_map(places: &Places, speed_mps: f64) -> Self {
        Self { speed_mps, pace: 1.0, measured_s: vec![None; places.stretch_count] }
    }

    /// As routes measured it; of two measurements the later route's counts. O(stretches of the routes).
    pub fn of_routes<'r>(places: &Places, speed_mps: f64, routes: impl Iterator<Item = &'r Route>) -> Self {
        let mut times = Self::of_map(places, speed_mps);
        let mut paces = Vec::new();
        for (two, time_s) in routes.flat_map(|route| route.stops.windows(2).zip(&route.times_s)) {
            let stretch = two[0].known().zip(two[1].known()).and_then(|(from, to)| places.stretch(from, to));
            if let (Some(stretch), Some(time_s)) = (stretch, time_s) {
                times.measured_s[stretch.id] = Some(*time_s);
                paces.push(time_s * speed_mps / stretch.length_m);
            }
        }
        paces.retain(|pace| *pace <= SLOWEST_PACE);
        paces.sort_by(f64::total_cmp);
        times.pace = paces.get(paces.len() / 2).map_or(1.0, |pace| pace.max(1.0));
        times
    }

    /// Of one stretch.
    pub fn of_stretch_s(&self, stretch: &Stretch) -> f64 {
        self.measured_s[stretch.id].unwrap_or_else(|| self.expected_s(stretch.length_m))
    }

    /// Of a whole route: as it was measured on it, else as known of the stretch, else by its length.
    pub fn of_route_s(&self, places: &Places, route: &Route) -> f64 {
        (0..route.times_s.len()).map(|step| self.of_step_s(places, route, step)).sum()
    }

    /// From one stop of a route to the next.
    pub(super) fn of_step_s(&self, places: &Places, route: &Route, step: usize) -> f64 {
        let [from, to] = [route.stops[step], route.stops[step + 1]];
        let of_stretch = || {
            let stretch = places.stretch(from.known()?, to.known()?)?;
            Some(self.of_stretch_s(stretch))
        };
        route.times_s[step].or_else(of_stretch).unwrap_or_else(|| self.expected_s(from.off_m(to, places)))
    }

    /// What a way of this length is expected to take that nobody has measured.
    pub fn expected_s(&self, length_m: f64) -> f64 {
        self.pace * length_m / self.speed_mps
    }

    /// What a way between two places is expected to take where it is as short as can be.
    pub fn least_expected_s(&self, places: &Places, one: PlaceId, other: PlaceId) -> f64 {
        self.expected_s(places.lower_bounds.between_m(one, other))
    }

    /// What a way between two places takes at least.
    pub fn least_s(&self, places: &Places, one: PlaceId, other: PlaceId) -> f64 {
        places.lower_bounds.between_m(one, other) / self.speed_mps
    }

    /// The quickest way between two places, by the supporting planner. None if there is none.
    pub fn quickest_way(&self, places: &Places, from: PlaceId, to: PlaceId) -> Option<Way> {
        let cost_s = |_: PlaceId, stretch: &Stretch| self.of_stretch_s(stretch);
        shortest_way(&places.stretches, from, to, cost_s, |one, other| self.least_s(places, one, other))
    }
}
