//! Log-odds on an unbounded grid of cells, in tiles that forks share as long as they agree.

use crate::geometry::Point;
use crate::occupancy::{Cell, OccupancyGrid};
use crate::sensors::RangeSensor;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Cells along the edge of a tile.
const TILE: i64 = 32;

/// Parts of a nat in which log-odds are kept.
const PARTS: f64 = 8.0;

/// Log-odds of a cell nothing has been seen of. Never those of one that has been.
const UNSEEN: i8 = i8::MIN;

/// Log-odds are kept within these bounds, so that what goes away is seen to be gone.
const LEAST: i8 = -40;
const MOST: i8 = 48;

/// Log-odds of an unseen cell where an echo is to be explained.
const UNSEEN_NATS: f64 = -1.5;

/// How sure it takes to be to call a cell an obstacle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Confidence {
    /// More than against it.
    Likely,
    /// Much more: an echo or two will not do.
    Certain,
}

impl Confidence {
    fn threshold(self) -> i8 {
        match self {
            Confidence::Likely => 4,
            Confidence::Certain => 24,
        }
    }
}

type Tile = [[i8; TILE as usize]; TILE as usize];

/// For each cell the log-odds that something stands there.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct LogOdds {
    /// The sensor it is as fine as.
    pub sensor: RangeSensor,
    /// Tile (i, j) begins at cell (32 i, 32 j), which begins at the origin of `odom` for i = j = 0.
    tiles: BTreeMap<(i32, i32), Arc<Tile>>,
    seen_cells: u64,
}

/// A cell of the plane, counted from the origin of `odom`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct GridCell {
    pub column: i64,
    pub row: i64,
}

impl GridCell {
    /// The one around a point.
    pub fn around(point_in_odom: Point, cell_m: f64) -> Self {
        let cell = |value_m: f64| libm::floor(value_m / cell_m) as i64;
        Self { column: cell(point_in_odom.x), row: cell(point_in_odom.y) }
    }

    /// Its middle.
    pub fn centre(self, cell_m: f64) -> Point {
        Point::new((self.column as f64 + 0.5) * cell_m, (self.row as f64 + 0.5) * cell_m)
    }

    fn tile(self) -> (i32, i32) {
        (self.column.div_euclid(TILE) as i32, self.row.div_euclid(TILE) as i32)
    }

    fn in_tile(self) -> (usize, usize) {
        (self.row.rem_euclid(TILE) as usize, self.column.rem_euclid(TILE) as usize)
    }
}

impl LogOdds {
    /// Nothing is known of any cell.
    pub fn new(sensor: RangeSensor) -> Self {
        Self { sensor, ..Self::default() }
    }

    /// Edge of a cell. Sonars are not sharper than 10 cm; a gap hardly wider than the robot leaves less
    /// air than a cell of 5 cm.
    pub fn cell_m(&self) -> f64 {
        match self.sensor {
            RangeSensor::Sonar => 0.1,
            RangeSensor::Laser => 0.035,
        }
    }

    /// The cell around a point.
    pub fn around(&self, point_in_odom: Point) -> GridCell {
        GridCell::around(point_in_odom, self.cell_m())
    }

    /// The cells whose centres are so near to a point, in row order.
    pub fn disc(&self, point_in_odom: Point, reach_m: f64) -> impl Iterator<Item = GridCell> + use<> {
        let cell_m = self.cell_m();
        let middle = GridCell::around(point_in_odom, cell_m);
        let reach = libm::ceil(reach_m / cell_m) as i64;
        (-reach..=reach)
            .flat_map(move |row| (-reach..=reach).map(move |column| (column, row)))
            .map(move |(column, row)| GridCell {
                column: middle.column.saturating_add(column),
                row: middle.row.saturating_add(row),
            })
            .filter(move |at| (at.centre(cell_m) - point_in_odom).norm_squared() <= reach_m * reach_m)
    }

    /// How many cells something is known of.
    pub fn seen_cells(&self) -> u64 {
        self.seen_cells
    }

    /// Whether a cell is believed to be an obstacle.
    pub fn is_obstacle(&self, at: GridCell, confidence: Confidence) -> bool {
        self.parts(at) >= confidence.threshold()
    }

    /// The map around these points and all that has been seen, with `margin_m` to spare, but nothing
    /// farther than `most_m` from the first. What has not been seen is free.
    pub fn grid(&self, points_in_odom: &[Point], margin_m: f64, most_m: f64, confidence: Confidence) -> OccupancyGrid {
        let first = points_in_odom.first().map_or(Point::origin(), |&first| first);
        let shift = |by_m: f64| self.around(Point::new(first.x + by_m, first.y + by_m));
        let (least, most) = (shift(-most_m), shift(most_m));
        let corners = self.tiles.keys().flat_map(|&(i, j)| {
            let (column, row) = (i64::from(i) * TILE, i64::from(j) * TILE);
            [GridCell { column, row }, GridCell { column: column + TILE, row: row + TILE }]
        });
        let margin = libm::ceil(margin_m / self.cell_m()) as i64;
        let wanted = points_in_odom.iter().map(|&point| self.around(point)).flat_map(|at| {
            let apart = |by: i64| GridCell { column: at.column.saturating_add(by), row: at.row.saturating_add(by) };
            [apart(-margin), apart(margin)]
        });
        let (mut low, mut high) = (shift(0.0), shift(0.0));
        for at in wanted.chain(corners) {
            low = GridCell { column: low.column.min(at.column), row: low.row.min(at.row) };
            high = GridCell { column: high.column.max(at.column), row: high.row.max(at.row) };
        }
        low = GridCell { column: low.column.max(least.column), row: low.row.max(least.row) };
        high = GridCell { column: high.column.min(most.column), row: high.row.min(most.row) };
        self.window(low, high, confidence)
    }

    fn window(&self, low: GridCell, high: GridCell, confidence: Confidence) -> OccupancyGrid {
        let cell_m = self.cell_m();
        let origin = Point::new(low.column as f64 * cell_m, low.row as f64 * cell_m);
        let (columns, rows) = ((high.column - low.column + 1) as usize, (high.row - low.row + 1) as usize);
        let mut grid = OccupancyGrid::filled(origin, cell_m, columns, rows, Cell::Free);
        for (&(i, j), tile) in &self.tiles {
            for (y, line) in tile.iter().enumerate() {
                for (x, &log_odds) in line.iter().enumerate() {
                    let column = i64::from(i) * TILE + x as i64 - low.column;
                    let row = i64::from(j) * TILE + y as i64 - low.row;
                    let inside = column >= 0 && row >= 0 && column < columns as i64 && row < rows as i64;
                    if inside && log_odds >= confidence.threshold() {
                        grid.set(column as usize, row as usize, Cell::Occupied);
                    }
                }
            }
        }
        grid
    }

    /// Bytes of tiles that an earlier one does not share.
    pub fn bytes_apart(&self, earlier: &Self) -> usize {
        let is_new = |(key, tile): &(&(i32, i32), &Arc<Tile>)| {
            earlier.tiles.get(*key).is_none_or(|known| !Arc::ptr_eq(known, tile))
        };
        self.tiles.iter().filter(is_new).count() * size_of::<Tile>()
    }

    fn parts(&self, at: GridCell) -> i8 {
        let (row, column) = at.in_tile();
        self.tiles.get(&at.tile()).map_or(UNSEEN, |tile| tile[row][column])
    }

    /// The log-odds of a cell, with a guess for one that nothing has been seen of.
    pub fn nats(&self, at: GridCell) -> f64 {
        match self.parts(at) {
            UNSEEN => UNSEEN_NATS,
            parts => f64::from(parts) / PARTS,
        }
    }

    /// Adds what an observation says of a cell.
    pub fn add(&mut self, at: GridCell, nats: f64) {
        let tile = self.tiles.entry(at.tile()).or_insert_with(|| Arc::new([[UNSEEN; TILE as usize]; TILE as usize]));
        let (row, column) = at.in_tile();
        let before = tile[row][column];
        let from = if before == UNSEEN { UNSEEN_NATS * PARTS } else { f64::from(before) };
        let after = libm::round(from + nats * PARTS).clamp(f64::from(LEAST), f64::from(MOST)) as i8;
        if after != before {
            Arc::make_mut(tile)[row][column] = after;
        }
        self.seen_cells += u64::from(before == UNSEEN);
    }
}
