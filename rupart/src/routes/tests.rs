use super::*;
use crate::memory::{CaseMemory, CaseNumber};
use crate::places::tests::{places_in_a_row, random_places};
use crate::places::{PlaceId, Places};
use crate::route::{Route, Stop};
use crate::similarity::{Scales, Similarity};
use rpl_random::Stream;
use rpl_robot::geometry::Point;

const SPEED_MPS: f64 = 0.5;

/// Two random places with a way between them.
fn random_ends(stream: &mut Stream, places: &Places, times: &TravelTimes) -> (PlaceId, PlaceId) {
    loop {
        let mut place = || PlaceId(stream.index(places.count()) as u32);
        let (from, to) = (place(), place());
        if from != to && times.quickest_way(places, from, to).is_some() {
            return (from, to);
        }
    }
}

fn random_routes(stream: &mut Stream, places: &Places, times: &TravelTimes, count: usize) -> Vec<(CaseNumber, Route)> {
    let mut route = || {
        let (from, to) = random_ends(stream, places, times);
        times.quickest_way(places, from, to).map(|way| Route::over(&way.places)).expect("there is a way")
    };
    (0..count as u32).map(|number| (CaseNumber(number), route())).collect()
}

/// Each stop sees the next, the times fit, and the ends are those asked for.
fn assert_leads(places: &Places, adapted: &Adapted, problem: &RouteProblem) {
    let route = &adapted.route;
    assert_eq!((route.stops.first(), route.stops.last()), (Some(&problem.start), Some(&problem.goal)));
    assert_eq!(route.times_s.len() + 1, route.stops.len());
    for two in route.stops.windows(2) {
        if let (Some(from), Some(to)) = (two[0].known(), two[1].known()) {
            assert!(places.stretch(from, to).is_some(), "{route:?}");
        }
    }
}

#[test]
fn adapted_routes_lead_from_the_start_to_the_goal_and_guided_ones_are_not_poor() {
    for seed in 1..20 {
        let mut stream = Stream::new(seed, "routes");
        let places = random_places(&mut stream);
        let times = TravelTimes::of_map(&places, SPEED_MPS);
        let routes = random_routes(&mut stream, &places, &times, 10);
        for _ in 0..20 {
            let (from, to) = random_ends(&mut stream, &places, &times);
            let start = Stop::At(places.at_in_map(from) + rpl_robot::geometry::Vector::new(0.5, 0.5));
            for (start, goal) in [(Stop::Known(from), Stop::Known(to)), (start, Stop::Known(to))] {
                let problem = RouteProblem::new(&places, &times, start, goal);
                let (number, case) = &routes[stream.index(routes.len())];
                if let Some(literal) = adapt_literally(&places, &times, &problem, *number, case) {
                    assert_leads(&places, &literal, &problem);
                }
                let cases = routes.iter().map(|(number, route)| (*number, route));
                let guided = adapt_guided(&places, &times, &problem, cases, Guidance::USUAL).expect("there is a way");
                assert_leads(&places, &guided, &problem);
                let whole_s = times.of_route_s(&places, &guided.route);
                let best_s = times.quickest_way(&places, problem.start_place, to).expect("there is a way").cost;
                assert!(whole_s <= 1.1 * best_s + 1.5 / SPEED_MPS, "{whole_s} {best_s}");
            }
        }
    }
}

#[test]
fn overlaps_are_cut_at_the_first_common_place() {
    let known = |ids: &[u32]| Route::over(&ids.iter().copied().map(PlaceId).collect::<Vec<_>>());
    let mut stream = Stream::new(1, "places");
    // A row of places: 0 – 1 – 2 – 3 – 4, and the case leads from 3 back to 1 and on to nothing else.
    let places = loop {
        let places = random_places(&mut stream);
        if (0..4).all(|at| places.stretch(PlaceId(at), PlaceId(at + 1)).is_some()) {
            break places;
        }
    };
    let times = TravelTimes::of_map(&places, SPEED_MPS);
    let problem = RouteProblem::new(&places, &times, Stop::Known(PlaceId(0)), Stop::Known(PlaceId(4)));
    let adapted = adapt_literally(&places, &times, &problem, CaseNumber(7), &known(&[1, 2, 3])).expect("a way");
    assert_eq!(adapted.route, known(&[0, 1, 2, 3, 4]));
    assert_eq!((adapted.generated_steps, adapted.new_steps), (2, 2));
    // The way to its beginning at 3 and the way from its end at 1 both overlap with it.
    let adapted = adapt_literally(&places, &times, &problem, CaseNumber(7), &known(&[3, 2, 1])).expect("a way");
    assert_eq!(adapted.route, known(&[0, 1, 2, 3, 4]));
    assert_eq!(adapted.generated_steps, 6);
    let guided =
        adapt_guided(&places, &times, &problem, [(CaseNumber(7), &known(&[3, 2, 1]))].into_iter(), Guidance::USUAL);
    let guided = guided.expect("a way");
    assert_eq!(guided.route, known(&[0, 1, 2, 3, 4]));
    assert_eq!((guided.case, guided.generated_steps, guided.new_steps), (Some(CaseNumber(7)), 2, 2));
}

#[test]
fn a_round_is_left_out() {
    let mut route = Route::over(&[1, 2, 3, 4, 2, 5].map(PlaceId));
    route.times_s = (0..5).map(|step| Some(f64::from(step))).collect();
    route.cut_rounds();
    assert_eq!(route.stops, Route::over(&[1, 2, 5].map(PlaceId)).stops);
    assert_eq!(route.times_s, [Some(0.0), Some(4.0)]);
}

#[test]
fn measured_times_reach_every_case_and_lead_around_what_is_slow() {
    let mut stream = Stream::new(5, "routes");
    let places = random_places(&mut stream);
    let times = TravelTimes::of_map(&places, SPEED_MPS);
    let mut memory = CaseMemory::new(Similarity::new(Scales::default()));
    // A way of some steps besides which there is another.
    let (from, to, mut route) = loop {
        let (from, to) = random_ends(&mut stream, &places, &times);
        let way = times.quickest_way(&places, from, to).expect("there is a way");
        let mut slow = Route::over(&way.places);
        slow.times_s = vec![Some(1e4); slow.times_s.len()];
        let slow_times = TravelTimes::of_routes(&places, SPEED_MPS, [&slow].into_iter());
        if way.places.len() > 4 && slow_times.quickest_way(&places, from, to).is_some_and(|way| way.cost < 1e4) {
            break (from, to, Route::over(&way.places));
        }
    };
    learn_route(&mut memory, &places, route.part(route.stops.len() - 1, 0));
    route.times_s = vec![Some(1e4); route.times_s.len()];
    learn_times(&mut memory, &route);
    let (number, case) = memory.cases().next().expect("it was retained");
    let crate::case::Content::Route(backwards) = &case.content else { panic!("a route was retained") };
    assert_eq!(backwards.times_s, route.times_s);
    let times = TravelTimes::of_routes(&places, SPEED_MPS, [backwards].into_iter());
    assert_eq!(times.of_route_s(&places, &route), 1e4 * route.times_s.len() as f64);
    let problem = RouteProblem::new(&places, &times, Stop::Known(from), Stop::Known(to));
    let around = adapt_guided(&places, &times, &problem, [(number, backwards)].into_iter(), Guidance::USUAL)
        .expect("there is a way");
    assert!(times.of_route_s(&places, &around.route) < 1e4);
}

#[test]
fn a_route_within_another_is_what_a_memory_can_do_without() {
    let places = places_in_a_row();
    let times = TravelTimes::of_map(&places, SPEED_MPS);
    let whole = Route::over(&[0, 1, 2, 3, 4].map(PlaceId));
    let part = whole.part(3, 1);
    let routes = [(CaseNumber(1), &whole), (CaseNumber(2), &part)];
    let found = competences(&places, &times, &routes);
    assert_eq!((found[0].coverage, found[0].reachability), (1, 0));
    assert_eq!((found[1].coverage, found[1].reachability), (0, 1));
    assert_eq!(reachability(&places, &times, &part, routes[..1].iter().copied()), 1);
    assert_eq!(reachability(&places, &times, &whole, routes[1..].iter().copied()), 0);
}

#[test]
fn coordinates_stand_at_the_ends() {
    let mut stream = Stream::new(3, "places");
    let places = random_places(&mut stream);
    let times = TravelTimes::of_map(&places, SPEED_MPS);
    let (from, to) = random_ends(&mut stream, &places, &times);
    let near = |place: PlaceId| Stop::At(Point::new(places.at_in_map(place).x + 0.3, places.at_in_map(place).y));
    let problem = RouteProblem::new(&places, &times, near(from), near(to));
    let adapted = adapt_guided(&places, &times, &problem, std::iter::empty(), Guidance::USUAL).expect("there is a way");
    assert_leads(&places, &adapted, &problem);
    assert_eq!(adapted.case, None);
    let known = &adapted.route.stops[1..adapted.route.stops.len() - 1];
    assert_eq!((known.first(), known.last()), (Some(&Stop::Known(from)), Some(&Stop::Known(to))));
}

/// A robot that drives at two thirds of its speed everywhere uses what it knows, and does not hope for what nobody
/// has driven.
#[test]
fn what_is_known_is_preferred_though_the_robot_is_slower_than_its_speed() {
    for seed in 1..10 {
        let mut stream = Stream::new(seed, "routes");
        let places = random_places(&mut stream);
        let map = TravelTimes::of_map(&places, SPEED_MPS);
        let (from, to) = random_ends(&mut stream, &places, &map);
        let way = map.quickest_way(&places, from, to).expect("there is a way");
        let mut driven = Route::over(&way.places);
        let length_m = |two: &[PlaceId]| places.stretch(two[0], two[1]).expect("a stretch").length_m;
        driven.times_s = way.places.windows(2).map(|two| Some(1.5 * length_m(two) / SPEED_MPS)).collect();
        let times = TravelTimes::of_routes(&places, SPEED_MPS, [&driven].into_iter());
        assert!((times.pace - 1.5).abs() < 1e-9, "{}", times.pace);
        let problem = RouteProblem::new(&places, &times, Stop::Known(to), Stop::Known(from));
        let cases = [(CaseNumber(0), &driven)].into_iter();
        let back = adapt_guided(&places, &times, &problem, cases, Guidance::USUAL).expect("there is a way");
        assert_eq!((back.case, back.new_steps, back.is_repaired), (Some(CaseNumber(0)), 0, false));
    }
}

/// Whatever leads on from the start holds the robot up, and a case knows a way that no chain of places does.
#[test]
fn a_case_that_knows_a_way_round_is_used_where_the_short_way_is_known_to_be_slow() {
    for seed in 1..10 {
        let mut stream = Stream::new(seed, "routes");
        let places = random_places(&mut stream);
        let map = TravelTimes::of_map(&places, SPEED_MPS);
        let (from, to) = random_ends(&mut stream, &places, &map);
        let slow = |to: PlaceId| Route { times_s: vec![Some(1e4)], ..Route::over(&[from, to]) };
        let mut routes: Vec<Route> = places.stretches[from.index()].iter().map(|stretch| slow(stretch.to)).collect();
        // Twice as long as the straight way, more than new ways are taken to be.
        let across = places.at_in_map(to) - places.at_in_map(from);
        let aside = rpl_robot::geometry::Vector::new(-across.y, across.x) * 0.87;
        let middle = places.at_in_map(from) + across / 2.0 + aside;
        routes.push(Route::new(vec![Stop::Known(from), Stop::At(middle), Stop::Known(to)]));
        let times = TravelTimes::of_routes(&places, SPEED_MPS, routes.iter());
        assert_eq!(times.pace, 1.0, "who was held up is not slow elsewhere");
        let problem = RouteProblem::new(&places, &times, Stop::Known(from), Stop::Known(to));
        let cases = (0..).map(CaseNumber).zip(&routes);
        let round = adapt_guided(&places, &times, &problem, cases, Guidance::USUAL).expect("there is a way");
        assert_eq!(round.route.stops, routes.last().expect("there is one").stops, "{seed}");
        assert_eq!((round.case, round.new_steps), (Some(CaseNumber(routes.len() as u32 - 1)), 0));
    }
}
