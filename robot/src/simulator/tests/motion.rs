use super::*;
use crate::description::OdometryDrift;
use crate::simulator::odometry::OdometryBias;
use proptest::prelude::*;

#[test]
fn an_arc_is_the_limit_of_many_small_steps() {
    let start = Pose::new(1.0, -2.0, 0.7);
    for (way_m, turn_rad) in [(1.0, 0.0), (0.5, 1.0), (-0.7, 2.0), (2.0, -3.0), (0.3, 1e-5), (0.0, 1.0)] {
        let count = 20_000;
        let share = 1.0 / f64::from(count);
        let small = (0..count).fold(start, |pose, _| {
            let (sin, cos) = libm::sincos(pose.heading_rad + turn_rad * share / 2.0);
            Pose::new(
                pose.x_m + way_m * share * cos,
                pose.y_m + way_m * share * sin,
                pose.heading_rad + turn_rad * share,
            )
        });
        let arc = drive_arc(start, way_m, turn_rad);
        assert!(arc.distance_m(small) < 1e-8, "{way_m} {turn_rad}: {arc:?} {small:?}");
        assert!(crate::geometry::wrap_angle_rad(arc.heading_rad - small.heading_rad).abs() < 1e-8);
    }
}

#[test]
fn speeds_stay_within_the_robots_limits() {
    let model = hall(SimulatorSettings::default(), "");
    let motors = model.robot().motors;
    let mut state = model.start(1);
    let first = model.step(&mut state, &drive(100.0, -100.0));
    assert!((first.translation_mps - motors.translation_acceleration_mps2 * 0.05).abs() < 1e-12);
    assert!((first.rotation_radps + motors.rotation_acceleration_radps2 * 0.05).abs() < 1e-12);
    let later = steps(&model, &mut state, &drive(100.0, -100.0), 60);
    assert_eq!((later.translation_mps, later.rotation_radps), (motors.max_translation_mps, -motors.max_rotation_radps));
    let stopped = steps(&model, &mut state, &drive(f64::NAN, f64::INFINITY), 60);
    assert_eq!((stopped.translation_mps, stopped.rotation_radps), (0.0, 0.0));
}

#[test]
fn a_touch_stops_the_robot_and_counts_once() {
    let model = hall(exact("b21"), "");
    let mut state = model.start(1);
    let pressed = steps(&model, &mut state, &drive(0.9, 0.0), 400);
    assert!(pressed.bumped);
    assert_eq!(pressed.translation_mps, 0.0);
    assert_eq!(state.contacts(), Contacts { caused: 1, ..Contacts::default() });
    assert!((state.true_pose().x_m - (10.0 - 0.265)).abs() < 1e-6);
    assert!((state.distance_driven_m() - 4.735).abs() < 1e-6);
    assert!((pressed.odometry_in_odom.x_m - 4.735).abs() < 1e-6, "wheels stand while the robot is held");

    let parted = steps(&model, &mut state, &drive(-0.3, 0.0), 20);
    assert!(!parted.bumped);
    steps(&model, &mut state, &drive(0.3, 0.0), 60);
    assert_eq!(state.contacts().caused, 2);
}

/// The leaf is 2 m east of the start. At 0.3 m/s the robot stops within 9 cm of seeing it.
#[test]
fn a_door_shut_right_before_the_robot_is_not_its_fault() {
    let model = model("test-room", exact("b21"));
    let contacts_when_shut_at = |gap_m: f64| {
        let mut state = model.start(1);
        model.teleport(&mut state, Pose::new(3.0, 3.0, 0.0)).expect("free");
        while state.true_pose().x_m < 4.98 - 0.265 - gap_m {
            steps(&model, &mut state, &drive(0.3, 0.0), 1);
        }
        model.close_door(&mut state, "east").expect("nobody is in the door");
        steps(&model, &mut state, &drive(0.3, 0.0), 60);
        state.contacts()
    };
    assert_eq!(contacts_when_shut_at(0.05), Contacts { run_into: 1, ..Contacts::default() });
    assert_eq!(contacts_when_shut_at(0.2), Contacts { caused: 1, ..Contacts::default() });
}

#[test]
fn a_touch_is_over_when_the_thing_is_gone() {
    let model = hall(exact("b21"), "[[object]]\nname = \"bin\"\ncircle = [6.0, 3.0, 0.2]");
    let mut state = model.start(1);
    assert!(steps(&model, &mut state, &drive(0.5, 0.0), 60).bumped);
    assert!(model.step(&mut state, &drive(0.0, 0.0)).bumped);
    model.remove_object(&mut state, "bin").expect("it is there");
    assert!(!model.step(&mut state, &drive(0.0, 0.0)).bumped);
}

#[test]
fn a_touched_robot_still_turns() {
    let model = hall(exact("b21"), "");
    let mut state = model.start(1);
    steps(&model, &mut state, &drive(0.9, 0.0), 200);
    steps(&model, &mut state, &drive(0.9, 0.5), 40);
    assert!(state.true_pose().heading_rad > 0.5);
}

#[test]
fn a_touch_of_something_no_sensor_sees_is_not_the_robots_fault() {
    let model = hall(exact("b21"), "");
    let mut glass = model.start(1);
    model.add_object(&mut glass, crate_at("glass", 7.0, 3.0, false, false)).expect("nobody is there");
    steps(&model, &mut glass, &drive(0.5, 0.0), 100);
    assert_eq!(glass.contacts(), Contacts { unseen: 1, ..Contacts::default() });

    let mut blind = model.start(1);
    blind.drop_sonars(1000.0);
    steps(&model, &mut blind, &drive(0.9, 0.0), 400);
    assert_eq!(blind.contacts(), Contacts { unseen: 1, ..Contacts::default() });
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn the_body_never_enters_anything(seed in any::<u64>()) {
        let model = model("dept", SimulatorSettings::default());
        let mut stream = Stream::new(seed, "test");
        let mut state = model.start(seed);
        shuffle_doors(&mut state, &mut stream);
        let pose = free_pose(&model, &state, &mut stream);
        model.teleport(&mut state, pose).expect("free");
        let mut commands = Commands::default();
        for step in 0..400 {
            if step % 25 == 0 {
                commands = drive(stream.uniform_in(-1.5, 1.5), stream.uniform_in(-2.0, 2.0));
            }
            model.step(&mut state, &commands);
            let inner_m = model.robot().radius_m - 1e-8;
            prop_assert_eq!(model.in_the_way(&state, state.true_pose().point(), inner_m), None);
        }
    }
}

/// Mean and standard deviation.
fn moments(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let variance = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / values.len() as f64;
    (mean, variance.sqrt())
}

#[test]
fn odometry_without_bias_is_right_on_average_whatever_the_step() {
    let biased = builtin("b21").odometry;
    let drift = OdometryDrift { translation_bias: 0.0, rotation_bias: 0.0, heading_bias_radpm: 0.0, ..biased };
    const RUNS: u64 = 1500;
    for count in [20, 400] {
        let (mut ways, mut headings) = (Vec::new(), Vec::new());
        for seed in 0..RUNS {
            let mut stream = Stream::new(seed, "odometry");
            let bias = OdometryBias::draw(&drift, &mut stream);
            // Straight on for 9 m, and a full turn on the spot.
            let (mut pose, mut way_m) = (Pose::default(), 0.0);
            for _ in 0..count {
                let before = pose;
                pose = bias.measure(&drift, &mut stream, pose, 9.0 / f64::from(count), 0.0);
                way_m += pose.distance_m(before);
            }
            ways.push(way_m - 9.0);
            let mut heading_rad = 0.0;
            for _ in 0..count {
                let turn_rad = std::f64::consts::TAU / f64::from(count);
                let turned = bias.measure(&drift, &mut stream, Pose::default(), 0.0, turn_rad);
                heading_rad += turned.heading_rad - turn_rad;
            }
            headings.push(heading_rad);
        }
        let (way_mean_m, way_sigma_m) = moments(&ways);
        let (turn_mean_rad, turn_sigma_rad) = moments(&headings);
        let expected_way_m = drift.translation_noise_m_per_sqrt_m * 3.0;
        let expected_turn_rad = drift.rotation_noise_rad_per_sqrt_rad * std::f64::consts::TAU.sqrt();
        let of_mean = 4.0 / (RUNS as f64).sqrt();
        assert!(way_mean_m.abs() < of_mean * expected_way_m, "{count}: {way_mean_m}");
        assert!(turn_mean_rad.abs() < of_mean * expected_turn_rad, "{count}: {turn_mean_rad}");
        assert!((way_sigma_m / expected_way_m - 1.0).abs() < 0.1, "{count}: {way_sigma_m}");
        assert!((turn_sigma_rad / expected_turn_rad - 1.0).abs() < 0.1, "{count}: {turn_sigma_rad}");
    }
}

#[test]
fn exact_odometry_is_the_true_motion() {
    let model = model("dept", exact("b21"));
    let mut state = model.start(9);
    for (translation_mps, rotation_radps) in [(0.4, 0.1), (0.2, -0.5), (0.5, 0.3)] {
        steps(&model, &mut state, &drive(translation_mps, rotation_radps), 60);
    }
    let expected = model.world.start_in_map.compose(state.odometry_in_odom);
    assert_eq!(state.contacts(), Contacts::default());
    assert!(state.true_pose().distance_m(expected) < 1e-9);
}

#[test]
fn a_robot_at_rest_measures_no_motion() {
    let model = hall(SimulatorSettings::default(), "");
    let mut state = model.start(1);
    assert_eq!(steps(&model, &mut state, &drive(0.0, 0.0), 100).odometry_in_odom, Pose::default());
}
