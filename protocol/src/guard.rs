//! What a host does for safety by itself, whatever a mission is: it stops the motors when nobody commands
//! them any more, and when something presses against the body.

use crate::host::SILENCE_US;
use rpl_robot::simulator::{Commands, GripperCommand, Percept};
use serde::Serialize;

/// Wheels that are measured never say 0: a robot that is no faster than this stands.
const STANDS_MPS: f64 = 0.01;
const STANDS_RADPS: f64 = 0.02;

/// Why motors are off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Halt {
    /// No mission has commanded anything yet.
    Unused,
    /// No command came for [`SILENCE_US`].
    Silence,
    /// The line to the mission is closed.
    LineClosed,
    /// Something presses against the body.
    Bumper,
}

/// How often motors were cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct HaltCounts {
    /// For want of commands.
    pub silences: u32,
    /// Because the line was closed.
    pub closed_lines: u32,
    /// Because of the bumper.
    pub bumps: u32,
}

/// Stands between commands and motors.
#[derive(Clone, Debug)]
pub struct Guard {
    heard_us: u64,
    halt: Option<Halt>,
    was_bumped: bool,
    /// How often it stopped them. What happens to a robot that stands is not counted.
    pub counts: HaltCounts,
}

impl Default for Guard {
    fn default() -> Self {
        Self { heard_us: 0, halt: Some(Halt::Unused), was_bumped: false, counts: HaltCounts::default() }
    }
}

impl Guard {
    /// Commands, or the same again, came at a time of the clock on the wall. A robot that the bumper stops
    /// comes to stand first.
    pub fn heard(&mut self, now_us: u64) {
        self.heard_us = now_us;
        if self.halt != Some(Halt::Bumper) {
            self.halt = None;
        }
    }

    /// The line is closed: nothing is commanded any more.
    pub fn line_closed(&mut self) {
        self.halt = Some(Halt::LineClosed);
        self.counts.closed_lines += 1;
    }

    /// Why the motors are off, if they are.
    pub fn halt(&self) -> Option<Halt> {
        self.halt
    }

    /// The commands that reach the motors at a time of the clock on the wall, and the halt that begins now,
    /// if one does; `percept` is what the robot perceived last.
    pub fn permitted(&mut self, now_us: u64, wanted: &Commands, percept: Option<&Percept>) -> (Commands, Option<Halt>) {
        let begins = self.look(now_us, percept);
        if self.halt.is_none() {
            return (wanted.clone(), None);
        }
        let halted = Commands { motors_off: true, sonars_on: wanted.sonars_on, ..Commands::default() };
        match self.halt {
            // A mission that is there still has its hand and its eye.
            Some(Halt::Bumper) => {
                (Commands { gripper: wanted.gripper.clone(), camera: wanted.camera, ..halted }, begins)
            }
            _ => (Commands { gripper: GripperCommand::None, ..halted }, begins),
        }
    }

    fn look(&mut self, now_us: u64, percept: Option<&Percept>) -> Option<Halt> {
        let is_bumped = percept.is_some_and(|percept| percept.bumped);
        let stands = percept.is_none_or(|percept| {
            percept.translation_mps.abs() <= STANDS_MPS && percept.rotation_radps.abs() <= STANDS_RADPS
        });
        let is_new_bump = is_bumped && !std::mem::replace(&mut self.was_bumped, is_bumped);
        if self.halt == Some(Halt::Bumper) && stands {
            self.halt = None;
        }
        let begins = match self.halt {
            None if now_us.saturating_sub(self.heard_us) >= SILENCE_US => {
                self.counts.silences += 1;
                Halt::Silence
            }
            None if is_new_bump => {
                self.counts.bumps += 1;
                Halt::Bumper
            }
            Some(Halt::Bumper) if now_us.saturating_sub(self.heard_us) >= SILENCE_US => Halt::Silence,
            _ => return None,
        };
        self.halt = Some(begins);
        Some(begins)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_robot::description::RobotDescription;
    use rpl_robot::geometry::Pose;
    use rpl_robot::simulator::{SimulatorModel, SimulatorSettings, SimulatorState};
    use rpl_robot::world::World;
    use std::sync::Arc;

    const PERIOD_US: u64 = 50_000;

    fn full_speed() -> Commands {
        Commands { translation_mps: 0.95, rotation_radps: 1.0, sonars_on: true, ..Commands::default() }
    }

    /// A robot at its top speed in a long corridor.
    fn driving() -> (SimulatorModel, SimulatorState, Percept) {
        let world = World::builtin("dept").expect("a built-in world");
        let robot = RobotDescription::clone(&RobotDescription::papers()).without_errors();
        let model = SimulatorModel::new(Arc::new(world), SimulatorSettings::of(robot));
        let mut state = model.start(1);
        state.translation_mps = 0.95;
        state.rotation_radps = 60.0_f64.to_radians();
        let percept = model.step(&mut state, &full_speed());
        (model, state, percept)
    }

    /// Steps until the robot stands, from a guard that has just cut the motors.
    fn steps_to_stand(guard: &mut Guard, mut now_us: u64) -> u32 {
        let (model, mut state, mut percept) = driving();
        let mut steps = 0;
        while state.translation_mps != 0.0 || state.rotation_radps != 0.0 {
            let (commands, _) = guard.permitted(now_us, &full_speed(), Some(&percept));
            percept = model.step(&mut state, &commands);
            steps += 1;
            now_us += PERIOD_US;
            assert!(steps < 100, "it does not stand");
        }
        steps
    }

    #[test]
    fn silence_cuts_the_motors_and_is_told_once() {
        let (_, _, percept) = driving();
        let mut guard = Guard::default();
        guard.heard(1_000_000);
        let at = |guard: &mut Guard, now_us| guard.permitted(now_us, &full_speed(), Some(&percept));
        assert_eq!(at(&mut guard, 1_299_999), (full_speed(), None));
        let (commands, begins) = at(&mut guard, 1_300_000);
        assert!(commands.motors_off);
        assert_eq!(begins, Some(Halt::Silence));
        assert_eq!(at(&mut guard, 1_350_000).1, None);
        guard.heard(1_360_000);
        assert_eq!(at(&mut guard, 1_400_000), (full_speed(), None));
        assert_eq!(guard.counts, HaltCounts { silences: 1, ..HaltCounts::default() });
    }

    #[test]
    fn a_robot_whose_motors_are_cut_stands_within_half_a_second() {
        let mut guard = Guard::default();
        guard.heard(0);
        guard.line_closed();
        let steps = steps_to_stand(&mut guard, 0);
        assert!(u64::from(steps) * PERIOD_US <= 500_000, "{steps} steps");
        let mut unused = Guard::default();
        assert!(u64::from(steps_to_stand(&mut unused, 0)) * PERIOD_US <= 500_000);
    }

    #[test]
    fn a_bump_stops_the_robot_and_then_it_may_back_off() {
        let (model, mut state, percept) = driving();
        let mut guard = Guard::default();
        guard.heard(0);
        let bumped = Percept { bumped: true, ..percept };
        let (commands, begins) = guard.permitted(0, &full_speed(), Some(&bumped));
        assert!(commands.motors_off && begins == Some(Halt::Bumper));
        let mut percept = model.step(&mut state, &commands);
        let mut steps = 1;
        while percept.translation_mps != 0.0 || percept.rotation_radps != 0.0 {
            guard.heard(steps * PERIOD_US);
            percept.bumped = true;
            let (commands, begins) = guard.permitted(steps * PERIOD_US, &full_speed(), Some(&percept));
            assert!(commands.motors_off && begins.is_none());
            percept = model.step(&mut state, &commands);
            steps += 1;
        }
        percept.bumped = true;
        let back = Commands { translation_mps: -0.1, ..Commands::default() };
        assert_eq!(guard.permitted(steps * PERIOD_US, &back, Some(&percept)), (back, None));
        assert_eq!(guard.counts.bumps, 1);
    }

    #[test]
    fn motors_are_off_until_somebody_commands() {
        let mut guard = Guard::default();
        let resting = Percept { odometry_in_odom: Pose::default(), ..driving().2 };
        let (commands, begins) = guard.permitted(9_000_000, &full_speed(), Some(&resting));
        assert!(commands.motors_off && begins.is_none());
        assert_eq!(guard.counts, HaltCounts::default());
    }
}
