//! Recorded drives in a small room that is made here.

use super::*;
use crate::geometry::{Point, Pose, wrap_angle_rad};
use crate::localization::{LocalizationModel, LocalizationParameters};
use crate::occupancy::{Cell, DistanceField, OccupancyGrid};
use rpl_random::Stream;
use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

/// 8 m by 5 m with a pillar and a niche, so that no pose looks like another one.
fn room() -> OccupancyGrid {
    let mut map = OccupancyGrid::filled(Point::new(-1.0, 2.0), 0.1, 80, 50, Cell::Free);
    let mut block = |columns: std::ops::Range<usize>, rows: std::ops::Range<usize>| {
        rows.for_each(|row| columns.clone().for_each(|column| map.set(column, row, Cell::Occupied)));
    };
    block(0..80, 0..1);
    block(0..80, 49..50);
    block(0..1, 0..50);
    block(79..80, 0..50);
    block(20..26, 22..31);
    block(60..80, 0..9);
    block(45..48, 38..50);
    map
}

/// The pose after a way around the room.
fn pose_after(way_m: f64) -> Pose {
    let turn = way_m / 9.0 * TAU;
    let (sin, cos) = libm::sincos(turn);
    Pose::new(3.1 + 2.6 * cos, 4.3 + 1.0 * sin, libm::atan2(cos * 1.0, -sin * 2.6))
}

/// A log of a drive: what a laser with `sigma_m` sees, and odometry whose heading drifts.
fn log(readings: usize, sigma_m: f64) -> String {
    let field = DistanceField::new(&room());
    let mut noise = Stream::new(10_001, "log");
    let geometry = ScanGeometry::symmetric(readings, PI, FirstReading::Right);
    let mut odometry = Pose::new(50.0, -20.0, 1.0);
    let mut last = pose_after(0.0);
    let mut text = "# a comment\nPARAM robot_width 0.5\n".to_string();
    for step in 0..150 {
        let pose = pose_after(f64::from(step) * 0.1);
        let moved = pose.relative_to(last);
        odometry = odometry.compose(Pose::new(moved.x_m, moved.y_m, moved.heading_rad + 0.002));
        last = pose;
        text += &format!("FLASER {readings}");
        for reading in 0..readings {
            let (sin, cos) = libm::sincos(pose.heading_rad + geometry.bearing_rad(reading));
            let range_m = field.cast_m(pose.point(), (cos, sin), 80.0) + sigma_m * noise.normal();
            text += &format!(" {:.3}", range_m.max(0.0));
        }
        for pose in [pose, odometry] {
            text += &format!(" {:.4} {:.4} {:.4}", pose.x_m, pose.y_m, pose.heading_rad);
        }
        text += &format!(" {step}.0 robot {step}.0\n");
    }
    text
}

fn read(text: &str) -> Result<Recording, LogError> {
    Recording::parse_carmen(text, &mount(FirstReading::Right))
}

fn mount(first: FirstReading) -> LaserMount {
    LaserMount { field_of_view_rad: PI, first, laser_in_base: Pose::default() }
}

/// A line of a scan with two readings: the corrected pose and the odometry are this far along x, at a time.
fn scan(corrected_m: f64, odometry_m: f64, time_s: f64) -> String {
    format!("FLASER 2 1 2 {corrected_m} 0 0 {odometry_m} 0 0 {time_s} host {time_s}\n")
}

fn model(recording: &Recording, beams: usize) -> (LocalizationModel, BeamChoice) {
    let beams = BeamChoice::spread(&recording.geometry, beams).expect("enough readings");
    let parameters = LocalizationParameters {
        cell_m: 0.1,
        angle_step_deg: 4,
        ..LocalizationParameters::recorded(beams.bearings_deg.clone())
    };
    (LocalizationModel::new(&room(), parameters).expect("the room is a map"), beams)
}

#[test]
fn a_log_gives_scans_with_the_lines_they_stand_in() {
    let recording = read(&log(19, 0.0)).expect("a fine log");
    assert_eq!(recording.scans.len(), 150);
    assert_eq!(recording.scans[0].line, 3);
    assert_eq!(recording.geometry.bearing_rad(0), -PI / 2.0);
    assert!((recording.geometry.bearing_rad(18) - PI / 2.0).abs() < 1e-12);
    let even = ScanGeometry::symmetric(180, PI, FirstReading::Right);
    assert!((even.bearing_rad(179) - 89f64.to_radians()).abs() < 1e-12);
}

#[test]
fn a_laser_that_begins_at_the_left_sees_the_same() {
    let text = scan(0.0, 5.0, 0.0) + &scan(1.0, 6.0, 1.0);
    let recording = Recording::parse_carmen(&text, &mount(FirstReading::Left)).expect("a fine log");
    assert_eq!(recording.scans[0].ranges_m, [2.0, 1.0]);
    // The first of two readings over 180° is at the left end, the second a step of 90° from it.
    assert!(recording.geometry.bearing_rad(0).abs() < 1e-12);
    assert!((recording.geometry.bearing_rad(1) - PI / 2.0).abs() < 1e-12);
}

#[test]
fn odometry_that_is_the_corrected_pose_is_that_of_the_messages_between() {
    let scans = scan(0.0, 0.0, 0.5) + &scan(1.0, 1.0, 1.25) + &scan(2.0, 2.0, 9.0);
    let error = read(&scans).expect_err("told what it is to find").to_string();
    assert!(error.starts_with("line 1: the odometry of this scan, as of all others, is the corrected pose"), "{error}");
    let rounded = scan(0.0, 0.0, 0.5) + &scan(1.0004, 1.0, 1.25) + &scan(2.0003, 2.0, 9.0);
    assert!(read(&rounded).is_err(), "the same poses with fewer digits");
    let odom = |x_m: f64, heading_rad: f64, time_s: f64| format!("ODOM {x_m} 7 {heading_rad} 0 0 0 {time_s} host 0\n");
    // The heading goes through ±π; the last scan was taken when no message came any more.
    let recording = read(&(scans.clone() + &odom(40.0, 3.1, 0.5) + &odom(42.0, -3.1, 1.5))).expect("a fine log");
    assert_eq!(recording.scans.iter().map(|scan| scan.line).collect::<Vec<_>>(), [1, 2]);
    assert_eq!(recording.scans[0].laser_in_odom, Pose::new(40.0, 7.0, 3.1));
    let between = recording.scans[1].laser_in_odom;
    assert!((between.x_m - 41.5).abs() < 1e-12);
    assert!((wrap_angle_rad(between.heading_rad - 3.1) - 0.75 * (TAU - 6.2)).abs() < 1e-12);
    let late = read(&(scans + &odom(40.0, 0.0, 100.0))).expect_err("no message in time").to_string();
    assert!(late.contains("the ODOM messages were not sent while they were taken"), "{late}");
    // A scan's own odometry is that of its very moment.
    let own = scan(0.0, 5.0, 0.0) + &scan(1.0, 6.0, 1.0) + &odom(40.0, 0.0, 0.0) + &odom(42.0, 0.0, 2.0);
    assert_eq!(read(&own).expect("a fine log").scans[1].laser_in_odom.x_m, 6.0);
}

#[test]
fn the_newer_message_says_where_its_readings_point() {
    let line = |x: f64| {
        format!(
            "ROBOTLASER1 0 -2.0 4.0 0.5 30 0.01 0 3 1 2 3 2 7 8 {x} 0 0 {} 0 0.1 0.2 0.3 0 0 0 1.0 robot 1.0\n",
            x + 5.0
        )
    };
    let mounted = Pose::new(0.2, 0.0, 0.0);
    let text = line(0.0) + &line(1.0);
    let mount = LaserMount { laser_in_base: mounted, ..mount(FirstReading::Right) };
    let recording = Recording::parse_carmen(&text, &mount).expect("a fine log");
    assert_eq!(recording.geometry, ScanGeometry { readings: 3, first_rad: -2.0, step_rad: 0.5 });
    assert_eq!(recording.scans[1].laser_in_map.x_m, 1.0);
    let odometry = recording.scans[1].laser_in_odom;
    assert!((odometry.x_m - (6.0 + 0.2 * libm::cos(0.1))).abs() < 1e-12);
}

#[test]
fn faults_of_a_log_are_told_with_their_line() {
    let good = log(5, 0.0);
    let line = good.lines().nth(2).expect("a scan").to_string();
    let after = |line: &str| format!("{good}{line}\n");
    let no_odometry: String = (0..3).map(|x| format!("FLASER 2 1 1 {x} 0 0 0 0 0 0 h 0\n")).collect();
    let raw = "RAWLASER1 0 -1.57 3.14 0.0174 80 0.01 0 2 1 1 0 0.0 host 0.0\n";
    for (text, part) in [
        (after("FLASER 5 1 2 3"), "line 153: the FLASER line ends before reading 4 of 5; is it truncated?"),
        (after("FLASER 5 1 2 3 4 5 0 0"), "line 153: the FLASER line ends before theta of the corrected pose"),
        (after("FLASER 5 1 2 3 4 5 0 0 0"), "line 153: the FLASER line ends before x of the odometry"),
        (after("FLASER 5 1 2 nan 4 5 0 0 0 0 0 0"), "line 153: reading 3 of 5 is NaN"),
        (after("FLASER 5 1 -2 3 4 5 0 0 0 0 0 0"), "line 153: reading 2 of 5 is -2"),
        (after("FLASER 5 1 2 3 inf 5 0 0 0 0 0 0"), "line 153: reading 4 of 5 is inf"),
        (after("FLASER 5 1 2 x 4 5 0 0 0 0 0 0"), "line 153: reading 3 of 5 must be a number, found `x`"),
        (after(&format!("FLASER 5 1 2 {} 4 5", "x".repeat(100_000))), " characters) …"),
        (after("FLASER 5 1 2 3 4 5 0 0 0 0 inf 0"), "line 153: y of the odometry must be finite"),
        (after("FLASER 0 0 0 0 0 0 0"), "line 153: the number of readings must be a whole number from 1"),
        (after("FLASER 4 1 2 3 4 0 0 0 0 0 0"), "line 153: 4 readings where earlier scans have 5"),
        (format!("{line}\n"), "the robot never moves"),
        (no_odometry, "the log has no odometry: its poses (odom_x odom_y odom_theta of CARMEN)"),
        (raw.to_string(), "line 1: the log has no odometry: a RAWLASER1 message"),
        (String::new(), "no laser scan in it"),
    ] {
        let error = read(&text).expect_err(part).to_string();
        assert!(error.contains(part), "{error}\nshould say: {part}");
    }
}

#[test]
fn beams_are_readings_at_whole_degrees_from_end_to_end() {
    for (readings, beams) in [(361, 24), (180, 24), (181, 1), (541, 180), (19, 19)] {
        let geometry = ScanGeometry::symmetric(readings, PI, FirstReading::Right);
        let choice = BeamChoice::spread(&geometry, beams).expect("there are enough");
        assert_eq!(choice.readings.len(), beams);
        for (&reading, &bearing_deg) in choice.readings.iter().zip(&choice.bearings_deg) {
            let off_rad = geometry.bearing_rad(reading) - f64::from(bearing_deg).to_radians();
            assert!(off_rad.abs() <= geometry.step_rad / 2.0 + 1e-9);
        }
        assert!(choice.readings.windows(2).all(|pair| pair[0] < pair[1]));
        assert!(beams == 1 || (choice.readings[0], choice.readings[beams - 1]) == (0, readings - 1));
    }
    let geometry = ScanGeometry::symmetric(19, PI, FirstReading::Right);
    assert_eq!(BeamChoice::spread(&geometry, 0), Err(BeamError::None));
    assert_eq!(BeamChoice::spread(&geometry, 20), Err(BeamError::TooMany { wanted: 20, most: 19 }));
}

#[test]
fn windows_are_as_long_as_asked_and_spread_over_the_drive() {
    let recording = read(&log(5, 0.0)).expect("a fine log");
    let travelled_m = recording.travelled_m();
    for phase in [0.0, 0.5] {
        let windows = Window::spread(&recording, 4, 5.0, phase).expect("it fits");
        for window in &windows {
            let (first, last) = (travelled_m[window.scans.start], travelled_m[window.scans.end - 1]);
            assert!(last - first >= 5.0 && travelled_m[window.scans.end - 2] - first < 5.0);
        }
        assert!(windows.windows(2).all(|pair| pair[0].start_m < pair[1].start_m));
    }
    assert!(Window::spread(&recording, 4, 1000.0, 0.5).is_err());
}

#[test]
fn a_robot_that_knows_nothing_is_found_and_one_that_is_known_is_kept() {
    let recording = read(&log(91, 0.02)).expect("a fine log");
    let (model, beams) = model(&recording, 24);
    for (start, length_m) in [(TrialStart::Uniform, 10.0), (TrialStart::FromTruth, 10.0)] {
        for window in Window::spread(&recording, 2, length_m, 0.5).expect("it fits") {
            let mut scans = 0;
            let count = || {
                scans += 1;
                ControlFlow::Continue(())
            };
            let trial = localize(&model, &recording, &beams, &window, start, count).expect("it goes to its end");
            assert_eq!(scans, window.scans.len());
            assert!(trial.succeeded, "{start:?} {:?}", trial.found_after_m);
            let found = trial.errors_once_found();
            let mean_m = found.iter().map(PoseError::position_m).sum::<f64>() / found.len() as f64;
            assert!(mean_m < 0.1, "{start:?} {mean_m}");
        }
    }
}

fn go_on() -> ControlFlow<()> {
    ControlFlow::Continue(())
}

#[test]
fn a_trial_that_is_broken_off_is_none() {
    let recording = read(&log(91, 0.02)).expect("a fine log");
    let (model, beams) = model(&recording, 24);
    let stop = || ControlFlow::Break(());
    assert_eq!(localize(&model, &recording, &beams, &Window::whole(&recording), TrialStart::FromTruth, stop), None);
}

#[test]
fn a_robot_that_is_right_too_late_or_not_at_the_end_was_not_found() {
    let recording = read(&log(91, 0.02)).expect("a fine log");
    let (model, beams) = model(&recording, 24);
    let window = Window::whole(&recording);
    // Where the log says the robot was in another place, the filter is wrong.
    let mut moved = recording.clone();
    let last = moved.scans.len() - 1;
    moved.scans[last].laser_in_map = Pose::new(6.0, 6.0, 0.0);
    let trial = localize(&model, &moved, &beams, &window, TrialStart::FromTruth, go_on).expect("it goes to its end");
    assert_eq!((trial.found_after_m, trial.succeeded), (None, false));
    let mut late = recording.clone();
    late.scans[last - 3].laser_in_map.heading_rad = wrap_angle_rad(late.scans[last - 3].laser_in_map.heading_rad + 0.3);
    let trial = localize(&model, &late, &beams, &window, TrialStart::FromTruth, go_on).expect("it goes to its end");
    assert!(trial.found_after_m.is_some() && !trial.succeeded);
}

#[test]
fn a_fit_finds_what_the_drive_was_made_with() {
    let recording = read(&log(91, 0.15)).expect("a fine log");
    let (model, beams) = model(&recording, 24);
    let sensor = fit_sensor(&model, &recording, &beams).expect("enough readings");
    // A cell and four degrees add to the noise of the laser.
    let at_2_m = sensor.sigma_m + 2.0 * sensor.sigma_per_m;
    assert!((0.14..0.24).contains(&at_2_m), "{sensor:?}");
    assert!(sensor.hit > 0.8 && sensor.wall_depth_m.abs() < 0.05, "{sensor:?}");
    let odometry = fit_odometry(&recording).expect("enough motions");
    // 2 mrad every 0.1 m, all in one direction.
    let drift_rad = odometry.turn_per_metre_rad;
    assert!(odometry.forward_m < 0.005 && (0.003..0.01).contains(&drift_rad), "{odometry:?}");
}

#[test]
fn a_fit_of_too_little_is_refused() {
    let mut recording = read(&log(5, 0.0)).expect("a fine log");
    recording.scans.truncate(5);
    let (model, beams) = model(&recording, 3);
    assert_eq!(fit_sensor(&model, &recording, &beams), Err(FitError::Readings(15)));
    assert_eq!(fit_odometry(&recording), Err(FitError::Motions(4)));
}
