//! Hallways whose features are known.

use super::score::{Confusion, TrueFeature};
use super::*;
use crate::drive::{Drive, corridor};
use rpl_robot::description::RobotDescription;

fn robot(name: &str) -> RobotDescription {
    RobotDescription::clone(&RobotDescription::builtin(name).expect("built in"))
}

/// A closed door and an open one on the left, with rooms behind.
const DOORS: &str = "[[room]]\nname = \"a\"\nrect = [3.0, 6.35, 6.9, 9.8]\n\
    [[room]]\nname = \"b\"\nrect = [7.1, 6.35, 11.0, 9.8]\n\
    [[wall]]\nline = [[7.0, 6.275], [7.0, 9.9]]\n\
    [[door]]\nroom = \"a\"\nat = [5.0, 6.275]\nwidth = 0.95\naxis = \"x\"\nopen = false\n\
    [[door]]\nroom = \"b\"\nat = [8.5, 6.275]\nwidth = 0.95\naxis = \"x\"\nopen = true\n";

/// The same in the percepts, as they lie on the map.
fn seen_on_map(drive: &Drive) -> Vec<(Side, Feature, f64, f64)> {
    let on_map = |percept: &Percept| {
        let from_m = drive.detected_from.x_m;
        (percept.side, percept.seen, percept.from_m + from_m, percept.to_m + from_m)
    };
    drive.percepts.iter().map(on_map).collect()
}

fn assert_near(seen: (Side, Feature, f64, f64), side: Side, is: Feature, middle_m: f64, width_m: f64) {
    assert_eq!((seen.0, seen.1), (side, is));
    let (seen_middle_m, seen_width_m) = ((seen.2 + seen.3) / 2.0, seen.3 - seen.2);
    assert!((seen_middle_m - middle_m).abs() < 0.15, "{is:?} at {seen_middle_m}, truly at {middle_m}");
    assert!((seen_width_m - width_m).abs() < 0.25, "{is:?} {seen_width_m} wide, truly {width_m}");
}

#[test]
fn doors_are_perceived_once_where_they_are_as_what_they_are() {
    for name in ["b21", "nomad-200", "pioneer-2dx"] {
        let mut drive = Drive::begin(&corridor(DOORS), robot(name), 4, 0.05);
        drive.drive_to(12.0);
        let seen = seen_on_map(&drive);
        assert_eq!(seen.len(), 2, "{name}: {seen:?}");
        assert_near(seen[0], Side::Left, Feature::ClosedDoor, 5.0, 0.95);
        assert_near(seen[1], Side::Left, Feature::OpenDoor, 8.5, 0.95);
        let depth_m = drive.percepts[0].depth_m;
        assert!((depth_m - 0.055).abs() < 0.025, "{name}: the leaf is {depth_m} deep");
        assert_eq!(drive.percepts.iter().map(|percept| percept.number).collect::<Vec<_>>(), [0, 1]);
    }
}

/// A hallway that branches off to the right and a foyer to the left, further on.
fn branches() -> String {
    "name = \"branches\"\nsize = [22.0, 12.0]\nstart = [1.8, 5.1, 0]\n\
     [[wall]]\nline = [[0.925, 3.925], [4.925, 3.925], [4.925, 0.2]]\n\
     [[wall]]\nline = [[7.275, 0.2], [7.275, 3.925], [20.075, 3.925], [20.075, 6.275], [13.075, 6.275], [13.075, 9.0], \
     [8.925, 9.0], [8.925, 6.275], [0.925, 6.275], [0.925, 3.925]]\n"
        .to_owned()
}

#[test]
fn hallways_and_foyers_are_told_apart_by_their_width() {
    let mut drive = Drive::begin(&branches(), robot("b21"), 5, -0.05);
    drive.drive_to(15.5);
    let seen = seen_on_map(&drive);
    assert_eq!(seen.len(), 2, "{seen:?}");
    assert_near(seen[0], Side::Right, Feature::Hallway, 6.1, 2.2);
    assert_near(seen[1], Side::Left, Feature::Foyer, 11.0, 4.0);
    assert!(drive.percepts.iter().all(|percept| percept.depth_m > 0.25), "no leaf is so deep");
}

#[test]
fn the_end_is_heard_and_an_opening_beside_it_ends_there() {
    // The hallway that branches off at the end has the end wall for its far wall.
    let text = "name = \"corner\"\nsize = [13.0, 10.0]\nstart = [1.8, 5.1, 0]\n\
        [[wall]]\nline = [[8.725, 9.8], [8.725, 6.275], [0.925, 6.275], [0.925, 3.925], [11.075, 3.925], [11.075, 9.8]]\n";
    let mut drive = Drive::begin(text, robot("b21"), 6, 0.0);
    drive.drive_to(10.3);
    let end_m = drive.detection.as_ref().and_then(FeatureDetection::hallway_end_m).expect("a wall across");
    assert!((end_m + drive.detected_from.x_m - 11.0).abs() < 0.1, "{end_m}");
    drive.stop_at(end_m);
    let seen = seen_on_map(&drive);
    assert_eq!(seen.len(), 1, "{seen:?}");
    assert_near(seen[0], Side::Left, Feature::Hallway, 9.9, 2.2);
}

#[test]
fn a_box_at_the_wall_is_neither_an_opening_nor_an_end() {
    let text = "[[object]]\nname = \"box\"\nrect = [5.0, 5.8, 5.5, 6.2]\n\
        [[object]]\nname = \"crate\"\nrect = [9.0, 4.0, 9.4, 4.5]\n";
    for seed in 0..4 {
        let mut drive = Drive::begin(&corridor(text), robot("b21"), seed, 0.0);
        drive.drive_to(12.0);
        assert_eq!(seen_on_map(&drive), [], "seed {seed}");
        let detection = drive.detection.as_ref().expect("registered");
        assert_eq!(detection.hallway_end_m(), None, "seed {seed}");
    }
}

#[test]
fn driven_back_and_on_again_nothing_is_perceived_twice() {
    let mut drive = Drive::begin(&corridor(DOORS), robot("b21"), 7, 0.0);
    drive.drive_to(10.0);
    let before = drive.percepts.clone();
    assert_eq!(before.len(), 2);
    // Carried back by hand, as far as its wheels tell: the same as driven back.
    let axis = *drive.registration.axis().expect("registered");
    let (along, _) = axes_in_odom(axis.heading_in_odom_rad);
    let detection = drive.detection.as_mut().expect("started");
    let sonars = drive.model.sensors.sonars.as_ref().expect("it has sonars");
    let silence = vec![sonars.range_m as f32; sonars.mounts.len()];
    let here = drive.odometry_in_odom;
    for step in (0..200).chain((0..200).rev()) {
        let at = here.point() - along * (0.02 * f64::from(step));
        let scan = SonarScan { sonars, ranges_m: &silence };
        let again = detection.take_in(&axis, Pose::new(at.x, at.y, here.heading_rad), scan, None);
        assert_eq!(again, [], "{} m back", 0.02 * f64::from(step));
    }
    drive.drive_to(12.0);
    assert_eq!(drive.percepts, before);
}

#[test]
fn a_saved_drive_goes_on_as_it_would_have() {
    let mut drive = Drive::begin(&corridor(DOORS), robot("b21"), 8, 0.0);
    drive.drive_to(5.2);
    let detection = drive.detection.clone().expect("started");
    let saved = postcard::to_allocvec(&(&drive.registration, &detection)).expect("plain values");
    let loaded: (Registration, FeatureDetection) = postcard::from_bytes(&saved).expect("the same");
    assert!(loaded == (drive.registration.clone(), detection));
    assert!(saved.len() < 150_000, "{} bytes", saved.len());
}

/// 1.4 m before it the 16 cones of a Nomad hear half a metre of the wall.
#[test]
fn the_end_of_a_hallway_is_heard_by_few_sonars_too() {
    for name in ["b21", "nomad-200"] {
        let mut drive = Drive::begin(&corridor(""), robot(name), 3, 0.0);
        drive.drive_to(14.0);
        let detection = drive.detection.as_ref().expect("started");
        let ahead_m = detection.hallway_end_m().map(|end_m| end_m - detection.along_m());
        assert!(ahead_m.is_some_and(|ahead_m| (ahead_m - 1.0).abs() < 0.1), "{name}: {ahead_m:?}");
    }
}

#[test]
fn percepts_are_scored_by_the_feature_they_overlap_most() {
    let percept =
        |number, side, seen, from_m, to_m| Percept { number, side, seen, from_m, to_m, depth_m: 1.0, marked: false };
    let truth = |side, is, from_m, to_m| TrueFeature { side, is, from_m, to_m };
    let features = [
        truth(Side::Left, Feature::OpenDoor, 1.0, 2.0),
        truth(Side::Left, Feature::ClosedDoor, 2.3, 3.2),
        truth(Side::Right, Feature::Hallway, 4.0, 6.0),
        truth(Side::Right, Feature::ClosedDoor, 9.2, 10.1),
    ];
    let percepts = [
        percept(0, Side::Left, Feature::OpenDoor, 1.1, 2.4),
        percept(1, Side::Right, Feature::OpenDoor, 4.0, 4.8),
        percept(2, Side::Right, Feature::Hallway, 4.9, 6.1),
        percept(3, Side::Left, Feature::ClosedDoor, 7.0, 7.9),
    ];
    let confusion = Confusion::of(&percepts, &features, &[], 10.0);
    assert_eq!((confusion.features(), confusion.right(), confusion.doubled), (3, 2, 1), "the last was not passed");
    let missed = confusion.taken[Feature::ClosedDoor as usize];
    assert_eq!(missed, [1, 0, 0, 0, 0]);
    assert_eq!(confusion.false_alarms[Feature::ClosedDoor as usize], 1);
    assert!((confusion.false_in_100_m() - 20.0).abs() < 1e-9);
    let hidden = |from_m, to_m| [HiddenWall { side: Side::Left, from_m, to_m }];
    let shown = Confusion::of(&percepts, &features, &hidden(1.0, 3.0), 10.0);
    assert_eq!(shown.taken[Feature::ClosedDoor as usize], [0; 5], "a box stood before it");
    assert_eq!(shown.taken[Feature::OpenDoor as usize], confusion.taken[Feature::OpenDoor as usize]);
    assert_eq!(Confusion::of(&percepts, &features, &hidden(1.0, 2.7), 10.0), confusion, "not before its middle");
    for row in confusion.certainties(0.5, 2.0) {
        assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }
}
