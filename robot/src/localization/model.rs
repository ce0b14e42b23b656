//! Everything about localization that never changes during a mission.

use super::error::ModelError;
use super::grid::{BeliefGrid, State, TILE};
use super::ground::Ground;
use super::kernel::MAX_BEAMS;
use super::parameters::LocalizationParameters;
use super::scan::{ScanModel, SeenMap, Weighing};
use super::sensor::{BinnedScan, NO_ECHO};
use super::simd::Instructions;
use crate::geometry::{Point, Pose, Vector};
use crate::occupancy::{Cell, DistanceField, OccupancyGrid};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The fine belief is made of the coarse one that watches as soon as so few of its states would be above θ.
pub(super) const FEW_STATES: f64 = 20_000.0;

/// How badly scans fit a pose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Misfit {
    /// −ln of their likelihood, tempered, less the least it can be anywhere.
    pub nats: f64,
    /// What that is on the average, by the sensor model.
    pub mean_nats: f64,
}

/// With more than this share a scan alone is a reason to ask whether odometry was badly wrong: one of fifty at the right pose.
const MOST_EXPLAINED: f64 = 0.8;

impl Misfit {
    /// Whether a scan alone gives no reason to look for another explanation.
    pub(super) fn is_explained(&self) -> bool {
        self.nats <= MOST_EXPLAINED * self.mean_nats
    }

    /// How much worse scans fit than with a share of what the sensor model has on the average; below 0 if better.
    pub(super) fn beyond_nats(&self, share: f64) -> f64 {
        self.nats - share * self.mean_nats
    }
}

/// The map as localization needs it: cells that can be stood in, and what each sensor is expected to
/// measure there. Shared by `Arc`; never part of a saved state.
#[derive(Debug)]
pub struct LocalizationModel {
    /// What was set.
    pub parameters: LocalizationParameters,
    /// Where the cells lie.
    pub grid: BeliefGrid,
    /// The range sensors, in the order of the parameters; at least one.
    pub sensors: Vec<ScanModel>,
    /// Distances in the map.
    pub distances: Arc<DistanceField>,
    /// Which cells of a plane can be stood in.
    pub(super) ground: Arc<Ground>,
    /// What the loops over cells are run with.
    pub(super) instructions: Instructions,
    /// The model of the coarse belief that watches, if there is one.
    pub(super) watch: Option<Box<LocalizationModel>>,
}

impl LocalizationModel {
    /// For sensors that see everything in the map. The tables of expected distances are computed when they are first
    /// asked for, about a microsecond for each cell.
    ///
    /// # Errors
    /// When the parameters do not describe a grid and what is sensed on it, or the robot fits nowhere in
    /// the map.
    pub fn new(map: &OccupancyGrid, parameters: LocalizationParameters) -> Result<Self, ModelError> {
        let seen = vec![map; parameters.sensors.len()];
        Self::seeing(map, &seen, parameters)
    }

    /// The same where each sensor has a map of its own, of what it sees: `seen` has one for each.
    ///
    /// # Errors
    /// As [`LocalizationModel::new`].
    pub fn seeing(
        map: &OccupancyGrid,
        seen: &[&OccupancyGrid],
        parameters: LocalizationParameters,
    ) -> Result<Self, ModelError> {
        assert_eq!(seen.len(), parameters.sensors.len(), "each sensor has a map");
        let all = SeenMap::new(map);
        let seen_map = |&seen: &&OccupancyGrid| if std::ptr::eq(seen, map) { all.clone() } else { SeenMap::new(seen) };
        let seen: Vec<SeenMap> = seen.iter().map(seen_map).collect();
        Self::over(map, &all.distances, &seen, parameters)
    }

    fn over(
        map: &OccupancyGrid,
        distances: &Arc<DistanceField>,
        seen: &[SeenMap],
        parameters: LocalizationParameters,
    ) -> Result<Self, ModelError> {
        parameters.check()?;
        let step_deg = parameters.angle_step_deg;
        if step_deg == 0 || !360u32.is_multiple_of(step_deg) {
            return Err(ModelError::AngleStep(step_deg));
        }
        if !(parameters.cell_m.is_finite() && parameters.cell_m >= map.resolution_m - 1e-9) {
            return Err(ModelError::CellSize(map.resolution_m.to_string()));
        }
        if parameters.sensors.is_empty() {
            return Err(ModelError::NoSensor);
        }
        parameters.sensors.iter().try_for_each(|sensor| check_beams(&sensor.beams_deg))?;
        let grid = BeliefGrid::over(map, parameters.cell_m, step_deg, parameters.centred);
        let ground = Arc::new(Ground::new(&grid, |column, row| {
            fits(map, distances, grid.centre(column, row), parameters.clearance_m)
        }));
        if ground.cells() == 0 {
            return Err(ModelError::NoFreeCell);
        }
        let watch = match parameters.of_watch() {
            Some(coarse) => Some(Box::new(Self::over(map, distances, seen, coarse)?)),
            None => None,
        };
        let sensors = parameters.sensors.iter().zip(seen);
        let sensors = sensors.map(|(sensor, seen)| ScanModel::new(sensor.clone(), seen, &grid, &ground)).collect();
        Ok(Self {
            sensors,
            parameters,
            grid,
            distances: distances.clone(),
            ground,
            instructions: Instructions::fastest(),
            watch,
        })
    }

    /// Memory that the tables and a belief over a map of this size take at the most, without building them:
    /// two copies of the belief, because noise is spread from one into the other. Where a coarse belief watches, the fine
    /// one begins with few states, in as many tiles at the most.
    pub fn needed_bytes(size_m: Vector, parameters: &LocalizationParameters) -> u64 {
        let along = |length_m: f64| libm::ceil(length_m / parameters.cell_m).max(1.0);
        let cells = along(size_m.x) * along(size_m.y);
        let headings = 360.0 / f64::from(parameters.angle_step_deg.max(1));
        // Whole degrees are the finest table of directions.
        let tables = 360.0 * parameters.sensors.len() as f64;
        let begun_with = parameters.watch.as_ref().map_or(f64::INFINITY, |_| FEW_STATES * TILE as f64);
        let states = (cells * headings).min(begun_with);
        let own = (states * 2.0 * size_of::<f32>() as f64 + cells * tables) as u64;
        let watch = parameters.of_watch().map_or(0, |coarse| Self::needed_bytes(size_m, &coarse));
        own.saturating_add(watch)
    }

    /// Cells of (x, y) the robot can stand in.
    pub fn admissible_cells(&self) -> usize {
        self.ground.cells()
    }

    /// Whether the robot can stand in this cell.
    pub fn is_admissible(&self, column: usize, row: usize) -> bool {
        self.ground.is_free(self.grid.place(column, row))
    }

    /// Probability of one state when nothing is known.
    pub fn prior(&self) -> f64 {
        1.0 / (self.ground.cells() as f64 * self.grid.headings as f64)
    }

    /// θ of Beetz et al. Eq. (3).
    pub(super) fn threshold(&self) -> f64 {
        self.parameters.activity_threshold * self.prior()
    }

    /// Whether anything of a belief ever sleeps.
    pub(super) fn sleeps(&self) -> bool {
        self.parameters.activity_threshold > 0.0
    }

    /// The same model with its loops run by these instructions: slower or faster, with the same bits.
    pub fn with_instructions(self, instructions: Instructions) -> Self {
        let watch = self.watch.map(|coarse| Box::new(coarse.with_instructions(instructions)));
        Self { instructions, watch, ..self }
    }

    /// The noise-free scan of a sensor at a state, in bins.
    pub fn expected_scan(&self, sensor: usize, state: State) -> Vec<u8> {
        self.sensors[sensor].expected_scan(state.heading, self.grid.place(state.column, state.row))
    }

    /// The average weight of a scan of a sensor; sampled where the coarse belief has its cells, if one watches: it
    /// looks everywhere anyway.
    pub(super) fn average_weight(&self, sensor: usize, readings: &[(usize, u8)], weighing: Weighing) -> f64 {
        let sampled = self.watch.as_ref().map_or(&self.sensors[sensor], |coarse| &coarse.sensors[sensor]);
        self.sensors[sensor].average_weight(sampled, readings, weighing, self.instructions)
    }

    /// The bins of a scan of each sensor in metres; empty for one that is missing.
    pub(super) fn binned(&self, scans_m: &[Option<&[f32]>]) -> Vec<BinnedScan> {
        let binned = |(sensor, ranges_m): (&ScanModel, &Option<&[f32]>)| {
            ranges_m.map_or(BinnedScan::new(), |ranges_m| sensor.likelihood.scan(ranges_m))
        };
        self.sensors.iter().zip(scans_m).map(binned).collect()
    }

    /// −ln of the likelihood of the scan of each sensor at a pose, tempered, less the least it can be anywhere; none where
    /// nobody can stand.
    pub(super) fn costs(&self, pose_in_map: Pose, scans_m: &[Option<&[f32]>]) -> Option<Vec<f64>> {
        let state = self.state_at(pose_in_map).filter(|state| self.is_admissible(state.column, state.row))?;
        let of_sensor = |(sensor, scan): (usize, BinnedScan)| {
            let tables = &self.sensors[sensor];
            let pairs = scan.into_iter().zip(self.expected_scan(sensor, state));
            let nats = pairs.filter_map(|(measured, expected)| Some(tables.likelihood.nats(measured?, expected)));
            tables.parameters.tempering * nats.sum::<f64>()
        };
        Some(self.binned(scans_m).into_iter().enumerate().map(of_sensor).collect())
    }

    /// How badly scans fit a pose; none where nobody can stand.
    pub(super) fn misfit<'s>(
        &self,
        pose_in_map: Pose,
        scans: impl IntoIterator<Item = &'s BinnedScan>,
    ) -> Option<Misfit> {
        let state = self.state_at(pose_in_map).filter(|state| self.is_admissible(state.column, state.row))?;
        let mut misfit = Misfit::default();
        for (sensor, scan) in scans.into_iter().enumerate() {
            let ScanModel { likelihood, parameters, .. } = &self.sensors[sensor];
            for (&measured, expected) in scan.iter().zip(self.expected_scan(sensor, state)) {
                let Some(measured) = measured else { continue };
                misfit.nats += parameters.tempering * likelihood.nats(measured, expected);
                misfit.mean_nats += parameters.tempering * likelihood.mean_nats(expected);
            }
        }
        Some(misfit)
    }

    /// Share of the readings of some scans that tell anything of a pose: an echo was heard, or is expected. All do where
    /// nobody can stand.
    pub(super) fn told(&self, pose_in_map: Pose, scans: &[BinnedScan]) -> f64 {
        let state = self.state_at(pose_in_map).filter(|state| self.is_admissible(state.column, state.row));
        let Some(state) = state else { return 1.0 };
        let (mut told, mut read) = (0, 0);
        for (sensor, scan) in scans.iter().enumerate() {
            for (measured, expected) in scan.iter().zip(self.expected_scan(sensor, state)) {
                let Some(measured) = *measured else { continue };
                read += 1;
                told += usize::from(measured != NO_ECHO || expected != NO_ECHO);
            }
        }
        told as f64 / read.max(1) as f64
    }

    /// The state around a pose, if it is on the grid.
    pub fn state_at(&self, pose_in_map: Pose) -> Option<State> {
        let (column, row) = self.grid.cell_at(pose_in_map.point())?;
        Some(State { heading: self.grid.heading_at(pose_in_map.heading_rad), row, column })
    }
}

fn check_beams(beams_deg: &[i32]) -> Result<(), ModelError> {
    match beams_deg.len() {
        1..=MAX_BEAMS => Ok(()),
        beams => Err(ModelError::Beams(beams)),
    }
}

/// The four directions in which a point may lie on the edge of a map cell.
const BESIDE_M: [Vector; 4] =
    [Vector::new(-1e-6, -1e-6), Vector::new(1e-6, -1e-6), Vector::new(-1e-6, 1e-6), Vector::new(1e-6, 1e-6)];

/// Whether the robot can stand at a point; one that lies between map cells counts as in each of them.
fn fits(map: &OccupancyGrid, field: &DistanceField, point: Point, clearance_m: f64) -> bool {
    let fits_at = |point: Point| map.at(point) == Cell::Free && field.clearance_m(point) >= clearance_m;
    BESIDE_M.iter().all(|beside| fits_at(point + beside))
}
