//! Eq. (2) for all active planes: the loop that takes nearly all the time.

use super::grid::BLOCK;
use super::kernel::{self, Beam};
use super::model::LocalizationModel;
use super::plane::Plane;
use rayon::prelude::*;

/// With fewer active planes than this, handing them to other threads costs more than it gains.
pub(super) const PLANES_FOR_THREADS: usize = 32;

/// Cells of a tile, whole blocks; the table of expected distances for one, all directions, is some
/// 360 kB and fits a second-level cache.
const TILE: usize = 16 * BLOCK;

/// A scan to be weighed: bins by beam, and the average weight of such a scan.
struct Evidence<'m> {
    model: &'m LocalizationModel,
    readings: &'m [(usize, u8)],
    average: f64,
}

/// Multiplies the active planes by the weights of a scan and sums them.
///
/// The cells are visited tile by tile and within a tile plane by plane: neighbouring headings look
/// into the same directions of the table, whose part for one tile stays in the cache. Tiles share
/// nothing, and their sums are added in order, whatever the number of threads.
pub(super) fn weigh_planes(planes: &mut [Plane], model: &LocalizationModel, readings: &[(usize, u8)], average: f64) {
    let evidence = Evidence { model, readings, average };
    let mut tiles: Vec<Vec<(usize, &mut [f32])>> = Vec::new();
    tiles.resize_with(model.grid.plane_len().div_ceil(TILE), Vec::new);
    for (heading, plane) in planes.iter_mut().enumerate().filter(|(_, plane)| plane.is_active()) {
        for (tile, cells) in tiles.iter_mut().zip(plane.cells_mut().chunks_mut(TILE)) {
            tile.push((heading, cells));
        }
    }
    let threads =
        tiles.first().is_some_and(|tile| tile.len() >= PLANES_FOR_THREADS) && rayon::current_num_threads() > 1;
    let sums: Vec<Vec<f64>> = if threads {
        tiles.into_par_iter().enumerate().map(|(index, tile)| evidence.weigh_tile(index, tile)).collect()
    } else {
        tiles.into_iter().enumerate().map(|(index, tile)| evidence.weigh_tile(index, tile)).collect()
    };
    for (index, plane) in planes.iter_mut().filter(|plane| plane.is_active()).enumerate() {
        plane.stored_mass = sums.iter().map(|tile| tile[index]).sum();
    }
}

impl Evidence<'_> {
    /// The sums of the planes' parts in one tile.
    fn weigh_tile(&self, index: usize, tile: Vec<(usize, &mut [f32])>) -> Vec<f64> {
        tile.into_iter().map(|(heading, cells)| self.weigh_part(heading, index * TILE, cells)).collect()
    }

    /// The cells of one plane from `first` on.
    fn weigh_part(&self, heading: usize, first: usize, cells: &mut [f32]) -> f64 {
        let model = self.model;
        let range = first..first + cells.len();
        let beam = |&(beam, bin): &(usize, u8)| Beam {
            expected: &model.expected_plane(model.grid.direction(heading, beam))[range.clone()],
            costs: model.sensor.costs(bin),
        };
        let beams: Vec<Beam> = self.readings.iter().map(beam).collect();
        let admissible = &model.admissible[range.clone()];
        let (average, threshold) = (self.average as f32, model.threshold() as f32);
        kernel::weigh(cells, admissible, &beams, model.sensor.weights(), average, threshold)
    }
}
