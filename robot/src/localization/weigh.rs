//! Eq. (2) for all active planes: the loop that takes nearly all the time.

use super::kernel::{self, Beam, Extent, TILE, TilePart};
use super::model::LocalizationModel;
use super::plane::Plane;
use super::scan::ScanModel;
use rayon::prelude::*;

/// With fewer active planes than this, handing them to other threads costs more than it gains.
pub(super) const PLANES_FOR_THREADS: usize = 32;

/// A scan to be weighed.
struct Evidence<'m> {
    model: &'m LocalizationModel,
    sensor: &'m ScanModel,
    /// Costs of each reading, by expected bin.
    costs: Vec<&'m [u8; 256]>,
    /// The average weight of such a scan.
    average: f64,
}

/// What a tile has to know of one plane.
struct PlanePart<'p> {
    cells: &'p mut [f32],
    terms: [f32; 2],
    /// Where each reading looks into the table of expected distances.
    directions: &'p [usize],
}

/// Multiplies the active planes by the weights of a scan of a sensor, bringing in their factor and floor, and
/// sums them.
///
/// The cells are visited tile by tile and within a tile plane by plane: neighbouring headings look
/// into the same directions of the table, whose part for one tile stays in the cache. Tiles share
/// nothing, and their sums are added in order, whatever the number of threads.
pub(super) fn weigh_planes(
    planes: &mut [Plane],
    model: &LocalizationModel,
    sensor: &ScanModel,
    readings: &[(usize, u8)],
    average: f64,
) {
    let costs = readings.iter().map(|&(_, bin)| sensor.likelihood.costs(bin)).collect();
    let evidence = Evidence { model, sensor, costs, average };
    let directions: Vec<Vec<usize>> = (0..planes.len())
        .map(|heading| readings.iter().map(|&(beam, _)| sensor.bearings.direction(heading, beam)).collect())
        .collect();
    let mut tiles: Vec<Vec<PlanePart>> = Vec::new();
    tiles.resize_with(model.grid.plane_len().div_ceil(TILE), Vec::new);
    for (plane, directions) in planes.iter_mut().zip(&directions).filter(|(plane, _)| plane.is_active()) {
        let terms = plane.terms();
        for (tile, cells) in tiles.iter_mut().zip(plane.cells_mut().chunks_mut(TILE)) {
            tile.push(PlanePart { cells, terms, directions });
        }
    }
    let threads =
        tiles.first().is_some_and(|tile| tile.len() >= PLANES_FOR_THREADS) && rayon::current_num_threads() > 1;
    let extents: Vec<Vec<Extent>> = if threads {
        tiles.into_par_iter().enumerate().map(|(index, tile)| evidence.weigh_tile(index, tile)).collect()
    } else {
        tiles.into_iter().enumerate().map(|(index, tile)| evidence.weigh_tile(index, tile)).collect()
    };
    for (index, plane) in planes.iter_mut().filter(|plane| plane.is_active()).enumerate() {
        plane.weighed(extents.iter().map(|tile| tile[index]).fold(Extent::default(), Extent::and));
    }
}

impl Evidence<'_> {
    /// Sum and maximum of the planes' parts in one tile.
    fn weigh_tile(&self, index: usize, tile: Vec<PlanePart>) -> Vec<Extent> {
        let model = self.model;
        let threshold = model.threshold() as f32;
        let table = self.sensor.expected();
        let is_loud = || !self.costs.is_empty() && tile.iter().any(|part| part.is_loud(threshold));
        // Where no cell is weighed by its own costs, the table of the tile need not be made.
        let expected = table.known_tile(index).or_else(|| is_loud().then(|| table.tile(index)));
        let admissible = &model.admissible[index * TILE..];
        let weigh = |part: PlanePart| {
            let beams = expected.map_or(Vec::new(), |expected| {
                let readings = part.directions.iter().zip(&self.costs);
                Beam::together(readings.map(|(&direction, costs)| Beam { expected: &expected[direction], costs }))
            });
            model.instructions.weigh(TilePart {
                admissible: &admissible[..part.cells.len()],
                cells: part.cells,
                terms: part.terms,
                beams: &beams,
                log2_per_cost: self.sensor.likelihood.log2_per_cost(),
                average: self.average as f32,
                threshold,
            })
        };
        tile.into_iter().map(weigh).collect()
    }
}

impl PlanePart<'_> {
    fn is_loud(&self, threshold: f32) -> bool {
        kernel::is_loud(self.cells, self.terms, threshold)
    }
}
