//! The distances to be expected from the map, for every cell and direction: a tile of cells at a time, when it is
//! first asked for. A belief looks at the tiles it lies in, and a map may have thousands of others.

use super::grid::{BeliefGrid, Place, TILE};
use super::ground::Ground;
use super::scan_parameters::BeamParameters;
use super::sensor::{self, NO_ECHO};
use crate::geometry::Point;
use crate::occupancy::{DistanceField, SweepMap};
use std::sync::{Arc, OnceLock};

/// Expected bins of one tile, cone by cone. A table keeps the cones around every direction or, where two of them together
/// are the one between them, around every other direction.
pub(super) type TileBins = [[u8; TILE]];

/// The two cones that together are the one around a direction; the same one twice where it is kept.
pub(super) type Cones = [usize; 2];

/// What is expected from a cell in two cones together.
pub(super) fn bin_at(bins: &TileBins, cones: Cones, cell: usize) -> u8 {
    let [one, other] = cones.map(|cone| bins[cone][cell]);
    one.min(other)
}

/// The table. What it holds follows from the map alone, whoever asks for it and when.
#[derive(Debug)]
pub(super) struct ExpectedBins {
    sweeps: Arc<SweepMap>,
    grid: BeliefGrid,
    /// Which cells can be stood in; of the others nothing is known.
    ground: Arc<Ground>,
    directions: usize,
    /// Cosine and sine of each direction.
    along: Vec<(f64, f64)>,
    /// Rays from the middle of a cone to its edge.
    half_cone: usize,
    max_range_m: f64,
    mount_radius_m: f64,
    /// What is read together lies together.
    tiles: Vec<OnceLock<Box<TileBins>>>,
}

impl ExpectedBins {
    /// Nothing is computed yet.
    pub(super) fn new(
        sweeps: Arc<SweepMap>,
        grid: &BeliefGrid,
        directions: usize,
        ground: &Arc<Ground>,
        beam: &BeamParameters,
    ) -> Self {
        let mut tiles = Vec::new();
        tiles.resize_with(grid.tiles(), OnceLock::new);
        Self {
            sweeps,
            grid: grid.clone(),
            ground: ground.clone(),
            directions,
            along: (0..directions).map(|direction| direction_of(direction, directions)).collect(),
            half_cone: directions * beam.cone_deg as usize / 720,
            max_range_m: beam.max_range_m,
            mount_radius_m: beam.mount_radius_m,
            tiles,
        }
    }

    /// The cells that can be stood in, row by row of the map.
    fn admissible_cells(&self) -> impl Iterator<Item = Place> {
        let columns = self.grid.columns;
        let places = (0..self.grid.cells()).map(move |cell| self.grid.place(cell % columns, cell / columns));
        places.filter(|&place| self.ground.is_free(place))
    }

    /// `count` of the cells that can be stood in, spread evenly over them, row by row of the map; where there are
    /// fewer, some several times.
    pub(super) fn spread_cells(&self, count: usize) -> Vec<Place> {
        let all = self.ground.cells();
        let mut wanted = (0..count).map(|number| number * all / count).peekable();
        let mut cells = Vec::with_capacity(count);
        for (index, place) in self.admissible_cells().enumerate() {
            while wanted.next_if_eq(&index).is_some() {
                cells.push(place);
            }
        }
        cells
    }

    /// What is expected in one direction from a cell, without the table: by rays that are cast one by one.
    pub(super) fn cast(&self, distances: &DistanceField, place: Place, direction: usize) -> u8 {
        let centre = self.grid.centre_of(place);
        let in_cone = self.directions - self.half_cone..=self.directions + self.half_cone;
        let rays =
            in_cone.map(|step| (direction + step) % self.directions).filter(|ray| ray.is_multiple_of(self.stride()));
        // None needs to go farther than the nearest surface before it.
        let nearest_m = rays.fold(self.max_range_m + self.mount_radius_m, |nearest_m, ray| {
            f64::min(nearest_m, distances.cast_m(centre, self.along[ray], nearest_m))
        });
        sensor::bin(nearest_m - self.mount_radius_m, self.max_range_m)
    }

    /// Expected bins of one tile; computed if nobody asked before, which takes a millisecond.
    pub(super) fn tile(&self, tile: u32) -> &TileBins {
        self.tiles[tile as usize].get_or_init(|| self.swept(tile))
    }

    /// The first direction whose cone is kept, and every how many-th one from there is. Where every other ray is left
    /// out, a cone has one ray more around every other direction: it is the two cones beside it together.
    fn kept(&self) -> [usize; 2] {
        let stride = self.stride();
        [(self.half_cone + 1) % stride, stride]
    }

    /// Where to look for what is expected in a direction.
    pub(super) fn cones(&self, direction: usize) -> Cones {
        let [first, stride] = self.kept();
        let off = (direction + self.directions - first) % stride;
        [direction + self.directions - off, direction + off].map(|kept| kept % self.directions / stride)
    }

    /// The nearest surface in the cone around each direction that is kept.
    fn swept(&self, tile: u32) -> Box<TileBins> {
        let place = |cell| Place { tile: tile as usize, cell };
        let free = (0..TILE).filter(|&cell| self.ground.is_free(place(cell)));
        let points: Vec<(usize, Point)> = free.map(|cell| (cell, self.grid.centre_of(place(cell)))).collect();
        let points = self.sweeps.points(&points);
        let count = self.directions / self.stride();
        // After the last ones the first ones come once more, as many as a cone has.
        let mut rays = vec![[NO_ECHO; TILE]; count + 2 * self.half_cone / self.stride()];
        for (number, bins) in rays[..count].iter_mut().enumerate() {
            let ray = self.along[number * self.stride()];
            let bin = |range_m: f64| sensor::bin(range_m - self.mount_radius_m, self.max_range_m);
            self.sweeps.sweep(&points, ray, self.max_range_m + self.mount_radius_m, bin, |cell, bin| bins[cell] = bin);
        }
        for number in count..rays.len() {
            rays[number] = rays[number % count];
        }
        self.widened_to_cones(rays)
    }

    /// A cone of many rays loses nothing if every other one is left out.
    fn stride(&self) -> usize {
        if self.half_cone >= 4 && self.directions.is_multiple_of(2) { 2 } else { 1 }
    }

    /// The smallest bin within half a cone on either side of each direction that is kept: the smaller one of two runs of
    /// rays, which together are the cone.
    fn widened_to_cones(&self, mut runs: Vec<[u8; TILE]>) -> Box<TileBins> {
        let [first, stride] = self.kept();
        let levels = ((2 * self.half_cone + 1) / stride).ilog2();
        for half in (0..levels).map(|level| 1 << level) {
            for first in 0..runs.len() - half {
                let (run, beside) = runs.split_at_mut(first + half);
                run[first] = smaller(&run[first], &beside[0]);
            }
        }
        let cone = |direction: usize| {
            let here = direction + self.directions;
            let (first, last) = ((here - self.half_cone).div_ceil(stride), (here + self.half_cone) / stride);
            let turn = self.directions / stride;
            let begin = first % turn;
            smaller(&runs[begin], &runs[begin + last - first + 1 - (1 << levels)])
        };
        (first..self.directions).step_by(stride).map(cone).collect()
    }
}

/// Bin by bin.
fn smaller(a: &[u8; TILE], b: &[u8; TILE]) -> [u8; TILE] {
    std::array::from_fn(|cell| a[cell].min(b[cell]))
}

/// Cosine and sine of a direction; opposite ones are so to the last bit.
fn direction_of(direction: usize, directions: usize) -> (f64, f64) {
    if directions.is_multiple_of(2) && direction >= directions / 2 {
        let (cos, sin) = direction_of(direction - directions / 2, directions);
        return (-cos, -sin);
    }
    let (sin, cos) = libm::sincos(direction as f64 * std::f64::consts::TAU / directions as f64);
    (cos, sin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::localization::{LocalizationModel, LocalizationParameters};
    use crate::occupancy::{Cell, OccupancyGrid};
    use crate::world::World;
    use rpl_random::Stream;

    /// A walled corridor with two cupboards, each the other's image under half a turn.
    fn symmetric_corridor(columns: usize, rows: usize) -> OccupancyGrid {
        let mut map = OccupancyGrid::filled(Point::origin(), 0.1, columns, rows, Cell::Free);
        for (column, row) in (0..columns).flat_map(|column| (0..rows).map(move |row| (column, row))) {
            let is_wall = column == 0 || column == columns - 1 || row == 0 || row == rows - 1;
            let is_cupboard = |column: usize, row: usize| (30..38).contains(&column) && row < 10;
            if is_wall || is_cupboard(column, row) || is_cupboard(columns - 1 - column, rows - 1 - row) {
                map.set(column, row, Cell::Occupied);
            }
        }
        map
    }

    #[test]
    fn mirror_poses_expect_the_same() {
        // Cells whose middles are middles, edges and corners of cells of the map, and neither.
        for (columns, rows, cell_m) in [(120, 30, 0.3), (121, 30, 0.2), (120, 31, 0.2), (121, 31, 0.17)] {
            let parameters = LocalizationParameters { cell_m, angle_step_deg: 6, ..LocalizationParameters::default() };
            let model = LocalizationModel::new(&symmetric_corridor(columns, rows), parameters).expect("it is a map");
            let (grid, sensor) = (&model.grid, &model.sensors[0]);
            for (column, row) in (0..grid.cells()).map(|cell| (cell % grid.columns, cell / grid.columns)) {
                let (place, twin) =
                    (grid.place(column, row), grid.place(grid.columns - 1 - column, grid.rows - 1 - row));
                assert_eq!(model.ground.is_free(place), model.ground.is_free(twin));
                for heading in (0..grid.headings / 2).filter(|_| model.ground.is_free(place)) {
                    let mirrored = sensor.expected_scan(heading + grid.headings / 2, twin);
                    assert_eq!(sensor.expected_scan(heading, place), mirrored, "{columns} {rows} {place:?} {heading}");
                }
            }
        }
    }

    #[test]
    fn a_tile_is_the_same_whenever_it_is_asked_for() {
        let parameters =
            LocalizationParameters { cell_m: 0.1, angle_step_deg: 15, ..LocalizationParameters::default() };
        let model = || LocalizationModel::new(&symmetric_corridor(120, 30), parameters.clone()).expect("it is a map");
        let (one, other) = (model(), model());
        let [one, other] = [&one, &other].map(|model| model.sensors[0].expected());
        let numbers = 0..one.tiles.len() as u32;
        assert!(one.tiles.len() > 2 && one.tiles.iter().all(|tile| tile.get().is_none()));
        numbers.clone().for_each(|tile| assert!(one.tile(tile).len() == one.directions / one.stride()));
        for tile in numbers.rev() {
            assert!(other.tile(tile) == one.tile(tile) && other.tiles[tile as usize].get().is_some());
        }
    }

    #[test]
    fn a_cone_sees_the_nearest_of_its_rays() {
        let mut stream = Stream::new(10_321, "rays");
        for (cone_deg, angle_step_deg) in [(0, 15), (5, 5), (15, 2), (15, 6), (16, 2), (30, 2)] {
            let mut parameters = LocalizationParameters { angle_step_deg, ..LocalizationParameters::default() };
            parameters.sensors[0].beam.cone_deg = cone_deg;
            let model = LocalizationModel::new(&symmetric_corridor(120, 30), parameters).expect("it is a map");
            let table = model.sensors[0].expected();
            let (stride, half) = (table.stride(), table.half_cone);
            let count = table.directions / stride;
            let mut rays: Vec<[u8; TILE]> = (0..count).map(|_| [stream.index(256) as u8; TILE]).collect();
            rays.extend_from_within(..2 * half / stride);
            let cones = table.widened_to_cones(rays.clone());
            for direction in 0..table.directions {
                let around = direction + table.directions - half..=direction + table.directions + half;
                let seen = around.filter(|ray| ray.is_multiple_of(stride)).map(|ray| rays[ray / stride % count][7]);
                assert_eq!(
                    Some(bin_at(&cones, table.cones(direction), 7)),
                    seen.min(),
                    "{cone_deg} {angle_step_deg} {direction}"
                );
            }
        }
    }

    #[test]
    fn bins_are_those_of_rays_that_are_cast_one_by_one() {
        let map = World::builtin("dept").expect("it is built in").map_centred(0.05);
        let model = LocalizationModel::new(&map, LocalizationParameters::default()).expect("it is a map");
        let table = model.sensors[0].expected();
        let (mut apart, mut farther) = ([0usize; 256], 0);
        for place in table.admissible_cells().step_by(53) {
            for direction in 0..table.directions {
                let nearest = table.cast(&model.distances, place, direction);
                let swept = bin_at(table.tile(place.tile as u32), table.cones(direction), place.cell);
                apart[usize::from(swept.abs_diff(nearest))] += 1;
                if swept.abs_diff(nearest) <= 3 {
                    farther += i32::from(swept) - i32::from(nearest);
                }
            }
        }
        let all: usize = apart.iter().sum();
        let within = |bins: usize| apart[..=bins].iter().sum::<usize>() as f64 / all as f64;
        assert!(within(1) > 0.85 && within(3) > 0.96, "{} {} {}", within(0), within(1), within(3));
        assert!((farther as f64 / all as f64).abs() < 0.1, "{farther}");
    }
}
