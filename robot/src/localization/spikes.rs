//! Odometry that jumps: a wide part of the error of the heading, computed only where it can matter.

use super::belief::Belief;
use super::model::LocalizationModel;
use super::motion::Share;
use super::parameters::HeadingSpikes;
use super::plane::Plane;
use super::sensor::BinnedScan;

/// Scans that fit better than this, as the logarithm of their evidence by their average weight, leave nothing to a
/// spike.
const FITS: f64 = 4.0;

/// A share of the belief that is not worth to be brought in.
const LEAST_SHARE: f64 = 1e-3;

/// With more tiles awake than this the robot may be anywhere, and a spike makes no difference that is worth the time.
const MOST_TILES: usize = 1024;

impl Belief {
    /// Eq. (2) after Eq. (1): as [`Belief::sense`], and where the scans do not fit, the odometry may have jumped.
    ///
    /// The error of the heading is a mixture of a normal one and of a wide one, and so is the belief: each part has
    /// its share by Bayes' rule, the prior one times the evidence of the scans. The wide part is computed only where
    /// the scans fit badly without it; elsewhere its share is next to nothing.
    pub(super) fn sense_after_motion(&mut self, model: &LocalizationModel, scans: &[BinnedScan]) {
        let is_localized = |_: &&HeadingSpikes| self.tiles().count() <= MOST_TILES;
        let Some(spikes) = model.parameters.spikes.as_ref().filter(is_localized) else {
            self.sense(model, scans);
            return;
        };
        let before = self.clone();
        let fit = self.sense(model, scans);
        if fit >= FITS {
            return;
        }
        let mut jumped = before.jumped(model, spikes);
        let jumped_fit = jumped.sense(model, scans);
        let odds = spikes.share / (1.0 - spikes.share) * libm::exp(jumped_fit - fit);
        let share = odds / (1.0 + odds);
        if share > LEAST_SHARE {
            self.mix_in(model, &jumped, share);
        }
    }

    /// The belief after a jump of the odometry: every heading is as likely as those around it.
    fn jumped(&self, model: &LocalizationModel, spikes: &HeadingSpikes) -> Self {
        let around = self.surroundings(model);
        let count = self.planes.len() as i64;
        let most = (libm::round(spikes.most_rad / model.grid.angle_step_rad()) as i64).min((count - 1) / 2);
        let plane = |(heading, own): (usize, &Plane)| {
            let share = |by: i64| {
                let plane = &self.planes[(heading as i64 + by).rem_euclid(count) as usize];
                let away = |axis: usize| plane.offset_cells[axis] - own.offset_cells[axis];
                Share { plane, by_cells: [0, 1].map(|axis| libm::round(away(axis)) as i64) }
            };
            let shares: Vec<Share> = (-most..=most).map(share).collect();
            let is_active = shares.iter().any(|share| share.plane.is_active());
            let tiles = if is_active { around.averaged(&shares) } else { own.tiles.clone() };
            Plane { tiles, ..own.clone() }
        };
        let planes = self.planes.iter().enumerate().map(plane).collect();
        let mut jumped = self.clone();
        jumped.planes = planes;
        jumped
    }

    /// Brings in a share of a belief whose planes lie as these do.
    fn mix_in(&mut self, model: &LocalizationModel, other: &Self, share: f64) {
        for heading in 0..self.planes.len() {
            let tiles = self.tiles_with(model, other, heading, share as f32);
            self.planes[heading].tiles = tiles;
        }
        self.asleep += share * (other.asleep - self.asleep);
        (self.factor, self.floor) = (1.0, 0.0);
        self.sense(model, &[]);
    }
}
