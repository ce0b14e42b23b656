//! What a run was: where the robot went, what was reported and logged, and how it ended.

use crate::events::{self, LineKind};
use crate::onlooker::{Happened, Onlooker};
use anyhow::Result;
use rpl_mission::robot::Robot;
use rpl_mission::sight::{PositionBelief, Sight};
use rpl_robot::active::{ActionField, Choice};
use rpl_robot::localization::{Localization, Maximum};
use rpl_robot::office::ReportKind;
use rpl_runtime::run::system::Outcome;
use rpl_runtime::state::trace::Event;

/// Reports at which the belief is worth a drawing.
const TURNING_POINTS: [ReportKind; 3] =
    [ReportKind::PositionLost, ReportKind::LocalizationAction, ReportKind::PositionFound];

/// A maximum of the belief that is drawn has this share at least.
const LEAST_SHARE: f64 = 0.01;

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

/// What was observed of a run.
#[derive(Default)]
pub struct Observed {
    /// The robot, ten times a second.
    pub track: Vec<Sight>,
    /// What the plan logged, without the times.
    pub logs: Vec<String>,
    /// How often active localization was started.
    pub relocalizations: u64,
    /// What the robot and the scenario reported.
    pub incidents: Vec<Incident>,
    /// The belief at each choice of active localization, if it is to be looked into.
    pub choices: Option<Vec<Localization>>,
    /// The belief at the turning points of localization, if it is to be drawn.
    pub scenes: Option<Vec<BeliefScene>>,
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

impl Observed {
    /// The same, of a run whose beliefs are drawn, or not.
    pub fn with_scenes(are_drawn: bool) -> Self {
        Self { scenes: are_drawn.then(Vec::new), ..Self::default() }
    }

    fn note(&mut self, event: &Event, is_lost: bool, robot: &mut Robot) {
        if is_lost && events::is_relocalization(event) {
            self.relocalizations += 1;
        }
        let Some(what) = ReportKind::of(event) else { return };
        let (Some(sight), Some(account)) = (robot.sight(), robot.account()) else { return };
        let track_length = self.track.len();
        let is_choice = what == ReportKind::LocalizationAction;
        if let Some(scenes) = &mut self.scenes
            && TURNING_POINTS.contains(&what)
            && let Some(belief) = robot.belief()
        {
            let time_s = event.time_us as f64 / 1e6;
            let maxima = robot.maxima(LEAST_SHARE);
            let choice = if is_choice { robot.considered() } else { None };
            scenes.push(BeliefScene { what, time_s, belief, maxima, choice, sight, track_length });
        }
        if let Some(choices) = self.choices.as_mut().filter(|_| is_choice) {
            choices.extend(robot.localization().cloned());
        }
        self.incidents.push(Incident { what, sight, distance_m: account.distance_m, track_length });
    }
}

impl Onlooker for Observed {
    fn happened(&mut self, happened: &Happened<'_>, robot: &mut Robot) -> Result<()> {
        let logged = happened.told.iter().filter(|told| told.kind == LineKind::Log);
        self.logs.extend(logged.map(|told| told.text.clone()));
        happened.events.iter().for_each(|event| self.note(event, happened.is_lost, robot));
        Ok(())
    }

    fn seen(&mut self, _: u64, sight: &Sight, _: &mut Robot) -> Result<()> {
        self.track.push(*sight);
        Ok(())
    }
}
