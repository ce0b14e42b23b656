use super::sight::Sight;
use super::*;
use crate::control::{ARRIVAL_M, PASSING_M};
use crate::route::Route;
use crate::routes::TravelTimes;
use rpl_random::Stream;
use rpl_robot::geometry::{Point, Pose, distance_m};
use rpl_robot::world::{Axis, Door, Place, Rect, Room, Wall, World};

fn world(places: &[(&str, f64, f64)], rooms: &[(&str, [f64; 4])], walls: &[&[(f64, f64)]]) -> World {
    let mut world =
        World::parse("name = \"test\"\nsize = [30.0, 12.0]\nstart = [1.0, 1.0, 0]\n", "test.toml").expect("a world");
    world.places = places
        .iter()
        .map(|&(name, x_m, y_m)| Place {
            name: name.to_string(),
            pose_in_map: Pose::new(x_m, y_m, 0.0),
            room: None,
            charges: false,
        })
        .collect();
    world.rooms = rooms
        .iter()
        .map(|&(name, [left, low, right, high])| Room {
            name: name.to_string(),
            rect: Rect { min: Point::new(left, low), max: Point::new(right, high) },
        })
        .collect();
    world.walls = walls
        .iter()
        .map(|line| Wall { line: line.iter().map(|&(x, y)| Point::new(x, y)).collect(), thickness_m: 0.1 })
        .collect();
    world
}

/// Random places of which the first five each see the next.
pub(crate) fn places_in_a_row() -> Places {
    let mut stream = Stream::new(1, "places");
    loop {
        let places = random_places(&mut stream);
        if (0..4).all(|at| places.stretch(PlaceId(at), PlaceId(at + 1)).is_some()) {
            return places;
        }
    }
}

/// Places on a grid without walls, some of them left out, the costs of their stretches whatever they are.
pub(crate) fn random_places(stream: &mut Stream) -> Places {
    let points: Vec<Point> = (0..60)
        .filter(|_| stream.chance(0.8))
        .map(|index| Point::new(f64::from(index % 10) * 8.0, f64::from(index / 10) * 8.0))
        .collect();
    let all: Vec<KnownPlace> = points
        .iter()
        .enumerate()
        .map(|(index, &at_in_map)| KnownPlace { name: format!("p{index}"), at_in_map, influence: None })
        .collect();
    let mut pairs = Vec::new();
    for one in 0..points.len() {
        let near = (one + 1..points.len()).filter(|&other| distance_m(points[one], points[other]) < 8.5);
        pairs.extend(near.filter(|_| stream.chance(0.8)).map(|other| (one, other)));
    }
    Places::joined(all, &pairs, |_, _| 1.0)
}

#[test]
fn places_are_adjacent_that_see_each_other_with_none_between() {
    let world = world(
        &[("west", 2.0, 2.0), ("middle", 8.0, 2.1), ("east", 14.0, 2.0), ("behind", 8.0, 6.0), ("far", 29.0, 2.0)],
        &[],
        &[&[(0.0, 4.0), (30.0, 4.0)]],
    );
    let places = Places::new(&world, 0.25).expect("it has places");
    let beside = |name: &str| -> Vec<&str> {
        let place = places.named(name).expect("it is there");
        places.stretches[place.index()].iter().map(|stretch| places.name(stretch.to)).collect()
    };
    assert_eq!(beside("west"), ["middle"]);
    assert_eq!(beside("middle"), ["west", "east"]);
    assert_eq!(beside("east"), ["middle", "far"]);
    assert!(beside("behind").is_empty());
}

#[test]
fn a_robot_sees_through_a_door_it_fits_through() {
    let walls: [&[(f64, f64)]; 2] = [&[(0.0, 4.0), (7.6, 4.0)], &[(8.4, 4.0), (30.0, 4.0)]];
    let world = world(&[("in", 8.0, 6.0), ("out", 8.0, 2.0)], &[], &walls);
    let count = |radius_m: f64| Places::new(&world, radius_m).expect("it has places").stretch_count;
    assert_eq!((count(0.25), count(0.5)), (1, 0));
}

/// The names of the places on the quickest way, each in sight of the next.
fn way(world: &World, radius_m: f64, from: &str, to: &str) -> Option<Vec<String>> {
    let places = Places::new(world, radius_m).expect("it has places");
    let sight = Sight::new(&world.map(0.05), radius_m);
    for from in places.ids() {
        let is_seen = |to: PlaceId| sight.is_free(places.at_in_map(from), places.at_in_map(to));
        assert!(places.stretches[from.index()].iter().all(|stretch| is_seen(stretch.to)), "{}", places.name(from));
    }
    let [from, to] = [from, to].map(|name| places.named(name).expect("it is there"));
    let way = TravelTimes::of_map(&places, 1.0).quickest_way(&places, from, to)?;
    Some(way.places.iter().map(|&place| places.name(place).to_string()).collect())
}

#[test]
fn places_out_of_sight_of_each_other_are_joined_as_far_as_the_floor_leads() {
    let open: [&[(f64, f64)]; 2] = [&[(0.0, 4.0), (7.6, 4.0)], &[(8.4, 4.0), (30.0, 4.0)]];
    let places = [("in", 12.0, 8.0), ("out", 20.0, 2.0), ("key-position-1", 21.0, 2.0)];
    let gap = world(&places, &[], &open);
    let over = way(&gap, 0.25, "in", "out").expect("the floor leads there");
    let between = &over[1..over.len() - 1];
    assert!(!between.is_empty() && between.iter().all(|name| name.starts_with("key-position-")), "{over:?}");
    assert!(!between.contains(&"key-position-1".to_string()), "that is a place of the world: {over:?}");
    assert_eq!(way(&gap, 0.5, "in", "out"), None, "it does not fit through");
    let mut door = world(&places, &[], &[&[(0.0, 4.0), (30.0, 4.0)]]);
    let at = Point::new(8.0, 4.0);
    door.doors = vec![Door { room: "room".into(), at, width_m: 0.9, axis: Axis::X, open: true, mapped_open: true }];
    assert_eq!(way(&door, 0.25, "in", "out").expect("through the door").len(), 4, "inside, outside");
    door.doors[0].mapped_open = false;
    assert_eq!(way(&door, 0.25, "in", "out"), None);
}

#[test]
fn a_stop_before_a_narrow_way_is_gone_up_to() {
    let walls: [&[(f64, f64)]; 2] = [&[(0.0, 4.0), (7.6, 4.0)], &[(8.4, 4.0), (30.0, 4.0)]];
    let world = world(&[("in", 8.0, 6.0), ("out", 8.0, 2.0), ("hall", 16.0, 2.0)], &[], &walls);
    let places = Places::new(&world, 0.25).expect("it has places");
    let reached_m = |names: [&str; 2]| -> Vec<f64> {
        let route = Route::over(&names.map(|name| places.named(name).expect("it is there")));
        route.waypoints(&places).iter().map(|waypoint| waypoint.reached_m).collect()
    };
    assert_eq!(reached_m(["out", "in"]), [ARRIVAL_M, ARRIVAL_M]);
    assert_eq!(reached_m(["out", "hall"]), [PASSING_M, ARRIVAL_M]);
}

#[test]
fn a_point_counts_as_at_a_place_of_its_room() {
    let places = Places::new(
        &world(
            &[("hall", 8.0, 2.0), ("inside", 2.0, 10.0)],
            &[("room", [0.0, 4.0, 12.0, 12.0])],
            &[&[(0.0, 4.0), (30.0, 4.0)]],
        ),
        0.25,
    )
    .expect("it has places");
    assert_eq!(places.name(places.closest(Point::new(8.0, 4.2))), "inside", "the hall's is nearer, behind the wall");
    assert_eq!(places.name(places.closest(Point::new(2.0, 3.8))), "hall", "that of the room is for the room");
}

#[test]
fn a_world_without_places_says_what_is_missing() {
    let error = Places::new(&world(&[], &[], &[]), 0.25).expect_err("it has none");
    assert!(error.to_string().contains("has no places; routes lead over places: add [[place]]"), "{error}");
}

#[test]
fn ways_are_as_short_as_can_be_and_never_shorter_than_the_bound() {
    for seed in 1..20 {
        let places = random_places(&mut Stream::new(seed, "places"));
        // Floyd and Warshall.
        let count = places.count();
        let mut shortest_m = vec![vec![f64::INFINITY; count]; count];
        for from in places.ids() {
            shortest_m[from.index()][from.index()] = 0.0;
            places.stretches[from.index()].iter().for_each(|to| shortest_m[from.index()][to.to.index()] = to.length_m);
        }
        for over in 0..count {
            for from in 0..count {
                for to in 0..count {
                    shortest_m[from][to] = shortest_m[from][to].min(shortest_m[from][over] + shortest_m[over][to]);
                }
            }
        }
        for (from, to) in places.ids().flat_map(|from| places.ids().map(move |to| (from, to))) {
            let bounds = &places.lower_bounds;
            let least_m = shortest_m[from.index()][to.index()];
            let way = shortest_way(
                &places.stretches,
                from,
                to,
                |_, stretch| stretch.length_m,
                |one, other| bounds.between_m(one, other),
            );
            assert_eq!(way.is_some(), least_m.is_finite());
            let Some(way) = way else { continue };
            assert!((way.cost - least_m).abs() < 1e-9);
            assert!(bounds.between_m(from, to) <= least_m + 1e-9);
            assert_eq!((way.places.first(), way.places.last()), (Some(&from), Some(&to)));
            assert!(way.places.windows(2).all(|two| places.stretch(two[0], two[1]).is_some()));
        }
    }
}
