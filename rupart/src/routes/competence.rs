//! What a memory of routes can do without (Smyth and Keane 1995, "Remembering to forget"; Smyth and McKenna
//! 1999, "Footprint-based retrieval": relative coverage).

use super::guided::{Guidance, best_use};
use super::problem::RouteProblem;
use super::route::Route;
use super::travel_times::TravelTimes;
use crate::memory::CaseNumber;
use crate::places::Places;

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
    /// The problems it solves, its own among them, each divided among all cases that solve it.
    pub relative_coverage: f64,
}

/// What each route is good for, the problems being those that the routes themselves solve. Cost: for each
/// route and each of at most 200 problems, the stops of the route.
pub fn competences(places: &Places, times: &TravelTimes, routes: &[(CaseNumber, &Route)]) -> Vec<Competence> {
    let mut found: Vec<Competence> = routes
        .iter()
        .map(|&(number, _)| Competence { number, coverage: 0, reachability: 0, relative_coverage: 0.0 })
        .collect();
    let apart = routes.len().div_ceil(MOST_PROBLEMS).max(1);
    for own in (0..routes.len()).step_by(apart) {
        let (_, route) = routes[own];
        let (Some(&start), Some(&goal)) = (route.stops.first(), route.stops.last()) else { continue };
        let problem = RouteProblem::new(places, times, start, goal);
        let enough_s = SOLVES * times.of_route_s(places, route);
        let solves = |&(_, case): &(CaseNumber, &Route)| {
            best_use(places, times, &problem, case, Guidance::USUAL.new_way)
                .is_some_and(|found| found.estimate_s <= enough_s)
        };
        let solvers: Vec<usize> = (0..routes.len()).filter(|&at| at == own || solves(&routes[at])).collect();
        found[own].reachability = solvers.len() - 1;
        for &solver in &solvers {
            found[solver].coverage += usize::from(solver != own);
            found[solver].relative_coverage += 1.0 / solvers.len() as f64;
        }
    }
    found
}

/// The route a memory can do without most easily: that of the least relative coverage, of several the oldest.
/// None if there is none. Cost: that of [`competences`].
pub fn least_competent(places: &Places, times: &TravelTimes, routes: &[(CaseNumber, &Route)]) -> Option<CaseNumber> {
    let competences = competences(places, times, routes);
    let least = competences.iter().min_by(|one, other| {
        one.relative_coverage.total_cmp(&other.relative_coverage).then(one.number.cmp(&other.number))
    });
    least.map(|competence| competence.number)
}
