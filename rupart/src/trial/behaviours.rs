//! Driving by behaviour cases: memories that are trained by forks, and how good what they retrieve is.

use super::drive::Trial;
use crate::beginning::{no_cases, open_space, tuned_alone};
use crate::case::{Case, Content, Kind};
use crate::control::{BehaviourParameters, CaseDrive, DriveEvent, State};
use crate::forgetting::{Capacity, forget_beyond};
use crate::memory::{CaseMemory, CaseNumber};
use crate::places::{PlaceId, Places};
use crate::route::Route;
use crate::routes::TravelTimes;
use crate::situation::Situation;
use rpl_random::Stream;
use rpl_robot::geometry::{Point, Pose, distance_m};
use rpl_robot::simulator::SimulatorModel;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::sync::Arc;

/// How long a fork is driven.
const FORK_S: f64 = 5.0;

/// The time from one retrieval of a case to the next on the way.
const RETRIEVAL_S: f64 = 3.0;

/// A retrieval is learned from or judged after driving for this time.
const LOOK_S: f64 = 6.0;

/// How much of the way a touch counts as lost.
const CONTACT_M: f64 = 5.0;

/// Parameters are kept if they get the robot farther than the retrieved ones by more than this.
const WORTH_M: f64 = 0.3;

/// Longer routes are driven by none of the trials.
const LONGEST_M: f64 = 45.0;

/// A drive has failed that takes longer than at this speed, and this time besides.
const SLOWEST_MPS: f64 = 0.2;
const GRACE_S: f64 = 30.0;

/// What a fork loses against the best, as a share of its way: up to these it is optimal, near-optimal, fair.
const REGRETS: [f64; 3] = [0.05, 0.15, 0.4];

/// How good a retrieved case is (Fox and Anderson-Sprecher, Case retrieval quality).
///
/// # Deviation
/// The paper judged by eye. Here all candidates are driven from the same state, and what counts is how much
/// less far the retrieved one gets than the best.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Quality {
    /// As good as the best.
    Optimal,
    /// Hardly worse.
    NearOptimal,
    /// Not the one to take.
    Fair,
    /// It does not get on.
    Poor,
}

impl Quality {
    /// All of them, the best first.
    pub const ALL: [Quality; 4] = [Self::Optimal, Self::NearOptimal, Self::Fair, Self::Poor];

    /// Of parameters that get the first distance, where the best get the second.
    fn of(gain_m: f64, best_m: f64) -> Self {
        let regret = if best_m > 0.0 { (best_m - gain_m) / best_m } else { 0.0 };
        let worse = REGRETS.iter().filter(|&&most| regret > most).count();
        Self::ALL[worse]
    }
}

/// How the robot of a trial is driven.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Driver {
    /// By the tuned parameters alone.
    Tuned,
    /// By nine cases made by hand.
    HandMade,
    /// By a memory that began with the tuned parameters and was trained on this number of drives.
    Learned(u32),
}

/// What came of a drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Driven {
    /// Whether the robot came to the end of the route.
    pub has_arrived: bool,
    /// How long it took.
    pub time_s: f64,
    /// How long the route is.
    pub length_m: f64,
    /// Touches that the robot caused.
    pub contacts: u32,
    /// How good what was retrieved on the way was, if that was asked for.
    pub qualities: Vec<Quality>,
    /// What the control did.
    pub course: Vec<CourseMoment>,
}

/// A moment of a drive, from which on something is other than before.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CourseMoment {
    /// Since the drive began.
    pub time_s: f64,
    /// The state of the control.
    pub state: State,
    /// The behaviour case it drives by.
    pub case: Option<CaseNumber>,
    /// Whether that was retrieved just then.
    pub has_retrieved: bool,
    /// Stops that are not reached yet.
    pub stops_left: usize,
}

impl CourseMoment {
    /// After a step in which this case was retrieved, if any was.
    fn after(trial: &Trial, begun_us: u64, found: Option<CaseNumber>, before: Option<&CourseMoment>) -> Self {
        Self {
            time_s: (trial.state.time_us - begun_us) as f64 / 1e6,
            state: trial.drive.state,
            case: found.or(before.and_then(|before| before.case)),
            has_retrieved: found.is_some(),
            stops_left: trial.way.len(),
        }
    }

    /// Whether all is as it was.
    fn says_nothing_new(&self, before: &CourseMoment) -> bool {
        !self.has_retrieved && (self.state, self.stops_left) == (before.state, before.stops_left)
    }
}

/// A building to drive in.
pub struct DrivingGround<'w> {
    /// The simulator.
    pub model: &'w Arc<SimulatorModel>,
    /// Its places.
    pub places: &'w Places,
}

/// The parameters that are tried: the tuned ones, and such as differ from them in one or two respects.
pub fn candidates() -> Vec<BehaviourParameters> {
    let tuned = BehaviourParameters::TUNED;
    let mut all = vec![tuned];
    for translation_mps in [0.25, 0.45, 0.7] {
        for avoid_distance_m in [0.2, 0.35, 0.6] {
            for (avoid_weight, escape_weight, to_goal_weight) in [(0.6, 0.4, 0.8), (0.2, 0.8, 0.8), (0.3, 0.2, 1.0)] {
                all.push(BehaviourParameters {
                    translation_mps,
                    avoid_distance_m,
                    avoid_weight,
                    escape_weight,
                    to_goal_weight,
                    ..tuned
                });
            }
        }
    }
    all
}

impl DrivingGround<'_> {
    /// The memory of a driver. Cost of a learned one: for each drive of its training some hundred seconds of
    /// simulation for each candidate.
    pub fn memory(&self, driver: Driver) -> CaseMemory {
        match driver {
            Driver::Tuned => tuned_alone(&self.model.world, &self.model.sensors),
            Driver::HandMade => self.hand_made(),
            Driver::Learned(drives) => self.learned(drives),
        }
    }

    /// Nine cases as one thinks of them: fast where all is open, slow and weighed to Escape where it is narrow.
    fn hand_made(&self) -> CaseMemory {
        let mut memory = no_cases(&self.model.world, &self.model.sensors);
        for (room_m, translation_mps, escape_weight) in [(4.0, 0.7, 0.1), (1.2, 0.45, 0.4), (0.5, 0.2, 0.9)] {
            for bearing_rad in [0.0, 1.2, -1.2] {
                let open = open_space(&self.model.world, &self.model.sensors);
                let near_m = open.sonars_m.as_ref().map(|free_m| vec![room_m; free_m.len()]);
                let index = Situation {
                    sonars_m: near_m.clone(),
                    mean_sonars_m: near_m,
                    short_term_goal_bearing_rad: Some(bearing_rad),
                    translation_mps: Some(translation_mps),
                    ..open
                };
                let content = BehaviourParameters { translation_mps, escape_weight, ..BehaviourParameters::TUNED };
                memory.retain(Case::new(index, Content::Behaviour(content)));
            }
        }
        memory
    }

    /// On each drive of the training the robot stops now and then, tries all candidates from where it is, and
    /// keeps the best where it beats what was retrieved, again with other noise.
    fn learned(&self, drives: u32) -> CaseMemory {
        let mut memory = tuned_alone(&self.model.world, &self.model.sensors);
        for seed in 0..u64::from(drives) {
            let Some((mut trial, until_us, _)) = self.begin(&mut Stream::new(seed, "training"), seed, true) else {
                continue;
            };
            let mut look = 0;
            while !trial.is_over() && trial.state.time_us < until_us {
                self.drive_on(&mut trial, &memory, LOOK_S, |_, _| ());
                if trial.is_over() {
                    break;
                }
                look += 1;
                self.learn(&mut memory, &trial, seed.wrapping_mul(1_000) + look);
            }
        }
        memory
    }

    pub(super) fn learn(&self, memory: &mut CaseMemory, trial: &Trial, noise: u64) {
        let situation = trial.situation();
        let Some((_, retrieved)) = retrieved(memory, &situation) else { return };
        let gains_m = |noise: u64| {
            let candidates = candidates();
            let gains_m: Vec<f64> =
                candidates.iter().map(|parameters| self.gain_m(trial, *parameters, noise)).collect();
            (candidates, gains_m)
        };
        let (candidates, gains_m) = gains_m(2 * noise);
        let Some(best) =
            (0..gains_m.len()).max_by(|&one, &other| gains_m[one].total_cmp(&gains_m[other]).then(other.cmp(&one)))
        else {
            return;
        };
        let beats =
            |noise: u64| self.gain_m(trial, candidates[best], noise) > self.gain_m(trial, retrieved, noise) + WORTH_M;
        if beats(2 * noise) && beats(2 * noise + 1) {
            memory.retain(Case::new(situation, Content::Behaviour(candidates[best])));
            forget_beyond(memory, Kind::Behaviour, Capacity::USUAL.behaviours, None);
        }
    }

    /// How much shorter the way to the goal is after some seconds with these parameters, with other noise.
    fn gain_m(&self, trial: &Trial, parameters: BehaviourParameters, noise: u64) -> f64 {
        let mut fork = trial.clone();
        fork.state.streams = self.model.start(noise).streams;
        let (before_m, contacts) = (fork.left_m(), fork.state.contacts.caused);
        let begun_us = fork.state.time_us;
        fork.drive_for(parameters, FORK_S);
        let left_s = FORK_S - (fork.state.time_us - begun_us) as f64 / 1e6;
        // Who is there earlier could have gone on.
        let ahead_m = if fork.is_over() { left_s.max(0.0) * parameters.translation_mps } else { 0.0 };
        before_m - fork.left_m() + ahead_m - CONTACT_M * f64::from(fork.state.contacts.caused - contacts)
    }

    /// Drives along a random route of the seed.
    pub fn drive(&self, memory: &CaseMemory, is_braked: bool, judges: bool, seed: u64) -> Option<Driven> {
        let (mut trial, until_us, length_m) = self.begin(&mut Stream::new(seed, "drives"), seed, is_braked)?;
        let begun_us = trial.state.time_us;
        let (mut qualities, mut course) = (Vec::new(), Vec::<CourseMoment>::new());
        while !trial.is_over() && trial.state.time_us < until_us {
            self.drive_on(&mut trial, memory, LOOK_S, |trial, found| {
                let moment = CourseMoment::after(trial, begun_us, found, course.last());
                if course.last().is_none_or(|before| !moment.says_nothing_new(before)) {
                    course.push(moment);
                }
            });
            if judges && !trial.is_over() {
                qualities.extend(self.judged(&trial, memory, seed));
            }
        }
        Some(Driven {
            has_arrived: trial.is_over(),
            time_s: (trial.state.time_us - begun_us) as f64 / 1e6,
            length_m,
            contacts: trial.state.contacts.caused,
            qualities,
            course,
        })
    }

    fn judged(&self, trial: &Trial, memory: &CaseMemory, noise: u64) -> Option<Quality> {
        let (_, retrieved) = retrieved(memory, &trial.situation())?;
        let gain_m = self.gain_m(trial, retrieved, noise);
        let others = candidates().into_iter().map(|parameters| self.gain_m(trial, parameters, noise));
        Some(Quality::of(gain_m, others.fold(gain_m, f64::max)))
    }

    /// Drives on by what is retrieved, every few seconds and at each new goal; `note` hears of each step, and of what was
    /// retrieved before it.
    fn drive_on(
        &self,
        trial: &mut Trial,
        memory: &CaseMemory,
        seconds: f64,
        mut note: impl FnMut(&Trial, Option<CaseNumber>),
    ) {
        let until_us = trial.state.time_us + (seconds * 1e6) as u64;
        let mut retrieve_us = trial.state.time_us;
        while !trial.is_over() && trial.state.time_us < until_us {
            let found = self.step_by(trial, memory, &mut retrieve_us);
            note(trial, found);
        }
    }

    /// One step, before which a case is retrieved if that is due; which one.
    pub(super) fn step_by(&self, trial: &mut Trial, memory: &CaseMemory, retrieve_us: &mut u64) -> Option<CaseNumber> {
        let is_due = trial.state.time_us >= *retrieve_us || trial.event == Some(DriveEvent::GoalReached);
        let found = if is_due { retrieved(memory, &trial.situation()) } else { None };
        if is_due {
            *retrieve_us = trial.state.time_us + (RETRIEVAL_S * 1e6) as u64;
        }
        if let Some((_, parameters)) = found {
            trial.drive.parameters = parameters;
        }
        trial.step();
        found.map(|(number, _)| number)
    }

    /// A random route from where the robot stands, until when it must be driven, and its length.
    fn begin(&self, stream: &mut Stream, seed: u64, is_braked: bool) -> Option<(Trial, u64, f64)> {
        let times = TravelTimes::of_map(self.places, 1.0);
        let count = self.places.count();
        let way = (0..100).find_map(|_| {
            let [from, to] = [stream.index(count), stream.index(count)].map(|place| PlaceId(place as u32));
            times.quickest_way(self.places, from, to).filter(|way| way.places.len() > 1 && way.cost <= LONGEST_M)
        })?;
        let points: Vec<Point> = way.places.iter().map(|&place| self.places.at_in_map(place)).collect();
        let length_m: f64 = points.windows(2).map(|two| distance_m(two[0], two[1])).sum();
        let waypoints = Route::over(&way.places).waypoints(self.places);
        let at = Pose::new(points[0].x, points[0].y, stream.uniform_in(-PI, PI));
        let drive = CaseDrive::new(BehaviourParameters::TUNED, is_braked);
        let trial = Trial::begin(self.model, seed, at, waypoints[1..].to_vec(), drive)?;
        let until_us = trial.state.time_us + allowed_us(length_m);
        Some((trial, until_us, length_m))
    }
}

/// How long a drive over such a way may take.
pub(super) fn allowed_us(length_m: f64) -> u64 {
    ((GRACE_S + length_m / SLOWEST_MPS) * 1e6) as u64
}

/// The most similar behaviour case, with its parameters.
fn retrieved(memory: &CaseMemory, situation: &Situation) -> Option<(CaseNumber, BehaviourParameters)> {
    let found = memory.retrieve(situation)?;
    let mut behaviours = std::iter::once(&found.best).chain(&found.runners_up);
    let best = behaviours.find(|found| found.kind == Kind::Behaviour)?;
    match &memory.get(best.number)?.content {
        Content::Behaviour(parameters) => Some((best.number, *parameters)),
        Content::Route(_) | Content::Goal(_) | Content::MetaPlan(_) => None,
    }
}
