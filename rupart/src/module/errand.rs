//! A route that is driven.

use crate::control::{CaseDrive, DriveEvent, DriveGoal};
use crate::memory::CaseNumber;
use crate::places::Places;
use crate::route::{Route, Stop};
use crate::routes::Underway;
use rpl_robot::geometry::{Point, Pose, Velocity};
use rpl_robot::office::Moment;
use rpl_runtime::robot::Ending;
use serde::{Deserialize, Serialize};

/// A route that is driven.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Errand {
    /// How far it has come.
    pub underway: Underway,
    /// How it was made, if it is one that was.
    pub made: Option<Made>,
    /// What its stops are called; none where they are coordinates.
    names: Vec<Option<String>>,
    patience_s: f64,
}

/// How a route was made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Made {
    /// The route, as it is driven.
    pub stops: Vec<Stop>,
    /// The case it was made from; none if it was made from scratch.
    pub case: Option<CaseNumber>,
    /// Whether what came of that case was poor, and the route made anew.
    pub is_repaired: bool,
    /// What is to be remembered instead of the route as it is driven.
    pub to_keep: Option<Route>,
    /// From where it was asked for ...
    pub start_in_map: Point,
    /// ... to where.
    pub goal_in_map: Point,
}

/// What became of it in a step.
pub(super) struct ErrandStep {
    pub velocity: Velocity,
    /// If it is over.
    pub ending: Option<Ending>,
    /// Whether there is another short-term goal.
    pub has_news: bool,
    /// What happened to the drive.
    pub event: Option<DriveEvent>,
}

impl Errand {
    pub fn begin(route: Route, made: Option<Made>, places: &Places, patience_s: f64) -> Self {
        let name = |stop: &Stop| stop.known().map(|place| places.name(place).to_string());
        let names = route.stops.iter().map(name).collect();
        Self { underway: Underway::begin(route, places), made, names, patience_s }
    }

    /// What the short-term goal is called, if it is a known place.
    pub fn next_name(&self) -> Option<&str> {
        self.names.get(self.underway.next())?.as_deref()
    }

    /// One step.
    pub fn step(
        &mut self,
        drive: &mut CaseDrive,
        now: &Moment<'_>,
        estimated_in_map: Pose,
        places: &Places,
    ) -> ErrandStep {
        let limits = &now.model.limits;
        let goal = self.underway.next_in_map().map(|goal_in_map| DriveGoal {
            in_base: estimated_in_map.inverse().transform(goal_in_map),
            reached_m: self.underway.route.reached_m(places, self.underway.next()),
            is_last: self.underway.is_at_last(),
        });
        self.underway.note_time(limits.step_s);
        let mut step = drive.step(limits, &now.input(), goal);
        step.velocity.translation_mps = step.velocity.translation_mps.min(limits.speed_limit_mps(now.mode));
        if step.event == Some(DriveEvent::GoalReached) {
            self.underway.pass();
            if !self.underway.is_over() {
                drive.begin_goal();
            }
            let ending = self.underway.is_over().then_some(Ending::DONE);
            return ErrandStep { velocity: step.velocity, ending, has_news: true, event: step.event };
        }
        let is_blocked = drive.progress.idle_s() > self.patience_s;
        let ending = is_blocked.then(|| {
            let at = estimated_in_map;
            let patience_s = self.patience_s;
            let message = format!(
                "for {patience_s} s the robot got no nearer to its short-term goal; it is at {:.1} {:.1}",
                at.x_m, at.y_m
            );
            Ending::failure("blocked", message)
        });
        ErrandStep { velocity: step.velocity, ending, has_news: false, event: step.event }
    }
}
