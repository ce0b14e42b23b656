//! Days of errands: what a robot that delivers in a building learns from one day to the next.

use super::behaviours::{DrivingGround, allowed_us};
use super::drive::Trial;
use crate::beginning::{to_be_trained, tuned_alone};
use crate::case::Kind;
use crate::control::{BehaviourParameters, CaseDrive, DriveEvent};
use crate::forgetting::{Capacity, forget_beyond};
use crate::memory::{CaseMemory, CaseNumber};
use crate::places::PlaceId;
use crate::routes::{Guidance, Route, RouteProblem, Stop, TravelTimes, adapt_guided, learn_route, learn_times};
use rpl_random::Stream;
use rpl_robot::avoidance::DriveLimits;
use rpl_robot::geometry::{Pose, distance_m};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Errands of a day.
const ERRANDS: u32 = 100;

/// At night behaviours are trained for so many moments of the day, besides those where the robot got no further.
const TRAINED_MOMENTS: usize = 12;

/// An errand, and how it went.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Errand {
    /// Whether the robot came to the end of the route.
    pub has_arrived: bool,
    /// How long it took.
    pub time_s: f64,
    /// The length of the shortest way.
    pub length_m: f64,
    /// Touches that the robot caused.
    pub contacts: u32,
}

/// A day of errands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Day {
    /// In their order.
    pub errands: Vec<Errand>,
    /// Cases at its end, before the night.
    pub cases: usize,
}

/// What a day leaves for the night.
#[derive(Default)]
struct Evening {
    /// Moments on the way.
    moments: Vec<Trial>,
    /// Where the robot got no further, with the meta-plan that says so.
    stuck: Vec<(Trial, CaseNumber)>,
}

impl DrivingGround<'_> {
    /// The days of a robot that begins with the tuned parameters and no route: by day it drives its errands and keeps
    /// routes and the times they took; at night the experimenter trains behaviours, where meta-plans ask for it and
    /// for some moments of the day. Cost: some seconds of computing for each day and errand.
    pub fn days(&self, count: u32, seed: u64) -> Vec<Day> {
        let mut memory = tuned_alone(&self.model.world, &self.model.sensors);
        let mut stream = Stream::new(seed, "days");
        let mut at = self.places.closest(self.model.world.start_in_map.point());
        let mut days = Vec::new();
        for _ in 0..count {
            let mut evening = Evening::default();
            let mut errands = Vec::new();
            for _ in 0..ERRANDS {
                let to = PlaceId(stream.index(self.places.count()) as u32);
                let noise = noise(&mut stream);
                if let Some(errand) = self.errand(&mut memory, &mut stream, (at, to), noise, &mut evening) {
                    errands.push(errand);
                    // Whoever asked for it fetches a robot that got stuck.
                    at = to;
                }
            }
            days.push(Day { errands, cases: memory.len() });
            self.train(&mut memory, evening, &mut stream);
        }
        days
    }

    /// One errand; none if there is no way, or somebody stands where it begins.
    fn errand(
        &self,
        memory: &mut CaseMemory,
        stream: &mut Stream,
        (from, to): (PlaceId, PlaceId),
        noise: u64,
        evening: &mut Evening,
    ) -> Option<Errand> {
        let length_m = TravelTimes::of_map(self.places, 1.0).quickest_way(self.places, from, to)?.cost;
        let mut route = self.route(memory, from, to).filter(|route| route.stops.len() > 1)?;
        let points: Vec<_> = route.stops.iter().map(|stop| stop.at_in_map(self.places)).collect();
        let start_in_map = Pose::new(points[0].x, points[0].y, stream.uniform_in(-PI, PI));
        let drive = CaseDrive::new(BehaviourParameters::TUNED, true);
        let mut trial =
            Trial::begin(self.model, noise, start_in_map, route.waypoints(self.places)[1..].to_vec(), drive)?;
        let begun_us = trial.state.time_us;
        let until_us = begun_us + allowed_us(points.windows(2).map(|two| distance_m(two[0], two[1])).sum());
        // One moment of the way is remembered, each as likely as any other.
        let (mut retrieve_us, mut left_us, mut step, mut moments) = (begun_us, begun_us, 0, 0);
        let (mut moment, mut used) = (None, None);
        while !trial.is_over() && trial.state.time_us < until_us {
            let is_due = trial.state.time_us >= retrieve_us;
            if is_due {
                moments += 1;
                if stream.index(moments) == 0 {
                    moment = Some(trial.clone());
                }
            }
            used = self.step_by(&mut trial, memory, &mut retrieve_us).or(used);
            if trial.event == Some(DriveEvent::GoalReached) {
                note_use(memory, used, true);
                route.times_s[step] = Some((trial.state.time_us - left_us) as f64 / 1e6);
                (step, left_us) = (step + 1, trial.state.time_us);
            }
        }
        evening.moments.extend(moment);
        let errand = Errand {
            has_arrived: trial.is_over(),
            time_s: (trial.state.time_us - begun_us) as f64 / 1e6,
            length_m,
            contacts: trial.state.contacts.caused,
        };
        if errand.has_arrived {
            self.keep(memory, route);
        } else {
            note_use(memory, used, false);
            let number = memory.retain(to_be_trained(trial.situation()));
            evening.stuck.push((trial, number));
        }
        Some(errand)
    }

    /// As a robot makes its routes: of remembered ones, by the times that are known.
    fn route(&self, memory: &CaseMemory, from: PlaceId, to: PlaceId) -> Option<Route> {
        let times = self.times(memory);
        let problem = RouteProblem::new(self.places, &times, Stop::Known(from), Stop::Known(to));
        let adapted = adapt_guided(self.places, &times, &problem, memory.routes(), Guidance::USUAL)?;
        Some(Route::new(adapted.route.stops))
    }

    /// How long stretches take, as far as it remembers.
    fn times(&self, memory: &CaseMemory) -> TravelTimes {
        let speed_mps = DriveLimits::of(self.model.robot()).hallway_mps;
        TravelTimes::of_routes(self.places, speed_mps, memory.routes().map(|(_, route)| route))
    }

    /// As a robot keeps its routes.
    fn keep(&self, memory: &mut CaseMemory, driven: Route) {
        learn_times(memory, &driven);
        if memory.routes().all(|(_, known)| driven.steps_beyond(known) > 0) {
            learn_route(memory, self.places, driven);
            let times = self.times(memory);
            forget_beyond(memory, Kind::Route, Capacity::USUAL.routes, Some((self.places, &times)));
        }
    }

    fn train(&self, memory: &mut CaseMemory, evening: Evening, stream: &mut Stream) {
        let Evening { mut moments, stuck } = evening;
        for (trial, number) in stuck {
            memory.forget(number);
            self.learn(memory, &trial, noise(stream));
        }
        for _ in 0..TRAINED_MOMENTS.min(moments.len()) {
            let trial = moments.swap_remove(stream.index(moments.len()));
            self.learn(memory, &trial, noise(stream));
        }
    }
}

/// The behaviour case in use has brought the robot to its short-term goal, or not.
fn note_use(memory: &mut CaseMemory, used: Option<CaseNumber>, succeeded: bool) {
    if let Some(number) = used {
        memory.change(number, |case| case.counts.note(succeeded));
    }
}

/// The seed of a simulation.
fn noise(stream: &mut Stream) -> u64 {
    stream.index(1 << 40) as u64
}
