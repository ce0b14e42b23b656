//! Everything about localization that never changes during a mission.

use super::error::ModelError;
use super::grid::{BeliefGrid, State};
use super::kernel::{MAX_BEAMS, TILE};
use super::parameters::{LocalizationParameters, SensorParameters};
use super::sensor::{self, BINS, SensorModel};
use super::simd::Instructions;
use crate::geometry::{Point, Pose, Vector};
use crate::occupancy::{Cell, DistanceField, OccupancyGrid};
use rayon::prelude::*;
use std::sync::Arc;

/// States the average of a scan is taken over.
const SAMPLES: usize = 2048;

/// The map as localization needs it: cells that can be stood in, expected distances, and the
/// sensor model. Shared by `Arc`; never part of a saved state.
#[derive(Debug)]
pub struct LocalizationModel {
    /// What was set.
    pub parameters: LocalizationParameters,
    /// Where the cells lie.
    pub grid: BeliefGrid,
    /// The sensor model.
    pub sensor: SensorModel,
    /// Distances in the map.
    pub distances: DistanceField,
    /// 1 for cells of a plane that can be stood in, else 0; padded to whole blocks.
    pub(super) admissible: Arc<Vec<f32>>,
    /// How many of them there are in one plane.
    pub(super) admissible_cells: usize,
    /// `[tile][direction]` bins of the cells of a tile: what is read together lies together.
    expected: Vec<[u8; TILE]>,
    /// What the loops over cells are run with.
    pub(super) instructions: Instructions,
    /// Expected scans of states spread evenly over all admissible ones.
    samples: Vec<Vec<u8>>,
    /// The model of the coarse belief that watches, if there is one.
    pub(super) watch: Option<Box<LocalizationModel>>,
}

impl LocalizationModel {
    /// Builds the tables; about 0.3 s for 540 m² at 15 cm and 2° on two cores.
    ///
    /// # Errors
    /// When the parameters do not describe a grid, or the robot fits nowhere in the map.
    pub fn new(map: &OccupancyGrid, parameters: LocalizationParameters) -> Result<Self, ModelError> {
        parameters.check()?;
        let step_deg = parameters.angle_step_deg;
        if step_deg == 0 || !360u32.is_multiple_of(step_deg) {
            return Err(ModelError::AngleStep(step_deg));
        }
        if !(parameters.cell_m.is_finite() && parameters.cell_m >= map.resolution_m - 1e-9) {
            return Err(ModelError::CellSize(map.resolution_m.to_string()));
        }
        check_beams(&parameters.beams_deg)?;
        let grid = BeliefGrid::over(map, parameters.cell_m, step_deg, parameters.centred, &parameters.beams_deg);
        let distances = DistanceField::new(map);
        let admissible = admissible_cells(map, &distances, &grid, parameters.clearance_m);
        if admissible.iter().all(|&cell| cell == 0.0) {
            return Err(ModelError::NoFreeCell);
        }
        let watch = match parameters.of_watch() {
            Some(coarse) => Some(Box::new(Self::new(map, coarse)?)),
            None => None,
        };
        let tables = Self::tables(parameters, grid, distances, Arc::new(admissible));
        Ok(Self { watch, ..tables })
    }

    /// The same cells read by another sensor: `seen` is the map of what it sees. A belief over one of
    /// the two models is one over the other.
    ///
    /// # Errors
    /// When a scan has no beams or too many.
    pub fn with_sensor(
        &self,
        seen: &OccupancyGrid,
        sensor: SensorParameters,
        beams_deg: Vec<i32>,
    ) -> Result<Self, ModelError> {
        check_beams(&beams_deg)?;
        let grid = self.grid.with_beams(&beams_deg);
        let parameters = LocalizationParameters { sensor, beams_deg, watch: None, ..self.parameters.clone() };
        Ok(Self::tables(parameters, grid, DistanceField::new(seen), self.admissible.clone()))
    }

    /// The tables of one sensor over cells that can be stood in.
    fn tables(
        parameters: LocalizationParameters,
        grid: BeliefGrid,
        distances: DistanceField,
        admissible: Arc<Vec<f32>>,
    ) -> Self {
        let mut model = Self {
            expected: expected_bins(&distances, &grid, &admissible, &parameters),
            sensor: SensorModel::new(&parameters.sensor, parameters.tempering),
            admissible_cells: admissible.iter().filter(|&&cell| cell > 0.0).count(),
            parameters,
            grid,
            distances,
            admissible,
            instructions: Instructions::fastest(),
            samples: Vec::new(),
            watch: None,
        };
        model.samples = model.draw_samples();
        model
    }

    /// Memory that the tables and a belief over a map of this size will take, without building them:
    /// two copies of the belief, because noise is spread from one into the other.
    pub fn needed_bytes(size_m: Vector, parameters: &LocalizationParameters) -> u64 {
        let along = |length_m: f64| libm::ceil(length_m / parameters.cell_m).max(1.0);
        let cells = along(size_m.x) * along(size_m.y);
        let headings = 360.0 / f64::from(parameters.angle_step_deg.max(1));
        // Whole degrees are the finest table of directions.
        let own = (cells * (headings * 2.0 * size_of::<f32>() as f64 + 360.0)) as u64;
        let watch = parameters.of_watch().map_or(0, |coarse| Self::needed_bytes(size_m, &coarse));
        own.saturating_add(watch)
    }

    /// Cells of (x, y) the robot can stand in.
    pub fn admissible_cells(&self) -> usize {
        self.admissible_cells
    }

    /// Whether the robot can stand in this cell.
    pub fn is_admissible(&self, column: usize, row: usize) -> bool {
        self.admissible[row * self.grid.columns + column] > 0.0
    }

    /// Probability of one state when nothing is known.
    pub fn prior(&self) -> f64 {
        1.0 / (self.admissible_cells as f64 * self.grid.headings as f64)
    }

    /// θ of Beetz et al. Eq. (3).
    pub(super) fn threshold(&self) -> f64 {
        self.parameters.activity_threshold * self.prior()
    }

    /// The same model with its loops run by these instructions: slower or faster, with the same bits.
    pub fn with_instructions(self, instructions: Instructions) -> Self {
        let watch = self.watch.map(|coarse| Box::new(coarse.with_instructions(instructions)));
        Self { instructions, watch, ..self }
    }

    /// Expected bins of one tile, by direction.
    pub(super) fn expected_tile(&self, tile: usize) -> &[[u8; TILE]] {
        &self.expected[tile * self.grid.directions..][..self.grid.directions]
    }

    pub(super) fn expected_bin(&self, direction: usize, cell: usize) -> u8 {
        self.expected_tile(cell / TILE)[direction][cell % TILE]
    }

    /// The noise-free scan at a state, in bins.
    pub fn expected_scan(&self, state: State) -> Vec<u8> {
        let cell = state.row * self.grid.columns + state.column;
        let beams = 0..self.grid.beams();
        beams.map(|beam| self.expected_bin(self.grid.direction(state.heading, beam), cell)).collect()
    }

    /// The state around a pose, if it is on the grid.
    pub fn state_at(&self, pose_in_map: Pose) -> Option<State> {
        let (column, row) = self.grid.cell_at(pose_in_map.point())?;
        Some(State { heading: self.grid.heading_at(pose_in_map.heading_rad), row, column })
    }

    /// Expected scans of states spread evenly over cells and headings.
    fn draw_samples(&self) -> Vec<Vec<u8>> {
        let cells: Vec<usize> = (0..self.grid.cells()).filter(|&cell| self.admissible[cell] > 0.0).collect();
        let headings = self.grid.headings;
        let stride = (cells.len() * headings / SAMPLES).max(1);
        let states = (0..cells.len() * headings).step_by(stride).enumerate();
        states
            .map(|(turn, index)| {
                let cell = cells[index / headings];
                // The golden section spreads consecutive samples over the circle.
                let heading = (turn as f64 * 0.618_033_988_749_895 % 1.0 * headings as f64) as usize;
                self.expected_scan(State { heading, row: cell / self.grid.columns, column: cell % self.grid.columns })
            })
            .collect()
    }

    /// P̃(s): the average weight of a scan over all states, to a few percent.
    ///
    /// # Deviation
    /// Beetz et al. leave open how this average is found. The product of the average likelihoods of
    /// the single readings is far too low, because neighbouring beams see the same wall; a lost
    /// robot would still look likelier than that. Here it is the average over a sample of states.
    pub(super) fn average_weight(&self, readings: &[(usize, u8)]) -> f64 {
        let costs: Vec<(usize, &[u8; BINS])> =
            readings.iter().map(|&(beam, bin)| (beam, self.sensor.costs(bin))).collect();
        let sum = |sample: &[u8]| -> usize {
            costs.iter().map(|&(beam, costs)| usize::from(costs[usize::from(sample[beam])])).sum()
        };
        let total: f64 = self.samples.iter().map(|sample| self.sensor.weight(sum(sample))).sum();
        total / self.samples.len() as f64
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

fn admissible_cells(map: &OccupancyGrid, field: &DistanceField, grid: &BeliefGrid, clearance_m: f64) -> Vec<f32> {
    let mut cells = vec![0.0; grid.plane_len()];
    for row in 0..grid.rows {
        for column in 0..grid.columns {
            // A middle that lies between map cells counts as in each of them.
            let fits = BESIDE_M.iter().all(|beside| {
                let point = grid.centre(column, row) + beside;
                map.at(point) == Cell::Free && field.clearance_m(point) >= clearance_m
            });
            if fits {
                cells[row * grid.columns + column] = 1.0;
            }
        }
    }
    cells
}

/// Expected bins `[tile][direction]`: the nearest surface in the cone around the direction.
fn expected_bins(
    field: &DistanceField,
    grid: &BeliefGrid,
    admissible: &[f32],
    parameters: &LocalizationParameters,
) -> Vec<[u8; TILE]> {
    let rays: Vec<(f64, f64)> = (0..grid.directions)
        .map(|direction| {
            let (sin, cos) = libm::sincos(direction as f64 * std::f64::consts::TAU / grid.directions as f64);
            (cos, sin)
        })
        .collect();
    let half_cone = grid.directions * parameters.sensor.cone_deg as usize / 720;
    // A cone of many rays loses nothing if every other one is left out.
    let stride = if half_cone >= 4 && grid.directions.is_multiple_of(2) { 2 } else { 1 };
    let rows: Vec<Vec<u8>> = (0..grid.rows)
        .into_par_iter()
        .map(|row| {
            let free = &admissible[row * grid.columns..][..grid.columns];
            let centres: Vec<Option<Point>> =
                free.iter().enumerate().map(|(column, &cell)| (cell > 0.0).then(|| grid.centre(column, row))).collect();
            widen_to_cones(&cast_row(field, &centres, &rays, stride, parameters), grid.columns, half_cone)
        })
        .collect();
    let tiles = grid.plane_len().div_ceil(TILE);
    let mut expected = vec![[0; TILE]; tiles * grid.directions];
    let mut plane = vec![0; tiles * TILE];
    for direction in 0..grid.directions {
        for (row, bins) in rows.iter().enumerate() {
            plane[row * grid.columns..][..grid.columns]
                .copy_from_slice(&bins[direction * grid.columns..][..grid.columns]);
        }
        for (tile, bins) in plane.as_chunks::<TILE>().0.iter().enumerate() {
            expected[tile * grid.directions + direction] = *bins;
        }
    }
    expected
}

/// Bins `[direction][column]` of every `stride`-th ray; the others find nothing.
fn cast_row(
    field: &DistanceField,
    centres: &[Option<Point>],
    rays: &[(f64, f64)],
    stride: usize,
    parameters: &LocalizationParameters,
) -> Vec<u8> {
    let (max_m, mount_m) = (parameters.sensor.max_range_m, parameters.sensor.mount_radius_m);
    let mut bins = vec![sensor::NO_ECHO; centres.len() * rays.len()];
    for (column, centre) in centres.iter().enumerate() {
        let Some(centre) = centre else { continue };
        let from_here = rays.iter().step_by(stride).map(|&ray| (*centre, ray));
        field.cast_all(from_here, max_m + mount_m, |number, range_m| {
            bins[number * stride * centres.len() + column] = sensor::bin(range_m - mount_m, max_m);
        });
    }
    bins
}

/// The smallest bin within `half_cone` directions on either side.
fn widen_to_cones(rays: &[u8], columns: usize, half_cone: usize) -> Vec<u8> {
    let directions = rays.len() / columns;
    let mut cones = rays.to_vec();
    for (direction, cone) in cones.chunks_exact_mut(columns).enumerate() {
        for step in directions - half_cone..=directions + half_cone {
            let ray = &rays[(direction + step) % directions * columns..][..columns];
            for (nearest, &bin) in cone.iter_mut().zip(ray) {
                *nearest = (*nearest).min(bin);
            }
        }
    }
    cones
}
