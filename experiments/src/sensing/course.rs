//! One run: the robot is moved, reads one direction at a time, and is compared with the truth.

use super::settings::{Policy, SensingSetting};
use super::shuttle::Shuttle;
use anyhow::{Context, Result};
use rpl_random::Stream;
use rpl_robot::active::{Direction, SensingModel};
use rpl_robot::description::RobotDescription;
use rpl_robot::geometry::{Point, Pose};
use rpl_robot::localization::{
    BeamParameters, Belief, LocalizationModel, LocalizationParameters, OdometryError, ScanParameters,
};
use rpl_robot::sensors::RangeSensor;
use rpl_robot::simulator::{Commands, Percept, SimulatorModel, SimulatorSettings};
use rpl_robot::world::{SeenBy, World};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// How long a run lasts.
pub const NEVER_LONGER_US: u64 = 600_000_000;

/// Time between two readings.
const READ_EVERY_US: u64 = 1_000_000;

/// The robot must be certain after this time.
pub const CERTAIN_WITHIN_S: f64 = 400.0;

/// Certain is this probability ...
const CERTAIN: f64 = 0.9;

/// ... of positions nearer to the true one than this.
const NEAR_M: f64 = 0.4;

/// ... held for this time: in the middle of the corridor, where no end is in sight, the position
/// along it blurs now and then.
pub const HELD_S: f64 = 60.0;

/// States a choice looks at.
const STATES: usize = 4096;

/// Edge of a cell of the maps the expected distances are cast in.
const SENSOR_MAP_CELL_M: f64 = 0.05;

/// Everything about the corridor that does not change.
#[derive(Debug)]
pub struct Hall {
    pub world: Arc<World>,
    simulator: SimulatorModel,
    localization: LocalizationModel,
    /// The ends of the lane.
    ends_in_map: [Point; 2],
}

/// What was the case after a reading.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensingMoment {
    pub time_s: f64,
    /// L1 distance to the true position, weighted by the belief.
    pub error_m: f64,
    /// Probability within 0.4 m of the true position.
    pub near: f64,
}

/// What a reading met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EndPoint {
    pub is_sonar: bool,
    /// From where the robot really was.
    pub end_in_map: Point,
}

/// One run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensingRun {
    pub seed: u64,
    pub moments: Vec<SensingMoment>,
    /// Probability within 0.4 m of the position mirrored at the middle of the world, at the end.
    pub mirrored: f64,
}

/// The runs of each row.
pub type SensingRuns = Vec<(&'static SensingSetting, Vec<SensingRun>)>;

impl SensingRun {
    /// When the robot first became certain of its true position and stayed so for a while.
    pub fn certain_after_s(&self) -> Option<f64> {
        let mut runs = self.moments.chunk_by(|a, b| (a.near >= CERTAIN) == (b.near >= CERTAIN));
        let certain =
            |run: &&[SensingMoment]| run[0].near >= CERTAIN && run[run.len() - 1].time_s - run[0].time_s >= HELD_S;
        runs.find(certain).map(|run| run[0].time_s)
    }

    /// Whether that was soon enough.
    pub fn succeeded(&self) -> bool {
        self.certain_after_s().is_some_and(|time_s| time_s <= CERTAIN_WITHIN_S)
    }
}

/// The equations as printed: single readings, apart in place and direction, are independent enough to
/// count in full. θ alone is the default's, below the printed one, so that neither of two mirror poses
/// falls behind. Odometry errs by what the simulated one does, its constant errors over some metres
/// included.
fn parameters(sensors: Vec<ScanParameters>) -> LocalizationParameters {
    LocalizationParameters {
        activity_threshold: LocalizationParameters::default().activity_threshold,
        odometry: OdometryError {
            forward_m: 0.04,
            sideward_m: 0.02,
            turn_per_metre_rad: 0.75_f64.to_radians(),
            turn_per_radian_rad: 1.5_f64.to_radians(),
            position_per_radian_m: 0.0,
        },
        ..LocalizationParameters { sensors, ..LocalizationParameters::default() }.literal()
    }
}

/// The laser in a map of outlines: the Gaussian covers half a cell, and half a step of the heading
/// where the ray meets a wall at a small angle.
fn laser_beam(max_range_m: f64) -> BeamParameters {
    BeamParameters {
        max_range_m,
        wall_depth_m: 0.0,
        sigma_m: 0.05,
        sigma_per_m: 0.03,
        fades: true,
        ..BeamParameters::laser()
    }
}

impl Hall {
    /// The models of a corridor with places `west-end` and `east-end`.
    ///
    /// # Errors
    /// The world has no such places, or no room for a robot.
    pub fn new(world: World) -> Result<Self> {
        let world = Arc::new(world);
        let end = |name| world.place(name).map(|place| place.pose_in_map.point());
        let ends_in_map = [end("west-end")?, end("east-end")?];
        let robot = RobotDescription::builtin("b21-laser").context("the papers' robot with a laser is built in")?;
        let sensors = robot.range_sensors();
        let scanner = sensors.laser.context("it has one")?;
        let map = |seen: fn(SeenBy) -> bool| world.map_centred_seen(SENSOR_MAP_CELL_M, seen);
        let sonar = robot.sonar.as_ref().context("it has sonars")?;
        let beam = BeamParameters { fades: true, ..BeamParameters::sonar(sonar) };
        let sonars = ScanParameters { beam, ..ScanParameters::sonars(sonar) };
        let bearings = (0..scanner.readings).map(|beam| scanner.direction_rad(beam).to_degrees().round() as i32);
        let laser = ScanParameters {
            beams_deg: bearings.collect(),
            beam: laser_beam(scanner.range_m),
            tempering: sonars.tempering,
            ..ScanParameters::laser(&scanner)
        };
        let seen = [map(|seen| seen.sonar), map(|seen| seen.laser)];
        let localization = LocalizationModel::seeing(
            &map(|_| true).around_free(),
            &[&seen[0], &seen[1]],
            parameters(vec![sonars, laser]),
        )
        .context("the robot cannot be localized in this world")?;
        let simulator = SimulatorModel::new(world.clone(), SimulatorSettings::of(robot));
        Ok(Self { simulator, world, localization, ends_in_map })
    }

    /// What a direction of a sensor measures.
    fn read(
        &self,
        Direction { sensor, beam }: Direction,
        percept: &Percept,
        truth_in_map: Pose,
    ) -> Option<(f64, EndPoint)> {
        let is_sonar = self.localization.sensors[sensor].parameters.source == RangeSensor::Sonar;
        let sensors = &self.simulator.sensors;
        let (range_m, bearing_rad) = if is_sonar {
            (*percept.sonar_m.as_ref()?.get(beam)?, sensors.sonars.as_ref()?.mounts.get(beam)?.heading_rad)
        } else {
            (*percept.laser_m.as_ref()?.get(beam)?, sensors.laser?.direction_rad(beam))
        };
        let range_m = f64::from(range_m);
        let end = Point::new(range_m * bearing_rad.cos(), range_m * bearing_rad.sin());
        Some((range_m, EndPoint { is_sonar, end_in_map: truth_in_map.transform(end) }))
    }

    /// Moves the robot, from a place on the lane that is drawn from the seed. Answers what its readings met, too.
    pub fn run(&self, setting: &SensingSetting, seed: u64, until_us: u64) -> (SensingRun, Vec<EndPoint>) {
        let model = &self.localization;
        let sensing = SensingModel::new(model, setting.sensors.numbers());
        let mut chance = Stream::new(seed, "sensing");
        let (mut shuttle, start_in_map) = Shuttle::start(self.ends_in_map, &mut Stream::new(seed, "shuttle"));
        let mut state = self.simulator.start(seed);
        state.robot_in_map = start_in_map;
        let mut belief = Belief::uniform(model);
        let mut odometry_in_odom = state.odometry_in_odom;
        let mut course = SensingRun { seed, moments: Vec::new(), mirrored: 0.0 };
        let mut readings = Vec::new();
        while state.time_us < until_us {
            let commands = Commands { sonars_on: true, ..shuttle.commands(state.robot_in_map) };
            let percept = self.simulator.step(&mut state, &commands);
            if !percept.time_us.is_multiple_of(READ_EVERY_US) {
                continue;
            }
            belief.moved(model, percept.odometry_in_odom.relative_to(odometry_in_odom));
            odometry_in_odom = percept.odometry_in_odom;
            let direction = choose(setting.policy, &sensing, &belief, model, &mut chance);
            if let Some((range_m, end)) = self.read(direction, &percept, state.robot_in_map) {
                belief.sense_reading(model, direction.sensor, direction.beam, range_m);
                readings.push(end);
            }
            let off = belief.off_from(model, state.robot_in_map.point(), NEAR_M);
            course.moments.push(SensingMoment {
                time_s: percept.time_us as f64 / 1e6,
                error_m: off.l1_m,
                near: off.near,
            });
        }
        let middle = self.world.bounds().centre();
        let mirrored = middle + (middle - state.robot_in_map.point());
        course.mirrored = belief.off_from(model, mirrored, NEAR_M).near;
        (course, readings)
    }
}

fn choose(
    policy: Policy,
    sensing: &SensingModel<'_>,
    belief: &Belief,
    model: &LocalizationModel,
    chance: &mut Stream,
) -> Direction {
    let random = sensing.directions()[chance.index(sensing.directions().len())];
    match policy {
        Policy::Random => random,
        Policy::Active => sensing.choose(&belief.drawn_states(model, STATES)).map_or(random, |choice| choice.direction),
    }
}
