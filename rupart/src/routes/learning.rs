//! Learning routes: what was driven is kept where it is new, and how long it took.

use crate::case::{Case, Content, Kind, MetaPlan};
use crate::memory::{CaseMemory, CaseNumber};
use crate::places::Places;
use crate::route::{Route, Stop};
use crate::situation::Situation;
use rpl_robot::geometry::Point;

/// Keeps a route as a case for its start and goal. None if it leads nowhere.
pub fn learn_route(memory: &mut CaseMemory, places: &Places, route: Route) -> Option<CaseNumber> {
    let (start, goal) = (route.stops.first()?.at_in_map(places), route.stops.last()?.at_in_map(places));
    Some(memory.retain(Case::new(Situation::of_route(start, goal), Content::Route(route))))
}

/// Keeps that no route case is good for this problem: the route is to be made on the map. Nothing, if the memory says
/// so already.
pub fn learn_to_make(memory: &mut CaseMemory, start_in_map: Point, goal_in_map: Point) {
    let problem = Situation::of_route(start_in_map, goal_in_map);
    let best = memory.retrieve(&problem).map(|found| found.best.kind);
    if best != Some(Kind::MetaPlan) {
        memory.retain(Case::new(problem, Content::MetaPlan(MetaPlan::MakeRoute)));
    }
}

/// Notes how long the steps of a driven route took in every case that has them, in either direction. Cost: the
/// steps of all routes times those that were driven.
pub fn learn_times(memory: &mut CaseMemory, driven: &Route) {
    let stale: Vec<(CaseNumber, Vec<Option<f64>>)> = memory
        .cases_of(Kind::Route)
        .filter_map(|(number, case)| {
            let Content::Route(route) = &case.content else { return None };
            let times_s = measured(route, driven);
            (times_s != route.times_s).then_some((number, times_s))
        })
        .collect();
    for (number, times_s) in stale {
        memory.change(number, |case| {
            if let Content::Route(route) = &mut case.content {
                route.times_s = times_s;
            }
        });
    }
}

/// How long the steps of a route take, as it was driven or known before.
fn measured(route: &Route, driven: &Route) -> Vec<Option<f64>> {
    let in_driven = |two: &[Stop]| {
        let is_same = |step: &[Stop]| step == two || (step[0] == two[1] && step[1] == two[0]);
        driven.stops.windows(2).position(is_same).and_then(|step| driven.times_s[step])
    };
    route.stops.windows(2).zip(&route.times_s).map(|(two, known_s)| in_driven(two).or(*known_s)).collect()
}
