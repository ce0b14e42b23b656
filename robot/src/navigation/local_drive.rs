//! Driving without a map: along a path given in `odom`, about at random, along walls, or on the spot.
//! All but the last go through the dynamic window like any other motion.

use super::input::NavigationInput;
use crate::avoidance::{AvoidanceStatus, CollisionAvoidance, DriveLimits, WindowInput, open_distance_m};
use crate::geometry::{Point, Pose, Transform, Velocity, distance_m, wrap_angle_rad};
use crate::obstacles::ObstacleMemory;
use rpl_random::Stream;
use serde::{Deserialize, Serialize};

/// What is to be done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum DriveTask {
    /// Pass these points in order and stop at the last.
    Follow {
        /// Points not yet reached, in `odom`.
        path_in_odom: Vec<Point>,
    },
    /// Go straight where there is room, turning away from obstacles, and at random now and then.
    Wander {
        /// Where the choices come from.
        stream: Stream,
        /// The way taken at present.
        heading_in_odom_rad: Option<f64>,
        /// For how much longer.
        left_s: f64,
    },
    /// Keep walls on one side.
    WallFollow {
        /// 1 on the left, −1 on the right: the sign of `y` in `base`.
        side: i8,
    },
    /// Spin by a quarter of a turn, back up a little, wait, and again: what a robot does that has a
    /// fixed routine for being stuck.
    SpinAndBackUp {
        /// Time in the present round.
        elapsed_s: f64,
    },
}

/// How a step went.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum DriveStatus {
    /// On the way.
    Driving,
    /// At the end of the path. Wandering never ends.
    Arrived,
    /// Has not got on for several seconds; goes on trying.
    Stuck,
}

/// What a step decides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveOutput {
    /// To command.
    pub velocity: Velocity,
    /// How it went.
    pub status: DriveStatus,
}

/// State of a drive without a map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LocalDrive {
    /// What is to be done.
    pub task: DriveTask,
    memory: ObstacleMemory,
    window: CollisionAvoidance,
}

/// A point before the last counts as reached from here.
const PASSING_M: f64 = 0.3;
/// The last point counts as reached from here.
const ARRIVAL_M: f64 = 0.15;
/// With less room ahead than this a wandering robot looks for another way.
const WANDER_ROOM_M: f64 = 0.6;
/// How far a wandering robot looks.
const WANDER_HORIZON_M: f64 = 2.0;
/// The shortest and the longest time for which a wandering robot keeps its way.
const WANDER_S: (f64, f64) = (5.0, 15.0);
/// A wall counts as one to follow within this distance.
const WALL_NEAR_M: f64 = 1.2;
/// A wall is followed in the outermost direction with this much room.
const WALL_ROOM_M: f64 = 0.9;
/// Directions all around that are tried; of these a robot at a wall tries those from the side of
/// the wall to the other.
const DIRECTIONS: u32 = 24;
const DIRECTION_RAD: f64 = std::f64::consts::TAU / DIRECTIONS as f64;
const WALL_DIRECTIONS: std::ops::RangeInclusive<i32> = -5..=11;
/// A round of spinning and backing up: until when it spins, backs up, and waits.
const SPIN_S: f64 = std::f64::consts::FRAC_PI_2;
const BACK_UP_S: f64 = SPIN_S + 3.0;
const ROUND_S: f64 = BACK_UP_S + 5.0;
/// Speed of backing up, and the room it needs behind.
const BACK_UP_MPS: f64 = 0.1;
const BACK_UP_ROOM_M: f64 = 0.3;

impl LocalDrive {
    /// Will follow a path.
    pub fn follow(path_in_odom: Vec<Point>) -> Self {
        Self::new(DriveTask::Follow { path_in_odom })
    }

    /// Will wander.
    pub fn wander(stream: Stream) -> Self {
        Self::new(DriveTask::Wander { stream, heading_in_odom_rad: None, left_s: 0.0 })
    }

    /// Will do this.
    pub fn new(task: DriveTask) -> Self {
        Self { task, memory: ObstacleMemory::default(), window: CollisionAvoidance::default() }
    }

    /// What held the robot up on one path says nothing against the next.
    pub fn forget_being_held_up(&mut self) {
        self.window = CollisionAvoidance::default();
    }

    /// One step of `limits.step_s`.
    pub fn step(&mut self, limits: &DriveLimits, input: &NavigationInput<'_>, speed_limit_mps: f64) -> DriveOutput {
        self.memory.update(input.odometry_in_odom, input.sonar, input.laser, limits.step_s, |_| None);
        self.memory.feel(input.odometry_in_odom, limits.robot_radius_m, input.bumped);
        let mut obstacles_in_base = Vec::new();
        self.memory.append_in_base(input.odometry_in_odom, &mut obstacles_in_base);
        if let DriveTask::SpinAndBackUp { elapsed_s } = &mut self.task {
            *elapsed_s = (*elapsed_s + limits.step_s) % ROUND_S;
            let velocity = spin_or_back_up(*elapsed_s, limits, input, &obstacles_in_base);
            return DriveOutput { velocity, status: DriveStatus::Driving };
        }
        let Some((target_in_odom, remaining_m)) = self.target(limits, input, &obstacles_in_base) else {
            return DriveOutput { velocity: Velocity::default(), status: DriveStatus::Arrived };
        };
        let choice = self.window.step(
            limits,
            &WindowInput {
                odometry_in_odom: input.odometry_in_odom,
                velocity: input.velocity,
                obstacles_in_base: &obstacles_in_base,
                target_in_base: Transform::new(input.odometry_in_odom.inverse()).apply(target_in_odom),
                speed_limit_mps,
                remaining_m,
            },
        );
        let status = match choice.status {
            AvoidanceStatus::Driving | AvoidanceStatus::Escaping => DriveStatus::Driving,
            AvoidanceStatus::Stuck => DriveStatus::Stuck,
        };
        DriveOutput { velocity: choice.velocity, status }
    }

    /// The point to head for and how far it is to where the robot is to stand.
    fn target(
        &mut self,
        limits: &DriveLimits,
        input: &NavigationInput<'_>,
        obstacles_in_base: &[Point],
    ) -> Option<(Point, f64)> {
        match &mut self.task {
            DriveTask::Follow { path_in_odom } => next_on_path(path_in_odom, input.odometry_in_odom.point()),
            DriveTask::Wander { stream, heading_in_odom_rad, left_s } => {
                *left_s -= limits.step_s;
                let here = input.odometry_in_odom;
                let room_m = |heading_rad: f64| {
                    let direction_rad = wrap_angle_rad(heading_rad - here.heading_rad);
                    open_distance_m(limits, obstacles_in_base, direction_rad, WANDER_HORIZON_M)
                };
                let kept =
                    heading_in_odom_rad.filter(|&heading_rad| *left_s > 0.0 && room_m(heading_rad) > WANDER_ROOM_M);
                let heading_rad = kept.unwrap_or_else(|| {
                    *left_s = stream.uniform_in(WANDER_S.0, WANDER_S.1);
                    open_heading_rad(stream, here, room_m)
                });
                *heading_in_odom_rad = Some(heading_rad);
                Some((ahead_of(here, heading_rad), WANDER_HORIZON_M))
            }
            DriveTask::WallFollow { side } => {
                let side = f64::from(*side);
                let here = input.odometry_in_odom;
                let room_m =
                    |direction_rad: f64| open_distance_m(limits, obstacles_in_base, direction_rad, WANDER_HORIZON_M);
                Some((
                    ahead_of(here, here.heading_rad + along_wall_rad(side, obstacles_in_base, room_m)),
                    WANDER_HORIZON_M,
                ))
            }
            DriveTask::SpinAndBackUp { .. } => None,
        }
    }
}

/// The point a metre ahead in a direction.
fn ahead_of(here: Pose, heading_rad: f64) -> Point {
    Pose::new(here.x_m, here.y_m, heading_rad).transform(Point::new(1.0, 0.0))
}

/// The direction with room that is outermost on the side of the wall, relative to the robot; straight ahead
/// where no wall is near.
fn along_wall_rad(side: f64, obstacles_in_base: &[Point], room_m: impl Fn(f64) -> f64) -> f64 {
    let near = obstacles_in_base.iter().any(|obstacle| obstacle.coords.norm_squared() < WALL_NEAR_M * WALL_NEAR_M);
    if !near {
        return 0.0;
    }
    WALL_DIRECTIONS
        .map(|step| -side * f64::from(step) * DIRECTION_RAD)
        .find(|&direction_rad| room_m(direction_rad) > WALL_ROOM_M)
        .unwrap_or(std::f64::consts::PI)
}

/// A robot that does not see what is behind it does not back up.
fn spin_or_back_up(
    elapsed_s: f64,
    limits: &DriveLimits,
    input: &NavigationInput<'_>,
    obstacles_in_base: &[Point],
) -> Velocity {
    let behind_m = open_distance_m(limits, obstacles_in_base, std::f64::consts::PI, WANDER_HORIZON_M);
    if elapsed_s < SPIN_S {
        Velocity { translation_mps: 0.0, rotation_radps: 1.0 }
    } else if elapsed_s < BACK_UP_S && behind_m > BACK_UP_ROOM_M && input.sees_towards(std::f64::consts::PI) {
        Velocity { translation_mps: -BACK_UP_MPS, rotation_radps: 0.0 }
    } else {
        Velocity::default()
    }
}

fn next_on_path(path_in_odom: &mut Vec<Point>, here: Point) -> Option<(Point, f64)> {
    while let [current, rest @ ..] = &path_in_odom[..] {
        let reach_m = if rest.is_empty() { ARRIVAL_M } else { PASSING_M };
        if distance_m(here, *current) > reach_m {
            break;
        }
        path_in_odom.remove(0);
    }
    let mut remaining_m = 0.0;
    let mut from = here;
    for &point in path_in_odom.iter() {
        remaining_m += distance_m(from, point);
        from = point;
    }
    path_in_odom.first().map(|&point| (point, remaining_m))
}

/// The most open of the directions all around, chance deciding among nearly equal ones.
fn open_heading_rad(stream: &mut Stream, here: Pose, room_m: impl Fn(f64) -> f64) -> f64 {
    let mut best = (f64::NEG_INFINITY, here.heading_rad);
    for direction in 0..DIRECTIONS {
        let heading_rad = wrap_angle_rad(here.heading_rad + f64::from(direction) * DIRECTION_RAD);
        let score = room_m(heading_rad) + stream.uniform();
        if score > best.0 {
            best = (score, heading_rad);
        }
    }
    best.1
}
