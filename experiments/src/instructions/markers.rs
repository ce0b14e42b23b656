//! `marker-detection`: whether the camera has found the markers of a hallway before the robot is beside them.

use super::setting::usual_camera;
use crate::conduct::chosen;
use crate::findings::Findings;
use crate::kind::{ExperimentKind, Run};
use crate::request::ExperimentRequest;
use crate::statistics::Proportion;
use anyhow::{Context, Result};
use rpl_lola::arena::{ArenaSettings, SingleHallway};
use rpl_lola::markers::calibration::calibrate;
use rpl_lola::markers::{Gaze, MarkerDetection, MarkerEye};
use rpl_robot::description::RobotDescription;
use rpl_robot::geometry::{Point, distance_m};
use rpl_robot::simulator::{Commands, SimulatorModel, SimulatorSettings, SimulatorState};
use rpl_robot::vision::FloorMark;
use rpl_robot::world::{Marker, MarkerColour};
use rpl_shell::status::Status;
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::{NOTHING, Table};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::sync::Arc;

/// A row: what markers are looked for, and among what.
pub struct MarkerRow {
    /// What it is called.
    pub name: &'static str,
    arena: ArenaSettings,
    colour: MarkerColour,
    /// Where the colours were measured: as they are shipped, or in a number of places of another seed.
    places: Option<u64>,
}

const CROWDED: ArenaSettings = ArenaSettings { markers: true, ..ArenaSettings::CROWDED };

const fn crowded(name: &'static str, colour: MarkerColour) -> MarkerRow {
    MarkerRow { name, arena: CROWDED, colour, places: None }
}

/// All rows.
pub static ROWS: [MarkerRow; 6] = [
    MarkerRow { name: "calm", arena: ArenaSettings::MARKED, colour: MarkerColour::Pink, places: None },
    crowded("crowded", MarkerColour::Pink),
    crowded("crowded, orange", MarkerColour::Orange),
    crowded("crowded, green", MarkerColour::Green),
    crowded("crowded, blue", MarkerColour::Blue),
    MarkerRow { places: Some(1), ..crowded("crowded, measured in one place", MarkerColour::Pink) },
];

/// The robot drives so fast.
const SPEED_MPS: f64 = 0.5;

/// The longest time for which it drives.
const LONGEST_S: f64 = 120.0;

/// A marker counts as found that is taken to be so near to where it is.
const NEAR_M: f64 = 0.4;

/// What is farther off has been passed, and the odometry has drifted since.
const JUDGED_M: f64 = 3.0;

/// What a drive along a hallway came to.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct MarkerDrive {
    /// Its seed.
    pub seed: u64,
    /// Markers the robot has driven past.
    passed: usize,
    /// Of those that were known when it was beside them, how far off their places were.
    off_m: Vec<f64>,
    /// What was taken for a marker, and is none.
    false_alarms: usize,
    driven_m: f64,
}

/// What can be asked for with `--row`.
pub fn row_names() -> Vec<&'static str> {
    ROWS.iter().map(|row| row.name).collect()
}

/// Drives along hallways with markers, row by row.
pub struct MarkerDetections {
    request: ExperimentRequest,
    rows: Vec<&'static MarkerRow>,
}

impl MarkerDetections {
    /// What is asked for.
    ///
    /// # Errors
    /// No row has the name.
    pub fn new(request: ExperimentRequest) -> Result<Self> {
        let rows = chosen(&request, &ROWS, |row| row.name)?;
        Ok(Self { request, rows })
    }
}

impl ExperimentKind for MarkerDetections {
    type Ground = ();
    type Record = MarkerDrive;
    type Tally = Vec<MarkerDrive>;

    fn series(&self) -> Vec<String> {
        self.rows.iter().map(|row| row.name.to_string()).collect()
    }

    fn ground(&self, _: usize) -> Result<()> {
        Ok(())
    }

    fn run(&self, series: usize, _: &(), run: Run) -> Result<MarkerDrive> {
        look_for_markers(self.rows[series], &self.request.robot, run.seed)
    }

    fn head(&self, _: &MarkerDrive) -> String {
        "row,seed,passed,found,false alarms,driven [m]".to_string()
    }

    fn lines(&self, series: &str, _: Run, drive: &MarkerDrive) -> String {
        let MarkerDrive { seed, passed, off_m, false_alarms, driven_m } = drive;
        format!("\"{series}\",{seed},{passed},{},{false_alarms},{driven_m:.2}\n", off_m.len())
    }

    fn findings(&self, tallies: Vec<Vec<MarkerDrive>>, _: bool) -> Result<Findings> {
        let rows = self.rows.iter().zip(&tallies).map(|(row, drives)| MarkerResult::of(row.name, drives));
        let rows: Vec<MarkerResult> = rows.collect();
        let (blocks, figures) = (blocks(&rows), json!({ "rows": rows }));
        Ok(Findings { status: Status::Succeeded, blocks, figures, drawings: Vec::new() })
    }
}

/// Drives along the hallway of a seed, and looks to both sides.
///
/// # Errors
/// There is no camera for the robot.
fn look_for_markers(row: &MarkerRow, robot: &Arc<RobotDescription>, seed: u64) -> Result<MarkerDrive> {
    let camera = robot.camera.or_else(usual_camera).context("a robot has a camera or the usual one")?;
    let robot = &Arc::new(RobotDescription { camera: Some(camera), ..RobotDescription::clone(robot) });
    let mut mark = FloorMark::marker(row.colour, 0.3);
    if let Some(places) = row.places {
        mark.colours = calibrate(robot, row.colour, seed, places);
    }
    let mut hallway = SingleHallway::draw(seed, &row.arena);
    hallway.world.markers.iter_mut().for_each(|marker| marker.colour = row.colour);
    let (low_mm, high_mm) = hallway.hallway.across_mm;
    let (low_m, high_m) = (low_mm as f64 / 1e3, high_mm as f64 / 1e3);
    let model = SimulatorModel::new(Arc::new(hallway.world), SimulatorSettings::of(robot.clone()));
    let eye = MarkerEye { camera: &camera, mark: &mark, step_s: robot.step_s() };
    let (mut state, mut detection) = (model.start(seed), MarkerDetection::default());
    let axis_in_odom_rad = -state.robot_in_map.heading_rad;
    let start_m = state.robot_in_map.x_m;
    let mut found = Found { drive: MarkerDrive { seed, ..MarkerDrive::default() }, wrong: Vec::new() };
    let is_beside = |marker: &&Marker| (low_m..high_m).contains(&marker.at.y) && marker.at.x > start_m + JUDGED_M;
    let mut ahead: Vec<Point> = model.world.markers.iter().filter(is_beside).map(|marker| marker.at).collect();
    ahead.sort_by(|a, b| b.x.total_cmp(&a.x));
    for _ in 0..(LONGEST_S / robot.step_s()) as usize {
        let commands = Commands { camera: Some(detection.command()), ..along(&state, (low_m + high_m) / 2.0) };
        let percept = model.step(&mut state, &commands);
        if let Some(reading) = &percept.camera {
            detection.take_in(&eye, Gaze::Both, Some(axis_in_odom_rad), percept.odometry_in_odom, reading);
        }
        while let Some(marker) = ahead.pop_if(|marker| marker.x <= state.robot_in_map.x_m) {
            found.pass(&state, &detection, marker);
        }
        found.look(&model, &state, &detection);
    }
    found.drive.driven_m = state.robot_in_map.x_m - start_m;
    Ok(found.drive)
}

/// Down the middle of a hallway that runs along x.
fn along(state: &SimulatorState, middle_m: f64) -> Commands {
    let robot = state.robot_in_map;
    let towards_rad = (middle_m - robot.y_m).clamp(-0.5, 0.5);
    let rotation_radps = (2.0 * (towards_rad - robot.heading_rad)).clamp(-0.8, 0.8);
    Commands { translation_mps: SPEED_MPS, rotation_radps, ..Commands::default() }
}

struct Found {
    drive: MarkerDrive,
    /// The numbers of what is no marker.
    wrong: Vec<u64>,
}

impl Found {
    /// The robot is beside a marker: was it known?
    fn pass(&mut self, state: &SimulatorState, detection: &MarkerDetection, marker: Point) {
        let off_m = detection.markers().map(|seen| distance_m(in_map(state, seen.at_in_odom), marker));
        let nearest_m = off_m.fold(f64::INFINITY, f64::min);
        self.drive.passed += 1;
        if nearest_m <= NEAR_M {
            self.drive.off_m.push(nearest_m);
        }
    }

    fn look(&mut self, model: &SimulatorModel, state: &SimulatorState, detection: &MarkerDetection) {
        for seen in detection.markers() {
            let at = in_map(state, seen.at_in_odom);
            let is_near = distance_m(at, state.robot_in_map.point()) <= JUDGED_M;
            let is_one = model.world.markers.iter().any(|marker| distance_m(marker.at, at) <= NEAR_M);
            if is_near && !is_one && !self.wrong.contains(&seen.number) {
                self.wrong.push(seen.number);
                self.drive.false_alarms += 1;
            }
        }
    }
}

fn in_map(state: &SimulatorState, in_odom: Point) -> Point {
    state.robot_in_map.transform(state.odometry_in_odom.inverse().transform(in_odom))
}

/// What came of the drives of a row.
#[derive(Clone, Debug, Serialize)]
pub struct MarkerResult {
    /// What the row is called.
    pub name: String,
    /// Drives.
    pub runs: usize,
    /// Markers that were known when the robot was beside them.
    pub found: Proportion,
    /// What was taken for a marker and is none, in 100 m.
    pub false_in_100_m: f64,
    /// How far a known marker was from where it was taken to be: the middle one, and what 95 % do not exceed.
    pub off_m: Option<[f64; 2]>,
}

impl MarkerResult {
    /// The figures of some drives.
    pub fn of(name: &str, drives: &[MarkerDrive]) -> Self {
        let mut off_m: Vec<f64> = drives.iter().flat_map(|drive| drive.off_m.iter().copied()).collect();
        off_m.sort_by(f64::total_cmp);
        let at = |share: f64| off_m.get((off_m.len() as f64 * share) as usize).copied();
        let driven_m: f64 = drives.iter().map(|drive| drive.driven_m).sum();
        let alarms: usize = drives.iter().map(|drive| drive.false_alarms).sum();
        Self {
            name: name.to_string(),
            runs: drives.len(),
            found: Proportion::new(off_m.len(), drives.iter().map(|drive| drive.passed).sum()),
            false_in_100_m: 100.0 * alarms as f64 / driven_m.max(1e-9),
            off_m: at(0.5).zip(at(0.95)).map(|(median_m, most_m)| [median_m, most_m]),
        }
    }
}

/// A line for each row.
pub fn blocks(rows: &[MarkerResult]) -> Vec<Block> {
    let heads = ["", "drives", "found", "95 % interval", "false in 100 m", "off by: median", "95 %"];
    let mut table = Table::new(&heads);
    for row in rows {
        let metres = |number: usize| row.off_m.map_or(NOTHING.to_string(), |off_m| format!("{:.3} m", off_m[number]));
        let alarms = format!("{:.2}", row.false_in_100_m);
        let cells = [row.found.fraction(), row.found.interval(), alarms, metres(0), metres(1)];
        table.row([row.name.clone(), row.runs.to_string()].into_iter().chain(cells));
    }
    vec![Block::Table(table)]
}
