//! What a robot without a map has seen, and the way it has planned on that.

use super::progress::SeenProgress;
use crate::avoidance::DriveLimits;
use crate::geometry::{Point, distance_m};
use crate::navigation::cache::Cache;
use crate::navigation::input::NavigationInput;
use crate::navigation::profile::DrivingProfile;
use crate::obstacles::{Confidence, LearnedMap, ObstacleMemory};
use crate::planning::{CostGrid, CostToGo, Inflation, path_length_m};
use crate::sensors::RangeSensor;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Time between two looks at the way ahead.
const LOOK_S: f64 = 0.5;
/// What is so near to the robot does not obstruct its way: it is there already.
const HERE_M: f64 = 0.4;
/// Ways lead at most so far around what has been seen.
const MARGIN_M: f64 = 3.0;
/// Targets farther than this are out of reach.
const FARTHEST_M: f64 = 100.0;
/// What is doubted around a robot that is held up.
const DOUBT_M: f64 = 1.5;

/// What a way was planned on: it is kept to until it turns out to be obstructed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct WayPlan {
    target_in_odom: Point,
    from_in_odom: Point,
    seen: LearnedMap,
    confidence: Confidence,
    at_s: f64,
}

/// State besides the targets; what has been seen outlives them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct SeenWays {
    pub seen: LearnedMap,
    /// What was heard and felt lately.
    pub heard: ObstacleMemory,
    /// What the laser saw lately.
    pub scanned: ObstacleMemory,
    plan: Option<WayPlan>,
    next_look_s: f64,
    /// Longer ways are not taken; none if any is.
    longest_way_m: Option<f64>,
    pub progress: SeenProgress,
    /// What it costs to go to the target of the plan.
    #[serde(skip)]
    costs: Cache<Arc<CostToGo>>,
}

impl SeenWays {
    /// Nothing has been seen.
    pub fn new(sharpest: RangeSensor) -> Self {
        Self { seen: LearnedMap::new(sharpest), ..Self::default() }
    }

    /// For new targets.
    pub fn start(&mut self, now_s: f64, patience_s: f64, longest_way_m: Option<f64>) {
        *self = Self {
            seen: std::mem::take(&mut self.seen),
            heard: std::mem::take(&mut self.heard),
            scanned: std::mem::take(&mut self.scanned),
            next_look_s: now_s,
            longest_way_m,
            progress: SeenProgress::from(now_s, patience_s),
            ..Self::default()
        };
    }

    /// Forgets all that was seen, or what was seen near a point, and plans anew.
    pub fn forget(&mut self, around_in_odom: Option<(Point, f64)>, now_s: f64) {
        let is_meant = |point| around_in_odom.is_none_or(|(at, reach_m)| distance_m(at, point) <= reach_m);
        self.heard.forget_where(is_meant);
        self.scanned.forget_where(is_meant);
        match around_in_odom {
            Some((at, reach_m)) => self.seen.forget_around(at, reach_m),
            None => self.seen = LearnedMap::new(self.seen.sharpest()),
        }
        self.plan = None;
        self.next_look_s = now_s;
    }

    /// Bytes of map and planned way that an earlier state does not share.
    pub fn bytes_apart(&self, earlier: &Self) -> usize {
        let is_same = |costs: &Arc<CostToGo>| earlier.costs.0.as_ref().is_some_and(|known| Arc::ptr_eq(known, costs));
        let costs = self.costs.0.iter().filter(|costs| !is_same(costs)).map(|costs| costs.bytes()).sum::<usize>();
        self.seen.bytes_apart(&earlier.seen) + costs
    }

    /// How the robot drives by what it sees.
    pub fn profile(&self) -> DrivingProfile {
        DrivingProfile::by(self.seen.sharpest())
    }

    /// Takes in what the sensors say.
    pub fn sense(&mut self, limits: &DriveLimits, input: &NavigationInput<'_>) {
        let NavigationInput { odometry_in_odom: here, sonar, laser, bumped, .. } = *input;
        let step_s = limits.step_s;
        self.heard.update(here, sonar, None, step_s, |_| None);
        self.scanned.update(here, None, laser, step_s, |_| None);
        self.seen.observe(here, sonar, laser, limits.robot_radius_m, step_s);
        if self.heard.feel(here, limits.robot_radius_m, bumped) {
            self.seen.feel(here, limits.robot_radius_m);
        }
    }

    /// The next target has a way of its own.
    pub fn take_next_target(&mut self, now_s: f64) {
        self.progress.measure_other_way();
        self.next_look_s = now_s;
    }

    /// Plans anew if there is no way yet, if something obstructs it, or after a while.
    pub fn look_at_way(&mut self, limits: &DriveLimits, here: Point, target_in_odom: Point, now_s: f64) {
        if now_s < self.next_look_s && self.plan.is_some() {
            return;
        }
        self.next_look_s = now_s + LOOK_S;
        let plan_s = self.profile().plan_s;
        let is_kept = |plan: &WayPlan| plan.target_in_odom == target_in_odom && now_s - plan.at_s < plan_s;
        if self.plan.as_ref().is_some_and(is_kept) && !self.is_way_obstructed(limits, here) {
            return;
        }
        self.plan_on(here, target_in_odom, Confidence::Likely, now_s);
        let has_way =
            |costs: Option<Arc<CostToGo>>| costs.is_some_and(|costs| costs.lookahead(here, 0.0, 0.0).is_some());
        if !has_way(self.costs(limits)) {
            self.plan_on(here, target_in_odom, Confidence::Certain, now_s);
        }
        if self.is_detour(limits, here) {
            // Who stands in the way walks on: the robot goes up to there, and waits.
            self.seen = LearnedMap::new(self.seen.sharpest());
            self.plan_on(here, target_in_odom, Confidence::Certain, now_s);
        }
    }

    /// Whether the target is at hand, so that no way to it may be long.
    pub fn is_nearby(&self) -> bool {
        self.longest_way_m.is_some()
    }

    /// Whether there is no way but one that leads too far around.
    fn is_detour(&mut self, limits: &DriveLimits, here: Point) -> bool {
        let Some(longest_way_m) = self.longest_way_m else { return false };
        let way = self.costs(limits).and_then(|costs| costs.way_ahead(here, FARTHEST_M));
        way.is_none_or(|way| path_length_m(&way) > longest_way_m)
    }

    fn plan_on(&mut self, from_in_odom: Point, target_in_odom: Point, confidence: Confidence, at_s: f64) {
        self.plan = Some(WayPlan { target_in_odom, from_in_odom, seen: self.seen.clone(), confidence, at_s });
        self.costs = Cache::default();
    }

    fn is_way_obstructed(&mut self, limits: &DriveLimits, here: Point) -> bool {
        let Some(confidence) = self.plan.as_ref().map(|plan| plan.confidence) else { return true };
        let Some(way) = self.costs(limits).and_then(|costs| costs.way_ahead(here, FARTHEST_M)) else { return true };
        way.iter()
            .filter(|&&point| distance_m(point, here) > HERE_M)
            .any(|&point| self.seen.is_obstructed(point, limits.robot_radius_m, confidence))
    }

    /// What it costs to go to the target by what was seen when the way was planned; none without a plan.
    pub fn costs(&mut self, limits: &DriveLimits) -> Option<Arc<CostToGo>> {
        let profile = self.profile();
        let WayPlan { target_in_odom, from_in_odom, seen, confidence, .. } = self.plan.as_ref()?;
        let costs = self.costs.0.get_or_insert_with(|| {
            let map = seen.grid(&[*from_in_odom, *target_in_odom], MARGIN_M, FARTHEST_M, *confidence);
            let inflation = Inflation {
                comfortable_distance_m: profile.comfortable_distance_m,
                ..Inflation::of_robot(seen.planning_radius_m(limits.robot_radius_m))
            };
            Arc::new(CostToGo::new(Arc::new(CostGrid::new(&map, inflation)), *target_in_odom))
        });
        Some(costs.clone())
    }

    /// Halves what is known around the robot, and plans on that: what holds it up may be wrong.
    pub fn doubt(&mut self, here: Point) {
        self.seen.doubt_around(here, DOUBT_M);
        self.plan = None;
    }

    /// The way ahead is looked at in the next step.
    pub fn look_soon(&mut self, now_s: f64) {
        self.next_look_s = now_s;
    }
}
