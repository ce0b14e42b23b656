//! Drives along a hallway with a marker beside each door.

use rpl_lola::feature::Side;
use rpl_lola::markers::{Gaze, MarkerDetection, MarkerEye, SeenMarker};
use rpl_robot::description::RobotDescription;
use rpl_robot::geometry::{Point, Pose, distance_m};
use rpl_robot::simulator::{Commands, SimulatorModel, SimulatorSettings, SimulatorState};
use rpl_robot::vision::FloorMark;
use rpl_robot::world::{MarkerColour, World};
use std::sync::Arc;

/// Three metres of markers on the left side, and one on the right.
const MARKERS: [(f64, f64); 4] = [(4.0, 3.9), (6.5, 2.1), (7.0, 3.9), (10.0, 3.9)];

/// A hallway 2.2 m wide, the robot at its beginning.
fn hallway(more: &str) -> SimulatorModel {
    let markers = MARKERS.map(|(x, y)| format!("[[marker]]\nat = [{x}, {y}]\n")).concat();
    let text = format!(
        "name = \"hallway\"\nsize = [14.0, 6.0]\nstart = [1.0, 3.0, 0]\n{more}
         [[wall]]\nline = [[0.1, 1.825], [13.9, 1.825]]\n[[wall]]\nline = [[0.1, 4.175], [13.9, 4.175]]\n{markers}"
    );
    let robot = RobotDescription::builtin("nomad-200").expect("built in");
    SimulatorModel::new(Arc::new(World::parse(&text, "hallway.toml").expect("no faults")), SimulatorSettings::of(robot))
}

/// A robot that drives along and looks for markers.
struct Drive<'m> {
    model: &'m SimulatorModel,
    state: SimulatorState,
    detection: MarkerDetection,
    mark: FloorMark,
    gaze: Gaze,
}

impl<'m> Drive<'m> {
    fn new(model: &'m SimulatorModel, seed: u64, gaze: Gaze) -> Self {
        let mark = FloorMark::marker(MarkerColour::Pink, 0.3);
        Self { model, state: model.start(seed), detection: MarkerDetection::default(), mark, gaze }
    }

    /// One step at a speed, towards the axis of the hallway.
    fn step(&mut self, translation_mps: f64) {
        let robot = self.state.robot_in_map;
        let towards_rad = (3.0 - robot.y_m).clamp(-0.4, 0.4);
        let commands = Commands {
            translation_mps,
            rotation_radps: (2.0 * (towards_rad - robot.heading_rad)).clamp(-0.8, 0.8),
            camera: Some(self.detection.command()),
            ..Commands::default()
        };
        let percept = self.model.step(&mut self.state, &commands);
        let eye = MarkerEye {
            camera: &self.model.robot().camera.expect("it has one"),
            mark: &self.mark,
            step_s: self.model.robot().step_s(),
        };
        let reading = percept.camera.expect("it is on");
        self.detection.take_in(&eye, self.gaze, Some(0.0), percept.odometry_in_odom, &reading);
    }

    fn drive(&mut self, steps: usize) {
        (0..steps).for_each(|_| self.step(0.5));
    }

    fn found(&self) -> Vec<SeenMarker> {
        self.detection.markers().copied().collect()
    }

    /// Where a marker is in the map, as far as the odometry is right.
    fn in_map(&self, marker: &SeenMarker) -> Point {
        let odom_in_map = self.state.robot_in_map.compose(self.state.odometry_in_odom.inverse());
        odom_in_map.transform(marker.at_in_odom)
    }
}

#[test]
fn every_marker_is_known_when_the_robot_is_beside_it() {
    let model = hallway("");
    for seed in 0..10 {
        let mut drive = Drive::new(&model, seed, Gaze::Both);
        for (x, y) in MARKERS {
            while drive.state.robot_in_map.x_m < x {
                drive.step(0.5);
            }
            let found = drive.found();
            let off_m = found.iter().map(|marker| distance_m(drive.in_map(marker), Point::new(x, y)));
            assert!(off_m.fold(f64::INFINITY, f64::min) < 0.15, "seed {seed}, {x}: {found:?}");
        }
        assert_eq!(drive.found().len(), MARKERS.len(), "seed {seed}: no marker twice, and none that is not there");
    }
}

#[test]
fn a_side_that_is_not_looked_at_tells_nothing_and_the_other_all() {
    let model = hallway("");
    for (side, count) in [(Side::Left, 3), (Side::Right, 1)] {
        let mut drive = Drive::new(&model, 1, Gaze::Side(side));
        drive.drive(420);
        let found = drive.found();
        let on_side = found.iter().filter(|marker| (drive.in_map(marker).y - 3.0) * side.sign() > 0.0);
        assert_eq!(on_side.count(), count, "{side:?}: {found:?}");
    }
}

#[test]
fn a_robot_that_stops_drives_back_and_on_again_counts_no_marker_twice() {
    let model = hallway("");
    let mut drive = Drive::new(&model, 2, Gaze::Both);
    drive.drive(120);
    (0..40).for_each(|_| drive.step(0.0));
    (0..80).for_each(|_| drive.step(-0.3));
    drive.drive(320);
    assert_eq!(drive.found().len(), MARKERS.len(), "{:?}", drive.found());
}

#[test]
fn a_person_in_the_colour_of_a_marker_is_none() {
    // Six people, of whom some wear pink and red; which ones is left to the seed.
    let model = hallway("people = 6");
    for seed in 0..10 {
        let mut drive = Drive::new(&model, seed, Gaze::Both);
        drive.drive(150);
        for marker in drive.found() {
            let at = drive.in_map(&marker);
            let off_m = MARKERS.iter().map(|&(x, y)| distance_m(at, Point::new(x, y))).fold(f64::INFINITY, f64::min);
            assert!(off_m < 0.4, "seed {seed}: {marker:?} at {at}");
        }
    }
}

#[test]
fn a_look_around_finds_what_lies_behind() {
    let model = hallway("");
    let mut drive = Drive::new(&model, 3, Gaze::Around);
    let behind = Pose::new(5.2, 3.0, 0.0);
    model.teleport(&mut drive.state, behind).expect("free");
    while drive.detection.looks_around() < 2 {
        drive.step(0.0);
    }
    let found: Vec<Point> = drive.found().iter().map(|marker| drive.in_map(marker)).collect();
    for (x, y) in &MARKERS[..3] {
        assert!(found.iter().any(|at| distance_m(*at, Point::new(*x, *y)) < 0.25), "({x}, {y}): {found:?}");
    }
}

#[test]
fn a_copy_written_and_read_back_goes_on_like_its_origin() {
    let model = hallway("people = 2");
    let (mut kept, mut saved) = (Drive::new(&model, 4, Gaze::Both), Drive::new(&model, 4, Gaze::Both));
    for step in 0..200 {
        let bytes = postcard::to_allocvec(&(&saved.state, &saved.detection)).expect("it can be written");
        (saved.state, saved.detection) = postcard::from_bytes(&bytes).expect("and read");
        kept.step(0.5);
        saved.step(0.5);
        assert_eq!(kept.detection, saved.detection, "step {step}");
    }
    assert!(!kept.found().is_empty());
}
