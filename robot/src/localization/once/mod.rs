//! Where a robot is by one scan: the whole map against it, at once (global localization without motion).
//!
//! A [`ScanLocator`] is built once from a map and a sensor; [`ScanLocator::locate`] answers with all poses that explain
//! a scan, each with its probability. It knows no belief and no odometry.
//!
//! Read in this order: `scale`, `blocks`, `bound` (what the search compares), `likelihood`, `scan` (what a pose is judged
//! by), `search`, `answer`.

mod answer;
mod blocks;
mod bound;
mod likelihood;
mod scale;
mod scan;
mod search;
#[cfg(test)]
mod tests;
pub mod trial;

use super::error::ModelError;
use super::scan_parameters::BeamParameters;
use crate::occupancy::{DistanceField, OccupancyGrid};
pub use answer::{LikelyPose, Located, MOST_POSES};
use blocks::{Blocks, Ground};
use likelihood::Likelihood;
use scale::RangeScale;
pub use scan::RangeBeam;
use scan::{Judge, Scan};

/// Standard deviation of a reading at a refined pose, beside half a cell of the map.
const FINE_SIGMA_M: f64 = 0.03;
const FINE_SIGMA_PER_M: f64 = 0.01;

/// Standard deviation of a reading at a pose known to half a block and half a step of the heading.
const COARSE_SIGMA_M: f64 = 0.1;
const COARSE_SIGMA_PER_M: f64 = 0.02;

/// A map and a sensor, ready for scans.
#[derive(Debug)]
pub struct ScanLocator {
    scale: RangeScale,
    blocks: Blocks,
    judge: Judge,
}

impl ScanLocator {
    /// For a sensor with these beams that sees what the map shows and is at least so far from everything. Cost: about a
    /// millisecond and 17 kB for each square metre that can be stood in, on one core.
    ///
    /// # Errors
    /// The robot fits nowhere.
    pub fn new(map: &OccupancyGrid, beam: &BeamParameters, clearance_m: f64) -> Result<Self, ModelError> {
        let (scale, distances) = (RangeScale::new(beam), DistanceField::new(map));
        let blocks = Blocks::new(&Ground { map, distances: &distances, beam, scale, clearance_m });
        if blocks.places.is_empty() {
            return Err(ModelError::NoFreeCell);
        }
        let cone = |sigma_m: f64, of_cone_m: f64| if beam.cone_deg == 0 { sigma_m } else { of_cone_m };
        let fine_m = libm::hypot(FINE_SIGMA_M, map.resolution_m / 2.0);
        let likelihood = |sigma_m: f64, per_m: f64| {
            Likelihood::new(beam, cone(sigma_m, sigma_m.max(beam.sigma_m)), cone(per_m, per_m.max(beam.sigma_per_m)))
        };
        let judge = Judge {
            distances,
            beam: beam.clone(),
            rays: Judge::rays(beam),
            coarse: likelihood(COARSE_SIGMA_M, COARSE_SIGMA_PER_M),
            fine: likelihood(fine_m, FINE_SIGMA_PER_M),
        };
        Ok(Self { scale, blocks, judge })
    }

    /// All poses that explain a scan. Cost: some ten milliseconds on 2,000 m² on one core; in proportion to the area.
    pub fn locate(&self, beams: &[RangeBeam]) -> Located {
        let scan = Scan::new(beams, &self.scale, &self.judge);
        if scan.is_empty() {
            return Located { poses: Vec::new(), elsewhere: 1.0, nowhere: 0.0 };
        }
        self.answer(&scan, &self.candidates(&scan))
    }
}
