//! Navigation of a robot without a map: to targets in `odom`, by what its own sensors have seen, taking
//! the unseen for free until it is seen (the freespace assumption: Koenig and Smirnov 1997,
//! "Sensor-Based Planning with the Freespace Assumption").
//!
//! `ways` is what it has seen and planned on it, with `progress`; `guide` how that leads the driver.

mod guide;
mod progress;
mod ways;

use super::driver::{Driver, NavigationOutput};
use super::input::NavigationInput;
use crate::avoidance::DriveLimits;
use crate::geometry::Point;
use crate::obstacles::{RememberedPoint, smoothed};
use crate::planning::Target;
use crate::sensors::{LaserScan, RangeSensor};
use guide::SeenGuide;
use serde::{Deserialize, Serialize};
use ways::SeenWays;

/// State of the navigation without a map. The frame of its targets is `odom`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MaplessNavigation {
    driver: Driver,
    ways: SeenWays,
}

impl MaplessNavigation {
    /// How long a robot that is told nothing else goes on where it gets no nearer and sees nothing new:
    /// without a map it knows of no door that could be opened.
    pub const PATIENCE_S: f64 = 30.0;

    /// Nothing has been seen, and there is nothing to do.
    pub fn new(sharpest: RangeSensor) -> Self {
        Self { driver: Driver::default(), ways: SeenWays::new(sharpest) }
    }

    /// Begins to drive to these targets, in order, instead of any others. What has been seen is kept.
    /// The way is blocked when for `patience_s` the robot has neither come nearer nor seen anything new.
    pub fn start(&mut self, targets: Vec<Target>, patience_s: f64) {
        self.driver.start(targets);
        self.ways.start(self.driver.now_s, patience_s, None);
    }

    /// The same for a target at hand, to which no way is taken that is longer than this: around what stands before it
    /// the robot would go through all of a building that it does not know. It goes up to there instead, and waits.
    pub fn start_nearby(&mut self, target: Target, patience_s: f64, longest_way_m: f64) {
        self.driver.start(vec![target]);
        self.ways.start(self.driver.now_s, patience_s, Some(longest_way_m));
    }

    /// Deletes all targets: how another process interrupts the navigation. Not an arrival.
    pub fn remove_all_targets(&mut self) {
        self.start(Vec::new(), Self::PATIENCE_S);
    }

    /// Targets not yet reached.
    pub fn remaining_targets(&self) -> &[Target] {
        &self.driver.targets
    }

    /// What the sensors saw, heard and felt lately.
    pub fn remembered(&self) -> impl Iterator<Item = &RememberedPoint> {
        self.ways.heard.points().iter().chain(self.ways.scanned.points())
    }

    /// Forgets all that it has seen, or what it has seen near a point.
    pub fn forget(&mut self, around_in_odom: Option<(Point, f64)>) {
        self.ways.forget(around_in_odom, self.driver.now_s);
    }

    /// Bytes of map and planned way that an earlier state does not share.
    pub fn bytes_apart(&self, earlier: &Self) -> usize {
        self.ways.bytes_apart(&earlier.ways)
    }

    /// One step of `limits.step_s`. Also takes in what the sensors say when there is nothing to do.
    pub fn step(
        &mut self,
        limits: &DriveLimits,
        input: &NavigationInput<'_>,
        speed_limit_mps: f64,
    ) -> NavigationOutput {
        self.driver.now_s += limits.step_s;
        let limits = &self.ways.profile().limits(limits);
        let smooth_m = input.laser.map(smoothed);
        let laser = input.laser.zip(smooth_m.as_deref()).map(|(scan, ranges_m)| LaserScan { ranges_m, ..scan });
        let input = &NavigationInput { laser, ..*input };
        self.ways.sense(limits, input);
        let mut guide = SeenGuide { ways: &mut self.ways, limits, input, speed_limit_mps };
        let decision = self.driver.step(&mut guide, limits, input);
        self.driver.output(decision, true)
    }
}
