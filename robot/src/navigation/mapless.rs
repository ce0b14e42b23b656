//! The behaviour `navigation` of a robot without a map: to targets in `odom`, by what its own sensors
//! have seen, taking the unseen for free until it is seen (the freespace assumption: Koenig and
//! Smirnov 1997, "Sensor-Based Planning with the Freespace Assumption").

use super::dynamic_window::{DriveLimits, DynamicWindow, Speeds, WindowInput};
use super::laser_scan::{is_seen, points_in_base, smoothed};
use super::learned_map::{Evidence, Grain, LearnedMap};
use super::manner::Manner;
use super::navigation::{NavigationEvent, NavigationInput, NavigationOutput, turn_to};
use super::obstacle_memory::{ObstacleMemory, Transform};
use super::planner::{PlannerModel, PlannerParameters};
use super::topological::Target;
use super::value_field::{ValueField, path_length_m};
use crate::geometry::{Point, distance_m};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
enum Phase {
    #[default]
    Idle,
    Driving,
    /// There seems to be no way: turning on the spot to see more, for so long.
    LookingAround {
        left_s: f64,
    },
    /// At the last target, turning to its heading.
    Turning,
}

/// What a way was planned on: it is kept to until it turns out to be obstructed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Plan {
    target_in_odom: Point,
    from_in_odom: Point,
    seen: LearnedMap,
    evidence: Evidence,
    at_s: f64,
}

/// The value of every cell for the plan; follows from it.
#[derive(Clone, Debug, Default)]
struct FieldCache(Option<Arc<ValueField>>);

impl PartialEq for FieldCache {
    /// A cache is what it was computed from, which is compared elsewhere.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// The nearest the robot has come by the way it knew, and what it had seen by then.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Progress {
    least_cost_m: Option<f64>,
    seen_cells: u64,
    at_s: f64,
    /// Whether the robot has forgotten what holds it up and begun anew since.
    anew: bool,
    /// Whether it has looked around for a way since.
    looked_around: bool,
}

/// State of the navigation without a map. The frame of its targets is `odom`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MaplessNavigation {
    phase: Phase,
    /// Targets not yet reached.
    targets: Vec<Target>,
    /// So long without getting nearer or seeing anything new is blocked.
    patience_s: f64,
    now_s: f64,
    seen: LearnedMap,
    /// What was heard and felt lately.
    heard: ObstacleMemory,
    /// What the laser saw lately.
    scanned: ObstacleMemory,
    window: DynamicWindow,
    plan: Option<Plan>,
    next_look_s: f64,
    progress: Progress,
    #[serde(skip)]
    cache: FieldCache,
}

/// A target before the last counts as reached from here.
const PASSING_M: f64 = 0.3;
/// The last target counts as reached from here.
const ARRIVAL_M: f64 = 0.15;
/// Something stands so near to the last target that the robot gets no nearer: after so long it
/// counts as reached from here.
const CROWDED_ARRIVAL_M: f64 = 0.3;
const CROWDED_S: f64 = 5.0;
/// The way ahead is looked at so often.
const LOOK_S: f64 = 0.5;
/// What is so near to the robot does not obstruct its way: it is there already.
const HERE_M: f64 = 0.4;
/// Ways lead at most so far around what has been seen.
const MARGIN_M: f64 = 3.0;
/// Targets farther than this are out of reach.
const FARTHEST_M: f64 = 100.0;
/// After so long the robot forgets what holds it up, once, and begins anew: what it forgets is new to
/// it afterwards.
const ANEW_S: f64 = 15.0;
/// The time a way takes that turned out to be longer: at this speed, and at most so much.
const DETOUR_MPS: f64 = 0.2;
const DETOUR_S: f64 = 120.0;
/// Getting nearer means by so much.
const PROGRESS_M: f64 = 0.1;
/// Something new means so many cells.
const NEW_CELLS: u64 = 20;
/// What is doubted around a robot that is held up.
const DOUBT_M: f64 = 1.5;
/// How fast the robot turns to look around, and for how long: a full turn.
const LOOK_RADPS: f64 = 0.6;
const LOOK_AROUND_S: f64 = std::f64::consts::TAU / LOOK_RADPS;

impl MaplessNavigation {
    /// How long a robot that is told nothing else goes on where it gets no nearer and sees nothing new:
    /// without a map it knows of no door that could be opened.
    pub const PATIENCE_S: f64 = 30.0;

    /// Nothing has been seen, and there is nothing to do.
    pub fn new(grain: Grain) -> Self {
        Self { seen: LearnedMap::new(grain), ..Self::default() }
    }

    /// Begins to drive to these targets, in order, instead of any others. What has been seen is kept.
    /// The way is blocked when for `patience_s` the robot has neither come nearer nor seen anything new.
    pub fn start(&mut self, targets: Vec<Target>, patience_s: f64) {
        let phase = if targets.is_empty() { Phase::Idle } else { Phase::Driving };
        *self = Self {
            phase,
            targets,
            patience_s,
            now_s: self.now_s,
            seen: std::mem::take(&mut self.seen),
            heard: std::mem::take(&mut self.heard),
            scanned: std::mem::take(&mut self.scanned),
            next_look_s: self.now_s,
            progress: Progress { at_s: self.now_s, ..Progress::default() },
            ..Self::default()
        };
    }

    /// Deletes all targets: how another process interrupts the navigation. Not an arrival.
    pub fn remove_all_targets(&mut self) {
        self.start(Vec::new(), Self::PATIENCE_S);
    }

    /// Targets not yet reached.
    pub fn remaining_targets(&self) -> &[Target] {
        &self.targets
    }

    /// What has been seen so far.
    pub fn seen(&self) -> &LearnedMap {
        &self.seen
    }

    /// Bytes of map and planned way that an earlier state does not share.
    pub fn bytes_apart(&self, earlier: &Self) -> usize {
        let is_same = |field: &Arc<ValueField>| earlier.cache.0.as_ref().is_some_and(|known| Arc::ptr_eq(known, field));
        let field = self.cache.0.iter().filter(|field| !is_same(field)).map(|field| field.bytes()).sum::<usize>();
        self.seen.bytes_apart(&earlier.seen) + field
    }

    /// One step of `limits.step_s`. Also takes in what the sensors say when there is nothing to do.
    pub fn step(
        &mut self,
        limits: &DriveLimits,
        input: &NavigationInput<'_>,
        speed_limit_mps: f64,
    ) -> NavigationOutput {
        self.now_s += limits.step_s;
        let limits = &self.manner().limits(limits);
        let (here, sonar_m) = (input.odometry_in_odom, input.sonar_m);
        let smooth_m = input.laser_m.map(smoothed);
        let laser_m = smooth_m.as_deref();
        self.heard.update(here, sonar_m, None, limits.sonar_max_range_m, limits.step_s, |_| None);
        self.scanned.update(here, None, laser_m, limits.sonar_max_range_m, limits.step_s, |_| None);
        self.seen.observe(here, sonar_m, laser_m, limits.sonar_max_range_m, limits.step_s);
        if self.heard.feel(here, limits.robot_radius_m, input.bumped) {
            self.seen.feel(here, limits.robot_radius_m);
        }
        let passed = self.drop_reached(here.point());
        match self.phase {
            Phase::Idle => self.output(Speeds::default(), None),
            Phase::Turning => self.turn(limits, input),
            Phase::LookingAround { left_s } => self.look_around(limits, left_s),
            Phase::Driving => {
                let input = &NavigationInput { laser_m, ..*input };
                let mut output = self.drive(limits, input, speed_limit_mps);
                if passed {
                    output.event = output.event.or(Some(NavigationEvent::TargetReached));
                }
                output
            }
        }
    }

    fn manner(&self) -> Manner {
        Manner::with(self.seen.grain())
    }

    fn output(&self, speeds: Speeds, event: Option<NavigationEvent>) -> NavigationOutput {
        NavigationOutput { speeds, remaining_targets: self.targets.len(), needs_sonars: true, event }
    }

    fn finish(&mut self, event: NavigationEvent) -> NavigationOutput {
        self.phase = Phase::Idle;
        if event == NavigationEvent::Arrived {
            self.targets.clear();
        }
        self.output(Speeds::default(), Some(event))
    }

    /// Drops the targets at hand but the last; true if there were any.
    fn drop_reached(&mut self, here: Point) -> bool {
        let before = self.targets.len();
        while self.targets.len() > 1 && distance_m(here, self.targets[0].point_in_map) <= PASSING_M {
            self.next_target();
        }
        if let [last] = self.targets[..]
            && self.phase == Phase::Driving
            && distance_m(here, last.point_in_map) <= ARRIVAL_M
        {
            self.phase = Phase::Turning;
        }
        self.targets.len() < before
    }

    fn next_target(&mut self) {
        self.targets.remove(0);
        self.progress.least_cost_m = None;
        self.next_look_s = self.now_s;
    }

    fn turn(&mut self, limits: &DriveLimits, input: &NavigationInput<'_>) -> NavigationOutput {
        let wanted_rad = self.targets.last().and_then(|target| target.heading_rad);
        match turn_to(limits, wanted_rad, input.odometry_in_odom, input.speeds) {
            Some(speeds) => self.output(speeds, None),
            None => self.finish(NavigationEvent::Arrived),
        }
    }

    fn look_around(&mut self, limits: &DriveLimits, left_s: f64) -> NavigationOutput {
        let left_s = left_s - limits.step_s;
        self.phase = if left_s > 0.0 { Phase::LookingAround { left_s } } else { Phase::Driving };
        self.output(Speeds { translation_mps: 0.0, rotation_radps: LOOK_RADPS }, None)
    }

    fn drive(&mut self, limits: &DriveLimits, input: &NavigationInput<'_>, speed_limit_mps: f64) -> NavigationOutput {
        let here = input.odometry_in_odom.point();
        let Some(target) = self.targets.first().copied() else { return self.finish(NavigationEvent::Arrived) };
        self.look_at_way(limits, here, target.point_in_map);
        let field = self.field(limits);
        let lookahead_m = self.manner().lookahead_m;
        let Some(towards_in_odom) = field.as_ref().and_then(|field| field.lookahead(here, 0.0, lookahead_m)) else {
            return self.without_way(here);
        };
        if self.has_stalled(field.and_then(|field| field.cost_m(here)), here) {
            return self.finish(NavigationEvent::Blocked);
        }
        if self.targets.len() == 1
            && distance_m(here, target.point_in_map) <= CROWDED_ARRIVAL_M
            && self.now_s - self.progress.at_s > CROWDED_S
        {
            self.phase = Phase::Turning;
        }
        let obstacles_in_base = self.obstacles_in_base(input);
        let speed_limit_mps = speed_limit_mps.min(self.manner().speed_in_gap_mps(limits, &obstacles_in_base));
        let choice = self.window.step(
            limits,
            &WindowInput {
                odometry_in_odom: input.odometry_in_odom,
                speeds: input.speeds,
                obstacles_in_base: &obstacles_in_base,
                target_in_base: Transform::new(input.odometry_in_odom.inverse()).apply(towards_in_odom),
                speed_limit_mps,
                remaining_m: self.remaining_m(here),
            },
        );
        self.output(choice.speeds, None)
    }

    /// What the laser sees, and what is remembered of the surfaces it does not see now: a reading a
    /// little short of a surface would close a narrow gap for as long as it is remembered.
    fn obstacles_in_base(&self, input: &NavigationInput<'_>) -> Vec<Point> {
        let mut obstacles_in_base = Vec::new();
        self.scanned.append_in_base(input.odometry_in_odom, &mut obstacles_in_base);
        if let Some(laser_m) = input.laser_m {
            obstacles_in_base.retain(|&point| !is_seen(laser_m, point));
            obstacles_in_base.extend(points_in_base(laser_m));
        }
        self.heard.append_in_base(input.odometry_in_odom, &mut obstacles_in_base);
        obstacles_in_base
    }

    fn remaining_m(&self, here: Point) -> f64 {
        let points: Vec<Point> =
            std::iter::once(here).chain(self.targets.iter().map(|target| target.point_in_map)).collect();
        path_length_m(&points)
    }

    /// Without a way the robot goes for the next target, then looks around, then gives up.
    fn without_way(&mut self, here: Point) -> NavigationOutput {
        if self.targets.len() > 1 {
            self.next_target();
            return self.output(Speeds::default(), None);
        }
        if self.progress.looked_around {
            return self.finish(NavigationEvent::Unreachable);
        }
        self.progress.looked_around = true;
        self.seen.doubt_around(here, DOUBT_M);
        self.phase = Phase::LookingAround { left_s: LOOK_AROUND_S };
        self.next_look_s = self.now_s;
        self.plan = None;
        self.output(Speeds::default(), None)
    }

    /// Plans anew if there is no way yet, if something obstructs it, or after a while.
    fn look_at_way(&mut self, limits: &DriveLimits, here: Point, target_in_odom: Point) {
        if self.now_s < self.next_look_s && self.plan.is_some() {
            return;
        }
        self.next_look_s = self.now_s + LOOK_S;
        let plan_s = self.manner().plan_s;
        let is_kept = |plan: &Plan| plan.target_in_odom == target_in_odom && self.now_s - plan.at_s < plan_s;
        if self.plan.as_ref().is_some_and(is_kept) && !self.is_way_obstructed(limits, here) {
            return;
        }
        self.plan_on(limits, here, target_in_odom, Evidence::Likely);
        let has_way =
            |field: Option<Arc<ValueField>>| field.is_some_and(|field| field.lookahead(here, 0.0, 0.0).is_some());
        if !has_way(self.field(limits)) {
            self.plan_on(limits, here, target_in_odom, Evidence::Certain);
        }
    }

    fn plan_on(&mut self, limits: &DriveLimits, from_in_odom: Point, target_in_odom: Point, evidence: Evidence) {
        self.plan = Some(Plan { target_in_odom, from_in_odom, seen: self.seen.clone(), evidence, at_s: self.now_s });
        self.cache = FieldCache::default();
        self.field(limits);
    }

    fn is_way_obstructed(&mut self, limits: &DriveLimits, here: Point) -> bool {
        let Some(evidence) = self.plan.as_ref().map(|plan| plan.evidence) else { return true };
        let Some(way) = self.field(limits).and_then(|field| field.way_ahead(here, FARTHEST_M)) else { return true };
        way.iter()
            .filter(|&&point| distance_m(point, here) > HERE_M)
            .any(|&point| self.seen.is_obstructed(point, limits.robot_radius_m, evidence))
    }

    fn field(&mut self, limits: &DriveLimits) -> Option<Arc<ValueField>> {
        let manner = self.manner();
        let Plan { target_in_odom, from_in_odom, seen, evidence, .. } = self.plan.as_ref()?;
        let field = self.cache.0.get_or_insert_with(|| {
            let grid = seen.grid(&[*from_in_odom, *target_in_odom], MARGIN_M, FARTHEST_M, *evidence);
            let parameters = PlannerParameters {
                robot_radius_m: seen.planning_radius_m(limits.robot_radius_m),
                comfortable_distance_m: manner.comfortable_distance_m,
                ..PlannerParameters::default()
            };
            Arc::new(PlannerModel::new(&grid, parameters).value_field(*target_in_odom))
        });
        Some(field.clone())
    }

    /// Whether the robot has neither come nearer nor seen anything new for long. A way that became
    /// longer is given the time it takes.
    fn has_stalled(&mut self, cost_m: Option<f64>, here: Point) -> bool {
        let seen_cells = self.seen.seen_cells();
        let is_nearer = match (cost_m, self.progress.least_cost_m) {
            (Some(cost_m), Some(least_m)) => cost_m < least_m - PROGRESS_M,
            (Some(_), None) => true,
            (None, _) => false,
        };
        if is_nearer || seen_cells >= self.progress.seen_cells + NEW_CELLS {
            let least_cost_m = cost_m.or(self.progress.least_cost_m);
            self.progress = Progress { least_cost_m, seen_cells, at_s: self.now_s, ..Progress::default() };
        }
        let idle_s = self.now_s - self.progress.at_s;
        if idle_s > ANEW_S && !self.progress.anew {
            self.begin_anew(here);
        }
        let detour_m = cost_m.zip(self.progress.least_cost_m).map_or(0.0, |(cost_m, least_m)| cost_m - least_m);
        idle_s > self.patience_s + (detour_m / DETOUR_MPS).clamp(0.0, DETOUR_S)
    }

    /// What holds the robot up may be an echo long gone.
    fn begin_anew(&mut self, here: Point) {
        self.progress.anew = true;
        self.heard.forget();
        self.scanned.forget();
        self.window = DynamicWindow::default();
        self.seen.doubt_around(here, DOUBT_M);
        self.plan = None;
    }
}
