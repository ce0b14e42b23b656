//! Adaptation of a route as the paper prints it: at the front, then at the end of what that gives.

use super::adapted::{Adapted, Work};
use super::problem::RouteProblem;
use super::travel_times::TravelTimes;
use crate::memory::CaseNumber;
use crate::places::{PlaceId, Places};
use crate::route::{Route, Stop};

/// The route of a case, with a new one from the start to where it begins and one from where it ends to the goal
/// (Fox and Anderson-Sprecher, Fig. 4). Where a new one and that of the case overlap, it goes on with the case
/// from the first place both have. None if there is no way.
pub fn adapt_literally(
    places: &Places,
    times: &TravelTimes,
    problem: &RouteProblem,
    number: CaseNumber,
    case: &Route,
) -> Option<Adapted> {
    let mut work = Work::default();
    let (first, last) = (*case.stops.first()?, *case.stops.last()?);
    let mut way = |from: PlaceId, to: PlaceId| -> Option<Route> {
        let way = times.quickest_way(places, from, to)?;
        work.note(&way);
        Some(Route::over(&way.places))
    };
    let mut route = case.clone();
    if first != problem.start {
        let to_case = with_ends(way(problem.start_place, first.closest(places))?, problem.start, first);
        route = joined(to_case, route);
    }
    if last != problem.goal {
        let to_goal = with_ends(way(last.closest(places), problem.goal_place)?, last, problem.goal);
        // Symmetrical: the last place of the new route that the old one has.
        route = backwards(&joined(backwards(&to_goal), backwards(&route)));
    }
    let new_steps = route.steps_beyond(case);
    Some(Adapted {
        route,
        case: Some(number),
        is_repaired: false,
        generated_steps: work.steps,
        new_steps,
        expanded: work.expanded,
    })
}

fn backwards(route: &Route) -> Route {
    route.stops.len().checked_sub(1).map_or_else(Route::default, |last| route.part(last, 0))
}

/// The ends of a way over known places, where they are coordinates.
fn with_ends(mut way: Route, start: Stop, goal: Stop) -> Route {
    if start.known().is_none() {
        way.stops.insert(0, start);
        way.times_s.insert(0, None);
    }
    if goal.known().is_none() {
        way.stops.push(goal);
        way.times_s.push(None);
    }
    way
}

/// A new route up to the first stop that the old one has, and the old one from there on.
fn joined(new: Route, old: Route) -> Route {
    let common = new.stops.iter().enumerate().find_map(|(at, stop)| {
        let in_old = old.stops.iter().position(|of_old| of_old == stop)?;
        Some((at, in_old))
    });
    let Some((at, in_old)) = common else {
        let mut whole = new;
        whole.go_on(old);
        return whole;
    };
    let mut whole = new.part(0, at);
    whole.go_on(old.part(in_old, old.stops.len() - 1));
    whole
}
