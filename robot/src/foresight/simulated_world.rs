//! The world of simulated projections: the one that the map shows, with what the robot knows to stand in it and with
//! doors and people as they are drawn. The robot is where it believes itself to be: it knows how far it has driven,
//! and measures distances only where something is not as in the map. Anywhere else it goes by the map, as it does
//! with its sensors switched off.
//!
//! So a step costs microseconds: ranges are measured only near a door that is drawn closed, or near something that the
//! robot remembers.

use super::abstract_robot::AbstractRobot;
use super::ways::Way;
use crate::geometry::{Point, Pose, Velocity, distance_m};
use crate::sensors::{FailedSensors, Signals};
use crate::simulator::{Commands, GripperMotion, GripperStatus, Percept, SimulatorModel, SimulatorState};
use crate::world::{Object, SeenBy, Shape};
use std::sync::Arc;

/// How a door stands shows from here on.
const DOOR_SHOWS_M: f64 = 2.5;

/// What is not as in the map is measured from here on.
const MEASURED_M: f64 = 3.0;

/// The radius of the disc that stands for anything seen standing, and the air around the robot.
const STANDING_RADIUS_M: f64 = 0.05;
const AIR_M: f64 = 0.05;

/// Of what is seen standing the nearest count.
const MOST_STANDING: usize = 128;

/// Where the robot is by its odometry, and how it moves.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion {
    /// Dead reckoning.
    pub odometry_in_odom: Pose,
    /// As measured.
    pub velocity: Velocity,
}

/// The world of one run.
#[derive(Clone, Debug)]
pub struct SimulatedWorld {
    model: Arc<SimulatorModel>,
    state: SimulatorState,
    /// Doors that the drive leads through and that the robot has not come to.
    doors_ahead: Vec<usize>,
    /// From when to when somebody stands before the robot.
    held_up_us: (u64, u64),
}

impl SimulatedWorld {
    /// Of a model of what the map shows, with the robot at a pose, and what stands there besides. A pose in which
    /// the robot would touch something is taken nevertheless: it drives away from it.
    pub fn new(
        model: Arc<SimulatorModel>,
        seed: u64,
        now_us: u64,
        robot_in_map: Pose,
        motion: Motion,
        standing_in_map: &[Point],
    ) -> Self {
        let mut state = model.start(seed);
        (state.time_us, state.robot_in_map, state.odometry_in_odom) = (now_us, robot_in_map, motion.odometry_in_odom);
        (state.translation_mps, state.rotation_radps) =
            (motion.velocity.translation_mps, motion.velocity.rotation_radps);
        let least_m = model.robot().radius_m + STANDING_RADIUS_M + AIR_M;
        let away_m = |point: &Point| distance_m(*point, robot_in_map.point());
        let mut standing: Vec<Point> =
            standing_in_map.iter().copied().filter(|point| away_m(point) > least_m).collect();
        standing.sort_by(|one, other| away_m(one).total_cmp(&away_m(other)));
        standing.truncate(MOST_STANDING);
        state.objects_added = standing.into_iter().map(disc).collect();
        Self { model, state, doors_ahead: Vec::new(), held_up_us: (0, 0) }
    }

    /// Where the robot is.
    pub fn robot_in_map(&self) -> Pose {
        self.state.robot_in_map
    }

    /// How it moves.
    pub fn motion(&self) -> Motion {
        let SimulatorState { odometry_in_odom, translation_mps, rotation_radps, .. } = self.state;
        Motion { odometry_in_odom, velocity: Velocity { translation_mps, rotation_radps } }
    }

    /// A drive begins, on a way that should take `expected_s`.
    pub fn begin_drive(&mut self, robot: &mut AbstractRobot, way: &Way, expected_s: f64) {
        self.held_up_us = robot.draw_hold_up(expected_s);
        self.doors_ahead = way.doors().collect();
        self.doors_ahead.sort_unstable();
        self.doors_ahead.dedup();
    }

    /// One step of the model, up to a time. The doors stand as they are drawn when the robot comes to them. A robot that
    /// goes by sight, and not by the map, measures all the time.
    pub fn step(&mut self, robot: &mut AbstractRobot, wanted: Velocity, now_us: u64, by_sight: bool) -> Percept {
        self.state.time_us = now_us;
        self.come_to_doors(robot);
        self.state.battery = if robot.has_power() { 1.0 } else { 0.0 };
        let is_held_up = (self.held_up_us.0..self.held_up_us.1).contains(&now_us);
        let Velocity { translation_mps, rotation_radps } = if is_held_up { Velocity::default() } else { wanted };
        let commands = Commands { translation_mps, rotation_radps, sonars_on: true, ..Commands::default() };
        self.model.move_robot(&mut self.state, &commands);
        let mut percept =
            if by_sight || self.measures() { self.model.sense(&mut self.state, &commands) } else { self.unmeasured() };
        percept.battery = robot.battery;
        percept
    }

    fn come_to_doors(&mut self, robot: &mut AbstractRobot) {
        let (doors, here) = (&self.model.world.doors, self.state.robot_in_map.point());
        self.doors_ahead.retain(|&door| {
            let is_far = distance_m(doors[door].at, here) > DOOR_SHOWS_M;
            if !is_far {
                robot.come_to(door);
            }
            is_far
        });
        for (door, is_closed) in robot.drawn_doors(self.state.time_us) {
            // No door shuts on the robot.
            let is_in_it = distance_m(doors[door].at, here) < self.model.robot().radius_m + doors[door].width_m / 2.0;
            if doors[door].mapped_open && !(is_closed && is_in_it) {
                self.state.doors_open[door] = !is_closed;
            }
        }
    }

    /// Whether something near the robot is not as in the map.
    fn measures(&self) -> bool {
        let here = self.state.robot_in_map.point();
        let is_near = |at: Point| distance_m(at, here) < MEASURED_M;
        let mut doors = self.model.world.doors.iter().zip(&self.state.doors_open);
        let is_standing = |object: &Object| matches!(object.shape, Shape::Circle { centre, .. } if is_near(centre));
        doors.any(|(door, &is_open)| is_open != door.mapped_open && is_near(door.at))
            || self.state.objects_added.iter().any(is_standing)
    }

    /// What the robot perceives where it goes by the map.
    fn unmeasured(&self) -> Percept {
        let state = &self.state;
        Percept {
            time_us: state.time_us,
            odometry_in_odom: state.odometry_in_odom,
            translation_mps: state.translation_mps,
            rotation_radps: state.rotation_radps,
            sonar_m: None,
            laser_m: None,
            camera: None,
            failed: FailedSensors::default(),
            bumped: self.model.robot().bumper && state.touching,
            gripper: GripperStatus { motion: GripperMotion::Open, holding: None },
            battery: state.battery,
            messages: Vec::new(),
            others: Signals::new(),
        }
    }
}

/// What is seen standing at a point.
fn disc(centre: Point) -> Object {
    Object {
        name: String::new(),
        shape: Shape::Circle { centre, radius_m: STANDING_RADIUS_M },
        mapped: false,
        seen_by: SeenBy { sonar: true, laser: true },
    }
}
