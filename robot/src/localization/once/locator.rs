//! A map and a sensor, made ready for scans.

use super::blocks::{Blocks, Ground};
use super::likelihood::Likelihood;
use super::scale::RangeScale;
use super::scan::Judge;
use crate::localization::error::ModelError;
use crate::localization::scan_parameters::BeamParameters;
use crate::occupancy::{DistanceField, OccupancyGrid};

/// Standard deviation of a reading at a refined pose, beside half a cell of the map.
const FINE_SIGMA_M: f64 = 0.03;
const FINE_SIGMA_PER_M: f64 = 0.01;

/// Standard deviation of a reading at a pose known to half a block and half a step of the heading.
const COARSE_SIGMA_M: f64 = 0.1;
const COARSE_SIGMA_PER_M: f64 = 0.02;

/// A map and a sensor, ready for scans.
#[derive(Debug)]
pub struct ScanLocator {
    pub(super) scale: RangeScale,
    pub(super) blocks: Blocks,
    pub(super) judge: Judge,
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
}
