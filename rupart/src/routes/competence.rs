//! What a memory of routes can do without (Smyth and Keane 1995, "Remembering to forget").

use super::guided::{Guidance, best_use};
use super::problem::RouteProblem;
use super::travel_times::TravelTimes;
use crate::memory::CaseNumber;
use crate::places::Places;
use crate::route::Route;

/// A case solves the problem of another if the route it promises takes at most this much longer.
const SOLVES: f64 = 1.1;

/// Problems that competence is judged by; more are represented by these, evenly.
const MOST_PROBLEMS: usize = 200;

/// What a case of a memory of routes is good for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Competence {
    /// Of the case.
    pub number: CaseNumber,
    /// Problems of other cases that it solves.
    pub coverage: usize,
    /// Cases that solve its problem, others than itself.
    pub reachability: usize,
}

/// What each route is good for, the problems being those that the routes themselves solve. Cost: for each
/// route and each of at most 200 problems, the stops of the route.
pub fn competences(places: &Places, times: &TravelTimes, routes: &[(CaseNumber, &Route)]) -> Vec<Competence> {
    let mut found: Vec<Competence> =
        routes.iter().map(|&(number, _)| Competence { number, coverage: 0, reachability: 0 }).collect();
    let apart = routes.len().div_ceil(MOST_PROBLEMS).max(1);
    for own in (0..routes.len()).step_by(apart) {
        let (_, route) = routes[own];
        let Some(solved) = Solved::by(places, times, route) else { continue };
        let solves = |&(_, case): &(CaseNumber, &Route)| solved.is_by(places, times, case);
        let solvers: Vec<usize> = (0..routes.len()).filter(|&at| at == own || solves(&routes[at])).collect();
        found[own].reachability = solvers.len() - 1;
        for &solver in &solvers {
            found[solver].coverage += usize::from(solver != own);
        }
    }
    found
}

/// How many of other routes solve the problem of one, as [`Competence::reachability`] counts them. Cost: their stops.
pub fn reachability<'r>(
    places: &Places,
    times: &TravelTimes,
    route: &Route,
    others: impl Iterator<Item = (CaseNumber, &'r Route)>,
) -> usize {
    let Some(solved) = Solved::by(places, times, route) else { return 0 };
    others.filter(|(_, other)| solved.is_by(places, times, other)).count()
}

/// The problem that a route solves, and what is enough to solve it.
struct Solved {
    problem: RouteProblem,
    enough_s: f64,
}

impl Solved {
    fn by(places: &Places, times: &TravelTimes, route: &Route) -> Option<Self> {
        let problem = RouteProblem::new(places, times, *route.stops.first()?, *route.stops.last()?);
        Some(Self { problem, enough_s: SOLVES * times.of_route_s(places, route) })
    }

    fn is_by(&self, places: &Places, times: &TravelTimes, case: &Route) -> bool {
        let found = best_use(places, times, &self.problem, case, Guidance::USUAL.new_way);
        found.is_some_and(|found| found.estimate_s <= self.enough_s)
    }
}
