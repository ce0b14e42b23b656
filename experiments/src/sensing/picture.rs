//! The figures of the experiment, as in the paper: error over time (Fig. 9), probability of the true
//! position (Fig. 10), and what the selected readings met (Fig. 11).

use super::course::{EndPoint, Hall, SensingMoment, SensingRun, SensingRuns};
use super::settings::{Policy, SensingSetting, Sensors};
use crate::chart::{self, Curve, CurvePoint as Mean};
use rpl_drawing::{Dots, Figure, FloorPlan};
use rpl_robot::geometry::Point;

/// Edge of a map cell in a drawing.
const RESOLUTION_M: f64 = 0.05;

/// Seconds between two points of a line.
const EVERY_S: usize = 20;

const KINDS: [(Sensors, &str); 3] = [(Sensors::Sonars, "sonars"), (Sensors::Laser, "laser"), (Sensors::Both, "both")];

/// Names of files, and error and probability over time in them.
pub fn over_time(rows: &SensingRuns) -> Vec<(String, String)> {
    let mut files = Vec::new();
    for (sensors, name) in KINDS {
        let lines = lines(rows, sensors, |moment| moment.error_m);
        if !lines.is_empty() {
            let title = format!("L1 error weighted by the belief, {name}");
            files.push((format!("error-{name}.svg"), chart::over_time(&title, "error [m]", 1.0, &lines)));
        }
        let lines = self::lines(rows, sensors, |moment| moment.near);
        if !lines.is_empty() {
            let title = format!("probability within 0.4 m of the true position, {name}");
            files.push((format!("probability-{name}.svg"), chart::over_time(&title, "probability", 1.0, &lines)));
        }
    }
    files
}

/// Whether the readings of the first run of a row are shown.
pub fn shows_readings(setting: &SensingSetting) -> bool {
    setting.sensors == Sensors::Both && setting.policy == Policy::Active
}

/// Names of files, and where the readings of a run ended in them.
pub fn readings(hall: &Hall, seed: u64, readings: &[EndPoint]) -> [(String, String); 2] {
    [true, false].map(|sonars| {
        let name = if sonars { "readings-sonars.svg" } else { "readings-laser.svg" };
        (name.to_string(), end_points(hall, seed, readings, sonars))
    })
}

/// The mean over the runs of each row with these sensors.
fn lines<'r>(rows: &'r SensingRuns, sensors: Sensors, of: fn(&SensingMoment) -> f64) -> Vec<Curve<'r>> {
    let of_sensors = rows.iter().filter(|(setting, _)| setting.sensors == sensors);
    of_sensors.map(|(setting, courses)| Curve { name: setting.name, points: points(courses, of) }).collect()
}

fn points(courses: &[SensingRun], of: fn(&SensingMoment) -> f64) -> Vec<Mean> {
    let moments = courses.iter().map(|course| course.moments.len()).min().unwrap_or(0);
    let at = |index: usize| {
        let numbers: Vec<f64> = courses.iter().map(|course| of(&course.moments[index])).collect();
        chart::point(courses[0].moments[index].time_s, &numbers)
    };
    (0..moments).step_by(EVERY_S).map(at).collect()
}

/// Where the readings of one run ended, seen from where the robot really was.
fn end_points(hall: &Hall, seed: u64, readings: &[EndPoint], sonars: bool) -> String {
    let map = hall.world.map(RESOLUTION_M).around_free();
    let ends = readings.iter().filter(|reading| reading.is_sonar == sonars);
    let dots_in_map: Vec<Point> = ends.map(|reading| reading.end_in_map).collect();
    let sensor = if sonars { "sonars" } else { "laser" };
    let title = format!("end points of the {} readings of the {sensor}, seed {seed}", dots_in_map.len());
    let mut figure = Figure::new(title, FloorPlan::of_map(&map));
    figure.dots = vec![Dots { means: "end of a reading".to_string(), points_in_map: dots_in_map }];
    figure.draw()
}
