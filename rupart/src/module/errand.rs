//! A route that is driven.

use crate::control::{CaseDrive, DriveEvent, DriveGoal};
use crate::memory::CaseNumber;
use crate::places::{PlaceId, Places};
use crate::routes::{Route, Stop};
use rpl_robot::geometry::{Point, Pose, Velocity};
use rpl_robot::office::Moment;
use rpl_runtime::robot::Ending;
use serde::{Deserialize, Serialize};

/// A route that is driven.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Errand {
    /// With the times of the steps that were driven so far.
    pub route: Route,
    /// How it was made, if it is one that was.
    pub made: Option<Made>,
    /// Where its stops are.
    stops_in_map: Vec<Point>,
    /// What they are called; none where they are coordinates.
    names: Vec<Option<String>>,
    /// The stop it is driving to.
    next: usize,
    /// How long it has been driving there.
    step_s: f64,
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
        let stops_in_map = route.stops.iter().map(|stop| stop.at_in_map(places)).collect();
        let name = |stop: &Stop| stop.known().map(|place| places.name(place).to_string());
        let names = route.stops.iter().map(name).collect();
        Self { route, made, stops_in_map, names, next: 0, step_s: 0.0, patience_s }
    }

    /// The short-term goal.
    pub fn next_in_map(&self) -> Option<Point> {
        self.stops_in_map.get(self.next).copied()
    }

    /// What the short-term goal is called, if it is a known place.
    pub fn next_name(&self) -> Option<&str> {
        self.names.get(self.next)?.as_deref()
    }

    /// The long-term goal.
    pub fn last_in_map(&self) -> Option<Point> {
        self.stops_in_map.last().copied()
    }

    /// The known place it was at last.
    pub fn before(&self) -> Option<PlaceId> {
        self.route.stops.get(self.next.checked_sub(1)?)?.known()
    }

    /// The route from the short-term goal on.
    pub fn rest(&self) -> Route {
        self.route.part(self.next, self.route.stops.len() - 1)
    }

    /// What was driven of it, if it is given up on the way from one known place to the next; that took so long, and
    /// takes so much longer from here.
    pub fn given_up(&self, longer_s: f64) -> Option<Route> {
        self.before()?;
        self.route.stops[self.next].known()?;
        let mut driven = self.route.part(0, self.next);
        driven.times_s[self.next - 1] = Some(self.step_s + longer_s);
        Some(driven)
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
        let goal = self.next_in_map().map(|goal_in_map| DriveGoal {
            in_base: estimated_in_map.inverse().transform(goal_in_map),
            reached_m: self.route.reached_m(places, self.next),
            is_last: self.next + 1 == self.stops_in_map.len(),
        });
        self.step_s += limits.step_s;
        let mut step = drive.step(limits, &now.input(), goal);
        step.velocity.translation_mps = step.velocity.translation_mps.min(limits.speed_limit_mps(now.mode));
        if step.event == Some(DriveEvent::GoalReached) {
            self.pass(drive);
            let ending = (self.next == self.stops_in_map.len()).then_some(Ending::Success);
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

    /// The short-term goal is reached. How long the way to the first took tells of no step.
    fn pass(&mut self, drive: &mut CaseDrive) {
        if self.next > 0 {
            self.route.times_s[self.next - 1] = Some(self.step_s);
        }
        self.next += 1;
        self.step_s = 0.0;
        if self.next < self.stops_in_map.len() {
            drive.begin_goal();
        }
    }
}
