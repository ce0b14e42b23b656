//! The belief and its two updates.

use super::grid::State;
use super::kernel::{self, LIFT, Share};
use super::model::LocalizationModel;
use super::parameters::Spread;
use super::plane::{Activity, Plane};
use super::sensor::BinnedScan;
use super::weigh::{PLANES_FOR_THREADS, weigh_planes};
use crate::geometry::{Pose, wrap_angle_rad};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Noise of the heading is applied once it reaches this variance, in squared angle steps.
const HEADING_BLUR_AT: f64 = 0.1;

/// With less than this (of [`LIFT`]), motion has left nothing.
const LEAST_EVIDENCE: f64 = 1e-15;

/// Planes that are spread over their neighbours one after the other.
const SLICE: usize = 45;

/// P(l) over all states: one plane per heading. Its mass is 1 after every operation but
/// [`Belief::advance`], which a normalizing one must follow.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Belief {
    /// Plane `k` has heading `(k + heading_offset) · angle_step`.
    pub(super) planes: Vec<Plane>,
    /// Rotation that is not yet applied, in angle steps, at most one half.
    pub(super) heading_offset: f64,
    /// Variance of the rotation that is not yet applied, in squared angle steps.
    heading_variance: f64,
}

impl Belief {
    /// Every admissible state alike.
    pub fn uniform(model: &LocalizationModel) -> Self {
        let prior = model.prior() as f32;
        let plane = Plane::active(Arc::new(model.admissible.iter().map(|cell| cell * prior).collect()));
        Self { planes: vec![plane; model.grid.headings], heading_offset: 0.0, heading_variance: 0.0 }
    }

    /// A normal distribution around a pose; the uniform one if nothing around it is admissible.
    pub fn around(model: &LocalizationModel, pose_in_map: Pose, spread: Spread) -> Self {
        let grid = &model.grid;
        let (x, y) = grid.fractional(pose_in_map.point());
        // Cells are laid through the pose itself, so that a belief without spread is exact.
        let offset = [x - libm::round(x), y - libm::round(y)];
        let heading_steps = pose_in_map.heading_rad / grid.angle_step_rad();
        let heading_offset = heading_steps - libm::round(heading_steps);
        let sigma = (spread.position_m / grid.cell_m).max(1e-3);
        let heading_sigma = (spread.heading_rad / grid.angle_step_rad()).max(1e-3);
        let along = |count: usize, middle: f64| -> Vec<f64> {
            (0..count).map(|i| normal((i as f64 - middle) / sigma)).collect()
        };
        let (along_x, along_y) = (along(grid.columns, libm::round(x)), along(grid.rows, libm::round(y)));
        let nearest = grid.heading_at(pose_in_map.heading_rad) as i64;
        let mut belief = Self::uniform(model);
        for (heading, plane) in belief.planes.iter_mut().enumerate() {
            let half = grid.headings as i64 / 2;
            let away = (heading as i64 - nearest + half).rem_euclid(grid.headings as i64) - half;
            let share = normal(away as f64 / heading_sigma);
            let mut cells = vec![0f32; grid.plane_len()];
            for (cell, value) in cells.iter_mut().take(grid.cells()).enumerate() {
                *value = (share * along_x[cell % grid.columns] * along_y[cell / grid.columns]) as f32;
            }
            *plane = Plane { offset_cells: offset, ..Plane::active(Arc::new(cells)) };
        }
        belief.heading_offset = heading_offset;
        belief.sense(model, &[]);
        belief
    }

    /// Half of this belief and half of another one, cell by cell: places are exact to half a cell.
    pub fn merged(&self, model: &LocalizationModel, other: &Self) -> Self {
        let mut merged = Self::uniform(model);
        for (heading, plane) in merged.planes.iter_mut().enumerate() {
            let both = |cell: usize| 0.5 * (self.planes[heading].value(cell) + other.planes[heading].value(cell));
            let cells = (0..model.grid.plane_len()).map(|cell| (both(cell) * f64::from(model.admissible[cell])) as f32);
            *plane = Plane::active(Arc::new(cells.collect()));
        }
        merged.sense(model, &[]);
        merged
    }

    /// The belief of another grid over the same map: every state takes the density of the state of
    /// the other grid it lies in.
    pub(super) fn resampled(model: &LocalizationModel, other: &Self, other_model: &LocalizationModel) -> Self {
        let grid = &model.grid;
        let place = |column, row| other_model.grid.fractional(grid.centre(column, row));
        let columns: Vec<f64> = (0..grid.columns).map(|column| place(column, 0).0).collect();
        let rows: Vec<f64> = (0..grid.rows).map(|row| place(0, row).1).collect();
        let resampled = |plane: &Plane| -> Plane {
            let densities = plane.densities(other_model, &columns, &rows).into_iter().chain(std::iter::repeat(0.0));
            let cells = model.admissible.iter().zip(densities);
            let cells = cells.map(|(&admissible, density)| if admissible > 0.0 { density as f32 } else { 0.0 });
            Plane::active(Arc::new(cells.collect()))
        };
        // The other grid may have fewer headings: each of its planes is resampled once.
        let sources: Vec<Plane> = other.planes.par_iter().map(resampled).collect();
        let mut belief = Self::uniform(model);
        update_planes(&mut belief.planes, |heading, plane| {
            let source = &sources[other.plane_at(other_model, grid.angle_step_rad() * heading as f64)];
            // Not shared, because they are weighed next.
            *plane = Plane { cells: Arc::new(source.cells.to_vec()), ..source.clone() };
        });
        belief.sense(model, &[]);
        belief
    }

    /// The plane whose heading is nearest.
    fn plane_at(&self, model: &LocalizationModel, heading_rad: f64) -> usize {
        let steps = libm::round(heading_rad / model.grid.angle_step_rad() - self.heading_offset) as i64;
        steps.rem_euclid(model.grid.headings as i64) as usize
    }

    /// The planes, by heading.
    pub fn planes(&self) -> &[Plane] {
        &self.planes
    }

    /// Bytes of planes that an earlier belief does not share.
    pub(super) fn bytes_apart(&self, earlier: &Self) -> usize {
        let pairs = self.planes.iter().zip(&earlier.planes);
        let apart = pairs.filter(|(plane, earlier)| !Arc::ptr_eq(&plane.cells, &earlier.cells));
        apart.map(|(plane, _)| size_of_val(plane.cells.as_slice())).sum()
    }

    /// Planes that take part in updates.
    pub fn active_planes(&self) -> usize {
        self.planes.iter().filter(|plane| plane.is_active()).count()
    }

    /// The sum of the belief, 1 but for rounding. Reads what the last update summed.
    pub fn mass(&self, model: &LocalizationModel) -> f64 {
        self.planes.iter().map(|plane| plane.mass(model)).sum()
    }

    /// Heading of a plane, with the rotation not yet applied.
    pub fn heading_rad(&self, model: &LocalizationModel, heading: usize) -> f64 {
        wrap_angle_rad((heading as f64 + self.heading_offset) * model.grid.angle_step_rad())
    }

    /// Probability of one state; 0 where the robot cannot stand.
    pub fn probability(&self, model: &LocalizationModel, state: State) -> f64 {
        let cell = state.row * model.grid.columns + state.column;
        if model.admissible[cell] == 0.0 { 0.0 } else { self.planes[state.heading].value(cell) }
    }

    /// Eq. (1) for a motion measured in the frame of the robot before it.
    ///
    /// # Deviation
    /// A motion moves planes by whole cells and headings by whole steps; the rest is kept beside
    /// each plane as the true place of its cells, and noise is kept until it amounts to something.
    /// Interpolating at each step instead would blur by up to a quarter of a squared cell, far
    /// more than odometry errs. What moves into walls is lost until the next normalization. What
    /// mixing has added, the same everywhere, stays.
    pub fn advance(&mut self, model: &LocalizationModel, motion: Pose) {
        let (grid, error) = (&model.grid, &model.parameters.odometry);
        let distance_m = libm::hypot(motion.x_m, motion.y_m);
        let forward = error.forward_m * error.forward_m * distance_m / (grid.cell_m * grid.cell_m);
        let sideward = error.sideward_m * error.sideward_m * distance_m / (grid.cell_m * grid.cell_m);
        let headings: Vec<f64> = (0..grid.headings).map(|heading| self.heading_rad(model, heading)).collect();
        update_planes(&mut self.planes, |heading, plane| {
            let (sin, cos) = libm::sincos(headings[heading]);
            plane.offset_cells[0] += (cos * motion.x_m - sin * motion.y_m) / grid.cell_m;
            plane.offset_cells[1] += (sin * motion.x_m + cos * motion.y_m) / grid.cell_m;
            plane.variance_cells[0] += cos * cos * forward + sin * sin * sideward;
            plane.variance_cells[1] += sin * sin * forward + cos * cos * sideward;
            plane.apply_motion(grid);
        });
        self.rotate(model, motion.heading_rad);
        let step = grid.angle_step_rad();
        let per_metre = error.turn_per_metre_rad / step;
        let per_radian = error.turn_per_radian_rad / step;
        self.heading_variance +=
            per_metre * per_metre * distance_m + per_radian * per_radian * libm::fabs(motion.heading_rad);
        while self.heading_variance >= HEADING_BLUR_AT {
            let variance = self.heading_variance.min(0.5);
            self.heading_variance -= variance;
            self.blur_headings(model, variance / 2.0);
        }
    }

    /// Turns every hypothesis alike: planes change places.
    fn rotate(&mut self, model: &LocalizationModel, turn_rad: f64) {
        self.heading_offset += turn_rad / model.grid.angle_step_rad();
        let whole = libm::round(self.heading_offset);
        self.heading_offset -= whole;
        self.planes.rotate_right((whole as i64).rem_euclid(model.grid.headings as i64) as usize);
    }

    /// Spreads every plane by `[g, 1 − 2g, g]` over its neighbours in heading.
    fn blur_headings(&mut self, model: &LocalizationModel, spread: f64) {
        let count = self.planes.len();
        let neighbours = |heading: usize| [(heading + count - 1) % count, (heading + 1) % count];
        let wakes = |planes: &[Plane], heading: usize| {
            neighbours(heading)
                .iter()
                .any(|&next| planes[next].is_active() && planes[next].peak() * spread >= model.threshold())
        };
        let waking: Vec<usize> =
            (0..count).filter(|&heading| !self.planes[heading].is_active() && wakes(&self.planes, heading)).collect();
        for heading in waking {
            self.planes[heading].activate(model);
        }
        let active = self.active_planes();
        let slices: Vec<[Plane; 2]> = (0..count)
            .step_by(SLICE)
            .map(|first| [(first + count - 1) % count, (first + SLICE).min(count) % count])
            .map(|edges| edges.map(|heading| self.planes[heading].clone()))
            .collect();
        let blur = |(slice, edges): (&mut [Plane], [Plane; 2])| blur_slice(model, slice, edges, spread);
        let slices = self.planes.chunks_mut(SLICE).zip(slices);
        if active >= PLANES_FOR_THREADS && rayon::current_num_threads() > 1 {
            slices.par_bridge().for_each(blur);
        } else {
            slices.for_each(blur);
        }
    }

    /// Eq. (2), selectively by Eqs. (3) and (4), and normalizes: takes in a scan of each sensor of the
    /// model, one after the other. Missing readings and scans count for nothing.
    ///
    /// # Deviation
    /// After the scans a share of the uniform distribution is mixed in.
    pub(super) fn sense(&mut self, model: &LocalizationModel, scans: &[BinnedScan]) {
        let readings = |scan: &BinnedScan| -> Vec<(usize, u8)> {
            scan.iter().enumerate().filter_map(|(beam, bin)| bin.map(|bin| (beam, bin))).collect()
        };
        let sensors = 0..model.sensors.len();
        let mut heard: Vec<(usize, Vec<(usize, u8)>)> = sensors.zip(scans.iter().map(readings)).collect();
        heard.retain(|(_, readings)| !readings.is_empty());
        let Some((last, readings)) = heard.pop() else {
            return self.sense_scan(model, 0, &[], 0.0);
        };
        for (sensor, readings) in heard {
            self.sense_scan(model, sensor, &readings, 0.0);
        }
        self.sense_scan(model, last, &readings, model.parameters.mixing);
    }

    /// Eq. (2) for the readings of one sensor; `mixed` is the share of the uniform distribution.
    fn sense_scan(&mut self, model: &LocalizationModel, sensor: usize, readings: &[(usize, u8)], mixed: f64) {
        let average = if readings.is_empty() { 1.0 } else { model.average_weight(sensor, readings) };
        weigh_planes(&mut self.planes, model, &model.sensors[sensor], readings, average);
        let lifted = average * f64::from(LIFT);
        let evidence: f64 =
            self.planes.iter().map(|plane| plane.mass(model) * if plane.is_active() { 1.0 } else { lifted }).sum();
        if evidence > LEAST_EVIDENCE {
            self.normalize(model, evidence, lifted, mixed);
        } else {
            *self = Self::uniform(model);
        }
    }

    /// Eq. (2) for a scan of each sensor in metres, every finite reading of it.
    pub fn sense_ranges(&mut self, model: &LocalizationModel, scans_m: &[Option<&[f32]>]) {
        self.sense(model, &model.binned(scans_m));
    }

    /// Mixes a share of the uniform distribution into the belief.
    pub fn mix(&mut self, model: &LocalizationModel, share: f64) {
        if share >= 1.0 {
            // A factor of 0 could not be taken out again when a neighbour is blended in.
            *self = Self::uniform(model);
            return;
        }
        let mass = self.mass(model);
        self.normalize(model, mass, 1.0, share);
    }

    /// Divides by the evidence, mixes, and lets planes fall asleep or wake up.
    pub(super) fn normalize(&mut self, model: &LocalizationModel, evidence: f64, average: f64, mixed: f64) {
        let scale = (1.0 - mixed) / evidence;
        let add = mixed * model.prior();
        let threshold = model.threshold();
        update_planes(&mut self.planes, |_, plane| {
            let scale = if plane.is_active() { scale } else { average * scale };
            plane.factor *= scale;
            plane.floor = plane.floor * scale + add;
            if plane.peak() >= threshold {
                plane.activate(model);
            } else {
                plane.activity = Activity::Inactive;
                plane.forget_if_negligible();
            }
        });
    }
}

/// Spreads the planes of consecutive headings over their neighbours; `edges` are those before and
/// after, as they were.
fn blur_slice(model: &LocalizationModel, slice: &mut [Plane], edges: [Plane; 2], spread: f64) {
    let [mut before, after] = edges;
    for heading in 0..slice.len() {
        let own = slice[heading].clone();
        if own.is_active() {
            let next = slice.get(heading + 1).unwrap_or(&after);
            slice[heading] = blurred(model, &own, [&before, next], spread);
        }
        before = own;
    }
}

/// A plane with a share of its neighbours, aligned by where their cells really are. Of an inactive
/// neighbour, whose cells are all below θ, the average is taken.
fn blurred(model: &LocalizationModel, own: &Plane, neighbours: [&Plane; 2], spread: f64) -> Plane {
    let keep = 1.0 - 2.0 * spread;
    let mut plane = Plane { floor: keep * own.floor, ..own.clone() };
    let mut shares = [const { Share::none() }; 2];
    for (next, share) in neighbours.into_iter().zip(&mut shares) {
        if next.is_active() {
            let away = [0, 1].map(|axis| libm::round(next.offset_cells[axis] - own.offset_cells[axis]) as i64);
            *share = Share { cells: &next.cells, by_cells: away, share: (spread * next.factor / own.factor) as f32 };
            plane.floor += spread * next.floor;
            plane.stored_peak = plane.stored_peak.max((f64::from(next.stored_peak) * next.factor / own.factor) as f32);
        } else {
            plane.floor += spread * next.mass(model) / model.admissible_cells as f64;
        }
    }
    plane.cells = Arc::new(kernel::blended(&own.cells, keep as f32, &shares, (model.grid.columns, model.grid.rows)));
    plane
}

fn normal(sigmas: f64) -> f64 {
    libm::exp(-0.5 * sigmas * sigmas)
}

/// Visits every plane, on several threads if many are active. A plane never looks at another one,
/// so the threads do not change the result.
fn update_planes(planes: &mut [Plane], update: impl Fn(usize, &mut Plane) + Sync) {
    let active = planes.iter().filter(|plane| plane.is_active()).count();
    if active >= PLANES_FOR_THREADS && rayon::current_num_threads() > 1 {
        planes.par_iter_mut().enumerate().for_each(|(heading, plane)| update(heading, plane));
    } else {
        planes.iter_mut().enumerate().for_each(|(heading, plane)| update(heading, plane));
    }
}
