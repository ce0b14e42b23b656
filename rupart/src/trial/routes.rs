//! Routes asked for one after the other, without the robot: how good they are, and how much work.

use crate::case::Kind;
use crate::forgetting::forget_beyond;
use crate::memory::{CaseMemory, CaseNumber};
use crate::places::{PlaceId, Places};
use crate::route::{Route, Stop};
use crate::routes::{
    Adapted, Guidance, RouteProblem, TravelTimes, adapt_guided, adapt_literally, learn_route, learn_times,
};
use crate::similarity::{Scales, Similarity};
use crate::situation::Situation;
use rpl_random::Stream;
use rpl_robot::geometry::distance_m;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Routes that the memory has at the beginning (Fox and Anderson-Sprecher, Route plan quality).
const FIRST_CASES: usize = 20;

/// What a robot drives where nothing holds it up.
const SPEED_MPS: f64 = 0.5;

/// Where the map says too little: the share of the stretches that take longer, and how many times as long.
pub const SLOW: (f64, f64) = (0.15, 6.0);

/// How routes are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Planner {
    /// From the most similar case, as the paper prints it.
    Literal,
    /// From the case that promises the quickest route.
    Guided(Guidance),
    /// On the map alone.
    Map,
}

/// Where routes begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RouteStart {
    /// At the robot's home.
    Home,
    /// At the place that is farthest from all others on the average: an end of the building.
    End,
    /// At a random place each time.
    Anywhere,
}

/// Routes that are asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RouteTrial {
    /// How they are made.
    pub planner: Planner,
    /// Whether they are kept.
    pub is_learning: bool,
    /// Where they begin.
    pub start: RouteStart,
    /// How many cases are kept.
    pub cap: Option<usize>,
    /// Whether some stretches take longer than the map lets expect.
    pub is_slow: bool,
    /// How many.
    pub goals: usize,
}

/// A route that was asked for, and what came of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RouteAsked {
    /// What was made.
    pub adapted: Adapted,
    /// The case it was made from, as it was.
    pub case: Option<Route>,
    /// How long it takes, for each second that the quickest takes.
    pub ratio: f64,
    /// Whether nobody asked for this goal before.
    pub is_first: bool,
    /// Places that a search for the whole route expands, on what is known of times.
    pub from_scratch_expanded: usize,
    /// Steps of the route it finds.
    pub from_scratch_steps: usize,
}

/// Asks for the routes of a seed; goals and first cases are the same whatever the planner. Routes that cannot be
/// made, in a building of several parts, are left out.
pub fn run_routes(places: &Places, home: PlaceId, trial: &RouteTrial, seed: u64) -> Vec<RouteAsked> {
    let mut stream = Stream::new(seed, "routes");
    let truth = true_times(places, trial.is_slow, &mut Stream::new(seed, "slow"));
    let mut building = Building { places, truth, trial, memory: first_cases(places, &mut stream) };
    let end = remotest(places).unwrap_or(home);
    let mut known_goals = BTreeSet::new();
    let mut asked = Vec::new();
    for _ in 0..trial.goals {
        let anywhere = random_place(places, &mut stream);
        let start = match trial.start {
            RouteStart::Home => home,
            RouteStart::End => end,
            RouteStart::Anywhere => anywhere,
        };
        let goal = random_place(places, &mut stream);
        if goal == start {
            continue;
        }
        if let Some(route) = building.ask(start, goal) {
            asked.push(RouteAsked { is_first: known_goals.insert((start, goal)), ..route });
        }
    }
    asked
}

fn random_place(places: &Places, stream: &mut Stream) -> PlaceId {
    PlaceId(stream.index(places.count()) as u32)
}

/// The place that is farthest from all others on the average.
fn remotest(places: &Places) -> Option<PlaceId> {
    let off_m = |one: PlaceId| -> f64 {
        places.ids().map(|other| distance_m(places.at_in_map(one), places.at_in_map(other))).sum()
    };
    places.ids().max_by(|&one, &other| off_m(one).total_cmp(&off_m(other)))
}

/// Routes of the supporting planner between random places.
fn first_cases(places: &Places, stream: &mut Stream) -> CaseMemory {
    let scales = Scales { location_m: 100.0, ..Scales::default() };
    let mut memory = CaseMemory::new(Similarity { weights: Similarity::UNIT_WEIGHTS, ..Similarity::new(scales) });
    let map = TravelTimes::of_map(places, SPEED_MPS);
    // Where hardly any two places have a way between them, fewer will do.
    for _ in 0..100 * FIRST_CASES {
        let (from, to) = (random_place(places, stream), random_place(places, stream));
        let way = map.quickest_way(places, from, to).filter(|way| way.places.len() > 1);
        if let Some(way) = way.filter(|_| memory.len() < FIRST_CASES) {
            learn_route(&mut memory, places, Route::over(&way.places));
        }
    }
    memory
}

/// How long stretches really take.
fn true_times(places: &Places, is_slow: bool, stream: &mut Stream) -> TravelTimes {
    let (share, factor) = SLOW;
    let mut routes = Vec::new();
    for from in places.ids() {
        for stretch in places.stretches[from.index()].iter().filter(|stretch| from < stretch.to) {
            let times = if stream.chance(share) { factor } else { 1.0 };
            let mut route = Route::over(&[from, stretch.to]);
            route.times_s = vec![Some(times * stretch.length_m / SPEED_MPS)];
            routes.push(route);
        }
    }
    if is_slow {
        TravelTimes::of_routes(places, SPEED_MPS, routes.iter())
    } else {
        TravelTimes::of_map(places, SPEED_MPS)
    }
}

/// A building in which routes are asked for and driven.
struct Building<'t> {
    places: &'t Places,
    truth: TravelTimes,
    trial: &'t RouteTrial,
    memory: CaseMemory,
}

impl Building<'_> {
    fn ask(&mut self, start: PlaceId, goal: PlaceId) -> Option<RouteAsked> {
        let (places, stops) = (self.places, [Stop::Known(start), Stop::Known(goal)]);
        let routes: Vec<(CaseNumber, &Route)> = self.memory.routes().collect();
        let map = TravelTimes::of_map(places, SPEED_MPS);
        let known = TravelTimes::of_routes(places, SPEED_MPS, routes.iter().map(|(_, route)| *route));
        let adapted = match self.trial.planner {
            Planner::Literal => {
                let asked = Situation::of_route(places.at_in_map(start), places.at_in_map(goal));
                let best = self.memory.retrieve(&asked)?.best.number;
                let (number, case) = routes.iter().find(|(number, _)| *number == best)?;
                let problem = RouteProblem::new(places, &map, stops[0], stops[1]);
                adapt_literally(places, &map, &problem, *number, case)?
            }
            Planner::Guided(guidance) => {
                let problem = RouteProblem::new(places, &known, stops[0], stops[1]);
                adapt_guided(places, &known, &problem, routes.iter().copied(), guidance)?
            }
            Planner::Map => {
                let problem = RouteProblem::new(places, &map, stops[0], stops[1]);
                adapt_guided(places, &map, &problem, std::iter::empty(), Guidance::USUAL)?
            }
        };
        let case = adapted.case.and_then(|number| routes.iter().find(|(known, _)| *known == number));
        let case = case.map(|(_, route)| (*route).clone());
        let from_scratch = known.quickest_way(places, start, goal)?;
        let (from_scratch_expanded, from_scratch_steps) = (from_scratch.expanded, from_scratch.places.len() - 1);
        let quickest_s = self.truth.quickest_way(places, start, goal)?.cost;
        let ratio = self.truth.of_route_s(places, &untimed(&adapted.route)) / quickest_s;
        if self.trial.is_learning {
            self.learn(&adapted);
        }
        Some(RouteAsked { adapted, case, ratio, is_first: false, from_scratch_expanded, from_scratch_steps })
    }

    /// Drives the route and keeps it, with the times it took, if it has steps the case does not have.
    fn learn(&mut self, adapted: &Adapted) {
        let mut driven = untimed(&adapted.route);
        driven.times_s = driven
            .stops
            .windows(2)
            .map(|two| Some(self.truth.of_route_s(self.places, &Route::new(two.to_vec()))))
            .collect();
        if let Some(number) = adapted.case {
            self.memory.change(number, |case| case.counts.note(true));
        }
        learn_times(&mut self.memory, &driven);
        if adapted.new_steps > 0 {
            learn_route(&mut self.memory, self.places, driven);
        }
        if let Some(cap) = self.trial.cap {
            let routes = self.memory.routes().map(|(_, route)| route);
            let known = TravelTimes::of_routes(self.places, SPEED_MPS, routes);
            forget_beyond(&mut self.memory, Kind::Route, cap, Some((self.places, &known)));
        }
    }
}

fn untimed(route: &Route) -> Route {
    Route::new(route.stops.clone())
}
