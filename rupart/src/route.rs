//! A route, as a case holds it.

use crate::control::{ARRIVAL_M, PASSING_M};
use crate::places::{PlaceId, Places};
use rpl_robot::geometry::{Point, distance_m};
use serde::{Deserialize, Serialize};

/// A place of a route: a known one, or coordinates (Fox and Anderson-Sprecher, Deliberative planning).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Stop {
    /// A known place.
    Known(PlaceId),
    /// In the map frame.
    At(Point),
}

impl Stop {
    /// Where it is.
    pub fn at_in_map(self, places: &Places) -> Point {
        match self {
            Self::Known(place) => places.at_in_map(place),
            Self::At(point_in_map) => point_in_map,
        }
    }

    /// The known place, if it is one.
    pub fn known(self) -> Option<PlaceId> {
        match self {
            Self::Known(place) => Some(place),
            Self::At(_) => None,
        }
    }

    /// The known place it is or counts as being at. O(places) for coordinates.
    pub fn closest(self, places: &Places) -> PlaceId {
        match self {
            Self::Known(place) => place,
            Self::At(point_in_map) => places.closest(point_in_map),
        }
    }

    /// How far another stop is, straight.
    pub fn off_m(self, other: Stop, places: &Places) -> f64 {
        distance_m(self.at_in_map(places), other.at_in_map(places))
    }
}

/// Where to go, in order; each stop is in sight of the next.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Route {
    /// From the start to the goal, both among them.
    pub stops: Vec<Stop>,
    /// How long the drive from each stop to the next took; none if it was never driven.
    pub times_s: Vec<Option<f64>>,
}

/// A stop of a route that is being driven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// Where it is.
    pub at_in_map: Point,
    /// From how far off it counts as reached.
    pub reached_m: f64,
}

impl Route {
    /// Its stops as they are driven to.
    pub fn waypoints(&self, places: &Places) -> Vec<Waypoint> {
        let waypoint = |(index, stop): (usize, &Stop)| Waypoint {
            at_in_map: stop.at_in_map(places),
            reached_m: self.reached_m(places, index),
        };
        self.stops.iter().enumerate().map(waypoint).collect()
    }

    /// From how far off a stop counts as reached: the robot can drive straight on to the next one from there, too.
    pub fn reached_m(&self, places: &Places, index: usize) -> f64 {
        let Some(next) = self.stops.get(index + 1) else { return ARRIVAL_M };
        let ends = self.stops[index].known().zip(next.known());
        let stretch = ends.and_then(|(from, to)| places.stretch(from, to));
        stretch.map_or(PASSING_M, |stretch| stretch.room_m.clamp(ARRIVAL_M, PASSING_M))
    }

    /// A route that was never driven.
    pub fn new(stops: Vec<Stop>) -> Self {
        let times_s = vec![None; stops.len().saturating_sub(1)];
        Self { stops, times_s }
    }

    /// A route over known places.
    pub fn over(places: &[PlaceId]) -> Self {
        Self::new(places.iter().copied().map(Stop::Known).collect())
    }

    /// A part of it, from one stop to another, backwards if the second is before the first: a drive takes as
    /// long there as back.
    ///
    /// # Panics
    /// There is no such stop.
    #[must_use]
    pub fn part(&self, entry: usize, exit: usize) -> Self {
        let (first, last) = (entry.min(exit), entry.max(exit));
        let mut part = Self { stops: self.stops[first..=last].to_vec(), times_s: self.times_s[first..last].to_vec() };
        if exit < entry {
            part.stops.reverse();
            part.times_s.reverse();
        }
        part
    }

    /// As a robot drives it that stands where it begins: without that point, unless it is a known place.
    #[must_use]
    pub fn from_here(self) -> Self {
        match self.stops[..] {
            [Stop::At(_), _, ..] => self.part(1, self.stops.len() - 1),
            _ => self,
        }
    }

    /// Goes on with another route, which begins where this one ends.
    pub fn go_on(&mut self, mut other: Route) {
        if self.stops.is_empty() {
            *self = other;
        } else if !other.stops.is_empty() {
            self.stops.extend(other.stops.drain(1..));
            self.times_s.append(&mut other.times_s);
        }
    }

    /// Leaves out the rounds: what lies between two visits of one stop. O(stops²) for a route that is bounded
    /// by the places of a building.
    pub fn cut_rounds(&mut self) {
        let mut at = 0;
        while at < self.stops.len() {
            if let Some(again) = self.stops.iter().rposition(|stop| *stop == self.stops[at]).filter(|&again| again > at)
            {
                self.stops.drain(at + 1..=again);
                self.times_s.drain(at..again);
            }
            at += 1;
        }
    }

    /// Its length.
    pub fn length_m(&self, places: &Places) -> f64 {
        self.stops.windows(2).map(|two| two[0].off_m(two[1], places)).sum()
    }

    /// How many of its steps another route does not have, in either direction.
    pub fn steps_beyond(&self, other: &Route) -> usize {
        let has =
            |two: &[Stop]| other.stops.windows(2).any(|step| step == two || (step[0] == two[1] && step[1] == two[0]));
        self.stops.windows(2).filter(|two| !has(two)).count()
    }
}
