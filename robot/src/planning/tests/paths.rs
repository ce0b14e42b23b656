//! Ways in single maps.

use super::*;
use proptest::prelude::*;

proptest! {
    #[test]
    fn paths_lead_through_free_cells_and_cost_no_more_than_the_whole(
        occupied in proptest::collection::vec(0u8..9, 400),
        from in 0usize..400,
        to in 0usize..400,
    ) {
        let inflation = Inflation { body_radius_m: 0.06, comfortable_distance_m: 0.4, closeness_weight: 5.0 };
        let map = grid(20, 20, &occupied);
        let model = PlannerModel::new(&map, inflation);
        let (from, to) = (map.centre(from % 20, from / 20), map.centre(to % 20, to / 20));
        let costs = model.cost_to_go(to);
        let stands_free = model.is_traversable(from) && model.is_traversable(to);
        if stands_free {
            prop_assert_eq!(costs.path(from).is_some(), costs.cost_m(from).is_some());
        }
        if let Some(path) = costs.path(from).filter(|_| stands_free) {
            prop_assert_eq!((path[0], path[path.len() - 1]), (from, to));
            let mut cost_m = 0.0;
            for leg in path.windows(2) {
                for step in 0..=100 {
                    let point = leg[0] + (leg[1] - leg[0]) * f64::from(step) / 100.0;
                    // A way along the edge between two cells may be counted to either.
                    let sides = [-1e-9, 1e-9].map(|side| point + nalgebra::Vector2::repeat(side));
                    prop_assert!(sides.iter().any(|&side| model.is_traversable(side)), "{point}");
                }
                cost_m += model.grid.straight_cost_m(leg[0], leg[1]).unwrap_or(f64::INFINITY);
            }
            let whole_m = costs.cost_m(from).unwrap_or(0.0);
            prop_assert!(cost_m <= whole_m * 1.0001 + 1e-9, "{cost_m} {whole_m}");
        }
    }
}

#[test]
fn open_floor_paths_are_straight() {
    let map = grid(60, 50, &[]);
    let model = PlannerModel::new(&map, POINT);
    let (from, to) = (Point::new(-0.73, 2.22), Point::new(4.61, 5.37));
    assert_eq!(model.cost_to_go(to).path(from), Some(vec![from, to]));
}

#[test]
fn blocked_points_close_a_door_and_leave_a_detour() {
    // Two rooms of 3 × 3 m side by side; two openings of 0.9 m in the wall between them.
    let mut map = grid(61, 30, &[]);
    for row in (0..30).filter(|row| !(3..12).contains(row) && !(18..27).contains(row)) {
        map.set(30, row, Cell::Occupied);
    }
    let model = PlannerModel::new(&map, Inflation::of_robot(0.265));
    let (from, to) = (map.centre(20, 7), map.centre(40, 7));
    let lower = map.centre(30, 7);
    let upper = map.centre(30, 22);
    let free = path_length_m(&model.cost_to_go(to).path(from).expect("a way"));
    let detour = path_length_m(&model.cost_to_go_around(to, &[lower]).path(from).expect("a way"));
    assert!(free < 2.1 && detour > 3.0, "{free} {detour}");
    assert_eq!(model.cost_to_go_around(to, &[lower, upper]).path(from), None);
    assert_eq!(model.cost_to_go_around(to, &[]), model.cost_to_go(to));
}

#[test]
fn unknown_cells_are_not_entered() {
    let mut map = grid(30, 10, &[]);
    for row in 0..10 {
        map.set(15, row, Cell::Unknown);
    }
    let model = PlannerModel::new(&map, POINT);
    assert_eq!(model.cost_to_go(map.centre(25, 5)).path(map.centre(5, 5)), None);
}

#[test]
fn a_start_too_near_the_wall_is_left_for_free_floor() {
    let map = grid(40, 40, &[]);
    let model = PlannerModel::new(&map, Inflation::of_robot(0.265));
    let (from, to) = (map.centre(0, 20), map.centre(30, 20));
    assert!(!model.is_traversable(from));
    let path = model.cost_to_go(to).path(from).expect("a way");
    assert_eq!(path[0], from);
    assert!(path[1..].iter().all(|&point| model.is_traversable(point)));
    assert!(distance_m(path[0], path[1]) < 0.35);
}

#[test]
fn paths_keep_clear_of_a_wall_they_could_graze() {
    // A wall reaching into the room; the shortest way grazes its tip.
    let mut map = grid(60, 60, &[]);
    for row in 0..30 {
        map.set(30, row, Cell::Occupied);
    }
    let model = PlannerModel::new(&map, Inflation::of_robot(0.265));
    let path = model.cost_to_go(map.centre(55, 15)).path(map.centre(5, 15)).expect("a way");
    let least_m = path
        .windows(2)
        .flat_map(|leg| (0..=50).map(|step| leg[0] + (leg[1] - leg[0]) * f64::from(step) / 50.0))
        .map(|point| model.obstacle_distance_m(point))
        .fold(f64::INFINITY, f64::min);
    assert!(least_m > 0.4, "{least_m}");
}
