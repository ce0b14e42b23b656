//! The coarse belief that watches over the fine one. It looks at the whole map, so it sleeps while there is nothing to
//! be seen.

use super::belief::Belief;
use super::landmark::LandmarkSighting;
use super::model::{LocalizationModel, Misfit};
use super::parameters::{OdometryError, Spread};
use super::scan::Weighing;
use super::sensor::BinnedScan;
use crate::geometry::Pose;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Updates in a row for which both beliefs must have been sure before the coarse one sleeps, and of which it is told
/// when it wakes: as many as a robot needs to find its place.
const KEPT_UPDATES: usize = 40;

/// A belief is sure of the mode that has as much of it as this.
pub(super) const ASSURED: f64 = 0.99;

/// Scans that fit the mode worse than usual by this, in nats, tempered, wake the coarse belief; far less than what it
/// needs itself to give up a pose.
const MOST_DOUBT_NATS: f64 = 3.0;

/// How well scans fit the right pose, as a share of what the sensor model has on the average: 0.45 in buildings that are as
/// their maps, scan by scan with a deviation of 0.17. The model is wider than the readings, to cover cells, headings, and
/// what is not in the map. At a mirror pose it may be 0.75.
const USUAL: f64 = 0.45;

/// Misfit beyond the usual share and this counts as doubt ...
const BEYOND_USUAL: f64 = 0.2;

/// ... and in any building misfit beyond this share: at a wrong pose it is about 1.
const MOST_USUAL: f64 = 0.85;

/// The usual share is learned over as many updates as have this misfit on the average, about forty.
const LEARNED_NATS: f64 = 150.0;

/// What one update had for the coarse belief.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Update {
    /// The estimate before it.
    pub from_in_map: Pose,
    /// As odometry told it.
    pub motion: Pose,
    /// How far odometry was taken to stray.
    pub error: OdometryError,
    /// The beams of each sensor that are to be heard.
    pub scans: Vec<BinnedScan>,
    /// How each of them is weighed.
    pub weighings: Vec<Weighing>,
    /// Share of the uniform distribution that is mixed in after them.
    pub mixed: f64,
    /// Landmarks seen after it.
    pub sightings: Vec<LandmarkSighting>,
}

impl Update {
    /// Without motion and scans.
    fn at_rest(coarse: &LocalizationModel, at_in_map: Pose) -> Self {
        let (motion, error, sightings) = (Pose::default(), coarse.parameters.odometry.clone(), Vec::new());
        Self { from_in_map: at_in_map, motion, error, scans: Vec::new(), weighings: Vec::new(), mixed: 0.0, sightings }
    }

    /// Eq. (2) for its scans, after its motion.
    fn sense(&self, coarse: &LocalizationModel, belief: &mut Belief) {
        belief.sense_weighed(coarse, &self.scans, self.mixed, |sensor| self.weighings[sensor]);
    }

    /// All of it.
    fn replay(&self, coarse: &LocalizationModel, belief: &mut Belief) {
        belief.advance(coarse, self.motion, &self.error);
        self.sense(coarse, belief);
        self.sightings.iter().for_each(|sighting| belief.see(coarse, sighting));
    }
}

/// A coarse belief that is updated in full or, while the scans fit where the fine one has the robot, not at all.
///
/// # Deviation
/// It does not hear every scan. While both agree, and the scans explain the mode as well as usual, it would only confirm
/// it, at a cost that grows with the area of the map. What it misses is kept for forty updates, and when it wakes it
/// hears them all: the scans that tell of a robot carried elsewhere are among them, because it is those that wake it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Watcher {
    attention: Attention,
    /// How much worse than usual scans have fitted the mode of late: a cumulative sum (Page, "Continuous Inspection
    /// Schemes", 1954).
    doubt_nats: f64,
    /// The share of the average misfit that is usual in this building, as learned while both beliefs were sure.
    ///
    /// # Deviation
    /// The papers have one sensor model for all buildings. Where much is not as in the map, or walls are smooth, scans fit
    /// the right pose no better than a mirror pose elsewhere, and a fixed limit would keep the coarse belief awake.
    usual: f64,
    /// How badly the last scans fit, until it is known whether both beliefs are sure.
    last: Option<Misfit>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum Attention {
    /// The updates in a row for which both beliefs have agreed.
    Awake { belief: Belief, agreed_updates: usize },
    /// What it has not heard of, the oldest first.
    Asleep { missed: VecDeque<Update> },
}

impl Watcher {
    /// That looks at everything.
    pub(super) fn awake(belief: Belief) -> Self {
        Self::with(Attention::Awake { belief, agreed_updates: 0 })
    }

    /// Over a robot that knows where it is.
    pub(super) fn asleep() -> Self {
        Self::with(Attention::Asleep { missed: VecDeque::new() })
    }

    fn with(attention: Attention) -> Self {
        Self { attention, doubt_nats: 0.0, usual: USUAL, last: None }
    }

    /// The belief, unless it sleeps.
    pub(super) fn belief(&self) -> Option<&Belief> {
        match &self.attention {
            Attention::Awake { belief, .. } => Some(belief),
            Attention::Asleep { .. } => None,
        }
    }

    /// The same, to be changed.
    pub(super) fn belief_mut(&mut self) -> Option<&mut Belief> {
        match &mut self.attention {
            Attention::Awake { belief, .. } => Some(belief),
            Attention::Asleep { .. } => None,
        }
    }

    /// Bytes of tiles that an earlier one does not share.
    pub(super) fn bytes_apart(&self, earlier: &Self) -> usize {
        match (self.belief(), earlier.belief()) {
            (Some(belief), Some(earlier)) => belief.bytes_apart(earlier),
            (Some(belief), None) => belief.bytes(),
            (None, _) => 0,
        }
    }

    /// Takes in the scans of an update that the fine belief has taken in; an awake belief has been moved by its motion.
    /// `misfit` is that of the scans and the mode, none if nobody can stand there.
    pub(super) fn hear(&mut self, coarse: &LocalizationModel, update: Update, misfit: Option<Misfit>) {
        let most = (self.usual + BEYOND_USUAL).min(MOST_USUAL);
        self.doubt_nats += misfit.map_or(MOST_DOUBT_NATS, |misfit| misfit.beyond_nats(most));
        self.doubt_nats = self.doubt_nats.clamp(0.0, 2.0 * MOST_DOUBT_NATS);
        self.last = misfit;
        let is_crowd = update.weighings.iter().any(|weighing| weighing.is_crowd);
        match &mut self.attention {
            Attention::Awake { belief, .. } => update.sense(coarse, belief),
            Attention::Asleep { missed } => {
                if missed.len() == KEPT_UPDATES {
                    missed.pop_front();
                }
                let pose_in_map = update.from_in_map;
                missed.push_back(update);
                if is_crowd || self.doubt_nats >= MOST_DOUBT_NATS {
                    self.wake(coarse, pose_in_map);
                }
            }
        }
    }

    /// Takes in a landmark that was seen after the last update, where the mode is at a pose.
    pub(super) fn see(&mut self, coarse: &LocalizationModel, sighting: &LandmarkSighting, mode_in_map: Pose) {
        match &mut self.attention {
            Attention::Awake { belief, .. } => belief.see(coarse, sighting),
            Attention::Asleep { missed } => {
                if missed.is_empty() {
                    missed.push_back(Update::at_rest(coarse, mode_in_map));
                }
                if let Some(last) = missed.back_mut() {
                    last.sightings.push(sighting.clone());
                }
            }
        }
    }

    /// Makes the belief anew of what it has missed, from where the mode was before; of the mode alone if it has missed
    /// nothing.
    pub(super) fn wake(&mut self, coarse: &LocalizationModel, mode_in_map: Pose) {
        let Attention::Asleep { missed } = &self.attention else { return };
        let from_in_map = missed.front().map_or(mode_in_map, |first| first.from_in_map);
        let mut belief = around(coarse, from_in_map);
        missed.iter().for_each(|update| update.replay(coarse, &mut belief));
        self.attention = Attention::Awake { belief, agreed_updates: 0 };
    }

    /// What an awake belief has heard against the mode is laid to the map; what comes from now on counts.
    pub(super) fn begin_anew(&mut self, coarse: &LocalizationModel, mode_in_map: Pose) {
        self.attention = Attention::Awake { belief: around(coarse, mode_in_map), agreed_updates: 0 };
    }

    /// It has heard all scans of late, without knowing where the robot was.
    pub(super) fn take_over(&mut self, belief: Belief) {
        self.attention = Attention::Awake { belief, agreed_updates: 0 };
    }

    /// The fine belief was made of this one.
    pub(super) fn disagree(&mut self) {
        (self.doubt_nats, self.usual, self.last) = (0.0, USUAL, None);
        if let Attention::Awake { agreed_updates, .. } = &mut self.attention {
            *agreed_updates = 0;
        }
    }

    /// Takes in whether the fine belief and this one are sure of the mode after an update; sleeps once they have been for
    /// long, and the scans fit.
    pub(super) fn agree(&mut self, are_sure: bool) {
        let Attention::Awake { agreed_updates, .. } = &mut self.attention else { return };
        if let Some(misfit) = self.last.take().filter(|_| are_sure) {
            self.usual = (self.usual + misfit.beyond_nats(self.usual) / LEARNED_NATS).max(USUAL);
        }
        let is_calm = are_sure && self.doubt_nats <= MOST_DOUBT_NATS / 2.0;
        *agreed_updates = if is_calm { *agreed_updates + 1 } else { 0 };
        if *agreed_updates >= KEPT_UPDATES {
            self.attention = Attention::Asleep { missed: VecDeque::new() };
            self.doubt_nats = 0.0;
        }
    }
}

/// A belief that takes a pose to be known to a cell.
fn around(coarse: &LocalizationModel, pose_in_map: Pose) -> Belief {
    let spread = Spread { position_m: coarse.grid.cell_m, heading_rad: coarse.grid.angle_step_rad() };
    let mut belief = Belief::around(coarse, on_grid(coarse, pose_in_map), spread);
    belief.mix(coarse, coarse.parameters.mixing);
    belief
}

/// The pose in the middle of the state around a pose: so cells lie where they do when nothing is known, and mirror poses
/// on mirror cells.
fn on_grid(coarse: &LocalizationModel, pose_in_map: Pose) -> Pose {
    coarse.state_at(pose_in_map).map_or(pose_in_map, |state| {
        let centre = coarse.grid.centre(state.column, state.row);
        Pose::new(centre.x, centre.y, coarse.grid.heading_rad(state.heading))
    })
}
