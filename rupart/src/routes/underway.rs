//! A route that is being driven: which stop is next, and how long each step took.

use crate::places::{PlaceId, Places};
use crate::route::Route;
use rpl_robot::geometry::Point;
use serde::{Deserialize, Serialize};

/// A route that is being driven.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Underway {
    /// With the times of the steps that were driven so far.
    pub route: Route,
    /// Where its stops are.
    stops_in_map: Vec<Point>,
    /// The stop it is driving to.
    next: usize,
    /// How long it has been driving there.
    step_s: f64,
}

impl Underway {
    /// Its first stop is the first that is driven to.
    pub fn begin(route: Route, places: &Places) -> Self {
        let stops_in_map = route.stops.iter().map(|stop| stop.at_in_map(places)).collect();
        Self { route, stops_in_map, next: 0, step_s: 0.0 }
    }

    /// Which stop is the short-term goal.
    pub fn next(&self) -> usize {
        self.next
    }

    /// The short-term goal.
    pub fn next_in_map(&self) -> Option<Point> {
        self.stops_in_map.get(self.next).copied()
    }

    /// The long-term goal.
    pub fn last_in_map(&self) -> Option<Point> {
        self.stops_in_map.last().copied()
    }

    /// Whether the short-term goal is the long-term goal.
    pub fn is_at_last(&self) -> bool {
        self.next + 1 == self.stops_in_map.len()
    }

    /// Whether all stops are reached.
    pub fn is_over(&self) -> bool {
        self.next == self.stops_in_map.len()
    }

    /// The known place it was at last.
    pub fn before(&self) -> Option<PlaceId> {
        self.route.stops.get(self.next.checked_sub(1)?)?.known()
    }

    /// The route from the short-term goal on.
    pub fn rest(&self) -> Route {
        self.route.part(self.next, self.route.stops.len() - 1)
    }

    /// What was driven of it, if it is given up on the way from one known place to the next: that way counts with the
    /// time it took and what it takes longer from here.
    pub fn given_up(&self, longer_s: f64) -> Option<Route> {
        self.before()?;
        self.route.stops.get(self.next)?.known()?;
        let mut driven = self.route.part(0, self.next);
        driven.times_s[self.next - 1] = Some(self.step_s + longer_s);
        Some(driven)
    }

    /// It goes on for the time of a step.
    pub fn note_time(&mut self, step_s: f64) {
        self.step_s += step_s;
    }

    /// The short-term goal is reached. How long the way to the first took tells of no step.
    pub fn pass(&mut self) {
        if self.next > 0 {
            self.route.times_s[self.next - 1] = Some(self.step_s);
        }
        self.next += 1;
        self.step_s = 0.0;
    }
}
