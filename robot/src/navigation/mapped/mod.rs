//! Navigation of a robot with a map: to targets in `map`, whatever stands in the way.
//!
//! `model` is what it knows for good; `ways` what it has found out about ways besides the map, in `costs`,
//! `blockages` and `progress`; `guide` how that leads the driver; `obstruction` what it says was in the
//! way.

mod blockages;
mod costs;
mod costs_to_go;
mod guide;
mod model;
mod obstruction;
mod progress;
mod ways;

pub use costs_to_go::CostsToGo;
pub use model::NavigationModel;
pub use obstruction::Obstruction;

use super::driver::{Driver, NavigationOutput};
use super::input::NavigationInput;
use super::profile::DrivingProfile;
use crate::avoidance::CollisionAvoidance;
use crate::geometry::{Point, Pose, Transform, wrap_angle_rad};
use crate::obstacles::RememberedPoint;
use crate::planning::Target;
use crate::world::TravelMode;
use guide::MapGuide;
use progress::MapProgress;
use serde::{Deserialize, Serialize};
use ways::MapWays;

/// State of the navigation on a map.
///
/// What it costs to go to the current target is kept beside the state, but is no part of it: it follows
/// from target and blockages, is not saved, and does not count in comparisons.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MappedNavigation {
    driver: Driver,
    ways: MapWays,
    /// Estimate and odometry of the step before.
    last: Option<(Pose, Pose)>,
    /// The drive that was interrupted, as long as no other was begun.
    interrupted: Option<InterruptedDrive>,
}

/// A drive that may go on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct InterruptedDrive {
    goal_in_map: Point,
    progress: MapProgress,
    /// Estimate and odometry when it was interrupted.
    at: (Pose, Pose),
}

/// The least time for which a robot that wanted its sonars in a doorway wants them.
const SEEING_IN_DOOR_S: f64 = 1.0;
/// A robot that was interrupted is in the same place if the estimate differs from the odometry since by no more than
/// what that may have erred.
const SAME_PLACE_M: f64 = 1.5;
const SAME_PLACE_RAD: f64 = 0.8;
/// Somebody who stands in the way goes on sooner than this.
const HELD_UP_S: f64 = 15.0;
/// An estimate that moves this much more than the odometry has jumped.
const JUMP_M: f64 = 0.4;
const JUMP_RAD: f64 = 0.5;

impl MappedNavigation {
    /// How long a robot that is told nothing else waits where it gets no nearer: doors are closed for a
    /// minute now and then, and people stand and talk.
    pub const PATIENCE_S: f64 = 120.0;

    /// Bytes of planned ways that an earlier state does not share.
    pub fn bytes_apart(&self, earlier: &Self) -> usize {
        self.ways.bytes_apart(&earlier.ways)
    }

    /// Begins to drive to these targets, in order, instead of any others. What the sensors saw and
    /// which doors were found closed is kept. The way is blocked when for `patience_s` the robot has
    /// come no nearer, those before an interruption included if the last target is the same.
    pub fn start(&mut self, targets: Vec<Target>, patience_s: f64) {
        let goal_in_map = targets.last().map(|target| target.point_in_frame);
        self.interrupted = self.interrupted.take().filter(|drive| Some(drive.goal_in_map) == goal_in_map);
        self.driver.start(targets);
        self.ways.start(self.driver.now_s, patience_s);
        self.last = None;
    }

    /// Deletes all targets. Not an arrival.
    pub fn remove_all_targets(&mut self) {
        self.start(Vec::new(), Self::PATIENCE_S);
    }

    /// The same, but the next drive to the last of them goes on with this one.
    pub fn interrupt(&mut self) {
        let goal = self.driver.targets.last().map(|target| target.point_in_frame);
        let drive = goal.zip(self.last).map(|(goal_in_map, at)| InterruptedDrive {
            goal_in_map,
            progress: self.ways.progress.clone(),
            at,
        });
        // One that was interrupted before its first step is still that before it.
        let interrupted = drive.or(self.interrupted.take());
        self.remove_all_targets();
        self.interrupted = interrupted;
    }

    /// Targets not yet reached.
    pub fn remaining_targets(&self) -> &[Target] {
        &self.driver.targets
    }

    /// What the sensors saw lately.
    pub fn remembered(&self) -> &[RememberedPoint] {
        self.ways.memory.points()
    }

    /// The doors found closed, as indices into the world's doors.
    pub fn closed_doors(&self) -> Vec<usize> {
        self.ways.closed_doors(self.driver.now_s)
    }

    /// What stands there and is not in the map, as far as the robot knows, in the map.
    pub fn standing_in_map(
        &self,
        model: &NavigationModel,
        estimated_in_map: Pose,
        odometry_in_odom: Pose,
    ) -> Vec<Point> {
        let unmapped = self.ways.unmapped_points(model, estimated_in_map, odometry_in_odom);
        unmapped.into_iter().map(|(point, _)| point).chain(self.ways.blockages.points_in_map()).collect()
    }

    /// Forgets what it saw and found at these places of the map, doors found closed included. What stands there is seen
    /// anew.
    pub fn forget_where(
        &mut self,
        model: &NavigationModel,
        estimated_in_map: Pose,
        odometry_in_odom: Pose,
        is_meant: impl Fn(Point) -> bool,
    ) {
        let odom_in_map = Transform::new(estimated_in_map.compose(odometry_in_odom.inverse()));
        let ways = &mut self.ways;
        ways.memory.forget_where(|point_in_odom| is_meant(odom_in_map.apply(point_in_odom)));
        ways.blockages.forget_where(&is_meant);
        let at = |door| model.doorways.iter().find(|doorway| doorway.door == door).map(|doorway| doorway.at);
        ways.doors.forget_where(|door| at(door).is_some_and(&is_meant));
        ways.next_look_s = self.driver.now_s;
    }

    /// Whether it has come no nearer for long where the map shows a way, and no closed door explains it: the map may be
    /// another one than it is, or the robot elsewhere.
    pub fn is_held_up(&self) -> bool {
        let now_s = self.driver.now_s;
        self.driver.is_active() && self.ways.progress.since_s(now_s) > HELD_UP_S && self.closed_doors().is_empty()
    }

    /// Time passes in which there is nothing to do and nothing to see.
    pub fn let_pass(&mut self, seconds: f64) {
        self.driver.now_s += seconds;
    }

    /// One step of `model.limits.step_s`. Also takes in the sonars when there is nothing to do, so
    /// that the memory of obstacles is fresh when there is.
    pub fn step(
        &mut self,
        model: &NavigationModel,
        estimated_in_map: Pose,
        input: &NavigationInput<'_>,
        mode: TravelMode,
    ) -> NavigationOutput {
        let limits = &model.limits;
        self.driver.now_s += limits.step_s;
        self.sense(model, estimated_in_map, input);
        self.want_sonars(input.bumped, mode);
        self.notice_jump(estimated_in_map, input.odometry_in_odom);
        self.go_on(estimated_in_map, input.odometry_in_odom);
        let mut guide = MapGuide { ways: &mut self.ways, model, estimated_in_map, input, mode };
        let in_narrow = DrivingProfile::IN_NARROW.limits(limits);
        let limits = if guide.is_narrow() { &in_narrow } else { limits };
        let decision = self.driver.step(&mut guide, limits, input);
        let needs_sonars = self.driver.is_active() && self.driver.now_s < self.ways.sonars_until_s;
        self.driver.output(decision, needs_sonars)
    }

    fn sense(&mut self, model: &NavigationModel, estimated_in_map: Pose, input: &NavigationInput<'_>) {
        let NavigationInput { odometry_in_odom, sonar, laser, bumped, .. } = *input;
        let (limits, memory) = (&model.limits, &mut self.ways.memory);
        let odom_in_map = Transform::new(estimated_in_map.compose(odometry_in_odom.inverse()));
        let off_map_m = |point_in_odom| model.planner.off_obstacle_m(odom_in_map.apply(point_in_odom));
        memory.update(odometry_in_odom, sonar, laser, limits.step_s, off_map_m);
        memory.feel(odometry_in_odom, limits.robot_radius_m, bumped);
    }

    fn want_sonars(&mut self, bumped: bool, mode: TravelMode) {
        let now_s = self.driver.now_s;
        if bumped || self.driver.avoidance.is_held_up() {
            self.ways.want_sonars(now_s);
        } else if mode == TravelMode::Doorway && now_s < self.ways.sonars_until_s {
            // Not off again half way through the door: memory and estimate were not good enough.
            self.ways.sonars_until_s = self.ways.sonars_until_s.max(now_s + SEEING_IN_DOOR_S);
        }
    }

    /// A drive that was begun goes on with the interrupted one.
    fn go_on(&mut self, estimated_in_map: Pose, odometry_in_odom: Pose) {
        if !self.driver.is_active() {
            return;
        }
        if let Some(InterruptedDrive { progress, at: (estimated_then, odometry_then), .. }) = self.interrupted.take() {
            let expected = estimated_then.compose(odometry_in_odom.relative_to(odometry_then));
            let off_rad = wrap_angle_rad(estimated_in_map.heading_rad - expected.heading_rad).abs();
            let is_same_place = estimated_in_map.distance_m(expected) <= SAME_PLACE_M && off_rad <= SAME_PLACE_RAD;
            self.ways.progress.go_on(self.driver.now_s, progress, is_same_place);
        }
    }

    /// An estimate that jumped makes old progress, blockages and doors meaningless.
    fn notice_jump(&mut self, estimated_in_map: Pose, odometry_in_odom: Pose) {
        if let Some((estimated_before, odometry_before)) = self.last {
            let expected = estimated_before.compose(odometry_in_odom.relative_to(odometry_before));
            let off_rad = wrap_angle_rad(estimated_in_map.heading_rad - expected.heading_rad).abs();
            if estimated_in_map.distance_m(expected) > JUMP_M || off_rad > JUMP_RAD {
                self.ways.forget_where_things_are(self.driver.now_s);
                self.driver.avoidance = CollisionAvoidance::default();
            }
        }
        self.last = Some((estimated_in_map, odometry_in_odom));
    }
}
