//! What is kept of a run that is driven: how it ended, where the robot was, what was reported.

use crate::journal::RunJournal;
use crate::mcap::McapRecording;
use crate::seen::{Live, Steering};
use crate::trace::TraceFile;
use rpl_link::recording::Recorder;
use rpl_mission::sight::{PositionBelief, Sight};
use rpl_robot::active::{ActionField, Choice};
use rpl_robot::localization::{Localization, Maximum};
use rpl_robot::office::ReportKind;
use rpl_runtime::run::system::Outcome;
use std::sync::Arc;

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RunEnd {
    /// By itself.
    Outcome(Outcome),
    /// The time given was up.
    TimeUp,
    /// It was told to stop, and its clean-ups have run.
    Interrupted,
    /// It was told to stop, and its clean-ups computed on and on.
    GivenUp,
}

/// What is kept of a run while it goes on.
#[derive(Default)]
pub struct Records {
    /// Where the trace goes.
    pub trace: Option<TraceFile>,
    /// Where what ROS tools read goes.
    pub mcap: Option<McapRecording>,
    /// Where the run is written down so that it can be gone on with.
    pub journal: Option<RunJournal>,
    /// What shows it in a browser.
    pub live: Option<Live>,
    /// Where it is written that the run was told to stop.
    pub recorder: Option<Arc<Recorder>>,
    /// How often the trace tells where the robot is, if it does.
    pub pose_every_us: Option<u64>,
    /// When it does so next.
    pub pose_due_us: u64,
    /// What was seen of the robot, ten times a second.
    pub track: Vec<Sight>,
    /// What the plan logged.
    pub logs: Vec<String>,
    /// How often active localization was started.
    pub relocalizations: u64,
    /// What the robot and the scenario reported.
    pub incidents: Vec<Incident>,
    /// The belief at each choice of active localization, if somebody is to look into it.
    pub choices: Option<Vec<Localization>>,
    /// The belief at the turning points of localization, if somebody is to draw it.
    pub scenes: Option<Vec<BeliefScene>>,
    /// Whether all that was considered at a choice is drawn, too.
    pub draws_choices: bool,
}

/// The belief at a moment.
pub struct BeliefScene {
    /// What happened.
    pub what: ReportKind,
    /// When, in seconds of virtual time.
    pub time_s: f64,
    /// The belief.
    pub belief: PositionBelief,
    /// Its local maxima, the heaviest first.
    pub maxima: Vec<Maximum>,
    /// What was chosen among what, if that is what happened.
    pub choice: Option<(Choice, ActionField)>,
    /// The robot.
    pub sight: Sight,
    /// How much of the track lies before it.
    pub track_length: usize,
}

/// Something the robot or the scenario reported, and how things stood then.
#[derive(Clone, Debug, PartialEq)]
pub struct Incident {
    /// What was reported.
    pub what: ReportKind,
    /// The robot at the end of that instant.
    pub sight: Sight,
    /// How far it had driven.
    pub distance_m: f64,
    /// How much of the track lies before it.
    pub track_length: usize,
}

impl Records {
    /// The page's hand on the run, if there is one.
    pub fn steering(&mut self) -> Option<&mut Steering> {
        self.live.as_mut()?.steering.as_mut()
    }
}
