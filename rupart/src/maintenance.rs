//! What is wrong with the cases of a memory, as far as the map and the cases themselves can tell.

use crate::case::{Case, Content, Kind};
use crate::memory::{CaseMemory, CaseNumber};
use crate::places::Places;
use crate::route::Route;
use crate::routes::{RouteProblem, TravelTimes};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

/// A route that takes longer than this, for each second of the quickest way that is known, is poor.
const POOR: f64 = 1.5;

/// Uses after which a case that never succeeded is suspect.
const ENOUGH_USES: u32 = 5;

/// What is wrong with a case.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Concern {
    /// Of the case.
    pub number: CaseNumber,
    /// What is wrong with it.
    pub fault: CaseFault,
}

/// What may be wrong with a case.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum CaseFault {
    /// A robot cannot drive straight from one stop to the next.
    NotInSight {
        /// The one.
        from: String,
        /// The other.
        to: String,
    },
    /// The route takes several times as long as the quickest that is known.
    Poor {
        /// How many times.
        times: f64,
    },
    /// An earlier case of its kind is for the same and no other, so that this one is never retrieved.
    Hidden {
        /// That case.
        by: CaseNumber,
    },
    /// It was used several times and never led to the goal.
    NeverSucceeded {
        /// How often.
        used: u32,
    },
}

impl fmt::Display for Concern {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "case {}: ", self.number)?;
        match &self.fault {
            CaseFault::NotInSight { from, to } => {
                write!(
                    out,
                    "a robot cannot drive straight from `{from}` to `{to}`; forget the case, or correct its stops"
                )
            }
            CaseFault::Poor { times } => {
                write!(out, "its route takes {times:.1} times as long as the quickest that is known; forget it")
            }
            CaseFault::Hidden { by } => {
                write!(out, "it is never retrieved: case {by} is for the same; forget one of them")
            }
            CaseFault::NeverSucceeded { used } => write!(out, "it was used {used} times and never led to the goal"),
        }
    }
}

/// What is wrong with the cases of a memory, by kind and then by number; `speed_mps` is the robot's where nothing holds
/// it up. Cost: a search for each route, and the size of all indices.
pub fn concerns(memory: &CaseMemory, places: Option<&Places>, speed_mps: f64) -> Vec<Concern> {
    let times = places.map(|places| TravelTimes::of_routes(places, speed_mps, memory.routes().map(|(_, route)| route)));
    let mut indices: BTreeMap<(Kind, String), CaseNumber> = BTreeMap::new();
    let mut concerns = Vec::new();
    for (number, case) in memory.cases() {
        let mut add = |fault: CaseFault| concerns.push(Concern { number, fault });
        // Any route may be the best to make another of, whatever its index.
        let stops = route_of(case).map(|route| &route.stops);
        let earlier = *indices.entry((case.content.kind(), format!("{:?} {stops:?}", case.index))).or_insert(number);
        if earlier != number {
            add(CaseFault::Hidden { by: earlier });
        }
        if case.counts.used >= ENOUGH_USES && case.counts.succeeded == 0 {
            add(CaseFault::NeverSucceeded { used: case.counts.used });
        }
        if let Some((route, (places, times))) = route_of(case).zip(places.zip(times.as_ref())) {
            out_of_sight(places, route).into_iter().chain(poor(places, times, route)).for_each(&mut add);
        }
    }
    concerns
}

fn route_of(case: &Arc<Case>) -> Option<&Route> {
    match &case.content {
        Content::Route(route) => Some(route),
        Content::Behaviour(_) | Content::Goal(_) | Content::MetaPlan(_) => None,
    }
}

fn out_of_sight(places: &Places, route: &Route) -> Option<CaseFault> {
    let known = route.stops.windows(2).filter_map(|two| two[0].known().zip(two[1].known()));
    let mut apart = known.filter(|&(from, to)| places.stretch(from, to).is_none());
    let (from, to) = apart.next()?;
    Some(CaseFault::NotInSight { from: places.name(from).to_string(), to: places.name(to).to_string() })
}

fn poor(places: &Places, known: &TravelTimes, route: &Route) -> Option<CaseFault> {
    let problem = RouteProblem::new(places, known, *route.stops.first()?, *route.stops.last()?);
    let quickest_s = known.quickest_way(places, problem.start_place, problem.goal_place)?.cost;
    let times = known.of_route_s(places, route) / quickest_s;
    (quickest_s > 0.0 && times > POOR).then_some(CaseFault::Poor { times })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::places::PlaceId;
    use crate::places::tests::places_in_a_row;
    use crate::routes::learn_route;
    use crate::similarity::{Scales, Similarity};

    #[test]
    fn each_fault_of_a_case_is_found() {
        let places = places_in_a_row();
        let mut memory = CaseMemory::new(Similarity::new(Scales::default()));
        let mut learn = |ids: &[u32]| {
            let ids: Vec<PlaceId> = ids.iter().copied().map(PlaceId).collect();
            learn_route(&mut memory, &places, Route::over(&ids)).expect("it has ends")
        };
        let good = learn(&[0, 1, 2]);
        let far = learn(&[0, 4]);
        let round = learn(&[1, 2, 3, 2]);
        let hidden = learn(&[0, 1, 2]);
        for _ in 0..ENOUGH_USES {
            memory.change(good, |case| case.counts.note(false));
        }
        let found = concerns(&memory, Some(&places), 0.5);
        let of = |number: CaseNumber| -> Vec<String> {
            found.iter().filter(|concern| concern.number == number).map(Concern::to_string).collect()
        };
        assert_eq!(of(good), ["case 0: it was used 5 times and never led to the goal"]);
        assert!(of(far)[0].contains("a robot cannot drive straight from `p0` to `p4`"), "{found:?}");
        assert!(of(round)[0].contains("takes 3.0 times as long as the quickest"), "{found:?}");
        assert!(of(hidden)[0].contains("case 0 is for the same"), "{found:?}");
        assert_eq!(found.len(), 4);
    }
}
