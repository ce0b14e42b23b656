//! Hallways whose direction is known: wall lines at known places, sonars without errors, and the real simulator.

use super::*;
use crate::drive::{Drive, corridor};
use rpl_robot::description::RobotDescription;
use rpl_robot::geometry::Point;

/// How far the axis is off the hallway's true direction.
fn error_rad(drive: &Drive) -> Option<f64> {
    let axis = drive.registration.axis()?;
    Some(wrap_angle_rad(axis.heading_in_odom_rad - drive.true_axis_in_odom_rad()).abs())
}

fn register(drive: &mut Drive, most_m: f64) -> f64 {
    while drive.registration.axis().is_none() && drive.state.distance_driven_m < most_m {
        drive.step();
    }
    error_rad(drive).expect("there are walls")
}

#[test]
fn between_two_walls_the_axis_is_theirs() {
    for (guess_off_rad, exact) in [(0.3, true), (-0.3, true), (0.2, false), (-0.1, false)] {
        let mut robot = RobotDescription::clone(&RobotDescription::builtin("b21").expect("built in"));
        if exact {
            robot = robot.without_errors();
        }
        let mut drive = Drive::begin(&corridor(""), robot, 3, guess_off_rad);
        let off_rad = register(&mut drive, 2.0);
        assert!(off_rad < if exact { 0.003 } else { 0.0175 }, "{off_rad}");
        let axis = drive.registration.axis().expect("registered");
        let width_m = axis.width_m.expect("two walls");
        assert!((width_m - 2.2).abs() < 0.02, "{width_m}");
        let distances_m = Side::ALL.map(|side| axis.wall_distance_m(drive.odometry_in_odom, side).expect("a wall"));
        let from_south_m = drive.state.robot_in_map.y_m - 4.0;
        assert!((distances_m[1] - from_south_m).abs() < 0.03, "{distances_m:?} {from_south_m}");
        assert!(axis.wall_m >= 0.8);
    }
}

#[test]
fn half_a_door_does_not_tilt_it() {
    // A closed door on each side, of which the robot passes the one half and not the other.
    let doors = "[[room]]\nname = \"a\"\nrect = [1.5, 6.35, 3.5, 9.8]\n\
        [[room]]\nname = \"b\"\nrect = [0.2, 0.2, 3.5, 3.85]\n\
        [[door]]\nroom = \"a\"\nat = [2.2, 6.275]\nwidth = 1.0\naxis = \"x\"\nopen = false\n\
        [[door]]\nroom = \"b\"\nat = [1.5, 3.925]\nwidth = 1.0\naxis = \"x\"\nopen = false\n";
    for seed in 0..3 {
        let robot = RobotDescription::clone(&RobotDescription::builtin("b21").expect("built in"));
        let mut drive = Drive::begin(&corridor(doors), robot, seed, 0.1);
        let off_rad = register(&mut drive, 2.5);
        assert!(off_rad < 2_f64.to_radians(), "seed {seed}: {}°", off_rad.to_degrees());
    }
}

#[test]
fn turned_by_hand_it_is_found_to_be_wrong_and_put_right() {
    let robot = RobotDescription::clone(&RobotDescription::builtin("b21").expect("built in"));
    let mut drive = Drive::begin(&corridor(""), robot, 1, 0.0);
    register(&mut drive, 2.0);
    // The odometry does not notice.
    drive.state.robot_in_map.heading_rad += 0.5;
    assert!(error_rad(&drive).expect("still held") > 0.45);
    let turned_at_m = drive.state.distance_driven_m;
    let mut was_doubted = false;
    while drive.state.distance_driven_m < turned_at_m + 2.5 {
        drive.step();
        was_doubted |= drive.registration.axis().is_none();
    }
    assert!(was_doubted);
    let off_rad = error_rad(&drive).expect("registered again");
    assert!(off_rad < 0.035, "{off_rad}");
}

/// Drives on for at most this distance; the other direction that single scans tell of, if they do.
fn doubted_rad(drive: &mut Drive, most_m: f64) -> Option<f64> {
    let axis = *drive.registration.axis().expect("registered");
    let from_m = drive.state.distance_driven_m;
    let (mut doubt, mut heard) = (None, None);
    while drive.state.distance_driven_m < from_m + most_m {
        drive.step();
        let sonars = drive.model.sensors.sonars.as_ref().expect("it has sonars");
        let scan = SonarScan { sonars, ranges_m: &drive.ranges_m };
        doubt = Doubt::after(doubt, heard.as_ref(), &axis, drive.odometry_in_odom, scan);
        heard = Some(Ring::of(drive.odometry_in_odom, scan));
        if let Some(other_rad) = doubt.as_ref().and_then(|doubt| doubt.other_axis_in_odom_rad()) {
            return Some(other_rad);
        }
    }
    None
}

#[test]
fn single_scans_tell_of_a_turn_by_hand_and_of_nothing_else() {
    // A hallway that branches off, and a door on the other side.
    let text = "name = \"branching\"\nsize = [16.0, 10.0]\nstart = [1.8, 5.1, 0]\n\
        [[wall]]\nline = [[0.925, 3.925], [5.0, 3.925]]\n[[wall]]\nline = [[6.0, 3.925], [15.075, 3.925]]\n\
        [[wall]]\nline = [[0.925, 6.275], [5.0, 6.275], [5.0, 9.0]]\n\
        [[wall]]\nline = [[7.2, 9.0], [7.2, 6.275], [15.075, 6.275]]\n";
    let robot = || RobotDescription::clone(&RobotDescription::builtin("b21").expect("built in"));
    for seed in 0..3 {
        let mut drive = Drive::begin(text, robot(), seed, 0.0);
        register(&mut drive, 2.0);
        assert_eq!(doubted_rad(&mut drive, 6.0), None, "seed {seed}: nobody turned it");
    }
    for (seed, by_deg) in [(0, 70.0), (1, -70.0), (2, 45.0), (3, -35.0)] {
        let mut drive = Drive::begin(text, robot(), seed, 0.0);
        register(&mut drive, 2.0);
        drive.state.robot_in_map.heading_rad += f64::to_radians(by_deg);
        let other_rad = doubted_rad(&mut drive, 0.6).expect("the walls are elsewhere");
        let off_rad = wrap_angle_rad(other_rad - drive.true_axis_in_odom_rad()).abs();
        assert!(off_rad < PARAMETERS.guess_gate_rad / 2.0, "seed {seed}: {}°", off_rad.to_degrees());
    }
}

#[test]
fn standing_still_teaches_nothing_and_a_crossing_unteaches_nothing() {
    let sonars = RobotDescription::papers().range_sensors().sonars.expect("it has a ring");
    let silence = vec![sonars.range_m as f32; sonars.mounts.len()];
    let walls = vec![1.1; sonars.mounts.len()];
    let mut registration = Registration::start(0.2);
    for _ in 0..200 {
        registration.take_in(Pose::default(), SonarScan { sonars: &sonars, ranges_m: &walls });
    }
    assert_eq!(registration.axis(), None);
    assert!(registration.heading_in_odom_rad() == 0.2);

    let robot = RobotDescription::clone(&RobotDescription::builtin("b21").expect("built in"));
    let mut drive = Drive::begin(&corridor(""), robot, 2, 0.0);
    register(&mut drive, 2.0);
    let before = *drive.registration.axis().expect("registered");
    let here = drive.odometry_in_odom;
    let mut registration = drive.registration.clone();
    for step in 0..200 {
        let at = here.transform(Point::new(0.025 * f64::from(step), 0.0));
        let silent = SonarScan { sonars: &sonars, ranges_m: &silence };
        registration.take_in(Pose::new(at.x, at.y, here.heading_rad), silent);
    }
    let after = registration.axis().expect("nothing speaks against it");
    assert!((after.heading_in_odom_rad - before.heading_in_odom_rad).abs() < 0.01);
    assert!(after.deviation_rad > before.deviation_rad, "it is less sure after five metres");
}
