//! Drives in the simulator by an experimenter, who knows where the robot is: for judging behaviours and for
//! learning them. A drive is a value; a copy of it is a fork.

use crate::control::{BehaviourParameters, CaseDrive, DriveEvent, DriveGoal};
use crate::route::Waypoint;
use crate::situation::{RecentSonars, Situation};
use rpl_robot::avoidance::DriveLimits;
use rpl_robot::geometry::{Point, Pose, Velocity, distance_m};
use rpl_robot::navigation::NavigationInput;
use rpl_robot::sensors::SonarScan;
use rpl_robot::simulator::{Commands, Percept, SimulatorModel, SimulatorState};
use std::sync::Arc;

/// A drive along a route.
#[derive(Clone, Debug)]
pub struct Trial {
    /// What does not change.
    pub model: Arc<SimulatorModel>,
    /// The robot and its world.
    pub state: SimulatorState,
    /// The control.
    pub drive: CaseDrive,
    /// The places not yet reached, the next one first.
    pub way: Vec<Waypoint>,
    /// What happened in the last step, if anything did.
    pub event: Option<DriveEvent>,
    recent: RecentSonars,
    percept: Percept,
    commands: Commands,
}

impl Trial {
    /// The robot stands somewhere in its world and is to drive along a route. None if something stands there.
    pub fn begin(
        model: &Arc<SimulatorModel>,
        seed: u64,
        robot_in_map: Pose,
        way: Vec<Waypoint>,
        drive: CaseDrive,
    ) -> Option<Self> {
        let mut state = model.start(seed);
        model.teleport(&mut state, robot_in_map).ok()?;
        let commands = Commands { sonars_on: true, ..Commands::default() };
        let percept = model.step(&mut state, &commands);
        let mut trial = Self {
            model: model.clone(),
            state,
            drive,
            way,
            event: None,
            recent: RecentSonars::default(),
            percept,
            commands,
        };
        trial.drive.begin_goal();
        Some(trial)
    }

    /// Whether the last place is reached.
    pub fn is_over(&self) -> bool {
        self.way.is_empty()
    }

    /// One step.
    pub fn step(&mut self) {
        let limits = DriveLimits::of(self.model.robot());
        let goal = self.goal();
        let percept = &self.percept;
        let sonar = self.model.sensors.sonars.as_ref().zip(percept.sonar_m.as_deref());
        let input = NavigationInput {
            odometry_in_odom: percept.odometry_in_odom,
            velocity: Velocity { translation_mps: percept.translation_mps, rotation_radps: percept.rotation_radps },
            sonar: sonar.map(|(sonars, ranges_m)| SonarScan { sonars, ranges_m }),
            laser: None,
            bumped: percept.bumped,
        };
        let step = self.drive.step(&limits, &input, goal);
        self.commands.translation_mps = step.velocity.translation_mps;
        self.commands.rotation_radps = step.velocity.rotation_radps;
        self.percept = self.model.step(&mut self.state, &self.commands);
        let readings = self.percept.sonar_m.iter().flatten().map(|&range_m| Some(f64::from(range_m)));
        self.recent.hear(&readings.collect::<Vec<_>>());
        self.event = step.event;
        if step.event == Some(DriveEvent::GoalReached) {
            self.way.remove(0);
            if !self.is_over() {
                self.drive.begin_goal();
            }
        }
    }

    /// Goes on along another route.
    pub fn go_on_along(&mut self, way: Vec<Waypoint>) {
        self.way = way;
        self.drive.begin_goal();
    }

    /// What the robot has heard lately.
    pub fn heard_in_map(&self) -> Vec<Point> {
        let heard_in_base = self.drive.heard_in_base(self.percept.odometry_in_odom);
        heard_in_base.into_iter().map(|at| self.state.robot_in_map.transform(at)).collect()
    }

    fn goal(&self) -> Option<DriveGoal> {
        let Waypoint { at_in_map, reached_m } = *self.way.first()?;
        let in_base = self.state.robot_in_map.inverse().transform(at_in_map);
        Some(DriveGoal { in_base, reached_m, is_last: self.way.len() == 1 })
    }

    /// What a case is looked for by.
    pub fn situation(&self) -> Situation {
        let situation = Situation {
            sonars_m: self.recent.last_m(),
            mean_sonars_m: self.recent.mean_m(),
            translation_mps: Some(self.percept.translation_mps),
            rotation_radps: Some(self.percept.rotation_radps),
            short_term_goal_in_map: self.way.first().map(|next| next.at_in_map),
            long_term_goal_in_map: self.way.last().map(|last| last.at_in_map),
            ..Situation::default()
        };
        situation.seen_from(self.state.robot_in_map)
    }

    /// How far it is to the end of the route, straight from place to place.
    pub fn left_m(&self) -> f64 {
        let mut at = self.state.robot_in_map.point();
        let mut left_m = 0.0;
        for next in self.way.iter().map(|next| next.at_in_map) {
            left_m += distance_m(at, next);
            at = next;
        }
        left_m
    }

    /// Goes on with these parameters for some time, or to the end of the route.
    pub fn drive_for(&mut self, parameters: BehaviourParameters, seconds: f64) {
        self.drive.parameters = parameters;
        let until_us = self.state.time_us + (seconds * 1e6) as u64;
        while !self.is_over() && self.state.time_us < until_us {
            self.step();
        }
    }
}
