//! Days of errands: what a robot that delivers in a building learns from one day to the next.

use super::behaviours::{DrivingGround, allowed_us};
use super::drive::Trial;
use crate::beginning::{to_be_trained, tuned_alone};
use crate::case::Kind;
use crate::control::{BLOCKED_S, BehaviourParameters, CaseDrive, DriveEvent};
use crate::forgetting::{Capacity, forget_beyond};
use crate::memory::{CaseMemory, CaseNumber};
use crate::places::{PlaceId, Places};
use crate::route::{Route, Stop};
use crate::routes::{
    Blockage, BlockedAt, Guidance, RouteProblem, TravelTimes, Underway, adapt_guided, learn_route, learn_times,
};
use rpl_random::Stream;
use rpl_robot::avoidance::DriveLimits;
use rpl_robot::geometry::{Pose, distance_m};
use rpl_robot::navigation::NavigationModel;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Errands of a day.
const ERRANDS: u32 = 100;

/// The number of moments of the day for which behaviours are trained at night, besides those where the robot got no
/// further.
const TRAINED_MOMENTS: usize = 12;

/// How often it is given another route, as `go-by-cases` does, before it counts as failed.
const OTHER_ROUTES: u32 = 2;

/// An errand, and how it went.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Errand {
    /// How it ended.
    pub ending: ErrandEnding,
    /// How often the robot got no further on a route.
    pub blocked: u32,
    /// How long it took.
    pub time_s: f64,
    /// The length of the shortest way.
    pub length_m: f64,
    /// Touches that the robot caused.
    pub contacts: u32,
}

impl Errand {
    /// Whether the robot came to its goal.
    pub fn has_arrived(&self) -> bool {
        self.ending == ErrandEnding::Arrived
    }
}

/// How an errand ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ErrandEnding {
    /// The robot came to its goal.
    Arrived,
    /// It got no further on its last route, either.
    Blocked,
    /// Its time was over.
    TooLate,
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

/// An errand that is driven.
struct Driving {
    underway: Underway,
    /// What is to be remembered instead of the route as it is driven.
    to_keep: Option<Route>,
    blockage: Blockage,
    blocked: u32,
    /// The behaviour case in use.
    used: Option<CaseNumber>,
}

/// What is where the days are spent.
pub struct DayGround<'w> {
    /// To drive in.
    pub driving: DrivingGround<'w>,
    /// The map, for ways round what blocks a route.
    pub navigation: &'w NavigationModel,
}

impl DayGround<'_> {
    /// The days of a robot that begins with the tuned parameters and no route: by day it drives its errands, takes
    /// another route where it gets no further, and keeps routes and the times they took; at night the experimenter
    /// trains behaviours, where meta-plans ask for it and for some moments of the day. Cost: some seconds of computing
    /// for each day and errand.
    pub fn days(&self, count: u32, seed: u64) -> Vec<Day> {
        let DrivingGround { model, places } = self.driving;
        let mut memory = tuned_alone(&model.world, &model.sensors);
        let mut stream = Stream::new(seed, "days");
        let mut at = places.closest(model.world.start_in_map.point());
        let mut days = Vec::new();
        for _ in 0..count {
            let mut evening = Evening::default();
            let mut errands = Vec::new();
            for _ in 0..ERRANDS {
                let to = PlaceId(stream.index(places.count()) as u32);
                let noise = noise(&mut stream);
                if let Some(errand) = self.errand(&mut memory, &mut stream, (at, to), noise, &mut evening) {
                    errands.push(errand);
                    // Whoever asked for it fetches a robot that did not come.
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
        let DrivingGround { model, places } = self.driving;
        let length_m = TravelTimes::of_map(places, 1.0).quickest_way(places, from, to)?.cost;
        let route = self.route(memory, Stop::Known(from), to).filter(|route| route.stops.len() > 1)?;
        let points: Vec<_> = route.stops.iter().map(|stop| stop.at_in_map(places)).collect();
        let start_in_map = Pose::new(points[0].x, points[0].y, stream.uniform_in(-PI, PI));
        let drive = CaseDrive::new(BehaviourParameters::TUNED, true);
        let mut trial = Trial::begin(model, noise, start_in_map, route.waypoints(places)[1..].to_vec(), drive)?;
        let mut driving = Driving::along(route, places);
        driving.underway.pass();
        let begun_us = trial.state.time_us;
        let until_us = begun_us + allowed_us(points.windows(2).map(|two| distance_m(two[0], two[1])).sum());
        // One moment of the way is remembered, each as likely as any other.
        let (mut retrieve_us, mut moments, mut moment) = (begun_us, 0, None);
        let ending = loop {
            if trial.is_over() {
                break ErrandEnding::Arrived;
            }
            if trial.state.time_us >= until_us {
                break ErrandEnding::TooLate;
            }
            if trial.state.time_us >= retrieve_us {
                moments += 1;
                if stream.index(moments) == 0 {
                    moment = Some(trial.clone());
                }
            }
            driving.used = self.driving.step_by(&mut trial, memory, &mut retrieve_us).or(driving.used);
            driving.underway.note_time(DriveLimits::of(model.robot()).step_s);
            if trial.event == Some(DriveEvent::GoalReached) {
                note_use(memory, driving.used, true);
                driving.underway.pass();
            }
            if trial.drive.progress.idle_s() > BLOCKED_S {
                self.note_blocked(memory, &mut driving, &trial, evening);
                if driving.blocked > OTHER_ROUTES || !self.take_other_route(memory, &mut driving, &mut trial, to) {
                    break ErrandEnding::Blocked;
                }
                retrieve_us = trial.state.time_us;
            }
        };
        evening.moments.extend(moment);
        match ending {
            ErrandEnding::Arrived => self.keep(memory, driving.underway.route, driving.to_keep),
            ErrandEnding::TooLate => note_use(memory, driving.used, false),
            ErrandEnding::Blocked => {}
        }
        Some(Errand {
            ending,
            blocked: driving.blocked,
            time_s: (trial.state.time_us - begun_us) as f64 / 1e6,
            length_m,
            contacts: trial.state.contacts.caused,
        })
    }

    /// As a robot notes that it got no further.
    fn note_blocked(&self, memory: &mut CaseMemory, driving: &mut Driving, trial: &Trial, evening: &mut Evening) {
        note_use(memory, driving.used, false);
        driving.blocked += 1;
        let at = BlockedAt {
            planner: &self.navigation.planner,
            places: self.driving.places,
            times: &self.times(memory),
            robot_radius_m: self.navigation.limits.robot_radius_m,
            robot_in_map: trial.state.robot_in_map.point(),
            heard_in_map: trial.heard_in_map(),
        };
        if let Some(driven) = driving.blockage.note(&driving.underway, at) {
            self.keep(memory, driven, None);
        }
        let number = memory.retain(to_be_trained(trial.situation()));
        evening.stuck.push((trial.clone(), number));
    }

    /// As `adapt-route` makes one for a robot that was blocked: round what blocks it, or from where it stands. Whether
    /// there is any.
    fn take_other_route(&self, memory: &CaseMemory, driving: &mut Driving, trial: &mut Trial, to: PlaceId) -> bool {
        let here_in_map = trial.state.robot_in_map.point();
        let (route, to_keep) = match driving.blockage.detour(here_in_map, to) {
            Some(detour) => (Some(detour.route.clone()), detour.to_keep.clone()),
            None => (self.route(memory, Stop::At(here_in_map), to).map(Route::from_here), None),
        };
        let Some(route) = route else { return false };
        trial.go_on_along(route.waypoints(self.driving.places));
        driving.underway = Underway::begin(route, self.driving.places);
        driving.to_keep = to_keep;
        true
    }

    /// As a robot makes its routes: of remembered ones, by the times that are known.
    fn route(&self, memory: &CaseMemory, from: Stop, to: PlaceId) -> Option<Route> {
        let (places, times) = (self.driving.places, self.times(memory));
        let problem = RouteProblem::new(places, &times, from, Stop::Known(to));
        let adapted = adapt_guided(places, &times, &problem, memory.routes(), Guidance::USUAL)?;
        Some(Route::new(adapted.route.stops))
    }

    /// How long stretches take, as far as it remembers.
    fn times(&self, memory: &CaseMemory) -> TravelTimes {
        let speed_mps = self.navigation.limits.hallway_mps;
        TravelTimes::of_routes(self.driving.places, speed_mps, memory.routes().map(|(_, route)| route))
    }

    /// As a robot keeps its routes: that which was driven, or another for it.
    fn keep(&self, memory: &mut CaseMemory, driven: Route, instead: Option<Route>) {
        let places = self.driving.places;
        learn_times(memory, &driven);
        let route = instead.unwrap_or(driven);
        if route.stops.len() > 1 && memory.routes().all(|(_, known)| route.steps_beyond(known) > 0) {
            learn_route(memory, places, route);
            let times = self.times(memory);
            forget_beyond(memory, Kind::Route, Capacity::USUAL.routes, Some((places, &times)));
        }
    }

    fn train(&self, memory: &mut CaseMemory, evening: Evening, stream: &mut Stream) {
        let Evening { mut moments, stuck } = evening;
        for (trial, number) in stuck {
            memory.forget(number);
            self.driving.learn(memory, &trial, noise(stream));
        }
        for _ in 0..TRAINED_MOMENTS.min(moments.len()) {
            let trial = moments.swap_remove(stream.index(moments.len()));
            self.driving.learn(memory, &trial, noise(stream));
        }
    }
}

impl Driving {
    fn along(route: Route, places: &Places) -> Self {
        Self {
            underway: Underway::begin(route, places),
            to_keep: None,
            blockage: Blockage::default(),
            blocked: 0,
            used: None,
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

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_robot::description::RobotDescription;
    use rpl_robot::simulator::{SimulatorModel, SimulatorSettings};
    use rpl_robot::world::World;
    use std::sync::Arc;

    /// Two halves, with an opening below and one above; `more` stands there and is in no map.
    fn halves(more: &str) -> World {
        let text = format!(
            "name = \"halves\"\nsize = [10.0, 6.0]\nstart = [1.5, 1.6, 0]\n\
             [[wall]]\nline = [[0.1, 0.1], [9.9, 0.1], [9.9, 5.9], [0.1, 5.9], [0.1, 0.1]]\n\
             [[wall]]\nline = [[5.0, 0.1], [5.0, 0.9]]\n[[wall]]\nline = [[5.0, 2.3], [5.0, 3.7]]\n\
             [[wall]]\nline = [[5.0, 5.1], [5.0, 5.9]]\n{more}\
             [[place]]\nname = \"west\"\npose = [1.5, 1.6, 0]\n[[place]]\nname = \"east\"\npose = [8.5, 1.6, 0]\n\
             [[place]]\nname = \"north-west\"\npose = [1.5, 4.4, 0]\n[[place]]\nname = \"north-east\"\npose = [8.5, 4.4, 0]\n"
        );
        World::parse(&text, "halves.toml").unwrap_or_else(|faults| panic!("{faults}"))
    }

    #[test]
    fn who_is_blocked_takes_another_route_and_the_next_errand_is_not() {
        let robot = RobotDescription::builtin("pioneer-2dx").expect("it is built in");
        let (map, shut) = (halves(""), halves("[[wall]]\nline = [[5.0, 0.9], [5.0, 2.3]]\n"));
        let places = Places::new(&map, robot.radius_m).expect("there are places");
        let navigation = NavigationModel::new(&map, DriveLimits::of(&robot));
        let model = Arc::new(SimulatorModel::new(Arc::new(shut), SimulatorSettings::of(robot)));
        let ground = DayGround { driving: DrivingGround { model: &model, places: &places }, navigation: &navigation };
        let mut memory = tuned_alone(&model.world, &model.sensors);
        let [west, east] = ["west", "east"].map(|name| {
            PlaceId((0..places.count() as u32).find(|&place| places.name(PlaceId(place)) == name).expect("it is one"))
        });
        let mut evening = Evening::default();
        let mut errand = |noise| {
            let mut stream = Stream::new(1, "days");
            ground.errand(&mut memory, &mut stream, (west, east), noise, &mut evening).expect("there is a way")
        };
        let (first, second) = (errand(1), errand(2));
        assert_eq!((first.ending, first.blocked), (ErrandEnding::Arrived, 1));
        assert_eq!((second.ending, second.blocked), (ErrandEnding::Arrived, 0), "it knows the way round");
        assert_eq!(evening.stuck.len(), 1, "a behaviour is to be trained where it was blocked");
    }
}
