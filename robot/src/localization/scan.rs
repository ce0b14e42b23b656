//! What one sensor is expected to measure: its table of distances, and the average weight of a scan.

use super::grid::{Bearings, BeliefGrid};
use super::kernel::TILE;
use super::scan_parameters::{BeamParameters, ScanParameters};
use super::sensor::{self, BINS, SensorModel};
use crate::geometry::Point;
use crate::occupancy::DistanceField;
use rayon::prelude::*;
use std::sync::Arc;

/// States the average of a scan is taken over.
const SAMPLES: usize = 2048;

/// One range sensor over the cells of a belief.
#[derive(Debug)]
pub struct ScanModel {
    /// What was set.
    pub parameters: ScanParameters,
    /// P(s | o) of one beam.
    pub likelihood: SensorModel,
    /// Where its beams look.
    pub bearings: Bearings,
    /// Distances to what it sees.
    pub(super) distances: Arc<DistanceField>,
    /// `[tile][direction]` bins of the cells of a tile: what is read together lies together.
    expected: Vec<[u8; TILE]>,
    /// Expected scans of states spread evenly over all admissible ones.
    samples: Vec<Vec<u8>>,
}

impl ScanModel {
    /// The tables of a sensor over the cells that can be stood in, by the distances to what it sees.
    pub(super) fn new(
        parameters: ScanParameters,
        distances: Arc<DistanceField>,
        grid: &BeliefGrid,
        admissible: &[f32],
    ) -> Self {
        let bearings = Bearings::new(grid.headings, &parameters.beams_deg);
        let mut model = Self {
            expected: expected_bins(&distances, grid, bearings.directions, admissible, &parameters.beam),
            likelihood: SensorModel::new(&parameters.beam, parameters.tempering),
            samples: Vec::new(),
            parameters,
            bearings,
            distances,
        };
        model.samples = model.draw_samples(grid, admissible);
        model
    }

    /// Expected bins of one tile, by direction.
    pub(super) fn expected_tile(&self, tile: usize) -> &[[u8; TILE]] {
        &self.expected[tile * self.bearings.directions..][..self.bearings.directions]
    }

    /// What a beam is expected to measure at a heading in a cell.
    pub(super) fn expected_bin(&self, heading: usize, cell: usize, beam: usize) -> u8 {
        self.expected_tile(cell / TILE)[self.bearings.direction(heading, beam)][cell % TILE]
    }

    /// The noise-free scan at a heading in a cell.
    pub(super) fn expected_scan(&self, heading: usize, cell: usize) -> Vec<u8> {
        (0..self.bearings.beams()).map(|beam| self.expected_bin(heading, cell, beam)).collect()
    }

    /// Expected scans of states spread evenly over cells and headings.
    fn draw_samples(&self, grid: &BeliefGrid, admissible: &[f32]) -> Vec<Vec<u8>> {
        let cells: Vec<usize> = (0..grid.cells()).filter(|&cell| admissible[cell] > 0.0).collect();
        let headings = grid.headings;
        let stride = (cells.len() * headings / SAMPLES).max(1);
        let states = (0..cells.len() * headings).step_by(stride).enumerate();
        states
            .map(|(turn, index)| {
                let cell = cells[index / headings];
                // The golden section spreads consecutive samples over the circle.
                let heading = (turn as f64 * 0.618_033_988_749_895 % 1.0 * headings as f64) as usize;
                self.expected_scan(heading, cell)
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
            readings.iter().map(|&(beam, bin)| (beam, self.likelihood.costs(bin))).collect();
        let sum = |sample: &[u8]| -> usize {
            costs.iter().map(|&(beam, costs)| usize::from(costs[usize::from(sample[beam])])).sum()
        };
        let total: f64 = self.samples.iter().map(|sample| self.likelihood.weight(sum(sample))).sum();
        total / self.samples.len() as f64
    }
}

/// Expected bins `[tile][direction]`: the nearest surface in the cone around the direction.
fn expected_bins(
    field: &DistanceField,
    grid: &BeliefGrid,
    directions: usize,
    admissible: &[f32],
    beam: &BeamParameters,
) -> Vec<[u8; TILE]> {
    let rays: Vec<(f64, f64)> = (0..directions)
        .map(|direction| {
            let (sin, cos) = libm::sincos(direction as f64 * std::f64::consts::TAU / directions as f64);
            (cos, sin)
        })
        .collect();
    let half_cone = directions * beam.cone_deg as usize / 720;
    // A cone of many rays loses nothing if every other one is left out.
    let stride = if half_cone >= 4 && directions.is_multiple_of(2) { 2 } else { 1 };
    let rows: Vec<Vec<u8>> = (0..grid.rows)
        .into_par_iter()
        .map(|row| {
            let free = &admissible[row * grid.columns..][..grid.columns];
            let centres: Vec<Option<Point>> =
                free.iter().enumerate().map(|(column, &cell)| (cell > 0.0).then(|| grid.centre(column, row))).collect();
            widen_to_cones(&cast_row(field, &centres, &rays, stride, beam), grid.columns, half_cone)
        })
        .collect();
    let tiles = grid.plane_len().div_ceil(TILE);
    let mut expected = vec![[0; TILE]; tiles * directions];
    let mut plane = vec![0; tiles * TILE];
    for direction in 0..directions {
        for (row, bins) in rows.iter().enumerate() {
            plane[row * grid.columns..][..grid.columns]
                .copy_from_slice(&bins[direction * grid.columns..][..grid.columns]);
        }
        for (tile, bins) in plane.as_chunks::<TILE>().0.iter().enumerate() {
            expected[tile * directions + direction] = *bins;
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
    beam: &BeamParameters,
) -> Vec<u8> {
    let (max_m, mount_m) = (beam.max_range_m, beam.mount_radius_m);
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

#[cfg(test)]
mod tests {
    use crate::geometry::{Point, Pose};
    use crate::localization::{Belief, LocalizationModel, LocalizationParameters, ScanParameters};
    use crate::occupancy::{Cell, OccupancyGrid};
    use crate::sensors::LaserScanner;

    #[test]
    fn scans_of_two_sensors_weigh_each_state_by_both() {
        let scanner = LaserScanner { readings: 13, resolution_deg: 15.0, range_m: 8.0 };
        let laser = ScanParameters::laser(&scanner);
        let mut map = OccupancyGrid::filled(Point::origin(), 0.1, 60, 40, Cell::Free);
        (0..40).for_each(|row| map.set(59, row, Cell::Occupied));
        (10..30).for_each(|column| map.set(column, 0, Cell::Occupied));
        let parameters = LocalizationParameters {
            cell_m: 0.3,
            angle_step_deg: 15,
            sensors: vec![ScanParameters::default(), laser],
            mixing: 0.0,
            activity_threshold: 0.0,
            ..LocalizationParameters::default()
        };
        let model = LocalizationModel::new(&map, parameters).expect("it is a map");
        let truth = model.state_at(Pose::new(2.4, 2.1, 0.8)).expect("a pose on the map");
        let scans_m: Vec<Vec<f32>> = (model.sensors.iter().enumerate())
            .map(|(sensor, tables)| {
                let expected = model.expected_scan(sensor, truth).into_iter();
                expected.map(|bin| tables.likelihood.range_m(bin) as f32).collect()
            })
            .collect();
        let [sonar_m, laser_m] = [&scans_m[0], &scans_m[1]].map(|scan_m| Some(scan_m.as_slice()));
        let after = |heard: &[[Option<&[f32]>; 2]]| -> Vec<f64> {
            let mut belief = Belief::uniform(&model);
            heard.iter().for_each(|scans_m| belief.sense_ranges(&model, scans_m));
            belief.all_states(&model).into_iter().map(|at| at.share).collect()
        };
        let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>() / 2.0;
        let both = after(&[[sonar_m, laser_m]]);
        assert!(apart(&both, &after(&[[sonar_m, None], [None, laser_m]])) < 1e-5);
        for one in [after(&[[sonar_m, None]]), after(&[[None, laser_m]])] {
            assert!(apart(&both, &one) > 0.05);
        }
        assert!(apart(&after(&[[None, None]]), &after(&[])) < 1e-5);
    }
}
