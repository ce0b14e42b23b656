use super::*;
use crate::description::RobotDescription;
use crate::geometry::{Pose, wrap_angle_rad};
use crate::localization::LandmarkNoise;
use crate::sensors::CameraReading;
use crate::simulator::{CameraCommand, Commands, SimulatorModel, SimulatorSettings, SimulatorState};
use crate::world::World;
use rpl_random::Stream;
use std::sync::Arc;

/// A hall with an orange landmark on its west wall, and what else is said.
fn hall(more: &str) -> SimulatorModel {
    let text = format!(
        "name = \"hall\"\nsize = [12.0, 12.0]\nstart = [6.0, 6.0, 0]\n\
         [[wall]]\nline = [[0.0, 0.0], [0.0, 12.0]]\nthickness = 0.2\n\
         [[landmark]]\nname = \"west\"\npose = [0.1, 6.0, 0]\ncolour = \"orange\"\n{more}"
    );
    let world = World::parse(&text, "hall.toml").expect("a world");
    let robot = RobotDescription::builtin("pioneer-2dx").expect("built in");
    SimulatorModel::new(Arc::new(world), SimulatorSettings::of(robot))
}

fn landmark(model: &SimulatorModel) -> &Landmark {
    &model.world.landmarks[0]
}

fn placed(model: &SimulatorModel, robot_in_map: Pose, seed: u64) -> SimulatorState {
    let mut state = model.start(seed);
    model.teleport(&mut state, robot_in_map).expect("nothing is there");
    state
}

fn view(model: &SimulatorModel) -> CameraView {
    model.robot().camera.expect("it has one").view
}

/// What the camera finds.
fn found(model: &SimulatorModel, state: &mut SimulatorState) -> Vec<Point> {
    let looking = Commands { camera: Some(CameraCommand::default()), ..Commands::default() };
    let images = std::iter::from_fn(|| model.step(state, &looking).camera);
    let image = images.take(10).find_map(|CameraReading { image, .. }| image).expect("an image each fifth of a second");
    wall_sightings(&WallMark::of(landmark(model)), &view(model), &image)
}

/// A place before the landmark, from which it is in the middle third of an image.
fn anywhere(stream: &mut Stream) -> Pose {
    let (aslant_rad, off_m) = (stream.uniform_in(-1.1, 1.1), stream.uniform_in(1.0, 4.5));
    let (sin, cos) = libm::sincos(aslant_rad);
    let heading_rad = std::f64::consts::PI + aslant_rad + stream.uniform_in(-0.25, 0.25);
    Pose::new(0.1 + off_m * cos, 6.0 + off_m * sin, heading_rad)
}

#[test]
fn a_landmark_is_seen_where_it_hangs_to_the_noise_that_localization_counts_on() {
    let model = hall("");
    let mut stream = Stream::new(7, "places");
    let (mut seen, mut bearings, mut ranges) = (0, 0.0, 0.0);
    for seed in 0..400 {
        let robot_in_map = anywhere(&mut stream);
        let truth = robot_in_map.inverse().transform(landmark(&model).pose_in_map.point());
        let sightings = found(&model, &mut placed(&model, robot_in_map, seed));
        let Some(sighting) = sightings.first() else { continue };
        assert_eq!(sightings.len(), 1);
        seen += 1;
        let bearing_rad = |at: Point| libm::atan2(at.y, at.x);
        let range_m = truth.coords.norm();
        let noise = LandmarkNoise::USUAL;
        let off_rad = wrap_angle_rad(bearing_rad(*sighting) - bearing_rad(truth)) / noise.bearing_rad;
        let off_m = (sighting.coords.norm() - range_m) / noise.range_m(range_m);
        assert!(off_rad.abs() < 5.0 && off_m.abs() < 5.0, "{robot_in_map:?}: {off_rad} {off_m}");
        bearings += off_rad * off_rad;
        ranges += off_m * off_m;
    }
    let [bearings, ranges] = [bearings, ranges].map(|sum: f64| libm::sqrt(sum / f64::from(seen)));
    assert!(seen > 360, "{seen}");
    for spread in [bearings, ranges] {
        assert!((0.5..1.3).contains(&spread), "in noises: bearing {bearings}, range {ranges}");
    }
}

#[test]
fn what_stands_before_a_landmark_hides_it() {
    let robot_in_map = Pose::new(3.1, 6.0, std::f64::consts::PI);
    for (thing, is_seen) in [
        ("", true),
        ("[[object]]\nname = \"box\"\nrect = [1.2, 5.6, 1.8, 6.4]", false),
        ("[[object]]\nname = \"box\"\nrect = [1.2, 7.0, 1.8, 7.8]", true),
        ("[[object]]\nname = \"box\"\nrect = [4.2, 5.6, 4.8, 6.4]", true),
        ("[[person]]\npath = [[1.5, 6.0], [1.5, 6.001]]\nspeed = 0.01", false),
        ("[[wall]]\nline = [[1.5, 5.0], [1.5, 7.0]]", false),
    ] {
        let model = hall(thing);
        let found = found(&model, &mut placed(&model, robot_in_map, 1));
        assert_eq!(found.len(), usize::from(is_seen), "{thing}: {found:?}");
    }
}

#[test]
fn it_is_not_seen_from_behind_and_nothing_else_is_taken_for_it() {
    let others = "[[marker]]\nat = [2.5, 6.0]\ncolour = \"orange\"\n\
                  [[landmark]]\nname = \"high\"\npose = [0.1, 7.0, 0]\ncolour = \"orange\"\nbottom = 0.7\n\
                  [[landmark]]\nname = \"pink\"\npose = [0.1, 5.0, 0]\ncolour = \"pink\"";
    let model = hall(others);
    let found_from = |pose| found(&model, &mut placed(&model, pose, 1));
    let sightings = found_from(Pose::new(3.6, 6.0, std::f64::consts::PI));
    assert_eq!(sightings.len(), 1, "{sightings:?}");
    assert!((sightings[0] - Point::new(3.5, 0.0)).norm() < 0.4, "{sightings:?}");
    assert_eq!(found_from(Pose::new(3.6, 6.0, 0.0)), []);
}
