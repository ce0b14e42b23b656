//! Direction-follow: along a hallway in its axis, in the middle or in a lane.

use super::lane::clear_lane;
use rpl_robot::avoidance::{CollisionAvoidance, DriveLimits, WindowInput};
use rpl_robot::geometry::{Point, Pose, Transform, Vector, Velocity, wrap_angle_rad};
use rpl_robot::navigation::NavigationInput;
use rpl_robot::obstacles::ObstacleMemory;
use serde::{Deserialize, Serialize};

/// How far ahead lies the point in the lane that the robot heads for.
const LOOKAHEAD_M: f64 = 1.2;

/// The share of what is missing to the middle of the hallway by which the lane moves there in a step: a wall that
/// recedes for a moment does not pull it aside.
const TO_MIDDLE: f64 = 0.04;

/// A wall nearer than the first is the hallway's own; without one on a side, the lane keeps off the other by the
/// second.
const WALL_M: f64 = 2.2;
const BESIDE_WALL_M: f64 = 1.1;

/// Getting on means by at least this; with less room ahead the robot waits for whoever stands there.
const PROGRESS_M: f64 = 0.1;

/// Held up for longer than this, the robot forgets what holds it up, once: it may be an echo long gone.
const ANEW_S: f64 = 8.0;

/// What a step gets to know.
#[derive(Clone, Copy, Debug)]
pub struct DirectionInput<'a> {
    /// What the sensors say.
    pub sensors: &'a NavigationInput<'a>,
    /// The axis of the hallway, the way the robot goes along it.
    pub heading_in_odom_rad: f64,
    /// From the middle of the robot to the walls, where they are known.
    pub left_m: Option<f64>,
    /// On the right.
    pub right_m: Option<f64>,
    /// How much nearer to the wall on the left than the middle the lane lies.
    pub lane_m: f64,
    /// How fast at most.
    pub speed_limit_mps: f64,
    /// How far it is to where the robot is to stand, along the hallway; infinite if nowhere.
    pub remaining_m: f64,
}

/// What a step decides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionOutput {
    /// To command.
    pub velocity: Velocity,
    /// For how long the robot has not got on.
    pub held_up_s: f64,
    /// How far the lane it drives in is free ahead, at most 2.5 m.
    pub free_m: f64,
}

/// State of a drive along a hallway.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DirectionFollow {
    memory: ObstacleMemory,
    window: CollisionAvoidance,
    /// Where the lane lies left of the robot; none before the first step.
    lane_m: Option<f64>,
    /// The lane that was driven in last, the same way.
    driven_m: f64,
    before_in_odom: Option<Pose>,
    /// Metres along the axis since the start, and the most there were when the robot last got on.
    along_m: f64,
    reached_m: f64,
    held_up_s: f64,
    begun_anew: bool,
}

impl DirectionFollow {
    /// One step of `limits.step_s`.
    pub fn step(&mut self, limits: &DriveLimits, input: &DirectionInput<'_>) -> DirectionOutput {
        let sensors = input.sensors;
        let here = sensors.odometry_in_odom;
        self.memory.update(here, sensors.sonar, sensors.laser, limits.step_s, |_| None);
        self.memory.feel(here, limits.robot_radius_m, sensors.bumped);
        self.move_lane(input);
        self.watch(limits.step_s);
        let mut obstacles_in_base = Vec::new();
        self.memory.append_in_base(here, &mut obstacles_in_base);
        let turn_rad = wrap_angle_rad(input.heading_in_odom_rad - here.heading_rad);
        let base_in_hallway = Transform::new(Pose::new(0.0, 0.0, -turn_rad));
        let in_hallway: Vec<Point> = obstacles_in_base.iter().map(|&point| base_in_hallway.apply(point)).collect();
        let wanted_m = self.lane_m.unwrap_or(0.0) + input.lane_m;
        let lane = clear_lane(limits, &in_hallway, wanted_m, self.driven_m);
        self.driven_m = lane.aside_m;
        let target = Point::new(LOOKAHEAD_M.min(input.remaining_m.max(0.3)), lane.aside_m);
        let choice = self.window.step(
            limits,
            &WindowInput {
                odometry_in_odom: here,
                velocity: sensors.velocity,
                obstacles_in_base: &obstacles_in_base,
                target_in_base: Pose::new(0.0, 0.0, turn_rad).transform(target),
                speed_limit_mps: input.speed_limit_mps,
                remaining_m: input.remaining_m,
            },
        );
        DirectionOutput { velocity: choice.velocity, held_up_s: self.held_up_s, free_m: lane.free_m }
    }

    /// The lane stays where it is in the hallway while the robot swerves, and is drawn to its middle.
    fn move_lane(&mut self, input: &DirectionInput<'_>) {
        let here = input.sensors.odometry_in_odom;
        let (sin, cos) = libm::sincos(input.heading_in_odom_rad);
        let driven = self.before_in_odom.map_or(Vector::zeros(), |before| here.point() - before.point());
        self.before_in_odom = Some(here);
        self.along_m += driven.x * cos + driven.y * sin;
        let aside_m = driven.y * cos - driven.x * sin;
        self.driven_m -= aside_m;
        let lane_m = self.lane_m.map_or(0.0, |lane_m| lane_m - aside_m);
        let near = |wall_m: Option<f64>| wall_m.filter(|&wall_m| wall_m < WALL_M);
        let middle_m = match (near(input.left_m), near(input.right_m)) {
            (Some(left_m), Some(right_m)) => (left_m - right_m) / 2.0,
            (Some(left_m), None) => left_m - BESIDE_WALL_M,
            (None, Some(right_m)) => BESIDE_WALL_M - right_m,
            (None, None) => lane_m,
        };
        self.lane_m = Some(lane_m + TO_MIDDLE * (middle_m - lane_m));
    }

    fn watch(&mut self, step_s: f64) {
        self.held_up_s += step_s;
        if self.along_m > self.reached_m + PROGRESS_M {
            self.reached_m = self.along_m;
            self.held_up_s = 0.0;
            self.begun_anew = false;
        }
        if self.held_up_s > ANEW_S && !self.begun_anew {
            self.begun_anew = true;
            self.memory.forget();
            self.window = CollisionAvoidance::default();
        }
    }
}
