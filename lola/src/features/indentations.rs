//! The monitor of indentations on a side: the leaf of a closed door stands some centimetres behind the face of its
//! wall, which is within the noise of one reading and far outside that of their mean.

use super::contour::{ContourPoint, Heard};
use super::openings::Found;
use super::parameters::PARAMETERS;
use crate::feature::Feature;
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// The best place for a door among those that overlap it, so far.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Candidate {
    found: Found,
    significance: f64,
}

/// The monitor flag of a side.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct IndentationMonitor {
    /// Doors that begin before this were tried.
    tried_m: Option<f64>,
    best: Option<Candidate>,
}

/// A candidate is the best if none of those that begin within this distance behind it is better.
const SETTLED_M: f64 = 0.15;

impl IndentationMonitor {
    /// Tries the places where a door would have been passed by now; answers the one that was found. `taken_m` are the parts of
    /// the wall that are openings, or known by now.
    pub fn take_in(&mut self, along_m: f64, kept: &[ContourPoint], taken_m: &[(f64, f64)]) -> Option<Found> {
        self.try_up_to(along_m - PARAMETERS.behind_m - PARAMETERS.door_m.0, along_m, kept, taken_m)
    }

    /// Nothing comes any more: tries the places up to the hallway's end.
    pub fn close(
        &mut self,
        along_m: f64,
        end_m: Option<f64>,
        kept: &[ContourPoint],
        taken_m: &[(f64, f64)],
    ) -> Option<Found> {
        let last_m = end_m.unwrap_or(along_m + PARAMETERS.door_m.0 / 2.0) - PARAMETERS.door_m.0;
        let found = self.try_up_to(last_m, along_m, kept, taken_m);
        found.or_else(|| self.best.take().map(|best| best.found))
    }

    fn try_up_to(&mut self, last_m: f64, along_m: f64, kept: &[ContourPoint], taken_m: &[(f64, f64)]) -> Option<Found> {
        let grain_m = PARAMETERS.grain_m;
        let mut from_m = self
            .tried_m
            .map_or(libm::ceil((last_m - PARAMETERS.kept_m) / grain_m) * grain_m, |tried_m| tried_m + grain_m);
        while from_m <= last_m {
            self.tried_m = Some(from_m);
            let candidate = candidate_at(from_m, along_m, kept, taken_m);
            if let Some(best) = self.best {
                let is_better = candidate.is_some_and(|candidate| candidate.significance > best.significance);
                if !is_better && from_m >= best.found.from_m + SETTLED_M {
                    self.best = None;
                    return Some(best.found);
                }
                if is_better {
                    self.best = candidate;
                }
            } else {
                self.best = candidate;
            }
            from_m += grain_m;
        }
        None
    }

    /// What lies before this is known by now.
    pub fn pass(&mut self, to_m: f64) {
        if self.best.is_some_and(|best| best.found.from_m < to_m) {
            self.best = None;
        }
        self.tried_m = Some(self.tried_m.map_or(to_m, |tried_m| tried_m.max(to_m)));
    }
}

/// A reading of the wall or of a leaf in it.
#[derive(Clone, Copy, Debug)]
struct WallReading {
    /// Where on the wall the echo comes from.
    foot_m: f64,
    /// The part of the wall in the cone.
    cone_m: (f64, f64),
    /// How much deeper than the wall it was heard.
    depth_m: f64,
}

/// The best door that begins at a place. Cost: the readings that are kept, and seven widths times those near the door.
fn candidate_at(from_m: f64, along_m: f64, kept: &[ContourPoint], taken_m: &[(f64, f64)]) -> Option<Candidate> {
    let p = &PARAMETERS;
    let widths = ((p.door_m.1 - p.door_m.0) / p.grain_m + 0.5) as u32;
    let all = (0..=widths).map(|step| from_m + p.door_m.0 + f64::from(step) * p.grain_m);
    let is_free = |to_m: f64| !taken_m.iter().any(|taken| from_m < taken.1 && to_m > taken.0);
    let tried: Vec<f64> = all.filter(|&to_m| to_m <= along_m + p.beside_m && is_free(to_m)).collect();
    let readings = wall_readings(kept, from_m - p.beside_m, tried.last()? + p.beside_m);
    let fits = tried.iter().filter_map(|&to_m| fitted(from_m, to_m, &readings, taken_m));
    fits.max_by(|a, b| a.significance.total_cmp(&b.significance))
}

/// The readings whose echo comes from this part of the wall.
fn wall_readings(kept: &[ContourPoint], from_m: f64, to_m: f64) -> Vec<WallReading> {
    let of_wall = kept.iter().filter_map(|point| {
        let foot_m = point.foot_m();
        let is_of_wall = foot_m >= from_m && foot_m <= to_m && point.heard() == Heard::Wall;
        is_of_wall.then(|| WallReading { foot_m, cone_m: point.footprint_m(), depth_m: point.depth_m() })
    });
    of_wall.collect()
}

/// Least squares of a wall, straight but for a step between two places: `depth = offset + slope · along + leaf · [on the leaf]`.
/// Cones that hear both wall and leaf are left out.
fn fitted(from_m: f64, to_m: f64, readings: &[WallReading], taken_m: &[(f64, f64)]) -> Option<Candidate> {
    let p = &PARAMETERS;
    let middle_m = (from_m + to_m) / 2.0;
    let mut normal = Matrix3::<f64>::zeros();
    let mut right = Vector3::<f64>::zeros();
    let (mut depth2, mut on_leaf, mut on_wall) = (0.0, 0.0, 0.0);
    for &WallReading { foot_m, cone_m, depth_m } in
        readings.iter().filter(|reading| reading.foot_m <= to_m + p.beside_m)
    {
        let leaf = if cone_m.0 >= from_m && cone_m.1 <= to_m {
            1.0
        } else if foot_m < from_m || foot_m > to_m {
            let is_beside_opening = taken_m.iter().any(|taken| cone_m.0 < taken.1 && cone_m.1 > taken.0);
            if is_beside_opening {
                continue;
            }
            0.0
        } else {
            continue;
        };
        let row = Vector3::new(1.0, foot_m - middle_m, leaf);
        normal += row * row.transpose();
        right += row * depth_m;
        depth2 += depth_m * depth_m;
        on_leaf += leaf;
        on_wall += 1.0 - leaf;
    }
    if on_leaf < p.least_readings || on_wall < p.least_readings {
        return None;
    }
    // The slope is known beforehand, as precisely as the axis.
    let noise2_m2 = p.least_noise_m * p.least_noise_m;
    normal[(1, 1)] += noise2_m2 / (p.slope_rad * p.slope_rad);
    let inverse = normal.try_inverse()?;
    let solution = inverse * right;
    let leaf_m = solution[2];
    let residual2 = ((depth2 - solution.dot(&right)) / (on_leaf + on_wall)).max(noise2_m2);
    let significance = leaf_m / (residual2 * inverse[(2, 2)]).sqrt();
    let is_leaf = leaf_m >= p.leaf_m.0 && leaf_m <= p.leaf_m.1 && significance >= p.least_significance;
    let found = Found { seen: Feature::ClosedDoor, from_m, to_m, depth_m: leaf_m };
    is_leaf.then_some(Candidate { found, significance })
}
