//! A run in a building, looked at from outside.

use super::certainty::{CertaintyCell, CertaintyCounts};
use crate::trial::{WRONG_ESTIMATE_M, described, is_right, off_m};
use rpl_mission::robot::Robot;
use rpl_mission::run::{Reached, run_to};
use rpl_mission::sight::Sight;
use rpl_robot::geometry::Pose;
use rpl_robot::office::ReportKind;
use rpl_robot::world::Place;
use rpl_runtime::run::system::{Outcome, System};
use rpl_runtime::state::output::Channel;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow::{self, Continue};

/// How often the estimate is compared with the truth.
const LOOK_US: u64 = 100_000;

/// That the robot was turned or carried must be noticed on this way.
pub const NOTICED_WITHIN_M: f64 = 3.0;

/// A robot that says it has arrived and is farther off is at the wrong place.
pub const WRONG_PLACE_M: f64 = 1.0;

/// With a larger share near the estimate than this dead reckoning blurs nothing.
const SHARP: f64 = 0.98;

/// With more than this a robot is certainly not lost.
const TRACKING: f64 = 0.95;

/// How the plan says that it has arrived, and that it was blocked.
const ARRIVED: &str = "arrived at ";
const BLOCKED: &str = "blocked";

/// What came of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BuildingTrial {
    /// Its seed.
    pub seed: u64,
    /// Why the run counts for nothing: its scenario failed.
    pub unmeasured: Option<String>,
    /// Why the plan did not succeed, its class first; none if it has arrived.
    pub fault: Option<String>,
    /// How far the robot really was from the last place at the end.
    pub off_m: f64,
    /// How often the plan said that it was at a place ...
    pub arrivals: usize,
    /// ... and was more than [`WRONG_PLACE_M`] off.
    pub wrong_arrivals: usize,
    /// How often the position counted as lost ...
    pub losses: u32,
    /// ... and the estimate was right.
    pub false_losses: u32,
    /// How often the position counted as found, and was more than [`WRONG_ESTIMATE_M`] off.
    pub wrong_recoveries: u32,
    /// How often the way was blocked.
    pub blocked: u32,
    /// Contacts the robot caused.
    pub contacts: u32,
    /// Driven.
    pub way_m: f64,
    /// Until the end.
    pub time_s: f64,
    /// None of a run in which nobody took the robot into his hands.
    pub by_hand: Option<ByHand>,
    /// What it said of its position, ten times a second.
    pub certainty: Vec<CertaintyCell>,
    /// The same while no dead reckoning blurred it.
    pub tracking: Vec<CertaintyCell>,
    /// What it said of the share that dead reckoning left near the estimate, while it was not lost.
    pub reckoning: Vec<CertaintyCell>,
}

/// What became of a robot that somebody turned or carried.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ByHand {
    /// Whether it took itself to be lost when that happened.
    was_lost: bool,
    /// Driven until it took itself to be lost, or its estimate was right again.
    noticed_m: Option<f64>,
    /// Driven since.
    way_m: f64,
    /// Whether its estimate is right at the end, and it does not take itself to be lost.
    pub is_found: bool,
}

impl ByHand {
    /// Whether it was noticed soon; none if the robot was lost anyway, or the run ended sooner.
    pub fn is_noticed(&self) -> Option<bool> {
        match self.noticed_m {
            _ if self.was_lost => None,
            Some(noticed_m) => Some(noticed_m <= NOTICED_WITHIN_M),
            None => (self.way_m > NOTICED_WITHIN_M).then_some(false),
        }
    }
}

impl BuildingTrial {
    /// Whether the run counts.
    pub fn is_measured(&self) -> bool {
        self.unmeasured.is_none()
    }

    /// Whether the plan has arrived, wherever the robot is.
    pub fn has_arrived(&self) -> bool {
        self.fault.is_none() && self.is_measured()
    }

    /// Whether it has, and the robot really is so near to the place.
    pub fn is_within(&self, reach_m: f64) -> bool {
        self.has_arrived() && self.off_m <= reach_m
    }

    /// Moments at which the robot was sure of its position and right, and at which it was sure.
    pub fn sure(&self) -> (usize, usize) {
        let sure = self.certainty.iter().filter(|cell| cell.is_sure());
        sure.fold((0, 0), |sum, cell| (sum.0 + cell.right, sum.1 + cell.looks))
    }

    /// What [`BuildingTrial::line`] has.
    pub const HEAD: &str = "row,seed,arrived,fault,off_m,arrivals,wrong_arrivals,losses,false_losses,\
                            wrong_recoveries,blocked,contacts,way_m,time_s,sure,sure_right,noticed_m,found";

    /// As comma-separated values.
    pub fn line(&self, row: &str) -> String {
        let Self { seed, off_m, arrivals, wrong_arrivals, losses, false_losses, wrong_recoveries, .. } = self;
        let Self { blocked, contacts, way_m, time_s, .. } = self;
        let unmeasured = self.unmeasured.as_ref().map(|why| format!("not measured: {why}"));
        let fault = self.fault.clone().or(unmeasured).unwrap_or_default().replace('"', "'");
        let (right, sure) = self.sure();
        let noticed = self.by_hand.and_then(|by_hand| by_hand.noticed_m);
        let noticed = noticed.map_or(String::new(), |noticed_m| format!("{noticed_m:.2}"));
        let found = self.by_hand.map_or(String::new(), |by_hand| by_hand.is_found.to_string());
        format!(
            "\"{row}\",{seed},{},\"{fault}\",{off_m:.2},{arrivals},{wrong_arrivals},{losses},{false_losses},\
             {wrong_recoveries},{blocked},{contacts},{way_m:.1},{time_s:.1},{sure},{right},{noticed},{found}\n",
            self.has_arrived()
        )
    }

    /// Drives a run to its end, or up to a time, and looks at it.
    pub fn of(mut system: System<Robot>, seed: u64, places: &[Place], until_us: u64) -> Self {
        let mut watcher = Watcher {
            places,
            due_us: 0,
            is_lost: false,
            since_m: None,
            certainty: CertaintyCounts::default(),
            tracking: CertaintyCounts::default(),
            reckoning: CertaintyCounts::default(),
            trial: Self { seed, ..Self::default() },
        };
        let reached = run_to(&mut system, until_us, |system| watcher.look(system));
        watcher.trial_of(&system, reached)
    }
}

/// Who looks at a run.
struct Watcher<'p> {
    places: &'p [Place],
    due_us: u64,
    is_lost: bool,
    /// Driven when somebody took the robot into his hands.
    since_m: Option<f64>,
    certainty: CertaintyCounts,
    tracking: CertaintyCounts,
    reckoning: CertaintyCounts,
    trial: BuildingTrial,
}

impl Watcher<'_> {
    fn look(&mut self, system: &mut System<Robot>) -> ControlFlow<()> {
        let (events, output) = (system.machine.trace.take(), std::mem::take(&mut system.machine.output));
        let outside = &system.outside;
        let (Some(sight), Some(tracking), Some(account)) = (outside.sight(), outside.tracking(), outside.account())
        else {
            return Continue(());
        };
        for line in output.iter().filter(|line| line.channel == Channel::Log) {
            self.hear(&line.text, &sight);
        }
        self.trial.way_m = account.distance_m;
        let was_lost = self.is_lost;
        let mut in_hand = false;
        for kind in events.iter().filter_map(ReportKind::of) {
            match kind {
                ReportKind::PositionLost => {
                    self.is_lost = true;
                    self.trial.losses += 1;
                    self.trial.false_losses += u32::from(is_right(&sight));
                }
                ReportKind::PositionFound => {
                    self.is_lost = false;
                    self.trial.wrong_recoveries += u32::from(off_m(&sight) > WRONG_ESTIMATE_M);
                }
                kind if kind.is_by_hand() => {
                    in_hand = true;
                    self.since_m = Some(account.distance_m);
                    self.trial.by_hand = Some(ByHand { was_lost, noticed_m: None, way_m: 0.0, is_found: false });
                }
                _ => {}
            }
        }
        if let (Some(since_m), Some(by_hand)) = (self.since_m, &mut self.trial.by_hand) {
            by_hand.way_m = account.distance_m - since_m;
            // At first the robot has perceived nothing of it yet.
            if !in_hand && by_hand.noticed_m.is_none() && (self.is_lost || is_right(&sight)) {
                by_hand.noticed_m = Some(by_hand.way_m);
            }
        }
        if system.machine.now_us >= self.due_us {
            self.due_us = system.machine.now_us + LOOK_US;
            let (sharp, is_right) = (sight.certainty / tracking.max(f64::MIN_POSITIVE), is_right(&sight));
            self.certainty.add(sight.certainty, is_right);
            if sharp >= SHARP {
                self.tracking.add(tracking, is_right);
            } else if tracking >= TRACKING {
                self.reckoning.add(sharp, is_right);
            }
        }
        Continue(())
    }

    /// What the plan says of its way.
    fn hear(&mut self, text: &str, sight: &Sight) {
        if let Some(name) = text.strip_prefix(ARRIVED)
            && let Some(place) = self.places.iter().find(|place| place.name == name)
        {
            self.trial.arrivals += 1;
            self.trial.wrong_arrivals += usize::from(away_m(sight, place.pose_in_map) > WRONG_PLACE_M);
        }
        self.trial.blocked += u32::from(text.starts_with(BLOCKED));
    }

    fn trial_of(self, system: &System<Robot>, reached: Reached) -> BuildingTrial {
        let failed = system.outside.failed_scenario();
        let unmeasured = failed.map(|(scenario, failure)| described(&scenario.machine, &scenario.program, failure));
        let fault = match reached {
            Reached::End(Outcome::Succeeded(_)) => None,
            Reached::End(Outcome::Failed(failure)) => Some(described(&system.machine, &system.program, failure)),
            Reached::End(Outcome::Evaporated) => Some("ended itself".to_string()),
            Reached::Time | Reached::Stop => Some("time is up".to_string()),
        };
        let (sight, is_lost) = (system.outside.sight(), self.is_lost);
        let goal = self.places.last().map(|place| place.pose_in_map);
        let is_found = sight.as_ref().is_some_and(|sight| is_right(sight) && !is_lost);
        BuildingTrial {
            unmeasured,
            fault,
            off_m: sight.zip(goal).map_or(0.0, |(sight, goal)| away_m(&sight, goal)),
            contacts: system.outside.account().and_then(|account| account.contacts).unwrap_or(0),
            time_s: system.machine.now_s(),
            by_hand: self.trial.by_hand.map(|by_hand| ByHand { is_found, ..by_hand }),
            certainty: self.certainty.cells(),
            tracking: self.tracking.cells(),
            reckoning: self.reckoning.cells(),
            ..self.trial
        }
    }
}

/// How far the robot really is from a pose.
fn away_m(sight: &Sight, pose_in_map: Pose) -> f64 {
    sight.robot_in_map.map_or(0.0, |robot_in_map| robot_in_map.distance_m(pose_in_map))
}
