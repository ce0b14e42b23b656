//! Eq. (1): what a motion does to a belief.

use super::belief::Belief;
use super::model::LocalizationModel;
use super::motion::{Share, Spare, Surroundings};
use super::parameters::OdometryError;
use super::plane::Plane;
use super::weigh::TILES_FOR_THREADS;
use crate::geometry::Pose;
use rayon::prelude::*;

/// Noise of the heading is applied once it reaches this variance, in squared angle steps.
const HEADING_BLUR_AT: f64 = 0.1;

impl Belief {
    /// Eq. (1) for a motion measured in the frame of the robot before it, by odometry that errs so.
    ///
    /// # Deviation
    /// A motion moves planes by whole cells and headings by whole steps; the rest is kept beside
    /// each plane as the true place of its cells, and noise is kept until it amounts to something.
    /// Interpolating at each step instead would blur by up to a quarter of a squared cell, far
    /// more than odometry errs. What moves into walls is lost until the next normalization. What
    /// mixing has added, the same everywhere, stays.
    pub fn advance(&mut self, model: &LocalizationModel, motion: Pose, error: &OdometryError) {
        let grid = &model.grid;
        let [forward, sideward, heading] = error.variances(motion);
        let [forward, sideward] = [forward, sideward].map(|variance| variance / (grid.cell_m * grid.cell_m));
        let headings: Vec<f64> = (0..grid.headings).map(|heading| self.heading_rad(model, heading)).collect();
        let around = self.surroundings(model);
        update_planes(&mut self.planes, |heading, plane, spare| {
            let (sin, cos) = libm::sincos(headings[heading]);
            plane.offset_cells[0] += (cos * motion.x_m - sin * motion.y_m) / grid.cell_m;
            plane.offset_cells[1] += (sin * motion.x_m + cos * motion.y_m) / grid.cell_m;
            plane.variance_cells[0] += cos * cos * forward + sin * sin * sideward;
            plane.variance_cells[1] += sin * sin * forward + cos * cos * sideward;
            around.apply_motion(plane, spare);
        });
        self.rotate(model, motion.heading_rad);
        self.heading_variance += heading / (grid.angle_step_rad() * grid.angle_step_rad());
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

    /// Spreads every plane by `[g, 1 − 2g, g]` over its neighbours in heading, aligned by where their cells really are.
    fn blur_headings(&mut self, model: &LocalizationModel, spread: f64) {
        let around = self.surroundings(model);
        let count = self.planes.len();
        // Stretches of planes, each between the planes before and after it as they were.
        let length =
            if is_for_threads(&self.planes) { count.div_ceil(2 * rayon::current_num_threads()) } else { count };
        let ends = (0..count).step_by(length).map(|first| {
            let next = (first + length).min(count) % count;
            [&self.planes[(first + count - 1) % count], &self.planes[next]].map(Plane::clone)
        });
        let ends: Vec<[Plane; 2]> = ends.collect();
        let blur = |(planes, [before, after]): (&mut [Plane], [Plane; 2])| {
            blur_stretch(&around, planes, before, &after, spread as f32);
        };
        if length < count {
            self.planes.par_chunks_mut(length).zip(ends).for_each(blur);
        } else {
            self.planes.chunks_mut(length).zip(ends).for_each(blur);
        }
    }
}

/// Spreads planes over their neighbours in turn, between one that was before them and one after them.
fn blur_stretch(around: &Surroundings, planes: &mut [Plane], mut before: Plane, after: &Plane, spread: f32) {
    let mut spare = Spare::default();
    for heading in 0..planes.len() {
        let own = planes[heading].clone();
        let shares = [&before, planes.get(heading + 1).unwrap_or(after)].map(|plane| {
            let away = |axis: usize| plane.offset_cells[axis] - own.offset_cells[axis];
            Share { plane, by_cells: [0, 1].map(|axis| libm::round(away(axis)) as i64) }
        });
        if own.is_active() || shares.iter().any(|share| share.plane.is_active()) {
            planes[heading].tiles = around.blended(&own, &shares, spread, &mut spare);
        }
        spare.keep(std::mem::replace(&mut before, own).tiles);
    }
}

/// Whether there is enough to do for several threads.
fn is_for_threads(planes: &[Plane]) -> bool {
    let tiles: usize = planes.iter().map(|plane| plane.tiles.len()).sum();
    tiles >= TILES_FOR_THREADS && rayon::current_num_threads() > 1
}

/// Visits every plane, on several threads if many tiles are awake. A plane never looks at another one,
/// so the threads do not change the result.
fn update_planes(planes: &mut [Plane], update: impl Fn(usize, &mut Plane, &mut Spare) + Sync) {
    if is_for_threads(planes) {
        let planes = planes.par_iter_mut().enumerate();
        planes.for_each_init(Spare::default, |spare, (heading, plane)| update(heading, plane, spare));
    } else {
        let mut spare = Spare::default();
        planes.iter_mut().enumerate().for_each(|(heading, plane)| update(heading, plane, &mut spare));
    }
}
