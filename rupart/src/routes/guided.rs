//! Adaptation-guided retrieval of routes: the case that will cost least to adapt and to drive (Smyth and Keane
//! 1998, "Adaptation-guided retrieval: questioning the similarity assumption in reasoning").

use super::adapted::{Adapted, Work};
use super::problem::RouteProblem;
use super::route::{Route, Stop};
use super::travel_times::TravelTimes;
use crate::memory::CaseNumber;
use crate::places::{PlaceId, Places};

/// What adaptation is guided by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guidance {
    /// What a new way is taken to cost, for each second that is expected of the shortest there can be: bounds are
    /// too low, and what is known is preferred to what is not.
    pub new_way: f64,
    /// A route that takes longer than this, for each second that is expected of the shortest, is poor and made anew.
    pub poor: f64,
}

impl Guidance {
    /// What routes are made by.
    pub const USUAL: Guidance = Guidance { new_way: 1.3, poor: 1.1 };
}

/// Between which stops a case is used, and what the whole route will take about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CaseUse {
    /// About how long the whole route will take.
    pub estimate_s: f64,
    /// The stop where the case is entered.
    pub entry: usize,
    /// The stop where it is left; before the entry if it is driven backwards.
    pub exit: usize,
}

/// The best use of a case: entered and left anywhere, in either direction; a new way counts `new_way` times what
/// it takes at least. None if it leads over no known place,
/// or the goal cannot be reached. O(stops).
pub fn best_use(
    places: &Places,
    times: &TravelTimes,
    problem: &RouteProblem,
    case: &Route,
    new_way: f64,
) -> Option<CaseUse> {
    let there = along(places, times, problem, case, new_way, 0..case.stops.len());
    let back = along(places, times, problem, case, new_way, (0..case.stops.len()).rev());
    [there, back]
        .into_iter()
        .flatten()
        .filter(|found| found.estimate_s.is_finite())
        .min_by(|one, other| one.estimate_s.total_cmp(&other.estimate_s))
}

/// The best use of a case in one direction.
fn along(
    places: &Places,
    times: &TravelTimes,
    problem: &RouteProblem,
    case: &Route,
    new_way: f64,
    order: impl Iterator<Item = usize>,
) -> Option<CaseUse> {
    // What it takes to be at a stop, entered wherever that is best.
    let mut reached: Option<(f64, usize)> = None;
    let mut before = None;
    let mut best: Option<CaseUse> = None;
    for at in order {
        let step_s = before.map_or(0.0, |before: usize| times.of_step_s(places, case, at.min(before)));
        reached = reached.map(|(reached_s, entry)| (reached_s + step_s, entry));
        before = Some(at);
        let Stop::Known(place) = case.stops[at] else { continue };
        let entered_s = new_way * problem.least_from_start_s[place.index()];
        if reached.is_none_or(|(reached_s, _)| entered_s < reached_s) {
            reached = Some((entered_s, at));
        }
        let left_s = new_way * problem.least_to_goal_s[place.index()];
        if let Some((reached_s, entry)) = reached
            && best.is_none_or(|best| reached_s + left_s < best.estimate_s)
        {
            best = Some(CaseUse { estimate_s: reached_s + left_s, entry, exit: at });
        }
    }
    best
}

/// The route made from the case that promises the quickest one, or from scratch if none promises more than
/// that; of two that promise the same from the first. A poor one is made anew, and the quicker is taken. None
/// if there is no way. Cost: O(stops of the cases), and the searches of the supporting planner.
pub fn adapt_guided<'r>(
    places: &Places,
    times: &TravelTimes,
    problem: &RouteProblem,
    cases: impl Iterator<Item = (CaseNumber, &'r Route)>,
    guidance: Guidance,
) -> Option<Adapted> {
    let mut best: Option<(CaseUse, CaseNumber, &Route)> = None;
    for (number, case) in cases {
        let Some(found) = best_use(places, times, problem, case, guidance.new_way) else { continue };
        if best.is_none_or(|(best, ..)| found.estimate_s < best.estimate_s) {
            best = Some((found, number, case));
        }
    }
    let from_scratch_s = guidance.new_way * problem.least_s();
    let worth_it = best.filter(|(found, ..)| found.entry != found.exit && found.estimate_s <= from_scratch_s);
    let mut work = Work::default();
    let adapted = worth_it.and_then(|(found, number, case)| {
        let route = spliced(places, times, problem, case, found, &mut work)?;
        Some((number, case, route))
    });
    let poor_s = guidance.poor * problem.least_s();
    let is_poor = |route: &Route| times.of_route_s(places, route) > poor_s;
    let (case, route, is_repaired) = match adapted {
        Some((number, case, route)) if !is_poor(&route) => (Some((number, case)), route, false),
        Some((number, case, route)) => {
            let anew = from_scratch(places, times, problem, &mut work)?;
            let is_quicker = times.of_route_s(places, &anew) < times.of_route_s(places, &route);
            let better = if is_quicker { anew } else { route };
            (Some((number, case)), better, is_quicker)
        }
        None => (None, from_scratch(places, times, problem, &mut work)?, false),
    };
    let new_steps = case.map_or(route.times_s.len(), |(_, case)| route.steps_beyond(case));
    Some(Adapted {
        route: problem.with_ends(route),
        case: case.map(|(number, _)| number),
        is_repaired,
        generated_steps: work.steps,
        new_steps,
        expanded: work.expanded,
    })
}

/// A way to where the case is entered, the case, and a way from where it is left.
fn spliced(
    places: &Places,
    times: &TravelTimes,
    problem: &RouteProblem,
    case: &Route,
    found: CaseUse,
    work: &mut Work,
) -> Option<Route> {
    let (entry, exit) = (case.stops[found.entry].known()?, case.stops[found.exit].known()?);
    let mut route = way(places, times, problem.start_place, entry, work)?;
    route.go_on(case.part(found.entry, found.exit));
    route.go_on(way(places, times, exit, problem.goal_place, work)?);
    route.cut_rounds();
    Some(route)
}

fn from_scratch(places: &Places, times: &TravelTimes, problem: &RouteProblem, work: &mut Work) -> Option<Route> {
    way(places, times, problem.start_place, problem.goal_place, work)
}

fn way(places: &Places, times: &TravelTimes, from: PlaceId, to: PlaceId, work: &mut Work) -> Option<Route> {
    let way = times.quickest_way(places, from, to)?;
    work.note(&way);
    Some(Route::over(&way.places))
}
