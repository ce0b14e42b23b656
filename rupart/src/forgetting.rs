//! How many cases a robot remembers, and which it forgets when it learns more (Smyth and Keane 1995, "Remembering to
//! forget: a competence-preserving case deletion policy").

use crate::beginning::is_standing;
use crate::case::{Case, Content, Kind};
use crate::memory::{CaseMemory, CaseNumber};
use crate::places::Places;
use crate::routes::{TravelTimes, reachability};

/// The most cases of each kind that a robot remembers by learning. What it was given beyond that it keeps, but then
/// forgets a case for each that it learns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capacity {
    /// Parameters of the control.
    pub behaviours: usize,
    /// Routes, those round what blocked the robot among them.
    pub routes: usize,
    /// Goals that wait. A robot forgets none by itself: who gives it more is told.
    pub goals: usize,
    /// Meta-plans.
    pub meta_plans: usize,
}

impl Capacity {
    /// What every robot has.
    pub const USUAL: Capacity = Capacity { behaviours: 1_000, routes: 1_000, goals: 1_000, meta_plans: 200 };

    /// The most cases of a kind.
    pub fn of(&self, kind: Kind) -> usize {
        match kind {
            Kind::Behaviour => self.behaviours,
            Kind::Route => self.routes,
            Kind::Goal => self.goals,
            Kind::MetaPlan => self.meta_plans,
        }
    }
}

/// How many cases, those that have helped least for their age, are looked at more closely.
const LOOKED_AT: usize = 8;

/// Forgets a case of a kind if there are too many of it: of those that have helped least for their age the one that
/// most others can stand in for, of several the one that has helped least. Goals and what every memory begins with stay.
/// Routes stand in for others by the times that are known. Cost: a pass over the cases of the kind; for each of eight of
/// them a retrieval or, of routes, the stops of all.
pub fn forget_beyond(
    memory: &mut CaseMemory,
    kind: Kind,
    most: usize,
    ground: Option<(&Places, &TravelTimes)>,
) -> Option<CaseNumber> {
    if memory.count(kind) <= most {
        return None;
    }
    let learned = memory.cases_of(kind).filter(|(_, case)| kind != Kind::Goal && !is_standing(case));
    let mut candidates: Vec<(f64, CaseNumber)> =
        learned.map(|(number, case)| (worth(memory, number, case), number)).collect();
    let order =
        |one: &(f64, CaseNumber), other: &(f64, CaseNumber)| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1));
    if candidates.len() > LOOKED_AT {
        candidates.select_nth_unstable_by(LOOKED_AT, order);
        candidates.truncate(LOOKED_AT);
    }
    candidates.sort_by(order);
    let mut best: Option<(usize, CaseNumber)> = None;
    for (_, number) in candidates {
        let others = stand_ins(memory, number, ground);
        if best.is_none_or(|(most, _)| others > most) {
            best = Some((others, number));
        }
    }
    let (_, number) = best?;
    memory.forget(number).then_some(number)
}

/// How often a case has led to the goal, for each case that was retained since.
fn worth(memory: &CaseMemory, number: CaseNumber, case: &Case) -> f64 {
    let age = memory.next_number().0 - number.0;
    (f64::from(case.counts.succeeded) + 1.0) / (f64::from(age) + 1.0)
}

/// How many other cases do for what this one is retrieved for: of routes those that solve its problem, of others the
/// one that would be retrieved instead, if it says the same.
fn stand_ins(memory: &CaseMemory, number: CaseNumber, ground: Option<(&Places, &TravelTimes)>) -> usize {
    let Some(case) = memory.get(number) else { return 0 };
    match (&case.content, ground) {
        (Content::Route(route), Some((places, times))) => {
            reachability(places, times, route, memory.routes().filter(|(other, _)| *other != number))
        }
        (Content::Route(_), None) => 0,
        (content @ (Content::Behaviour(_) | Content::Goal(_) | Content::MetaPlan(_)), _) => {
            let found = memory.without(&[number]).retrieve(&case.index);
            let instead = found.and_then(|found| memory.get(found.best.number));
            usize::from(instead.is_some_and(|other| other.content == *content))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::MetaPlan;
    use crate::control::BehaviourParameters;
    use crate::places::PlaceId;
    use crate::places::tests::places_in_a_row;
    use crate::route::Route;
    use crate::routes::learn_route;
    use crate::similarity::{Scales, Similarity};
    use crate::situation::Situation;

    fn behaviour(bearing_rad: f64, translation_mps: f64) -> Case {
        let index = Situation { short_term_goal_bearing_rad: Some(bearing_rad), ..Situation::default() };
        Case::new(index, Content::Behaviour(BehaviourParameters { translation_mps, ..BehaviourParameters::TUNED }))
    }

    #[test]
    fn of_those_that_help_least_the_one_goes_that_another_stands_in_for() {
        let mut memory = CaseMemory::new(Similarity::new(Scales::default()));
        let fast = memory.retain(behaviour(0.0, 0.7));
        let slow = memory.retain(behaviour(1.0, 0.2));
        let same = memory.retain(behaviour(1.1, 0.2));
        assert_eq!(forget_beyond(&mut memory, Kind::Behaviour, 3, None), None, "there is room");
        // The older one of the two that say the same.
        assert_eq!(forget_beyond(&mut memory, Kind::Behaviour, 2, None), Some(slow));
        assert!(memory.get(fast).is_some() && memory.get(same).is_some());
        // Nobody stands in for either now: the older one.
        assert_eq!(forget_beyond(&mut memory, Kind::Behaviour, 1, None), Some(fast));
    }

    #[test]
    fn what_helps_stays_however_much_is_learned() {
        let mut memory = CaseMemory::new(Similarity::new(Scales::default()));
        let helps = memory.retain(behaviour(0.0, 0.7));
        for learned in 0..500 {
            memory.retain(behaviour(f64::from(learned) * 0.005, 0.2));
            memory.change(helps, |case| case.counts.note(true));
            forget_beyond(&mut memory, Kind::Behaviour, 50, None);
            assert!(memory.len() <= 50);
        }
        assert!(memory.get(helps).is_some());
    }

    #[test]
    fn goals_and_what_every_memory_begins_with_stay() {
        let mut memory = CaseMemory::new(Similarity::new(Scales::default()));
        let standing = memory.retain(Case::new(Situation::default(), Content::MetaPlan(MetaPlan::LocalizeFirst)));
        let learned = memory.retain(Case::new(Situation::default(), Content::MetaPlan(MetaPlan::TrainBehaviour)));
        assert_eq!(forget_beyond(&mut memory, Kind::MetaPlan, 0, None), Some(learned));
        assert_eq!(forget_beyond(&mut memory, Kind::MetaPlan, 0, None), None);
        assert!(memory.get(standing).is_some());
    }

    #[test]
    fn of_routes_one_goes_whose_way_others_have() {
        let places = places_in_a_row();
        let mut memory = CaseMemory::new(Similarity::new(Scales::default()));
        let mut learn = |ids: &[u32]| {
            let ids: Vec<PlaceId> = ids.iter().copied().map(PlaceId).collect();
            learn_route(&mut memory, &places, Route::over(&ids)).expect("it has ends")
        };
        let whole = learn(&[0, 1, 2, 3, 4]);
        let part = learn(&[1, 2, 3]);
        let times = TravelTimes::of_map(&places, 0.5);
        assert_eq!(forget_beyond(&mut memory, Kind::Route, 1, Some((&places, &times))), Some(part));
        assert!(memory.get(whole).is_some());
    }
}
