//! The control, step by step: which state it is in, and what that does with the wheels.

use super::parameters::BehaviourParameters;
use super::progress::Progress;
use super::state::{State, Trigger};
use super::surroundings::Surroundings;
use super::wander::blend;
use crate::landmarks::{LandmarkFix, Localizing, LocalizingEnd, LocalizingTarget};
use rpl_robot::avoidance::{DriveLimits, braked_velocity};
use rpl_robot::geometry::{Point, Pose, Velocity};
use rpl_robot::navigation::NavigationInput;
use rpl_robot::obstacles::ObstacleMemory;
use serde::{Deserialize, Serialize};

/// A goal on the way counts as reached from here, where there is room ...
pub const PASSING_M: f64 = 0.6;

/// ... and the last one from here.
pub const ARRIVAL_M: f64 = 0.25;

/// A new goal is faced when it is ahead to within this angle.
const FACED_RAD: f64 = 0.3;

/// How fast and for how long the robot backs off.
const BACK_OFF_MPS: f64 = 0.12;
const BACK_OFF_S: f64 = 1.5;

/// Before its goal it brakes as if it had this share of its deceleration.
const ARRIVAL_BRAKING: f64 = 0.6;

/// It is at least this fast there, to arrive at all.
const ARRIVAL_MPS: f64 = 0.05;

/// Where the control is to drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveGoal {
    /// In the robot's frame.
    pub in_base: Point,
    /// From how far off it counts as reached.
    pub reached_m: f64,
    /// Whether the robot is to stand there, and not to pass.
    pub is_last: bool,
}

/// What happened in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DriveEvent {
    /// The goal is reached.
    GoalReached,
    /// The robot has run into something.
    Bumped,
    /// The robot knows where it is, by a landmark.
    Localized(LandmarkFix),
    /// It does not come to know it by this landmark.
    LandmarkLost,
}

/// What a step decides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveStep {
    /// To command.
    pub velocity: Velocity,
    /// If anything did.
    pub event: Option<DriveEvent>,
}

/// The control: its state, its parameters, and what it has heard.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CaseDrive {
    /// What a behaviour case sets.
    pub parameters: BehaviourParameters,
    /// Whether what the state wants is done only as far as the robot can stop before what it hears.
    pub is_braked: bool,
    /// The state it is in.
    pub state: State,
    /// How the robot gets on with its goal.
    pub progress: Progress,
    /// How far it has got with localizing by a landmark.
    pub localizing: Localizing,
    memory: ObstacleMemory,
    bumped_s: f64,
}

impl CaseDrive {
    /// A control with these parameters.
    pub fn new(parameters: BehaviourParameters, is_braked: bool) -> Self {
        Self { parameters, is_braked, ..Self::default() }
    }

    /// There is another goal.
    pub fn begin_goal(&mut self) {
        self.progress = Progress::default();
        self.pull(Trigger::GoalGiven);
    }

    /// There is a landmark to localize by. Whether the robot does: not while it stands, backs off or is at it.
    pub fn begin_localizing(&mut self, target: LocalizingTarget) -> bool {
        let before = self.state;
        self.pull(Trigger::LandmarkNear);
        let begins = self.state != before;
        if begins {
            self.localizing = Localizing::begin(target);
        }
        begins
    }

    /// Whether the robot localizes by a landmark.
    pub fn is_localizing(&self) -> bool {
        matches!(self.state, State::Loc1 | State::Loc2)
    }

    /// One step of `limits.step_s`. Cost: a look in some directions at what was heard lately.
    pub fn step(&mut self, limits: &DriveLimits, input: &NavigationInput<'_>, goal: Option<DriveGoal>) -> DriveStep {
        self.memory.update(input.odometry_in_odom, input.sonar, input.laser, limits.step_s, |_| None);
        let event = self.change_state(limits, input, goal);
        let obstacles_in_base = self.heard_in_base(input.odometry_in_odom);
        let goal_in_base = goal.map(|goal| goal.in_base);
        let around = Surroundings { limits, obstacles_in_base: &obstacles_in_base, goal_in_base };
        let wanted = self.wanted(&around, goal, input.odometry_in_odom);
        let velocity = match self.is_braked {
            true => braked_velocity(limits, &obstacles_in_base, input.velocity, wanted),
            false => wanted,
        };
        DriveStep { velocity, event }
    }

    /// What the state wants of the wheels.
    fn wanted(&self, around: &Surroundings<'_>, goal: Option<DriveGoal>, robot_in_odom: Pose) -> Velocity {
        match self.state {
            State::NoGoal => Velocity::default(),
            State::NewGoal => {
                let bearing_rad = around.goal_in_base.map_or(0.0, |goal| libm::atan2(goal.y, goal.x));
                let most_radps = self.parameters.rotation_radps;
                let rotation_radps = around.limits.braked_turn_radps(bearing_rad).clamp(-most_radps, most_radps);
                Velocity { translation_mps: 0.0, rotation_radps }
            }
            State::Wander => arriving(around.limits, blend(&self.parameters, around), goal),
            State::Bump => Velocity { translation_mps: -BACK_OFF_MPS, rotation_radps: 0.0 },
            State::Loc1 => self.localizing.approach(around.limits, robot_in_odom).unwrap_or_default(),
            State::Loc2 => self.localizing.turn(around.limits, robot_in_odom).unwrap_or_default(),
        }
    }

    /// What was heard lately, where the odometry is this.
    pub fn heard_in_base(&self, odometry_in_odom: Pose) -> Vec<Point> {
        let mut heard_in_base = Vec::new();
        self.memory.append_in_base(odometry_in_odom, &mut heard_in_base);
        heard_in_base
    }

    fn pull(&mut self, trigger: Trigger) {
        self.state = self.state.after(trigger);
    }

    fn change_state(
        &mut self,
        limits: &DriveLimits,
        input: &NavigationInput<'_>,
        goal: Option<DriveGoal>,
    ) -> Option<DriveEvent> {
        let is_hit = self.memory.feel(input.odometry_in_odom, limits.robot_radius_m, input.bumped);
        if is_hit {
            self.bumped_s = 0.0;
            self.pull(Trigger::Bumped);
            return Some(DriveEvent::Bumped);
        }
        if self.state == State::Bump {
            self.bumped_s += limits.step_s;
            if self.bumped_s > BACK_OFF_S {
                self.pull(Trigger::BackedOff);
            }
        }
        if self.is_localizing() {
            return self.localize(limits, input);
        }
        let goal = goal?;
        let goal_m = goal.in_base.coords.norm();
        self.progress.note(goal_m, limits.step_s);
        if goal_m < goal.reached_m {
            self.pull(Trigger::GoalReached);
            return Some(DriveEvent::GoalReached);
        }
        if libm::atan2(goal.in_base.y, goal.in_base.x).abs() < FACED_RAD {
            self.pull(Trigger::GoalFaced);
        }
        None
    }
}

impl CaseDrive {
    fn localize(&mut self, limits: &DriveLimits, input: &NavigationInput<'_>) -> Option<DriveEvent> {
        if self.localizing.is_spent(limits.step_s) {
            self.pull(Trigger::LandmarkLost);
            return Some(DriveEvent::LandmarkLost);
        }
        let robot_in_odom = input.odometry_in_odom;
        if self.state == State::Loc1 {
            if self.localizing.approach(limits, robot_in_odom).is_none() {
                self.pull(Trigger::LandmarkReached);
            }
            return None;
        }
        if self.localizing.turn(limits, robot_in_odom).is_some() {
            return None;
        }
        match self.localizing.measure(input)? {
            LocalizingEnd::Localized(fix) => {
                self.pull(Trigger::Localized);
                Some(DriveEvent::Localized(fix))
            }
            LocalizingEnd::Lost => {
                self.pull(Trigger::LandmarkLost);
                Some(DriveEvent::LandmarkLost)
            }
        }
    }
}

/// A robot that is to stand at its goal brakes before it.
fn arriving(limits: &DriveLimits, wanted: Velocity, goal: Option<DriveGoal>) -> Velocity {
    let Some(goal) = goal.filter(|goal| goal.is_last) else { return wanted };
    let braking_mps2 = ARRIVAL_BRAKING * limits.translation_deceleration_mps2;
    let braked_mps = libm::sqrt(2.0 * braking_mps2 * goal.in_base.coords.norm());
    Velocity { translation_mps: wanted.translation_mps.min(braked_mps.max(ARRIVAL_MPS)), ..wanted }
}
