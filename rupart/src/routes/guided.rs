//! Adaptation-guided retrieval of routes: the case that will cost least to adapt and to drive (Smyth and Keane
//! 1998, "Adaptation-guided retrieval: questioning the similarity assumption in reasoning").

use super::adapted::{Adapted, Work};
use super::problem::RouteProblem;
use super::travel_times::TravelTimes;
use crate::memory::CaseNumber;
use crate::places::{PlaceId, Places};
use crate::route::{Route, Stop};

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

/// What a case may be used for.
type Promise<'r> = (CaseUse, CaseNumber, &'r Route);

/// The route made from the case that promises the quickest one, or from scratch if none promises more than
/// that; of two that promise the same from the first. A poor one is made anew; and where a route from scratch leads
/// along what is known to hold the robot up, so that it takes longer than new ways are taken to, the case is looked
/// for once more that promises the quickest if they all are as slow. The quickest is taken. None if there is no way.
/// Cost: O(stops of the cases), and the searches of the supporting planner.
pub fn adapt_guided<'r>(
    places: &Places,
    times: &TravelTimes,
    problem: &RouteProblem,
    cases: impl Iterator<Item = (CaseNumber, &'r Route)>,
    guidance: Guidance,
) -> Option<Adapted> {
    let cases: Vec<(CaseNumber, &Route)> = cases.collect();
    let mut work = Work::default();
    let made_of = |best: Option<Promise<'r>>, most_s: f64, work: &mut Work| {
        let best = best.filter(|(found, ..)| found.estimate_s <= most_s)?;
        Some((best, spliced(places, times, problem, best.2, best.0, work)?))
    };
    let needed_s = |route: &Route| times.of_route_s(places, route);
    let [from_scratch_s, poor_s] = [guidance.new_way, guidance.poor].map(|factor| factor * problem.least_s());
    let best = best_case(places, times, problem, &cases, guidance.new_way);
    let (case, is_repaired, route) = match made_of(best, from_scratch_s, &mut work) {
        Some((best, route)) if needed_s(&route) <= poor_s => (Some(best), false, route),
        promised => {
            let anew = way(places, times, problem.start_place, problem.goal_place, &mut work)?;
            let anew_s = needed_s(&anew);
            let round = (anew_s > from_scratch_s)
                .then(|| best_case(places, times, problem, &cases, anew_s / problem.least_s()))
                .and_then(|round| made_of(round, anew_s, &mut work));
            let asked = promised.as_ref().map(|(best, _)| *best);
            let made = promised.into_iter().chain(round).filter(|(_, route)| needed_s(route) <= anew_s);
            match made.min_by(|(_, one), (_, other)| needed_s(one).total_cmp(&needed_s(other))) {
                Some((best, route)) => (Some(best), false, route),
                // Who asked a case in vain for a good route has repaired it.
                None => (asked, asked.is_some(), anew),
            }
        }
    };
    let new_steps = case.map_or(route.times_s.len(), |(.., case)| route.steps_beyond(case));
    Some(Adapted {
        route: problem.with_ends(route),
        case: case.map(|(_, number, _)| number),
        is_repaired,
        generated_steps: work.steps,
        new_steps,
        expanded: work.expanded,
    })
}

/// The case that promises the quickest route, if it is more than a place on the way.
fn best_case<'r>(
    places: &Places,
    times: &TravelTimes,
    problem: &RouteProblem,
    cases: &[(CaseNumber, &'r Route)],
    new_way: f64,
) -> Option<Promise<'r>> {
    let mut best: Option<Promise<'_>> = None;
    for &(number, case) in cases {
        let Some(found) = best_use(places, times, problem, case, new_way) else { continue };
        if best.is_none_or(|(best, ..)| found.estimate_s < best.estimate_s) {
            best = Some((found, number, case));
        }
    }
    best.filter(|(found, ..)| found.entry != found.exit)
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

fn way(places: &Places, times: &TravelTimes, from: PlaceId, to: PlaceId, work: &mut Work) -> Option<Route> {
    let way = times.quickest_way(places, from, to)?;
    work.note(&way);
    Some(Route::over(&way.places))
}
