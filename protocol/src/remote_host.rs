//! A host in another process, as a run has it: where the run stands in the conversation with it.
//! An answer given at a turn stays for every copy of the run; only a new turn is spoken.

use crate::course::Course;
use crate::host::{CommandsMessage, HostAnswer, PerceptMessage};
use crate::line::{Conversation, Line, LineFault};
use crate::thinking::{self, Thinking, ThinkingLine};
use rpl_robot::description::RobotDescription;
use rpl_robot::geometry::Pose;
use rpl_robot::office::{Host, HostLost, Report, SaveHost};
use rpl_robot::sensors::RangeSensors;
use rpl_robot::simulator::{Commands, GripperCommand, GripperMotion, Percept};
use rpl_runtime::robot::thinking::{Insight, Thought, Ticket};
use rpl_runtime::state::failure::Raise;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A host in another process. A copy shares the line, and hears what was said already.
#[derive(Clone, Debug)]
pub struct RemoteHost {
    /// What messages call it: `the host "127.0.0.1:7300"`.
    name: String,
    conversation: Conversation<CommandsMessage, HostAnswer>,
    robot: Arc<RobotDescription>,
    /// How many readings it gives.
    sensors: RangeSensors,
    /// The decision that told the gripper something, until the host has heard of it.
    gripper_told: Option<u64>,
    /// What it has said so far; a host that is reached again begins anew.
    course: Course,
    /// Whether its bumper was pressed at the last percept.
    was_bumped: bool,
    /// What is thought about while it goes on.
    thinking: Thinking,
    /// How it went.
    pub record: HostRecord,
}

/// How the conversation with a host went.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HostRecord {
    /// Percepts that were taken in.
    pub percepts: u64,
    /// Those that came late by more than a period.
    pub percepts_late: u64,
    /// Those that never came.
    pub percepts_missing: u64,
    /// Those whose time cannot be.
    pub times_astray: u64,
    /// Those whose motion cannot be.
    pub motions_astray: u64,
    /// Decisions that took longer than a period.
    pub decisions_long: u64,
    /// How long the longest of them took.
    pub longest_decision_s: f64,
    /// How often the bumper was pressed.
    pub bumps: u64,
    /// Way by the odometry.
    pub distance_m: f64,
}

impl RemoteHost {
    /// A host at the start of a mission, called by its address, of a robot; with the line to who thinks for the
    /// mission.
    pub fn new(
        address: &str,
        line: Arc<dyn Line<CommandsMessage, HostAnswer>>,
        thinking: ThinkingLine,
        robot: Arc<RobotDescription>,
    ) -> Self {
        Self {
            name: address.to_string(),
            conversation: Conversation::new(line),
            sensors: robot.range_sensors(),
            robot,
            gripper_told: None,
            course: Course::new(Pose::default()),
            was_bumped: false,
            thinking: Thinking::new(thinking),
            record: HostRecord::default(),
        }
    }

    /// What the robot has perceived by what was heard after these commands, as the run counts time: a host may have
    /// gone on while the run stood still.
    fn percept(
        &mut self,
        message: &PerceptMessage,
        commands: &Commands,
        reports: &mut Vec<Report>,
    ) -> Result<Percept, String> {
        let camera = self.robot.camera.map(|camera| camera.view);
        let mut percept = message.percept(&self.sensors, camera.as_ref())?;
        let before = self.course.robot_in_odom();
        let astray = self.course.take(message, &mut percept, commands, &self.robot, reports)?;
        percept.time_us = self.conversation.turn() * self.robot.step_us;
        // A hand that was told to move, by commands that had not arrived, is about to.
        if self.gripper_told.is_some_and(|told| message.commands < Some(told)) {
            percept.gripper.motion = GripperMotion::Moving;
        } else {
            self.gripper_told = None;
        }
        let was_bumped = std::mem::replace(&mut self.was_bumped, percept.bumped);
        let record = &mut self.record;
        record.times_astray += u64::from(astray.is_time);
        record.motions_astray += u64::from(astray.is_motion);
        record.distance_m += before.distance_m(percept.odometry_in_odom);
        record.bumps += u64::from(percept.bumped && !was_bumped);
        Ok(percept)
    }

    fn note(&mut self, answer: &HostAnswer, reports: &mut Vec<Report>) {
        let record = &mut self.record;
        record.percepts += 1;
        if let Some(took_s) = answer.decided_in_s {
            record.decisions_long += 1;
            record.longest_decision_s = record.longest_decision_s.max(took_s);
            reports.push(Report::DecisionLong { took_s });
        }
        if answer.missing > 0 {
            record.percepts_missing = record.percepts_missing.saturating_add(answer.missing);
            reports.push(Report::PerceptsMissing { count: answer.missing });
        }
        if let Some(late_s) = answer.late_s {
            record.percepts_late += 1;
            reports.push(Report::PerceptLate { late_s });
        }
    }
}

impl Host for RemoteHost {
    fn step(&mut self, commands: &Commands, reports: &mut Vec<Report>) -> Result<Percept, HostLost> {
        let standing =
            self.course.is_blind().then(|| Commands { translation_mps: 0.0, rotation_radps: 0.0, ..commands.clone() });
        let words = CommandsMessage::new(self.course.next, standing.as_ref().unwrap_or(commands));
        if commands.gripper != GripperCommand::None {
            self.gripper_told = Some(words.number);
        }
        let answer = self.conversation.say(&words).map_err(|LineFault(why)| HostLost(why))?;
        self.note(&answer, reports);
        let number = answer.percept.number;
        self.percept(&answer.percept, commands, reports).map_err(|why| {
            HostLost(format!("the host `{}` says what cannot be, in percept {number}: {why}", self.name))
        })
    }

    /// The world goes on while a question is thought about.
    fn think(&mut self, ticket: Ticket, thought: Arc<dyn Thought>) -> Result<Option<Arc<dyn Thought>>, Raise> {
        self.thinking.take(ticket, thought).map(|()| None)
    }

    fn answers(&mut self, is_awaited: &dyn Fn(Ticket) -> bool) -> Vec<(Ticket, Option<Insight>)> {
        self.thinking.hear(is_awaited)
    }

    fn forget_questions(&mut self) -> Vec<Ticket> {
        self.thinking.forget()
    }

    /// Time and odometry of a host begin anew with every mission that reaches it; those of the run go on.
    fn renew(&mut self) -> bool {
        self.course = Course::new(self.course.robot_in_odom());
        self.gripper_told = None;
        true
    }
}

/// What changes of it: turns that are over, the decision the gripper waits for, what it has said so far, whether its
/// bumper was pressed, what is thought about, the record.
type Changing = (u64, Option<u64>, Course, bool, thinking::Changing, HostRecord);

impl SaveHost for RemoteHost {
    fn save(&self) -> Vec<u8> {
        let (turn, thinking) = (self.conversation.turn(), self.thinking.changing());
        let changing: Changing = (turn, self.gripper_told, self.course, self.was_bumped, thinking, self.record);
        match postcard::to_allocvec(&changing) {
            Ok(bytes) => bytes,
            Err(error) => unreachable!("every length is known: {error}"),
        }
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), String> {
        let changing: Changing =
            postcard::from_bytes(bytes).map_err(|error| format!("where it stood with its host is damaged: {error}"))?;
        let (turn, thinking);
        (turn, self.gripper_told, self.course, self.was_bumped, thinking, self.record) = changing;
        self.conversation.go_on_at(turn);
        self.thinking.change(thinking);
        Ok(())
    }
}
