//! Localization by landmarks: what a camera sees of sheets on walls sets the position right, and an unexpected one
//! erases the route.

use rpl_robot::description::RobotDescription;
use rpl_robot::geometry::{Pose, wrap_angle_rad};
use rpl_robot::localization::{LocalizationParameters, Spread};
use rpl_robot::office::{OfficeModel, OfficeSettings, PositionBy};
use rpl_robot::world::World;
use rpl_runtime::run::system::System;
use rpl_tests::mission::{Mission, fluent_text, model, run_until};
use std::sync::Arc;

/// A hall of 24 m, bare but for two landmarks and, at each end, a place.
const HALL: &str = r#"
name = "bare-hall"
size = [24.0, 3.0]
start = [2.0, 1.5, 0.0]
[[wall]]
line = [[0.1, 0.1], [23.9, 0.1], [23.9, 2.9], [0.1, 2.9], [0.1, 0.1]]
thickness = 0.2
[[landmark]]
name = "pink-sheet"
pose = [9.0, 0.2, "90deg"]
[[landmark]]
name = "green-sheet"
pose = [15.0, 2.8, "270deg"]
colour = "green"
[[place]]
name = "west"
pose = [2.0, 1.5, 0.0]
[[place]]
name = "middle"
pose = [12.0, 1.5, 0.0]
[[place]]
name = "east"
pose = [22.0, 1.5, 0.0]
"#;

fn hall(position_by: PositionBy) -> Arc<OfficeModel> {
    let robot = RobotDescription::builtin("pioneer-2dx").expect("built in");
    let localization = LocalizationParameters::of(&robot).coarsened();
    let settings = OfficeSettings { position_by, localization, ..OfficeSettings::of(robot) };
    model(World::parse(HALL, "hall.toml").expect("no faults"), settings)
}

type Running = System<rpl_mission::modules::SiteRobot>;

/// How far the estimate is off, and by what angle.
fn off(system: &Running) -> (f64, f64) {
    let (truth, estimate) = (system.outside.host.state.robot_in_map, system.outside.estimate().pose_in_map);
    (estimate.distance_m(truth), wrap_angle_rad(estimate.heading_rad - truth.heading_rad).abs())
}

/// A run in which the robot takes itself to be elsewhere along the hall, `by_m` off.
fn misled(mission: &Mission, seed: u64, by_m: f64) -> Running {
    let mut robot = mission.robot(seed);
    let spread = Spread { position_m: 0.3, ..Spread::default() };
    robot.tell_position(Pose::new(2.0 + by_m, 1.5, 0.0), spread);
    mission.start_with(robot, seed)
}

#[test]
fn before_a_wall_the_position_of_a_robot_that_goes_by_its_odometry_is_right_to_10_cm() {
    let mission = Mission::new(hall(PositionBy::Landmarks), "(go-by-cases 'east)");
    for seed in 1..=5 {
        let mut system = misled(&mission, seed, 0.8);
        let is_right = |system: &mut Running| off(system).0 < 0.1;
        assert!(run_until(&mut system, 120.0, is_right), "{seed}: {:?}", off(&system));
        let (off_m, off_rad) = off(&system);
        assert!(off_m < 0.1 && off_rad < 0.08, "{seed}: {off_m} m, {off_rad} rad");
        assert!(run_until(&mut system, 240.0, |system| fluent_text(system, "landmark*") == "green-sheet"), "{seed}");
    }
}

#[test]
fn an_unexpected_landmark_erases_the_route() {
    for (position_by, by_m, is_erased) in [
        (PositionBy::Grid, 4.0, true),
        (PositionBy::Grid, 0.0, false),
        (PositionBy::Landmarks, 4.0, true),
        (PositionBy::Landmarks, 0.0, false),
    ] {
        let plan = "(with-policy (localize-by-landmarks)
                      (with-valve wheels
                        (with-failure-handling ((unexpected-landmark (f) 'erased))
                          (run-behaviour case-navigation :route '(middle east))
                          'driven)))";
        let mut system = misled(&Mission::new(hall(position_by), plan), 4, by_m);
        system.run_until(180_000_000);
        let outcome = rpl_tests::outcome_text(&system);
        assert_eq!(outcome, if is_erased { "=> erased" } else { "=> driven" }, "{position_by:?} {by_m}");
        // On the grid the belief is left to the plan; before the sheet the robot has measured where it is.
        if is_erased && position_by == PositionBy::Landmarks {
            assert!(off(&system).0 < 0.5, "{position_by:?}: {:?}", off(&system));
        }
    }
}

#[test]
fn who_cannot_see_landmarks_is_told_why_and_drives_without() {
    let told = |robot: &str, settings: fn(&mut OfficeSettings), world: &str, message: &str| {
        let robot = RobotDescription::builtin(robot).expect("built in");
        let localization = LocalizationParameters::of(&robot).coarsened();
        let mut all = OfficeSettings { localization, ..OfficeSettings::of(robot) };
        settings(&mut all);
        let plan = "(list (landmarks) (run-behaviour landmark-localization))";
        let run = Mission::new(model(World::parse(world, "w.toml").expect("no faults"), all), plan).run(1, 10.0);
        assert!(run.outcome().contains(message), "{}", run.outcome());
    };
    let bare = HALL.split("[[landmark]]").next().expect("what comes before");
    told("b21", |_| (), HALL, "the robot `b21` has no camera");
    told("pioneer-2dx", |settings| settings.map_known = false, HALL, "the robot has no map");
    told("pioneer-2dx", |_| (), bare, "the world `bare-hall` has no landmarks");
    let names = Mission::new(hall(PositionBy::Grid), "(landmarks)").run(1, 10.0);
    assert_eq!(names.outcome(), "=> (pink-sheet green-sheet)");
}

#[test]
fn a_robot_that_goes_by_its_odometry_is_told_how_it_localizes() {
    let plan = "(with-valve wheels (run-behaviour active-localization))";
    let told = Mission::new(hall(PositionBy::Landmarks), plan).run(1, 10.0).outcome();
    assert!(told.contains("there is nothing to localize in"), "{told}");
    assert!(told.contains("under `(with-policy (localize-by-landmarks) ...)`"), "{told}");
    assert!(!told.contains("no map"), "{told}");
}
