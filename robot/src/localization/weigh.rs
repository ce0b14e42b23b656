//! Eq. (2) for all tiles that are awake: the loop that takes nearly all the time.

use super::expected::Cones;
use super::kernel::{Beam, TilePart};
use super::model::LocalizationModel;
use super::plane::Plane;
use super::scan::{ScanModel, Weighing};
use super::tile::Tile;
use rayon::prelude::*;
use std::sync::Arc;

/// With fewer tiles than this, a millisecond of work, waking other threads and letting them wait for more takes as long
/// as they save.
pub(super) const TILES_FOR_THREADS: usize = 1024;

/// How the cells that are awake are stored.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stored {
    /// Factor and floor by which they are read.
    pub terms: [f32; 2],
    /// What those below θ are multiplied by: the average weight of the scan.
    pub average: f64,
    /// θ.
    pub threshold: f64,
}

/// A scan to be weighed.
struct Evidence<'m> {
    model: &'m LocalizationModel,
    sensor: &'m ScanModel,
    /// Costs of each reading, by expected bin.
    costs: Vec<&'m [u8; 256]>,
    /// Binary logarithm of the weight a unit of cost amounts to.
    log2_per_cost: f32,
    stored: Stored,
}

/// A tile of one plane.
struct Part<'p> {
    tile: &'p mut Tile,
    /// Where each reading looks into the table of expected distances.
    cones: Arc<[Cones]>,
}

/// Multiplies the tiles that are awake by the weights of a scan of a sensor, bringing in factor and floor, and
/// sums them.
///
/// They are visited place by place and there plane by plane: neighbouring headings look into the same directions of
/// the table, whose part for one tile stays in the cache. Tiles share nothing, so the threads do not change the
/// result.
pub(super) fn weigh_planes(
    planes: &mut [Plane],
    model: &LocalizationModel,
    sensor: &ScanModel,
    readings: &[(usize, u8)],
    weighing: Weighing,
    stored: Stored,
) {
    let likelihood = sensor.likelihood_of(weighing);
    let costs = readings.iter().map(|&(_, bin)| likelihood.costs(bin)).collect();
    let log2_per_cost = likelihood.log2_per_cost(weighing.power);
    let evidence = Evidence { model, sensor, costs, log2_per_cost, stored };
    let mut parts: Vec<Part> = Vec::new();
    for (heading, plane) in planes.iter_mut().enumerate().filter(|(_, plane)| plane.is_active()) {
        let cones: Arc<[Cones]> = readings.iter().map(|&(beam, _)| sensor.cones(heading, beam)).collect();
        parts.extend(plane.tiles_mut().iter_mut().map(|tile| Part { tile, cones: cones.clone() }));
    }
    parts.sort_by_key(|part| part.tile.number);
    let is_of_same = |one: &Part, next: &Part| one.tile.number == next.tile.number;
    if parts.len() >= TILES_FOR_THREADS && rayon::current_num_threads() > 1 {
        let places: Vec<&mut [Part]> = parts.chunk_by_mut(is_of_same).collect();
        places.into_par_iter().for_each(|parts| evidence.weigh(parts));
    } else {
        parts.chunk_by_mut(is_of_same).for_each(|parts| evidence.weigh(parts));
    }
}

impl Evidence<'_> {
    /// Weighs what several planes have in one place.
    fn weigh(&self, parts: &mut [Part]) {
        let Some(number) = parts.first().map(|part| part.tile.number) else { return };
        let Some(ground) = self.model.ground.tile(number) else { return };
        let expected = (!self.costs.is_empty()).then(|| self.sensor.expected().tile(number));
        let mut beams = Vec::new();
        let mut rest = parts;
        while let Some((Part { tile, cones }, others)) = rest.split_first_mut() {
            let next = others.first().map(|part| &*part.tile.cells);
            if let Some(expected) = expected {
                let readings = cones.iter().zip(self.costs.iter().copied());
                let beam = |(cones, costs): (&Cones, _)| Beam { expected: cones.map(|cone| &expected[cone]), costs };
                Beam::put_together(readings.map(beam), &mut beams);
            }
            let extent = self.model.instructions.weigh(TilePart {
                admissible: &ground.admissible,
                cells: Arc::make_mut(&mut tile.cells),
                terms: self.stored.terms,
                beams: &beams,
                log2_per_cost: self.log2_per_cost,
                average: self.stored.average as f32,
                threshold: self.stored.threshold as f32,
                next,
            });
            (tile.mass, tile.peak) = (extent.mass, extent.peak);
            rest = others;
        }
    }
}
