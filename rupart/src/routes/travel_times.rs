//! How long stretches take: as cases measured it, else as the map lets expect.

use super::route::Route;
use crate::places::{PlaceId, Places, Stretch, Way, shortest_way};

/// How long stretches take.
#[derive(Clone, Debug, PartialEq)]
pub struct TravelTimes {
    /// What a robot drives where nothing holds it up: no stretch takes less time than this lets expect.
    pub speed_mps: f64,
    /// By the number of the stretch; none where no case has one.
    measured_s: Vec<Option<f64>>,
}

impl TravelTimes {
    /// As the map lets expect.
    pub fn of_map(places: &Places, speed_mps: f64) -> Self {
        Self { speed_mps, measured_s: vec![None; places.stretch_count] }
    }

    /// As routes measured it; of two measurements the later route's counts. O(stretches of the routes).
    pub fn of_routes<'r>(places: &Places, speed_mps: f64, routes: impl Iterator<Item = &'r Route>) -> Self {
        let mut times = Self::of_map(places, speed_mps);
        for (two, time_s) in routes.flat_map(|route| route.stops.windows(2).zip(&route.times_s)) {
            let stretch = two[0].known().zip(two[1].known()).and_then(|(from, to)| places.stretch(from, to));
            if let (Some(stretch), Some(_)) = (stretch, time_s) {
                times.measured_s[stretch.id] = *time_s;
            }
        }
        times
    }

    /// Of one stretch.
    pub fn of_stretch_s(&self, stretch: &Stretch) -> f64 {
        self.measured_s[stretch.id].unwrap_or(stretch.length_m / self.speed_mps)
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
        route.times_s[step].or_else(of_stretch).unwrap_or_else(|| from.off_m(to, places) / self.speed_mps)
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
