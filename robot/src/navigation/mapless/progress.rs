//! Whether a robot without a map gets on: it comes nearer by the way it knows, or sees something new.

use serde::{Deserialize, Serialize};

/// After this time the robot forgets what holds it up, once, and begins anew: what it forgets is new to
/// it afterwards.
const ANEW_S: f64 = 15.0;
/// The time a way takes that turned out to be longer: at this speed, and at most this time.
const DETOUR_MPS: f64 = 0.2;
const DETOUR_S: f64 = 120.0;
/// The least distance that counts as getting nearer.
const PROGRESS_M: f64 = 0.1;
/// The least number of cells that counts as something new.
const NEW_CELLS: u64 = 20;

/// The nearest the robot has come by the way it knew, and what it had seen by then.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct SeenProgress {
    /// The time without getting nearer or seeing anything new that counts as blocked.
    patience_s: f64,
    least_cost_m: Option<f64>,
    seen_cells: u64,
    at_s: f64,
    /// Whether the robot has forgotten what holds it up and begun anew since.
    anew: bool,
    /// Whether it has looked around for a way since.
    pub looked_around: bool,
}

impl SeenProgress {
    /// Nothing is measured yet.
    pub fn from(at_s: f64, patience_s: f64) -> Self {
        Self { patience_s, at_s, ..Self::default() }
    }

    /// What is measured next is another way's cost.
    pub fn measure_other_way(&mut self) {
        self.least_cost_m = None;
    }

    /// Takes in the cost of the way left and how many cells have been seen.
    pub fn measure(&mut self, now_s: f64, cost_m: Option<f64>, seen_cells: u64) {
        let is_nearer = match (cost_m, self.least_cost_m) {
            (Some(cost_m), Some(least_m)) => cost_m < least_m - PROGRESS_M,
            (Some(_), None) => true,
            (None, _) => false,
        };
        if is_nearer || seen_cells >= self.seen_cells + NEW_CELLS {
            let least_cost_m = cost_m.or(self.least_cost_m);
            *self = Self { patience_s: self.patience_s, least_cost_m, seen_cells, at_s: now_s, ..Self::default() };
        }
    }

    /// Whether the robot should begin anew.
    pub fn is_time_to_begin_anew(&self, now_s: f64) -> bool {
        self.since_s(now_s) > ANEW_S && !self.anew
    }

    /// It does.
    pub fn begin_anew(&mut self) {
        self.anew = true;
    }

    /// For how long it has not got on.
    pub fn since_s(&self, now_s: f64) -> f64 {
        now_s - self.at_s
    }

    /// Whether the robot has not got on for too long. A way that became longer is given the time it
    /// takes.
    pub fn has_stalled(&self, now_s: f64, cost_m: Option<f64>) -> bool {
        let detour_m = cost_m.zip(self.least_cost_m).map_or(0.0, |(cost_m, least_m)| cost_m - least_m);
        self.since_s(now_s) > self.patience_s + (detour_m / DETOUR_MPS).clamp(0.0, DETOUR_S)
    }
}
