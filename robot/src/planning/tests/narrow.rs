//! Ways through narrow places, beside the bodies that make them so.

use super::*;
use crate::planning::narrow::GAP_AIR_M;

const RADIUS_M: f64 = 0.265;

/// Two halves, and a gap of some width around a point of the wall between them.
fn halves(at_y: f64, width_m: f64, more: &str) -> Building {
    let text = format!(
        "name = \"w\"\nsize = [10.0, 6.0]\nstart = [2.0, 3.0, 0]\n\
         [[wall]]\nline = [[0.1, 0.1], [9.9, 0.1], [9.9, 5.9], [0.1, 5.9], [0.1, 0.1]]\nthickness = 0.2\n\
         [[room]]\nname = \"east\"\nrect = [5.1, 0.2, 9.8, 5.8]\n\
         [[place]]\nname = \"Bed\"\npose = [8.0, 3.0, 0]\nroom = \"east\"\n\
         [[wall]]\nline = [[5.0, 0.1], [5.0, {}]]\n[[wall]]\nline = [[5.0, {}], [5.0, 5.9]]\n{more}",
        at_y - width_m / 2.0 - 0.075,
        at_y + width_m / 2.0 + 0.075,
    );
    Building::new(World::parse(&text, "w.toml").unwrap_or_else(|error| panic!("{error}")))
}

fn way(building: &Building) -> Option<Vec<Point>> {
    building.planner.cost_to_go(Point::new(8.0, 3.0)).path(Point::new(2.0, 3.0))
}

/// How near a way comes to what stands there.
fn least_m(building: &Building, way: &[Point]) -> f64 {
    let solids = building.world.solids();
    let along =
        way.windows(2).flat_map(|leg| (0..=100).map(|step| leg[0] + (leg[1] - leg[0]) * f64::from(step) / 100.0));
    let off_m = |at: Point| solids.iter().map(|solid| solid.outline.distance_m(at)).fold(f64::INFINITY, f64::min);
    along.map(off_m).fold(f64::INFINITY, f64::min)
}

#[test]
fn a_gap_a_little_wider_than_the_robot_is_gone_through_wherever_it_lies() {
    for step in 0..12 {
        let building = halves(3.0 + 0.013 * f64::from(step), 2.0 * RADIUS_M + 0.08, "");
        let way = way(&building).unwrap_or_else(|| panic!("no way, {step}"));
        assert!(least_m(&building, &way) >= RADIUS_M, "{step}: {}", least_m(&building, &way));
        let plan =
            building.plan(Pose::new(2.0, 3.0, 0.0), building.world.place("bed").expect("a place")).expect("a plan");
        assert!(plan.targets.len() >= 2, "it is gone through straight: {plan:?}");
    }
}

#[test]
fn a_gap_that_is_too_narrow_is_named_with_its_width_and_what_is_needed() {
    let building = halves(3.02, 0.56, "");
    assert_eq!(way(&building), None);
    let place = building.world.place("bed").expect("a place");
    let Err(Unreachable { reason }) = building.plan(Pose::new(2.0, 3.0, 0.0), place) else { panic!("there is a way") };
    assert!(reason.starts_with("the gap at (5.") && reason.contains(" m wide, and the robot needs 0.60 m"), "{reason}");
    let width_m: f64 =
        reason.split(" is ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap_or("").parse().expect("a width");
    assert!((width_m - 0.56).abs() < 0.021, "{reason}");
    const { assert!(2.0 * RADIUS_M + GAP_AIR_M > 0.56) };
}

#[test]
fn what_was_seen_closes_a_narrow_gap() {
    let building = halves(3.0, 0.65, "");
    let around = building.planner.cost_to_go_around(Point::new(8.0, 3.0), &[Point::new(5.0, 3.1)]);
    assert_eq!(around.path(Point::new(2.0, 3.0)), None);
}

/// Few cells are looked at again, and of these fewer are open: ways cost what they did.
#[test]
fn little_of_a_building_is_narrow() {
    for name in ["dept", "hall", "school", "olin-rice"] {
        let building = Building::builtin(name);
        let (narrow, all) = (building.planner.grid.narrow.len(), building.planner.grid.prices.len());
        assert!(narrow * 100 < all, "{name}: {narrow} of {all}");
    }
}
