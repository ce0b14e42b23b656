//! Single readings: a belief read one beam of one sensor at a time.

use super::belief::Belief;
use super::grid::{Place, State};
use super::model::LocalizationModel;
use super::scan::ScanModel;
use super::scan_parameters::BeamParameters;
use super::sensor::{BINS, BinnedScan, mixture};
use crate::geometry::{Point, Pose};
use rayon::prelude::*;

/// A state, and the share of the belief it stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateShare {
    /// The state.
    pub state: State,
    /// Its share; those of a summary sum to 1.
    pub share: f64,
}

/// How much of a belief lies where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offness {
    /// The distance |Δx| + |Δy| to a point, weighted by the belief.
    pub l1_m: f64,
    /// Probability nearer to it than a radius.
    pub near: f64,
}

/// P(s | o) of one reading: the distributions that the bytes of the filter stand for.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadingModel {
    /// `[expected][measured]`.
    likelihood: Vec<[f64; BINS]>,
    /// Entropy of each row, in nats.
    entropy: Vec<f64>,
}

impl ReadingModel {
    /// Of a beam of a sensor.
    pub fn new(beam: &BeamParameters) -> Self {
        let row = |expected| {
            let density = mixture(beam, expected);
            std::array::from_fn(|measured| density[measured])
        };
        let likelihood: Vec<[f64; BINS]> = (0..BINS).map(row).collect();
        let entropy = likelihood.iter().map(|row| entropy(row)).collect();
        Self { likelihood, entropy }
    }

    /// P(s | o) over the measured bins.
    pub fn likelihood(&self, expected: u8) -> &[f64; BINS] {
        &self.likelihood[usize::from(expected)]
    }

    /// What a reading tells on average, in nats, where each bin is expected with the share given:
    /// H(s) − Σ_o share(o) H(s | o).
    pub fn information(&self, shares: &[f64; BINS]) -> f64 {
        let mut sensed = [0.0; BINS];
        let mut known = 0.0;
        for (expected, &share) in shares.iter().enumerate().filter(|(_, share)| **share > 0.0) {
            for (sum, likelihood) in sensed.iter_mut().zip(&self.likelihood[expected]) {
                *sum += share * likelihood;
            }
            known += share * self.entropy[expected];
        }
        (entropy(&sensed) - known).max(0.0)
    }
}

/// −Σ p ln p, in nats.
fn entropy(density: &[f64]) -> f64 {
    density.iter().filter(|&&p| p > 0.0).map(|&p| -p * libm::log(p)).sum()
}

impl LocalizationModel {
    /// Shares of the bins that a beam of a sensor is expected to measure.
    pub fn expected_shares(&self, sensor: usize, beam: usize, states: &[StateShare]) -> [f64; BINS] {
        let mut shares = [0.0; BINS];
        for StateShare { state, share } in states {
            let bin = self.sensors[sensor].expected_bin(state.heading, self.grid.place(state.column, state.row), beam);
            shares[usize::from(bin)] += share;
        }
        shares
    }
}

impl Belief {
    /// Eq. (1) for a motion measured in the frame of the robot before it, normalized: what it carried
    /// into walls is gone.
    pub fn moved(&mut self, model: &LocalizationModel, motion: Pose) {
        self.advance(model, motion, &model.parameters.odometry);
        self.sense(model, &[]);
    }

    /// Eq. (2) for one reading of one beam of a sensor.
    pub fn sense_reading(&mut self, model: &LocalizationModel, sensor: usize, beam: usize, range_m: f64) {
        let mut scans = vec![BinnedScan::new(); model.sensors.len()];
        let ScanModel { likelihood, bearings, .. } = &model.sensors[sensor];
        scans[sensor] = vec![None; bearings.beams()];
        scans[sensor][beam] = range_m.is_finite().then(|| likelihood.bin(range_m));
        self.sense(model, &scans);
    }

    /// At most `count` states, drawn evenly: along the cells of the belief, plane by plane and tile by
    /// tile, one wherever another `1 / count` of it has been passed. A state with more than that stands
    /// for all it has, to `1 / count`. O(tiles, and cells of those that hold any).
    pub fn drawn_states(&self, model: &LocalizationModel, count: usize) -> Vec<StateShare> {
        let spacing = self.mass(model) / count as f64;
        let mut states: Vec<StateShare> = Vec::new();
        let (mut before, mut due) = (0.0, spacing / 2.0);
        for (heading, plane) in self.planes().iter().enumerate() {
            for (number, ground) in model.ground.tiles() {
                let mut passed = before;
                before +=
                    plane.tile(number).map_or(self.asleep * ground.cells as f64, |tile| self.mass_of(model, tile));
                if due >= before {
                    continue;
                }
                let values = self.values(heading, number, ground);
                for cell in ground.free() {
                    passed += f64::from(values[cell]);
                    if passed <= due {
                        continue;
                    }
                    let times = libm::ceil((passed - due) / spacing);
                    due += times * spacing;
                    states.push(StateShare { state: model.grid.state(heading, number, cell), share: times });
                }
            }
        }
        let total: f64 = states.iter().map(|state| state.share).sum();
        states.iter_mut().for_each(|state| state.share /= total);
        states
    }

    /// Every state the robot can be in, with its probability. O(states).
    pub fn all_states(&self, model: &LocalizationModel) -> Vec<StateShare> {
        let mut states = Vec::new();
        for heading in 0..self.planes().len() {
            for (number, ground) in model.ground.tiles() {
                let values = self.values(heading, number, ground);
                let state = |cell| StateShare {
                    state: model.grid.state(heading, number, cell),
                    share: f64::from(values[cell]),
                };
                states.extend(ground.free().map(state));
            }
        }
        states
    }

    /// How far the belief is from a point, and how much of it is near. O(states).
    pub fn off_from(&self, model: &LocalizationModel, point_in_map: Point, radius_m: f64) -> Offness {
        let off = |heading| self.plane_off_from(model, heading, point_in_map, radius_m);
        let parts: Vec<Offness> = (0..self.planes().len()).into_par_iter().map(off).collect();
        let sum = |of: fn(&Offness) -> f64| parts.iter().map(of).sum();
        Offness { l1_m: sum(|off| off.l1_m), near: sum(|off| off.near) }
    }

    fn plane_off_from(&self, model: &LocalizationModel, heading: usize, point_in_map: Point, radius_m: f64) -> Offness {
        let grid = &model.grid;
        let (x, y) = grid.fractional(point_in_map);
        let mut off = Offness { l1_m: 0.0, near: 0.0 };
        for (number, ground) in model.ground.tiles() {
            let values = self.values(heading, number, ground);
            for cell in ground.free() {
                let place = Place { tile: number as usize, cell };
                let (column, row) = self.planes()[heading].position_cells(grid, place);
                let (dx_m, dy_m) = ((column - x) * grid.cell_m, (row - y) * grid.cell_m);
                let value = f64::from(values[cell]);
                off.l1_m += value * (libm::fabs(dx_m) + libm::fabs(dy_m));
                if dx_m * dx_m + dy_m * dy_m < radius_m * radius_m {
                    off.near += value;
                }
            }
        }
        off
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::localization::LocalizationParameters;
    use crate::occupancy::{Cell, OccupancyGrid};

    fn model() -> LocalizationModel {
        let mut map = OccupancyGrid::filled(Point::origin(), 0.1, 50, 30, Cell::Free);
        (10..20).for_each(|column| map.set(column, 29, Cell::Occupied));
        let parameters = LocalizationParameters {
            cell_m: 0.5,
            angle_step_deg: 45,
            activity_threshold: 0.0,
            ..LocalizationParameters::default().literal()
        };
        LocalizationModel::new(&map, parameters).expect("it is a map")
    }

    #[test]
    fn a_reading_weighs_each_state_by_its_likelihood() {
        let model = model();
        let readings = ReadingModel::new(&model.parameters.sensors[0].beam);
        let mut belief = Belief::uniform(&model);
        belief.sense_reading(&model, 0, 5, 1.3);
        let likelihood = |state: &StateShare| {
            let expected = model.expected_scan(0, state.state)[5];
            readings.likelihood(expected)[usize::from(model.sensors[0].likelihood.bin(1.3))]
        };
        let states = belief.all_states(&model);
        let total: f64 = states.iter().map(likelihood).sum();
        for state in &states {
            // The filter's bytes round to 1/64 nat.
            assert!((state.share / (likelihood(state) / total) - 1.0).abs() < 0.04, "{state:?}");
        }
        let before = belief.clone();
        belief.sense_reading(&model, 0, 5, f64::NAN);
        assert!((belief.entropy(&model) - before.entropy(&model)).abs() < 1e-6);
    }

    #[test]
    fn distance_from_a_point_is_the_mean_over_all_states() {
        let model = model();
        let mut belief = Belief::uniform(&model);
        belief.sense_reading(&model, 0, 2, 1.3);
        belief.moved(&model, Pose::new(0.1, 0.0, 0.0));
        let point = Point::new(2.0, 1.0);
        let (mut l1_m, mut near) = (0.0, 0.0);
        for StateShare { state, share } in belief.all_states(&model) {
            let (sin, cos) = libm::sincos(model.grid.heading_rad(state.heading));
            let at = model.grid.centre(state.column, state.row);
            let (dx, dy) = (at.x + 0.1 * cos - point.x, at.y + 0.1 * sin - point.y);
            l1_m += share * (libm::fabs(dx) + libm::fabs(dy));
            near += if libm::hypot(dx, dy) < 0.7 { share } else { 0.0 };
        }
        let off = belief.off_from(&model, point, 0.7);
        assert!((off.l1_m - l1_m).abs() < 1e-6 && (off.near - near).abs() < 1e-6, "{off:?} {l1_m} {near}");
    }
}
