//! The mission that has the robot.

use super::notice::Who;
use crossbeam::channel::Sender;
use rpl_protocol::host::{CommandsMessage, FromHost, PerceptMessage, written};
use rpl_robot::geometry::Pose;
use rpl_robot::simulator::{Commands, GripperCommand, Percept};
use std::collections::VecDeque;
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Percepts whose commands are waited for, to tell how long they took.
const MOST_UNANSWERED: usize = 600;

/// A mission that is served.
pub(super) struct Mission {
    /// By which its events are told from those of an earlier one.
    pub connection: u64,
    pub percepts: Sender<String>,
    /// Whether what is handed to `percepts` has to be written soon, or not at all.
    pub is_leaving: Arc<AtomicBool>,
    pub stream: Arc<TcpStream>,
    pub who: Who,
    pub since: Instant,
    /// When it last said something.
    pub heard: Instant,
    /// Where time and odometry were when its first commands came; none before.
    pub began: Option<(u64, Pose)>,
    /// The number of its next percept.
    pub next: u64,
    newest: Option<CommandsMessage>,
    /// Since the last step the hand was told this.
    gripper: GripperCommand,
    /// Percepts that have not been answered, and when they were sent.
    unanswered: VecDeque<(u64, Instant)>,
}

impl Mission {
    /// One that has just come, and is sent what is handed to `percepts`.
    pub fn new(connection: u64, percepts: Sender<String>, stream: Arc<TcpStream>, who: Who, since: Instant) -> Self {
        Self {
            connection,
            percepts,
            is_leaving: Arc::default(),
            stream,
            who,
            since,
            heard: since,
            began: None,
            next: 0,
            newest: None,
            gripper: GripperCommand::None,
            unanswered: VecDeque::new(),
        }
    }

    /// What the robot is to do; none before the first commands.
    pub fn take_commands(&mut self) -> Option<Commands> {
        let commands = self.newest.as_ref()?.commands();
        Some(Commands { gripper: std::mem::take(&mut self.gripper), ..commands })
    }

    /// Commands that come between two steps replace each other, but the hand is told what it was told.
    pub fn newest_is(&mut self, commands: CommandsMessage) {
        match commands.commands().gripper {
            GripperCommand::None => {}
            told => self.gripper = told,
        }
        self.newest = Some(commands);
    }

    /// How long commands took that answer a percept; none if others did before.
    pub fn answered(&mut self, number: u64, at: Instant) -> Option<f32> {
        // Decision n has taken in the percepts up to n - 1.
        let last = number.checked_sub(1)?;
        while self.unanswered.front().is_some_and(|(percept, _)| *percept < last) {
            self.unanswered.pop_front();
        }
        let (_, sent) = self.unanswered.pop_front_if(|(percept, _)| *percept == last)?;
        Some(at.saturating_duration_since(sent).as_secs_f32())
    }

    /// Hands a percept to the writer, as the mission counts time and way; whether there was room.
    pub fn send(&mut self, percept: &Percept) -> bool {
        let Some((began_us, odom)) = self.began else { return true };
        let percept = Percept {
            time_us: percept.time_us - began_us,
            odometry_in_odom: percept.odometry_in_odom.relative_to(odom),
            ..percept.clone()
        };
        let commands = self.newest.as_ref().map(|commands| commands.number);
        let message = PerceptMessage::new(self.next, commands, &percept);
        self.unanswered.push_back((self.next, Instant::now()));
        if self.unanswered.len() > MOST_UNANSWERED {
            self.unanswered.pop_front();
        }
        self.next += 1;
        self.percepts.try_send(written(&FromHost::Percept(Box::new(message)))).is_ok()
    }
}
