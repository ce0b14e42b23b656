//! What one sensor is expected to measure: its table of distances, and the average weight of a scan.

use super::expected::{Cones, ExpectedBins, bin_at};
use super::grid::{Bearings, BeliefGrid, Place, TILE};
use super::ground::Ground;
use super::kernel::{Beam, LIFT, TilePart};
use super::scan_parameters::ScanParameters;
use super::sensor::{BINS, SensorModel, components};
use super::simd::Instructions;
use crate::occupancy::{DistanceField, OccupancyGrid, SweepMap};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::{Arc, OnceLock};

/// States the average of a scan is taken over, a whole number of tiles.
const SAMPLES: usize = TILE;

/// What a sensor sees of the map, as tables and fixes need it.
#[derive(Clone, Debug)]
pub(super) struct SeenMap {
    pub distances: Arc<DistanceField>,
    pub sweeps: Arc<SweepMap>,
}

impl SeenMap {
    pub(super) fn new(map: &OccupancyGrid) -> Self {
        Self { distances: Arc::new(DistanceField::new(map)), sweeps: Arc::new(SweepMap::new(map)) }
    }
}

/// How a scan is weighed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Weighing {
    /// Exponent of its likelihood, beyond its tempering.
    pub power: f64,
    /// Whether people stand around.
    pub is_crowd: bool,
}

impl Weighing {
    /// As the parameters of the sensor say.
    pub(super) const USUAL: Self = Self { power: 1.0, is_crowd: false };
}

/// One range sensor over the cells of a belief.
#[derive(Debug)]
pub struct ScanModel {
    /// What was set.
    pub parameters: ScanParameters,
    /// P(s | o) of one beam.
    pub likelihood: SensorModel,
    /// The same where people stand around, if the parameters tell it apart; made when first asked for.
    crowd_likelihood: OnceLock<Option<SensorModel>>,
    /// Where its beams look.
    pub bearings: Bearings,
    /// Distances to what it sees.
    pub(super) distances: Arc<DistanceField>,
    expected: ExpectedBins,
    /// `[tile][beam]` expected scans of states spread evenly over all admissible ones; made when first asked for.
    samples: OnceLock<Vec<[u8; TILE]>>,
    /// `[expected][measured]` what the Gaussian has beyond a bin; made when first asked for.
    beyond: OnceLock<Vec<[f64; BINS]>>,
}

impl ScanModel {
    /// A sensor over the cells that can be stood in, by the map of what it sees.
    pub(super) fn new(parameters: ScanParameters, seen: &SeenMap, grid: &BeliefGrid, ground: &Arc<Ground>) -> Self {
        let bearings = Bearings::new(grid.headings, &parameters.beams_deg);
        Self {
            expected: ExpectedBins::new(seen.sweeps.clone(), grid, bearings.directions, ground, &parameters.beam),
            likelihood: SensorModel::new(&parameters.beam, parameters.tempering),
            crowd_likelihood: OnceLock::new(),
            samples: OnceLock::new(),
            beyond: OnceLock::new(),
            distances: seen.distances.clone(),
            parameters,
            bearings,
        }
    }

    /// P(s | o) of one beam, by how a scan is weighed.
    pub(super) fn likelihood_of(&self, weighing: Weighing) -> &SensorModel {
        if !weighing.is_crowd {
            return &self.likelihood;
        }
        let made = || self.parameters.crowd_beam().map(|beam| SensorModel::new(&beam, self.parameters.tempering));
        self.crowd_likelihood.get_or_init(made).as_ref().unwrap_or(&self.likelihood)
    }

    /// Expected bins by tile and direction.
    pub(super) fn expected(&self) -> &ExpectedBins {
        &self.expected
    }

    /// Where to look for what a beam is expected to measure at a heading.
    pub(super) fn cones(&self, heading: usize, beam: usize) -> Cones {
        self.expected.cones(self.bearings.direction(heading, beam))
    }

    /// What a beam is expected to measure at a heading in a cell.
    pub(super) fn expected_bin(&self, heading: usize, Place { tile, cell }: Place, beam: usize) -> u8 {
        bin_at(self.expected.tile(tile as u32), self.cones(heading, beam), cell)
    }

    /// The noise-free scan at a heading in a cell.
    pub(super) fn expected_scan(&self, heading: usize, place: Place) -> Vec<u8> {
        (0..self.bearings.beams()).map(|beam| self.expected_bin(heading, place, beam)).collect()
    }

    /// The probability that a reading of what is expected is longer than this one.
    pub(super) fn beyond(&self, expected: u8, measured: u8) -> f64 {
        let beyond = self.beyond.get_or_init(|| {
            let of = |expected: usize| {
                let [hit, ..] = components(&self.parameters.beam, expected);
                let mut left = 1.0;
                std::array::from_fn(|measured| {
                    left -= hit[measured];
                    f64::max(left, 0.0)
                })
            };
            (0..BINS).map(of).collect()
        });
        beyond[usize::from(expected)][usize::from(measured)]
    }

    /// Expected scans of states spread evenly over cells and headings: their rays are cast, so that no table of a place is
    /// computed where the belief does not look.
    fn samples(&self) -> &[[u8; TILE]] {
        if let Some(samples) = self.samples.get() {
            return samples;
        }
        let (beams, headings) = (self.bearings.beams(), self.bearings.headings());
        let cells = self.expected.spread_cells(SAMPLES);
        let scan = |(sample, &cell): (usize, &Place)| -> Vec<u8> {
            // The golden section spreads consecutive samples over the circle.
            let heading = (sample as f64 * 0.618_033_988_749_895 % 1.0 * headings as f64) as usize;
            let directions = (0..beams).map(|beam| self.bearings.direction(heading, beam));
            directions.map(|direction| self.expected.cast(&self.distances, cell, direction)).collect()
        };
        // Before the lock is taken: who holds it must not wait for work of other threads, which may ask for it as well.
        let scans: Vec<Vec<u8>> = cells.par_iter().enumerate().map(scan).collect();
        self.samples.get_or_init(|| {
            let mut samples = vec![[0; TILE]; SAMPLES / TILE * beams];
            for (sample, scan) in scans.iter().enumerate() {
                let tile = &mut samples[sample / TILE * beams..][..beams];
                tile.iter_mut().zip(scan).for_each(|(of_beam, &bin)| of_beam[sample % TILE] = bin);
            }
            samples
        })
    }

    /// P̃(s): the average weight of a scan over all states, to a few percent; `sampled` is this sensor or the same
    /// one over coarser cells, whose expected scans are sampled.
    ///
    /// # Deviation
    /// Beetz et al. leave open how this average is found. The product of the average likelihoods of
    /// the single readings is far too low, because neighbouring beams see the same wall; a lost
    /// robot would still look likelier than that. Here it is the average over a sample of states.
    pub(super) fn average_weight(
        &self,
        sampled: &Self,
        readings: &[(usize, u8)],
        weighing: Weighing,
        instructions: Instructions,
    ) -> f64 {
        let ones = [1.0; TILE];
        let likelihood = self.likelihood_of(weighing);
        let masses = sampled.samples().chunks_exact(self.bearings.beams()).map(|expected| {
            let beam =
                |&(beam, bin): &(usize, u8)| Beam { expected: [&expected[beam]; 2], costs: likelihood.costs(bin) };
            let mut beams = Vec::new();
            Beam::put_together(readings.iter().map(beam), &mut beams);
            let part = TilePart {
                cells: &mut ones.clone(),
                admissible: &ones,
                terms: [1.0, 0.0],
                beams: &beams,
                log2_per_cost: likelihood.log2_per_cost(weighing.power),
                average: 1.0,
                threshold: 0.0,
                next: None,
            };
            instructions.weigh(part).mass
        });
        masses.sum::<f64>() / f64::from(LIFT) / SAMPLES as f64
    }
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
