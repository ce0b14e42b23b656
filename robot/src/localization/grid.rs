//! Where the cells of the belief lie.

use crate::geometry::{Point, wrap_angle_rad};
use crate::occupancy::OccupancyGrid;
use std::ops::RangeInclusive;

/// Cells per block: likelihoods are skipped block by block.
pub(super) const BLOCK: usize = 64;

/// Cells along an edge of a tile.
pub(super) const TILE_EDGE: usize = 32;

/// Cells of a tile, `[row][column]`, whole blocks; the table of expected distances for one, all directions, is at
/// most some 360 kB and fits a second-level cache.
pub(super) const TILE: usize = TILE_EDGE * TILE_EDGE;

/// Where a cell of a plane is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    /// Number of the tile, row by row.
    pub tile: usize,
    /// Its number there.
    pub cell: usize,
}

/// One cell of the belief.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct State {
    /// Index of the heading plane.
    pub heading: usize,
    /// Along y.
    pub row: usize,
    /// Along x.
    pub column: usize,
}

/// The belief's cells: planes of equal heading, each `[row][column]` row-major, row 0 at the
/// smallest y. Cell (row, column) has its middle at `origin_in_map` plus whole cells.
///
/// # Deviation
/// The grid is centred on the map and not on a corner of it, so that a pose turned by 180° about
/// the middle of a symmetric building falls on a cell again; otherwise a symmetric corridor looks
/// asymmetric and one of two mirror poses wins without evidence.
#[derive(Clone, Debug, PartialEq)]
pub struct BeliefGrid {
    /// Edge of a cell.
    pub cell_m: f64,
    /// Middle of cell (0, 0).
    pub origin_in_map: Point,
    /// Cells along x.
    pub columns: usize,
    /// Cells along y.
    pub rows: usize,
    /// Heading planes; plane `k` has heading `k · angle_step`.
    pub headings: usize,
}

impl BeliefGrid {
    /// The grid over a map; `angle_step_deg` must divide 360.
    pub(super) fn over(map: &OccupancyGrid, cell_m: f64, angle_step_deg: u32, centred: bool) -> Self {
        let cells_along = |map_cells: usize| {
            let exact = map_cells as f64 * map.resolution_m / cell_m;
            libm::ceil(exact - 1e-9).max(1.0) as usize
        };
        let (columns, rows) = (cells_along(map.columns), cells_along(map.rows));
        let middle = |origin: f64, map_cells: usize| origin + map_cells as f64 * map.resolution_m / 2.0;
        let first = |origin: f64, middle: f64, count: usize| {
            if centred { middle - (count as f64 - 1.0) / 2.0 * cell_m } else { origin + cell_m / 2.0 }
        };
        Self {
            cell_m,
            origin_in_map: Point::new(
                first(map.origin_in_frame.x, middle(map.origin_in_frame.x, map.columns), columns),
                first(map.origin_in_frame.y, middle(map.origin_in_frame.y, map.rows), rows),
            ),
            columns,
            rows,
            headings: (360 / angle_step_deg) as usize,
        }
    }

    /// Cells of one plane, without padding.
    pub fn cells(&self) -> usize {
        self.columns * self.rows
    }

    /// Cells of the whole belief.
    pub fn states(&self) -> usize {
        self.cells() * self.headings
    }

    /// Tiles along x and y.
    pub(super) fn tiles_along(&self) -> [usize; 2] {
        [self.columns.div_ceil(TILE_EDGE), self.rows.div_ceil(TILE_EDGE)]
    }

    /// Tiles that cover a plane.
    pub(super) fn tiles(&self) -> usize {
        let [across, up] = self.tiles_along();
        across * up
    }

    /// By how much the tiles reach beyond the grid to the west and the south: half of what they are larger by, so that
    /// tiles that mirror each other cover mirrored cells (but for one column or row where that is odd).
    fn margins(&self) -> [usize; 2] {
        let [across, up] = self.tiles_along();
        [(across * TILE_EDGE - self.columns) / 2, (up * TILE_EDGE - self.rows) / 2]
    }

    /// Where the cell at a column and row is kept.
    pub(super) fn place(&self, column: usize, row: usize) -> Place {
        let [west, south] = self.margins();
        let (column, row) = (column + west, row + south);
        Place {
            tile: row / TILE_EDGE * self.tiles_along()[0] + column / TILE_EDGE,
            cell: row % TILE_EDGE * TILE_EDGE + column % TILE_EDGE,
        }
    }

    /// Column and row of a cell, which may be beyond the grid.
    pub(super) fn column_and_row(&self, Place { tile, cell }: Place) -> [i64; 2] {
        let [across, _] = self.tiles_along();
        let [west, south] = self.margins();
        let (column, row) =
            (tile % across * TILE_EDGE + cell % TILE_EDGE, tile / across * TILE_EDGE + cell / TILE_EDGE);
        [column as i64 - west as i64, row as i64 - south as i64]
    }

    /// The state of a cell that is on the grid.
    pub(super) fn state(&self, heading: usize, tile: u32, cell: usize) -> State {
        let [column, row] = self.column_and_row(Place { tile: tile as usize, cell });
        State { heading, row: row as usize, column: column as usize }
    }

    /// Whether a tile has cells of some columns and rows.
    pub(super) fn meets(&self, tile: u32, columns: &RangeInclusive<i64>, rows: &RangeInclusive<i64>) -> bool {
        let [column, row] = self.column_and_row(Place { tile: tile as usize, cell: 0 });
        let last = TILE_EDGE as i64 - 1;
        let overlaps = |first: i64, of: &RangeInclusive<i64>| first <= *of.end() && first + last >= *of.start();
        overlaps(column, columns) && overlaps(row, rows)
    }

    /// Angle between two headings.
    pub fn angle_step_rad(&self) -> f64 {
        std::f64::consts::TAU / self.headings as f64
    }

    /// Heading of a plane, in (−π, π].
    pub fn heading_rad(&self, heading: usize) -> f64 {
        wrap_angle_rad(heading as f64 * self.angle_step_rad())
    }

    /// Middle of a cell, in the map frame.
    pub fn centre(&self, column: usize, row: usize) -> Point {
        Point::new(self.origin_in_map.x + column as f64 * self.cell_m, self.origin_in_map.y + row as f64 * self.cell_m)
    }

    /// Middle of a cell, in the map frame.
    pub(super) fn centre_of(&self, place: Place) -> Point {
        let [x_m, y_m] = self.column_and_row(place).map(|along| along as f64 * self.cell_m);
        Point::new(self.origin_in_map.x + x_m, self.origin_in_map.y + y_m)
    }

    /// Column and row, in fractions of a cell, of a point in the map frame.
    pub(super) fn fractional(&self, point_in_map: Point) -> (f64, f64) {
        ((point_in_map.x - self.origin_in_map.x) / self.cell_m, (point_in_map.y - self.origin_in_map.y) / self.cell_m)
    }

    /// Column and row of the cell around a point, if the point is on the grid.
    pub fn cell_at(&self, point_in_map: Point) -> Option<(usize, usize)> {
        let (x, y) = self.fractional(point_in_map);
        let (column, row) = (libm::floor(x + 0.5), libm::floor(y + 0.5));
        let inside = column >= 0.0 && row >= 0.0 && column < self.columns as f64 && row < self.rows as f64;
        inside.then_some((column as usize, row as usize))
    }

    /// The plane nearest to a heading.
    pub fn heading_at(&self, heading_rad: f64) -> usize {
        (libm::round(heading_rad / self.angle_step_rad()) as i64).rem_euclid(self.headings as i64) as usize
    }
}

/// Where the beams of a sensor look, in the directions of its table of expected distances.
#[derive(Clone, Debug, PartialEq)]
pub struct Bearings {
    /// Directions of the table: the coarsest step that meets every beam at every heading.
    pub directions: usize,
    headings: usize,
    /// By how many directions a heading differs from the next.
    heading_step: usize,
    /// Bearing of each beam, in directions.
    bearings: Vec<usize>,
}

impl Bearings {
    /// Of beams with these bearings, on a grid with this number of headings.
    pub(super) fn new(headings: usize, beams_deg: &[i32]) -> Self {
        let beams_deg: Vec<u32> = beams_deg.iter().map(|bearing| bearing.rem_euclid(360) as u32).collect();
        let step_deg = beams_deg.iter().copied().fold(360 / headings as u32, greatest_common_divisor);
        let directions = (360 / step_deg) as usize;
        Self {
            directions,
            headings,
            heading_step: directions / headings,
            bearings: beams_deg.iter().map(|bearing| (bearing / step_deg) as usize).collect(),
        }
    }

    /// Headings of the grid.
    pub(super) fn headings(&self) -> usize {
        self.headings
    }

    /// Beams of one scan.
    pub fn beams(&self) -> usize {
        self.bearings.len()
    }

    /// Which direction of the table beam `beam` reads at heading `heading`.
    pub fn direction(&self, heading: usize, beam: usize) -> usize {
        (heading * self.heading_step + self.bearings[beam]) % self.directions
    }
}

fn greatest_common_divisor(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::occupancy::Cell;

    fn grid(step_deg: u32) -> BeliefGrid {
        let map = OccupancyGrid::filled(Point::new(0.0, 0.0), 0.05, 540, 401, Cell::Free);
        BeliefGrid::over(&map, 0.15, step_deg, true)
    }

    #[test]
    fn a_mirror_pose_falls_on_a_cell() {
        let grid = grid(2);
        let (a, b) = (grid.centre(3, 5), grid.centre(grid.columns - 4, grid.rows - 6));
        assert!((a.x + b.x - 27.0).abs() < 1e-9 && (a.y + b.y - 20.05).abs() < 1e-9);
        assert_eq!(grid.headings % 2, 0);
    }

    #[test]
    fn every_beam_at_every_heading_has_its_own_exact_direction() {
        let ring: Vec<i32> = (0..24).map(|sonar| 15 * sonar).collect();
        let fan: Vec<i32> = (0..13).map(|beam| -90 + 15 * beam).chain([-89, 4]).collect();
        for (beams_deg, step_deg) in
            [&ring, &fan].into_iter().flat_map(|beams| [1, 2, 6, 8, 15].map(|step| (beams, step)))
        {
            let headings = grid(step_deg).headings;
            let bearings = Bearings::new(headings, beams_deg);
            for heading in 0..headings {
                for (beam, bearing_deg) in beams_deg.iter().enumerate() {
                    let degrees = bearings.direction(heading, beam) * 360 / bearings.directions;
                    let exact = (heading as i32 * step_deg as i32 + bearing_deg).rem_euclid(360);
                    assert_eq!(degrees, exact as usize);
                }
            }
        }
    }
}
