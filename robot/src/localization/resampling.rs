//! The belief of one grid in another one over the same map.

use super::belief::Belief;
use super::grid::{BeliefGrid, Place, TILE_EDGE};
use super::ground::{Cells, GroundTile};
use super::model::LocalizationModel;
use super::plane::Plane;
use super::tile::Tile;
use rayon::prelude::*;
use std::ops::RangeInclusive;

impl Belief {
    /// The belief of another grid over the same map: every state takes the density of the state of
    /// the other grid it lies in.
    pub(super) fn resampled(model: &LocalizationModel, other: &Self, other_model: &LocalizationModel) -> Self {
        let grid = &model.grid;
        // What a state of the other grid is worth in this one.
        let ratio = model.prior() / other_model.prior();
        let resampled = |heading: usize| -> Plane {
            let tiles = model.ground.tiles().filter_map(|(number, ground)| {
                let cells = other.density(other_model, heading, grid, number, model.threshold() / ratio)?;
                let tile =
                    Tile::new(number, std::array::from_fn(|cell| cells[cell] * ratio as f32 * ground.admissible[cell]));
                (f64::from(tile.peak) >= model.threshold()).then_some(tile)
            });
            Plane::of(tiles.collect())
        };
        // The other grid may have fewer headings: each of its planes is resampled once.
        let sources: Vec<Plane> = (0..other.planes.len()).into_par_iter().map(resampled).collect();
        let mut belief = Self::asleep(model);
        for (heading, plane) in belief.planes.iter_mut().enumerate() {
            *plane = sources[other.plane_at(other_model, grid.angle_step_rad() * heading as f64)].clone();
        }
        belief.asleep = ratio * other.mean_below(other_model, model.threshold() / ratio);
        belief.sense(model, &[]);
        belief
    }

    /// Probabilities of the states that the cells of a tile of another grid lie in: of the likeliest beside one that
    /// cannot be stood in, because at a wall a point may be free whose coarse cell is not. None if all are below a
    /// bound.
    fn density(
        &self,
        model: &LocalizationModel,
        heading: usize,
        grid: &BeliefGrid,
        number: u32,
        bound: f64,
    ) -> Option<Cells> {
        let offset = self.planes[heading].offset_cells;
        let corner = Place { tile: number as usize, cell: 0 };
        let [column, row] = grid.column_and_row(corner);
        let nearest = |along: i64, axis: usize| -> i64 {
            let at = grid.origin_in_map[axis] + along as f64 * grid.cell_m - model.grid.origin_in_map[axis];
            libm::round(at / model.grid.cell_m - offset[axis]) as i64
        };
        let columns: [i64; TILE_EDGE] = std::array::from_fn(|at| nearest(column + at as i64, 0));
        let rows: [i64; TILE_EDGE] = std::array::from_fn(|at| nearest(row + at as i64, 1));
        let [columns_around, rows_around] = [&columns, &rows].map(|places| places[0] - 1..=places[TILE_EDGE - 1] + 1);
        if self.highest_within(model, heading, columns_around, rows_around) < bound {
            return None;
        }
        let at = |column: i64, row: i64| self.probability_at(model, heading, [column, row]);
        let likeliest = |column: i64, row: i64| {
            let here = at(column, row);
            let beside = || [at(column + 1, row), at(column - 1, row), at(column, row + 1), at(column, row - 1)];
            if here > 0.0 { here } else { beside().into_iter().fold(0.0, f64::max) }
        };
        Some(std::array::from_fn(|cell| likeliest(columns[cell % TILE_EDGE], rows[cell / TILE_EDGE]) as f32))
    }

    /// The average probability of the states that are below a bound; 0 if none is.
    fn mean_below(&self, model: &LocalizationModel, bound: f64) -> f64 {
        let (mut mass, mut cells) = (0.0, 0_usize);
        let mut add = |value: f64, count: usize| {
            if value < bound {
                mass += value * count as f64;
                cells += count;
            }
        };
        add(self.asleep, self.cells_asleep(model));
        for tile in self.tiles() {
            let free = model.ground.tile(tile.number).into_iter().flat_map(GroundTile::free);
            free.for_each(|cell| add(self.value(tile.cells[cell]), 1));
        }
        mass / cells.max(1) as f64
    }

    /// At least the probability of the likeliest state in the tiles of a plane that some columns and rows meet.
    fn highest_within(
        &self,
        model: &LocalizationModel,
        heading: usize,
        columns: RangeInclusive<i64>,
        rows: RangeInclusive<i64>,
    ) -> f64 {
        let met = |tile: &&Tile| model.grid.meets(tile.number, &columns, &rows);
        let peaks = self.planes[heading].tiles.iter().filter(met).map(|tile| self.value(tile.peak));
        peaks.fold(self.asleep, f64::max)
    }

    /// The plane whose heading is nearest.
    fn plane_at(&self, model: &LocalizationModel, heading_rad: f64) -> usize {
        let steps = libm::round(heading_rad / model.grid.angle_step_rad() - self.heading_offset) as i64;
        steps.rem_euclid(model.grid.headings as i64) as usize
    }
}
