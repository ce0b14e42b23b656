//! Odometry that is badly wrong now and then: a part of its error model that is computed only where it can matter.

use super::belief::Belief;
use super::model::LocalizationModel;
use super::motion::Share;
use super::parameters::OdometryFaults;
use super::plane::Plane;
use super::scan::Weighing;
use super::sensor::BinnedScan;
use crate::geometry::Pose;

/// A share of the belief that is not worth to be brought in.
const LEAST_SHARE: f64 = 1e-3;

/// With more tiles awake than this the robot may be anywhere, and a fault makes no difference that is worth the time.
const MOST_TILES: usize = 1024;

impl Belief {
    /// Eq. (2) after Eq. (1) for a motion: as [`Belief::sense_weighed`], and where the scans do not fit, the odometry
    /// may have been wrong.
    ///
    /// The error of the odometry is a mixture of a normal one, a jump of the heading and a way in the other direction,
    /// and so is the belief: each part has its share by Bayes' rule, the prior one times the evidence of the scans. The
    /// faults are computed only where the scans are not explained as usual without them; elsewhere their share is next to
    /// nothing.
    pub(super) fn sense_after_motion(
        &mut self,
        model: &LocalizationModel,
        motion: Pose,
        scans: &[BinnedScan],
        mixed: f64,
        weighings: &[Weighing],
        is_explained: bool,
    ) {
        let sense = |belief: &mut Self| belief.sense_weighed(model, scans, mixed, |sensor| weighings[sensor]);
        let may_matter = |_: &&OdometryFaults| !is_explained && self.tiles().count() <= MOST_TILES;
        let Some(faults) = model.parameters.faults.as_ref().filter(may_matter) else {
            sense(self);
            return;
        };
        let before = self.clone();
        let fit = sense(self);
        let reversed = Pose::new(-motion.x_m, motion.y_m, motion.heading_rad).relative_to(motion);
        let after = [(before.jumped(model, faults), faults.jump), (before.corrected(model, reversed), faults.reversal)];
        let mut held = libm::log(1.0 - faults.jump - faults.reversal) + fit;
        for (mut faulty, share) in after.into_iter().filter(|(_, share)| *share > 0.0) {
            let odds = share * libm::exp(sense(&mut faulty) - held);
            let share = odds / (1.0 + odds);
            if share > LEAST_SHARE {
                self.mix_in(model, &faulty, share);
                held += libm::log1p(odds);
            }
        }
    }

    /// The belief after a jump of the odometry: every heading is as likely as those around it.
    fn jumped(&self, model: &LocalizationModel, faults: &OdometryFaults) -> Self {
        let around = self.surroundings(model);
        let count = self.planes.len() as i64;
        let most = (libm::round(faults.most_jump_rad / model.grid.angle_step_rad()) as i64).min((count - 1) / 2);
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
        self.with_planes(planes)
    }

    /// The belief after a motion that the odometry did not tell, to half a cell, from the pose that it did tell.
    fn corrected(&self, model: &LocalizationModel, motion: Pose) -> Self {
        let around = self.surroundings(model);
        let plane = |(heading, own): (usize, &Plane)| {
            let pose = Pose::new(0.0, 0.0, self.heading_rad(model, heading)).compose(motion);
            let cells = |along_m: f64| libm::round(along_m / model.grid.cell_m) as i64;
            let share = Share { plane: own, by_cells: [cells(pose.x_m), cells(pose.y_m)] };
            let tiles = if own.is_active() { around.averaged(&[share]) } else { own.tiles.clone() };
            Plane { tiles, ..own.clone() }
        };
        let planes = self.planes.iter().enumerate().map(plane).collect();
        self.with_planes(planes)
    }

    fn with_planes(&self, planes: Vec<Plane>) -> Self {
        let mut belief = self.clone();
        belief.planes = planes;
        belief
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
