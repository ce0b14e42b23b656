//! What lies beyond the edge of a world is for the simulator what it is for the map: nothing, and nobody gets there.

use super::*;
use crate::occupancy::DistanceField;

/// Walls along two sides, and bodies that reach beyond the edge or lie there.
const BODIES: &str = "[[wall]]\nline = [[-3.0, 0.1], [13.0, 0.1]]\nthickness = 0.2\n\
    [[wall]]\nline = [[-0.1, 0.0], [-0.1, 6.0]]\nthickness = 0.2\n\
    [[wall]]\nline = [[12.0, 0.0], [12.0, 6.0]]\n\
    [[object]]\nname = \"pillar\"\ncircle = [9.9, 3.0, 0.4]\n\
    [[object]]\nname = \"desk\"\nrect = [4.0, 5.5, 7.0, 6.4]\n";

#[test]
fn no_sensor_finds_anything_beyond_an_open_edge() {
    for robot in ["b21", "b21-laser"] {
        let model = open_lot(exact(robot), "");
        let mut state = model.start(1);
        model.teleport(&mut state, Pose::new(9.0, 3.0, 0.0)).expect("free");
        let percept = model.step(&mut state, &drive(0.0, 0.0));
        let (sonar, laser) = (&model.robot().sonar, &model.robot().laser);
        let sonar_m = sonar.as_ref().map_or(0.0, |sonar| sonar.range_m) as f32;
        assert!(percept.sonar_m.iter().flatten().all(|&range_m| range_m == sonar_m), "{:?}", percept.sonar_m);
        let laser_m = laser.as_ref().map_or(0.0, |laser| laser.scanner.range_m) as f32;
        assert!(percept.laser_m.iter().flatten().all(|&range_m| range_m == laser_m), "{:?}", percept.laser_m);
    }
}

#[test]
fn the_open_edge_stops_the_robot_and_counts_as_unseen() {
    let model = open_lot(exact("b21"), "");
    let mut state = model.start(1);
    let percept = steps(&model, &mut state, &drive(0.5, 0.0), 400);
    assert!(percept.bumped && (state.robot_in_map.x_m - (10.0 - model.robot().radius_m)).abs() < 1e-6);
    assert_eq!((state.contacts.unseen, state.contacts.caused), (1, 0));
}

#[test]
fn people_stay_within_an_open_edge() {
    let model = open_lot(exact("b21"), "[[person]]\npath = [[1.0, 1.0], [9.99, 1.0], [9.99, 5.99]]\nspeed = 1.0\n");
    let mut state = model.start(3);
    for _ in 0..600 {
        model.step(&mut state, &drive(0.0, 0.0));
        assert!(model.world.bounds().contains(state.people[0].at_in_map), "{:?}", state.people[0].at_in_map);
    }
}

/// Rays through a map of small cells, and a laser in the world.
#[test]
fn a_laser_sees_what_the_map_has_also_where_bodies_reach_beyond_the_edge() {
    let model = open_lot(exact("b21-laser"), BODIES);
    let field = DistanceField::new(&model.world.map(0.005));
    let mut stream = Stream::new(641, "poses");
    let (mut rays, mut far) = (0, 0);
    for _ in 0..20 {
        let state = model.start(1);
        let pose = free_pose(&model, &state, &mut stream);
        let scanner = model.robot().laser.expect("it has one").scanner;
        for (beam, range_m) in model.laser_ranges(&state, pose).into_iter().enumerate() {
            let (sin, cos) = libm::sincos(pose.heading_rad + scanner.direction_rad(beam));
            let mapped_m = field.cast_m(pose.point(), (cos, sin), scanner.range_m);
            rays += 1;
            // A surface that is met askew is met by some cells sooner or later.
            far += usize::from((mapped_m - range_m).abs() > 0.05);
        }
    }
    assert!(far * 200 < rays, "{far} of {rays}");
}
