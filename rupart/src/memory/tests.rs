use super::columns::CHUNK;
use super::*;
use crate::case::{Case, Content, Goal, Kind, MetaPlan};
use crate::control::BehaviourParameters;
use crate::route::Route;
use crate::similarity::{Scales, Similarity};
use crate::situation::{Feature, Situation};
use rpl_random::Stream;
use rpl_robot::geometry::Point;
use std::sync::Arc;

fn random_situation(stream: &mut Stream) -> Situation {
    let ranges = |stream: &mut Stream| {
        let count = if stream.chance(0.9) { 16 } else { 7 };
        stream.chance(0.8).then(|| (0..count).map(|_| stream.uniform_in(0.1, 6.0)).collect::<Vec<f64>>())
    };
    let point = |stream: &mut Stream| {
        stream.chance(0.7).then(|| Point::new(stream.uniform_in(0.0, 98.0), stream.uniform_in(0.0, 32.0)))
    };
    let number = |stream: &mut Stream, low: f64, high: f64| stream.chance(0.8).then(|| stream.uniform_in(low, high));
    Situation {
        sonars_m: ranges(stream),
        mean_sonars_m: ranges(stream),
        translation_mps: number(stream, -0.2, 1.2),
        rotation_radps: number(stream, -2.0, 2.0),
        place_in_map: point(stream),
        short_term_goal_in_map: point(stream),
        long_term_goal_in_map: point(stream),
        short_term_goal_distance_m: number(stream, 0.0, 30.0),
        short_term_goal_bearing_rad: number(stream, -3.1, 3.1),
        priority: number(stream, 0.0, 1.0),
        time_s: number(stream, 0.0, 1e5),
    }
}

fn random_case(stream: &mut Stream) -> Case {
    let content = match stream.index(4) {
        0 => Content::Route(Route::default()),
        1 => Content::Goal(Goal { place_in_map: Point::origin() }),
        2 => Content::MetaPlan(MetaPlan::MakeRoute),
        _ => Content::Behaviour(BehaviourParameters::default()),
    };
    Case::new(random_situation(stream), content)
}

fn random_memory(stream: &mut Stream, count: usize) -> CaseMemory {
    let mut memory = CaseMemory::new(Similarity::new(Scales::default()));
    for _ in 0..count {
        memory.retain(random_case(stream));
    }
    memory
}

/// By looking at every case.
fn nearest(memory: &CaseMemory, asked: &Situation) -> Vec<(f64, CaseNumber)> {
    let of_case = |(number, case): (CaseNumber, &Arc<Case>)| {
        (memory.similarity().distance(asked, case.content.kind(), &case.index), number)
    };
    let mut all: Vec<_> = memory.cases().map(of_case).collect();
    all.sort_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
    all.truncate(1 + RUNNERS_UP);
    all
}

#[test]
fn what_is_retrieved_is_what_a_look_at_every_case_finds() {
    let mut stream = Stream::new(31, "cases");
    for missing in [Similarity::CERTAIN, Similarity::UNIT_WEIGHTS, [0.25; Feature::COUNT]] {
        let mut memory = random_memory(&mut stream, 1_500);
        memory.similarity = Arc::new(Similarity { missing, ..Similarity::new(Scales::default()) });
        // Equal cases: the lowest number wins.
        let copy = memory.get(CaseNumber(700)).expect("it is there").as_ref().clone();
        memory.retain(copy.clone());
        for asked in (0..200).map(|_| random_situation(&mut stream)).chain([copy.index]) {
            let found = memory.retrieve(&asked).expect("there are cases");
            let found: Vec<_> =
                [found.best].into_iter().chain(found.runners_up).map(|found| (found.distance, found.number)).collect();
            assert_eq!(found, nearest(&memory, &asked));
        }
    }
}

#[test]
fn a_memory_that_forgets_and_learns_holds_what_it_should() {
    let mut stream = Stream::new(32, "cases");
    let mut memory = random_memory(&mut stream, 1_000);
    let before = memory.clone();
    let mut numbers: Vec<CaseNumber> = memory.cases().map(|(number, _)| number).collect();
    for _ in 0..3_000 {
        let forgotten = numbers.swap_remove(stream.index(numbers.len()));
        assert!(memory.forget(forgotten) && !memory.forget(forgotten));
        numbers.push(memory.retain(random_case(&mut stream)));
    }
    numbers.sort();
    let mut kept: Vec<CaseNumber> = memory.cases().map(|(number, _)| number).collect();
    kept.sort();
    assert_eq!(kept, numbers);
    assert_eq!(memory.len(), 1_000);
    assert!(memory.tables.iter().flatten().count() <= 2 * 4 + 2 * 1_000 / CHUNK, "chunks are joined");
    let asked = random_situation(&mut stream);
    assert_eq!(
        memory.retrieve(&asked).map(|found| found.best.distance),
        nearest(&memory, &asked).first().map(|best| best.0)
    );
    assert_eq!(before.len(), 1_000);
    assert!(before.cases().all(|(number, _)| number.0 < 1_000), "a copy does not notice");
}

#[test]
fn a_memory_is_the_same_after_it_was_written_and_read() {
    let mut stream = Stream::new(33, "cases");
    let mut memory = random_memory(&mut stream, 600);
    for number in (0..600).step_by(3) {
        memory.forget(CaseNumber(number));
    }
    memory.forget(CaseNumber(599));
    let bytes = postcard::to_allocvec(&memory).expect("it can be written");
    let mut read: CaseMemory = postcard::from_bytes(&bytes).expect("it can be read");
    assert_eq!(read, memory);
    assert_eq!(postcard::to_allocvec(&read).expect("it can be written"), bytes);
    let asked = random_situation(&mut stream);
    assert_eq!(read.retrieve(&asked), memory.retrieve(&asked));
    assert_eq!(read.retain(random_case(&mut stream)), CaseNumber(600), "no number is given twice");
}

#[test]
fn an_explanation_names_what_adds_to_the_distance() {
    let mut memory = CaseMemory::new(Similarity::new(Scales::default()));
    assert_eq!(memory.retrieve(&Situation::default()), None);
    let here = Point::new(10.0, 0.0);
    memory.retain(Case::new(Situation::of_route(here, Point::new(0.0, 50.0)), Content::Route(Route::default())));
    let found = memory.retrieve(&Situation::of_route(Point::origin(), Point::origin())).expect("there is one");
    assert_eq!(found.best.to_string(), "case 0 (route), distance 0.600: long-term-goal 0.500, place 0.100");
    assert_eq!(found.best.contributions[Feature::Place as usize], 0.1);
}

#[test]
fn a_change_reaches_one_copy_only() {
    let mut stream = Stream::new(34, "cases");
    let mut memory = random_memory(&mut stream, 10);
    let before = memory.clone();
    memory.change(CaseNumber(3), |case| case.counts.note(true));
    assert_eq!(memory.get(CaseNumber(3)).map(|case| case.counts.used), Some(1));
    assert_eq!(before.get(CaseNumber(3)).map(|case| case.counts.used), Some(0));
}

#[test]
fn the_next_goal_is_the_one_that_is_urgent_and_near() {
    let mut memory = CaseMemory::new(Similarity::new(Scales::default()));
    let mut goal = |x_m: f64, priority: f64, deadline_s: Option<f64>| {
        let place_in_map = Point::new(x_m, 0.0);
        let index = Situation {
            place_in_map: Some(place_in_map),
            priority: Some(priority),
            time_s: deadline_s,
            ..Situation::default()
        };
        memory.retain(Case::new(index, Content::Goal(Goal { place_in_map })))
    };
    let near = goal(5.0, 0.5, None);
    let far = goal(60.0, 0.5, None);
    let soon = goal(60.0, 0.5, Some(300.0));
    let important = goal(80.0, 1.0, Some(600.0));
    // The place is known and no goal is: goals come before all else.
    memory.retain(Case::new(Situation::of_route(Point::origin(), Point::origin()), Content::Route(Route::default())));
    memory.retain(Case::new(Situation::default(), Content::MetaPlan(MetaPlan::LocalizeFirst)));
    let asked = Situation {
        place_in_map: Some(Point::origin()),
        priority: Some(1.0),
        time_s: Some(0.0),
        ..Situation::default()
    };
    let mut order = Vec::new();
    while let Some(found) = memory.retrieve(&asked).filter(|found| found.best.kind == Kind::Goal) {
        order.push(found.best.number);
        memory.forget(found.best.number);
    }
    assert_eq!(order, [important, soon, near, far]);
    let found = memory.retrieve(&asked).expect("there are cases");
    assert_eq!(found.best.kind, Kind::MetaPlan, "with nothing to do it makes sure of where it is");
}

#[test]
fn a_robot_that_is_lost_is_told_to_localize_and_where_no_route_was_good_to_make_one() {
    let mut memory = CaseMemory::new(Similarity::new(Scales::default()));
    let (lab, hall, office) = (Point::new(5.0, 5.0), Point::new(20.0, 5.0), Point::new(90.0, 20.0));
    let route = memory.retain(Case::new(Situation::of_route(lab, hall), Content::Route(Route::default())));
    let make = memory.retain(Case::new(Situation::of_route(lab, office), Content::MetaPlan(MetaPlan::MakeRoute)));
    let lost = Situation { long_term_goal_in_map: Some(hall), ..Situation::default() };
    let localize = memory.retain(Case::new(lost.clone(), Content::MetaPlan(MetaPlan::LocalizeFirst)));
    let number = |asked: &Situation| memory.retrieve(asked).map(|found| found.best.number);
    assert_eq!(number(&Situation { long_term_goal_in_map: Some(office), ..lost }), Some(localize));
    assert_eq!(number(&Situation::of_route(Point::new(6.0, 5.0), Point::new(22.0, 5.0))), Some(route));
    assert_eq!(number(&Situation::of_route(Point::new(6.0, 5.0), Point::new(85.0, 20.0))), Some(make));
}
