//! The state of localization: belief, odometry, and what was last concluded from them.

use super::belief::Belief;
use super::beliefs::{Beliefs, Heard};
use super::gating::{Company, Crowd, leave_out_confusing, leave_out_novel, leave_out_short};
use super::landmark::LandmarkSighting;
use super::model::LocalizationModel;
use super::parameters::{LocalizationParameters, Spread};
use super::scan::ScanModel;
use super::scan_match::Fix;
use super::scan_parameters::Gating;
use super::summary::Maximum;
use crate::geometry::{Point, Pose};
use serde::{Deserialize, Serialize};

/// Where the robot is, as far as it knows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The mode of the belief, carried on by odometry since the last update.
    pub pose_in_map: Pose,
    /// Probability that the true pose is within 0.5 m and 15° of it.
    pub certainty: f64,
}

/// A reading that differs by more than this has changed; far beyond the noise.
const CHANGED_M: f32 = 0.5;

/// One changed reading in this many makes a changed scan; a person walking by changes fewer.
const CHANGED_ONE_IN: usize = 3;

/// Scans speak against a pose that they explain worse by this than the last ones did theirs, as the logarithm of the
/// likelihood, tempered.
const CONTRADICTION: f64 = 1.0;

/// What was taken in since the robot last moved.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Rest {
    /// Observations since the last update.
    waited: u32,
    /// Scans that were used.
    scans: u32,
}

/// Whether a scan of a sensor is another one than the last that was used; one that is missing is not.
fn has_changed(before_m: Option<&[f32]>, now_m: Option<&[f32]>) -> bool {
    let (Some(before_m), Some(now_m)) = (before_m, now_m) else { return now_m.is_some() };
    let changed = |(before, now): &(&f32, &f32)| (**before - **now).abs() > CHANGED_M;
    before_m.iter().zip(now_m).filter(changed).count() * CHANGED_ONE_IN >= now_m.len()
}

/// Share of the old belief kept when relocalization starts.
const KEPT_FOR_RELOCALIZATION: f64 = 0.1;

/// The certainty is no higher until both beliefs have agreed for long: of two places that explain what was heard since the
/// position was lost, the wrong one may be found first.
const UNSETTLED: f64 = 0.98;

/// The mode has gone elsewhere when it is farther than this from where odometry has carried it.
const ELSEWHERE_M: f64 = 1.0;

/// The state of the filter. Cloning it shares the tiles of the belief until one is written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Localization {
    beliefs: Beliefs,
    /// Odometry at the last update; none before the first observation.
    updated_at_in_odom: Option<Pose>,
    /// Odometry at the last observation.
    observed_at_in_odom: Option<Pose>,
    /// The last scan of each sensor that was used ...
    last_scans_m: Vec<Option<Vec<f32>>>,
    /// ... and what it cost to explain them at the mode, if odometry may be badly wrong; none since the belief was given
    /// up.
    last_costs_nats: Option<Vec<f64>>,
    rest: Rest,
    /// The pose found by the last scans, if one was.
    fix: Option<Fix>,
    /// Whether people stand around, and the mode is borne out nevertheless.
    crowd: Crowd,
    /// Updates so far.
    updates: u64,
    /// How many of them there were when landmarks were seen last.
    seen_at: Option<u64>,
}

impl Localization {
    /// At a known pose.
    pub fn start_at(model: &LocalizationModel, pose_in_map: Pose, spread: Spread) -> Self {
        Self::of(model, Beliefs::around(model, pose_in_map, spread))
    }

    /// Anywhere.
    pub fn start_uniform(model: &LocalizationModel) -> Self {
        Self::of(model, Beliefs::uniform(model))
    }

    fn of(model: &LocalizationModel, beliefs: Beliefs) -> Self {
        Self {
            beliefs,
            updated_at_in_odom: None,
            observed_at_in_odom: None,
            last_scans_m: vec![None; model.sensors.len()],
            last_costs_nats: None,
            rest: Rest::default(),
            fix: None,
            crowd: Crowd::default(),
            updates: 0,
            seen_at: None,
        }
    }

    /// Gives up most of the belief: 90 % uniform, so that the true pose is found wherever it is,
    /// and 10 % of what was believed, so that a false alarm heals in place.
    pub fn reset_for_relocalization(&mut self, model: &LocalizationModel) {
        self.mix(model, 1.0 - KEPT_FOR_RELOCALIZATION);
    }

    /// Gives up all of the belief: what it says has been refuted, and a share of it would only lead
    /// back there.
    pub fn refute(&mut self, model: &LocalizationModel) {
        self.crowd.support_nats = 0.0;
        self.mix(model, 1.0);
    }

    fn mix(&mut self, model: &LocalizationModel, share: f64) {
        self.beliefs.mix(model, share);
        self.rest = Rest::default();
        self.last_costs_nats = None;
    }

    /// Takes in whether the robot gets no nearer where the map shows a way. That speaks for another place as much as for a
    /// map that has aged, so all places are compared with where the robot takes itself to be.
    pub fn note_held_up(&mut self, is_held_up: bool) {
        self.beliefs.note_held_up(is_held_up);
    }

    /// Half of this belief and half of another one, to half a cell: two hypotheses to be told apart.
    pub fn merged(&self, model: &LocalizationModel, other: &Self) -> Self {
        Self::of(model, self.beliefs.merged(model, &other.beliefs))
    }

    /// Takes in odometry and what each sensor of the model has read, a reading for each of its beams; none
    /// from a sensor that is off. Readings that are not finite are missing.
    /// Returns whether the belief was updated.
    ///
    /// # Deviation
    /// The belief is updated only after some motion, by `update_distance_m` and
    /// `update_angle_rad`: scans from one place repeat the same evidence. A robot at rest takes a
    /// few scans and no more, unless a scan changes: somebody may have turned it.
    pub fn observe(&mut self, model: &LocalizationModel, odometry_in_odom: Pose, scans_m: &[Option<&[f32]>]) -> bool {
        self.observed_at_in_odom = Some(odometry_in_odom);
        let since = odometry_in_odom.relative_to(*self.updated_at_in_odom.get_or_insert(odometry_in_odom));
        let moved = libm::hypot(since.x_m, since.y_m) >= model.parameters.update_distance_m
            || libm::fabs(since.heading_rad) >= model.parameters.update_angle_rad;
        let is_scanned = scans_m.iter().any(Option::is_some);
        let powers = self.powers(model, since);
        let is_due = moved
            || is_scanned && self.is_due_at_rest(&model.parameters, scans_m)
            || self.is_contradicted(model, since, scans_m, &powers);
        if !is_due {
            return false;
        }
        let predicted_in_map = self.beliefs.mode.pose_in_map.compose(since);
        let error = self.beliefs.odometry_error(model);
        self.beliefs.advance(model, since);
        let heard = self.heard(model, predicted_in_map, scans_m, &powers);
        let misfit = model.misfit(predicted_in_map, heard.iter().map(|heard| &heard.gated));
        let is_explained = misfit.is_some_and(|misfit| misfit.is_explained());
        self.beliefs.sense(model, since, heard, self.crowd.support_nats, is_explained, self.updates);
        if self.beliefs.mode.pose_in_map.distance_m(predicted_in_map) > ELSEWHERE_M {
            self.crowd.support_nats = 0.0;
        }
        // Odometry that may be badly wrong would lead the next fix astray.
        let last = self.fix.filter(|_| model.parameters.faults.is_none() || is_explained);
        let last = last.map(|fix| fix.advanced(since, &error));
        self.fix = model.matched(self.beliefs.mode.pose_in_map, last, scans_m, &powers);
        self.take_fix();
        self.updated_at_in_odom = Some(odometry_in_odom);
        self.updates += 1;
        if moved {
            self.rest = Rest::default();
        }
        self.rest.waited = 0;
        self.rest.scans += u32::from(is_scanned);
        for (last_m, scan_m) in self.last_scans_m.iter_mut().zip(scans_m) {
            if let Some(scan_m) = scan_m {
                *last_m = Some(scan_m.to_vec());
            }
        }
        if model.parameters.faults.is_some() {
            let last_m: Vec<Option<&[f32]>> = self.last_scans_m.iter().map(Option::as_deref).collect();
            self.last_costs_nats = model.costs(self.beliefs.mode.pose_in_map, &last_m);
        }
        true
    }

    /// What a scan of each sensor tells beyond the last one it was heard with, after a motion since the last update.
    fn powers(&self, model: &LocalizationModel, since: Pose) -> Vec<f64> {
        let way_m = libm::hypot(since.x_m, since.y_m);
        let power = |(sensor, last_m): (&ScanModel, &Option<Vec<f32>>)| {
            let correlation = sensor.parameters.correlation.as_ref().filter(|_| last_m.is_some());
            correlation.map_or(1.0, |correlation| correlation.beyond_last(way_m))
        };
        model.sensors.iter().zip(&self.last_scans_m).map(power).collect()
    }

    /// Counts an observation at rest and tells whether it is to be used.
    fn is_due_at_rest(&mut self, parameters: &LocalizationParameters, scans_m: &[Option<&[f32]>]) -> bool {
        self.rest.waited += 1;
        let mut pairs = self.last_scans_m.iter().zip(scans_m);
        let changed = pairs.any(|(last_m, scan_m)| has_changed(last_m.as_deref(), *scan_m));
        if changed {
            self.rest.scans = 0;
        }
        self.rest.scans == 0
            || self.rest.waited >= parameters.standing_observations && self.rest.scans < parameters.standing_updates
    }

    /// Whether scans speak against what odometry tells of the way since the last update, if it may be badly wrong: they
    /// explain the pose it leads to much worse than those of the last update explained theirs.
    fn is_contradicted(
        &self,
        model: &LocalizationModel,
        since: Pose,
        scans_m: &[Option<&[f32]>],
        powers: &[f64],
    ) -> bool {
        let Some(last_nats) = &self.last_costs_nats else { return false };
        let weighed = |nats: &[f64]| nats.iter().zip(powers).map(|(nats, power)| nats * power).sum::<f64>();
        let now_nats = model.costs(self.beliefs.mode.pose_in_map.compose(since), scans_m);
        now_nats.is_none_or(|now_nats| weighed(&now_nats) - weighed(last_nats) > CONTRADICTION)
    }

    /// Where the scans have found the mode, it is their pose.
    fn take_fix(&mut self) {
        if let Some(fix) = &self.fix {
            self.beliefs.mode.pose_in_map = fix.pose_in_map;
        }
    }

    /// Takes in landmarks that were seen at the last observation. Returns whether they were: from a robot that has
    /// not moved since the last ones they would be the same evidence again.
    ///
    /// # Deviation
    /// Sightings count once for each update by the range sensors, whatever the rate of images.
    pub fn see(&mut self, model: &LocalizationModel, sightings: &[LandmarkSighting]) -> bool {
        if sightings.is_empty() || self.seen_at == Some(self.updates) {
            return false;
        }
        self.seen_at = Some(self.updates);
        let since = self.since_update();
        for sighting in sightings {
            let at_in_base = since.transform(sighting.at_in_base);
            let sighting = LandmarkSighting { at_in_base, ..sighting.clone() };
            self.beliefs.see(model, &sighting);
        }
        self.beliefs.settle(model);
        self.fix = self.fix.filter(|fix| fix.is_near(self.beliefs.mode.pose_in_map));
        self.take_fix();
        true
    }

    /// How the robot has moved since the last update.
    fn since_update(&self) -> Pose {
        match (self.updated_at_in_odom, self.observed_at_in_odom) {
            (Some(updated), Some(observed)) => observed.relative_to(updated),
            _ => Pose::default(),
        }
    }

    /// The bins of the scans, and which of them gating leaves out; the belief has been moved.
    fn heard(
        &mut self,
        model: &LocalizationModel,
        predicted_in_map: Pose,
        scans_m: &[Option<&[f32]>],
        powers: &[f64],
    ) -> Vec<Heard> {
        let scans = model.binned(scans_m).into_iter().zip(powers);
        let heard = scans.map(|(whole, &power)| Heard { gated: whole.clone(), whole, company: Company::Few, power });
        let mut heard: Vec<Heard> = heard.collect();
        let (belief, leading) = self.beliefs.leading(model);
        for (sensor, (heard, ranges_m)) in heard.iter_mut().zip(scans_m).enumerate() {
            let scan = &mut heard.gated;
            let (Some(gating), Some(ranges_m)) = (&model.sensors[sensor].parameters.gating, ranges_m) else { continue };
            match gating {
                Gating::Short(short) => {
                    let state = model.state_at(predicted_in_map);
                    let state = state.filter(|state| model.is_admissible(state.column, state.row));
                    if let Some(state) = state {
                        let expected = model.expected_scan(sensor, state);
                        let (tables, mass) = (&model.sensors[sensor], self.beliefs.mode.mass);
                        heard.company =
                            leave_out_short(short, tables, &expected, ranges_m, mass, &mut self.crowd, scan);
                    }
                }
                Gating::Entropy => leave_out_confusing(belief, leading, sensor, scan),
                Gating::Novelty { most_probable } => {
                    leave_out_novel(*most_probable, belief, leading, sensor, scan);
                }
            }
        }
        heard
    }

    /// Where the robot is; costs nothing, the mode is found at each update.
    pub fn estimate(&self, model: &LocalizationModel) -> Estimate {
        let pose_in_map = self.beliefs.mode.pose_in_map.compose(self.since_update());
        let share = (self.beliefs.mode.mass / self.beliefs.held).min(1.0);
        let sharp = model.parameters.reckoning.as_ref().map_or(share, |reckoning| reckoning.certainty(share));
        let most = if self.beliefs.is_unsettled() { UNSETTLED } else { 1.0 };
        Estimate { pose_in_map, certainty: (sharp * self.tracking(model)).min(most) }
    }

    /// Probability that dead reckoning has led the robot on from where it was known: low where scans speak for another
    /// place, and not where they say nothing. It is at least the certainty.
    ///
    /// # Deviation
    /// The papers take a robot for lost when its certainty is low. But where nothing is in reach of its sensors a robot
    /// gets uncertain as its odometry strays, and nothing speaks against the pose.
    pub fn tracking(&self, model: &LocalizationModel) -> f64 {
        let share = self.beliefs.held.min(self.beliefs.agreed);
        model.parameters.calibration.as_ref().map_or(share, |calibration| calibration.certainty(share))
    }

    /// How many times as far as the description of the robot says its odometry errs, as the scans tell, the position or
    /// the heading, whichever more; at least 1.
    pub fn slip(&self) -> f64 {
        self.beliefs.slip()
    }

    /// The share of what was seen of late from places that were sure, and is not as in the map.
    pub fn map_misfit(&self) -> f64 {
        self.beliefs.map_fit().misfit()
    }

    /// Where that is, in the map, in pieces of a metre, each with how many readings lie there.
    pub fn unmapped_readings(&self) -> impl Iterator<Item = (Point, f64)> {
        self.beliefs.map_fit().unexplained()
    }

    /// How often the belief was updated.
    pub fn updates(&self) -> u64 {
        self.updates
    }

    /// The local maxima, the heaviest first, as of the last update and carried on by odometry.
    pub fn maxima(&self, model: &LocalizationModel, max_count: usize, min_mass: f64) -> Vec<Maximum> {
        let since = self.since_update();
        let (belief, leading) = self.beliefs.leading(model);
        let mut maxima = belief.maxima(leading, max_count, min_mass);
        for maximum in &mut maxima {
            maximum.pose_in_map = maximum.pose_in_map.compose(since);
        }
        maxima
    }

    /// The likeliest states that together hold a share of the belief, the likeliest first, as of the
    /// last update.
    pub fn likely_states(&self, model: &LocalizationModel, share: f64) -> Vec<Maximum> {
        let (belief, leading) = self.beliefs.leading(model);
        belief.likely_states(leading, share)
    }

    /// The same states as poses, carried on by odometry.
    pub fn likely_poses(&self, model: &LocalizationModel, share: f64) -> Vec<Maximum> {
        let since = self.since_update();
        let mut poses = self.likely_states(model, share);
        for pose in &mut poses {
            pose.pose_in_map = pose.pose_in_map.compose(since);
        }
        poses
    }

    /// Entropy of the belief, in nats. O(states that are not known to be uniform).
    pub fn entropy(&self, model: &LocalizationModel) -> f64 {
        self.beliefs.entropy(model)
    }

    /// Probability of each cell of (x, y), `[row][column]`, for pictures.
    pub fn belief_xy(&self, model: &LocalizationModel) -> Vec<f64> {
        self.beliefs.xy(model)
    }

    /// The sum of the belief, 1 but for rounding.
    pub fn mass(&self, model: &LocalizationModel) -> f64 {
        let (belief, leading) = self.beliefs.leading(model);
        belief.mass(leading)
    }

    /// Bytes of tiles that an earlier state does not share.
    pub fn bytes_apart(&self, earlier: &Self) -> usize {
        self.beliefs.bytes_apart(&earlier.beliefs)
    }

    /// The belief that leads, and the model of its grid: the coarse one while the robot is lost.
    pub fn belief<'a>(&'a self, model: &'a LocalizationModel) -> (&'a Belief, &'a LocalizationModel) {
        self.beliefs.leading(model)
    }
}
