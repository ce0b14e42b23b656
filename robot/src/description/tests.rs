//! What a robot file says, and what is wrong with it.

use super::parse::MOST_SONARS;
use super::*;
use crate::localization::MAX_BEAMS;
use crate::sensors::RangeSensor;

fn b21_with(change: impl Fn(&str) -> String) -> Vec<String> {
    let text = change(RobotDescription::builtin_text("b21").expect("it is built in"));
    match RobotDescription::parse(&text, "r.toml") {
        Ok(_) => Vec::new(),
        Err(faults) => {
            faults.findings.iter().map(|fault| format!("{} {}: {}", fault.line, fault.key, fault.message)).collect()
        }
    }
}

/// The only fault of the papers' robot with something else in place of a part of its file.
fn fault(part: &str, instead: &str) -> String {
    let found = b21_with(|text| {
        assert!(text.contains(part), "{part}");
        text.replacen(part, instead, 1)
    });
    assert_eq!(found.len(), 1, "{found:?}");
    found[0].clone()
}

#[test]
fn the_papers_robot_is_what_its_papers_say() {
    let b21 = RobotDescription::papers();
    assert_eq!((b21.step_us, b21.radius_m, b21.motors.max_translation_mps), (50_000, 0.265, 0.95));
    assert_eq!(b21.motors.max_rotation_radps, 60_f64.to_radians());
    let sensors = b21.range_sensors();
    let sonars = sensors.sonars.as_ref().expect("it has a ring");
    assert_eq!((sonars.mounts.len(), sonars.cone_rad, sonars.range_m), (24, std::f64::consts::TAU / 24.0, 5.0));
    assert!(sensors.sharpest() == RangeSensor::Sonar && sonars.apexes.len() == 1);
    let laser = RobotDescription::builtin("b21-laser").expect("it is built in");
    assert_eq!(laser.laser.expect("it has one").scanner.readings, 181);
    assert_eq!(
        RobotDescription { laser: None, name: "b21".into(), purpose: b21.purpose.clone(), ..(*laser).clone() },
        *b21
    );
}

#[test]
fn a_robot_that_sees_nothing_is_refused_with_the_reason() {
    let found = b21_with(|text| {
        let (before, rest) = text.split_once("[sonar]").expect("it has sonars");
        let (_, after) = rest.split_once("[gripper]").expect("a gripper follows");
        format!("{before}[gripper]{after}")
    });
    assert_eq!(found, ["1 sonar: the robot sees nothing: it has neither a sonar nor a laser"]);
}

#[test]
fn what_no_robot_is_like_is_a_fault_with_line_and_key() {
    assert_eq!(
        fault("radius = 0.265", "radius = -0.265"),
        "6 radius: `radius` must be from 0.02 m to 2 m, found -0.265 m"
    );
    assert!(fault("step = 0.05", "step = 0").contains("step: `step` must be from 0.01 s to 0.5 s, found 0 s"));
    assert!(fault("step = 0.05", "step = nan").contains("must be a finite number"));
    assert!(
        fault("speed = 0.95", "sped = 0.95 # \nspeed = 0.95").contains("unknown key `sped`, did you mean `speed`?")
    );
    assert!(fault("ring = 24", "ring = 0").contains("ring: `ring` must be a whole number from 3 to 128, found 0"));
    assert!(
        fault("ring = 24", "mounts = []\ncone = 0.3")
            .contains("mounts: `mounts` must have from 1 to 128 sonars, found 0")
    );
    assert!(fault("ring = 24", "ring = 24\nmounts = []").contains("either `ring` or `mounts`, found both"));
    assert!(
        fault("ring = 24", "ring = 24\ncone = \"190deg\"").contains("cone: `cone` must be from 1° to 180°, found 190°")
    );
    let outside = fault("ring = 24", "cone = 0.3\nmounts = [[0.3, 0.0, 0.0]]");
    assert!(outside.contains("a sonar sits 0.300 m off the middle, and the body reaches 0.265 m"), "{outside}");
    assert!(
        fault("hallway = 0.7", "hallway = 1.0")
            .contains("hallway: `hallway` must be from 0.01 m/s to 0.95 m/s, found 1 m/s")
    );
    assert!(fault("braking = 0.9", "braking = 1.1").contains("`braking` must be from 0.01 m/s² to 1 m/s²"));
    assert!(fault("[battery]", "[laser]\nfield_of_view = \"360deg\"\nresolution = \"0.1deg\"\nrange = 8.0\nnoise = 0.0\ndropouts = 0.0\n[battery]").contains("the laser has 3600 readings"));
    assert!(fault("name = \"b21\"", "").contains("name: the robot has no `name`"));
}

/// What is wrong with the papers' robot and a camera that has something else in place of a part.
fn camera_fault(part: &str, instead: &str) -> String {
    let camera = include_str!("../../robots/camera-of-b21.toml");
    assert!(camera.contains(part), "{part}");
    let found = b21_with(|text| format!("{text}{}", camera.replacen(part, instead, 1)));
    assert_eq!(found.len(), 1, "{found:?}");
    found[0].clone()
}

#[test]
fn a_camera_is_as_its_file_says_or_refused_with_line_and_key() {
    let camera = RobotDescription::builtin("b21-camera").expect("built in");
    let b21 = RobotDescription::papers();
    let blind =
        RobotDescription { camera: None, name: b21.name.clone(), purpose: b21.purpose.clone(), ..(*camera).clone() };
    assert_eq!(blind, *b21);
    assert!(RobotDescription::builtin("nomad-200").is_some_and(|robot| robot.camera.is_some()));
    assert!(
        camera_fault("columns = 80", "columns = 1000")
            .contains("`columns` must be a whole number from 8 to 320, found 1000")
    );
    assert!(camera_fault("rows = 60\n", "").contains("[camera] has no `rows`"));
    assert!(camera_fault("\"60deg\"", "\"200deg\"").contains("`field_of_view` must be from 10° to 120°, found 200°"));
    assert!(
        camera_fault("tilt = \"28deg\"", "tilt = \"70deg\"").contains("tilt: the lower edge of the image looks behind")
    );
    assert!(
        camera_fault("noise = 0.02", "nois = 0.02\nnoise = 0.02").contains("unknown key `nois`, did you mean `noise`?")
    );
    assert!(
        camera_fault("pan_range = \"159deg\"", "pan_range = \"300deg\"")
            .contains("`pan_range` must be from 0° to 180°")
    );
}

#[test]
fn all_faults_are_told_at_once_in_the_order_of_the_text() {
    let found = b21_with(|text| {
        text.replace("radius = 0.265", "radius = 0")
            .replace("range = 5.0", "range = \"far\"")
            .replace("reach = 0.8", "")
    });
    let keys: Vec<&str> = found.iter().filter_map(|fault| fault.split([' ', ':']).nth(1)).collect();
    assert_eq!(keys, ["radius", "range", "reach"]);
}

#[test]
fn any_cut_of_a_robot_file_is_read_or_refused_in_words() {
    for name in RobotDescription::builtin_names() {
        let text = RobotDescription::builtin_text(name).expect("it is built in");
        for end in (0..text.len()).filter(|&end| text.is_char_boundary(end)) {
            if let Err(faults) = RobotDescription::parse(&text[..end], "r.toml") {
                assert!(faults.findings.iter().all(|fault| !fault.message.is_empty()), "{name} {end}");
            }
        }
    }
}

#[test]
fn angles_are_in_degrees_or_radians_and_a_full_turn_of_a_laser_ends_before_it_begins() {
    let text = RobotDescription::builtin_text("turtlebot").expect("it is built in");
    let radians = text.replace("\"360deg\"", "6.283185307179586").replace("\"1deg\"", "0.017453292519943295");
    for text in [text, &radians] {
        let scanner = RobotDescription::parse(text, "r.toml").expect("no faults").laser.expect("it has one").scanner;
        assert_eq!((scanner.readings, scanner.resolution_deg), (360, 1.0));
    }
}

#[test]
fn a_filter_can_weigh_as_many_sonars_as_a_robot_may_have() {
    const { assert!(MOST_SONARS <= MAX_BEAMS) };
}
