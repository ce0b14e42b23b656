//! Which parts of the grid are hallways, and the blocks between them that rooms are in.

use super::area::Area;
use super::bands::Bands;
use super::hallway::Hallway;
use super::interval::{Interval, Millimetres};
use rpl_random::Stream;
use rpl_robot::world::Axis;

/// How often a hallway goes on beyond the outermost crossing, to a blind end.
const BLIND_END: f64 = 0.3;

/// How often a hallway between two crossings is left out, if all others stay connected.
const LEFT_OUT: f64 = 0.2;

/// The grid. A cell is a block (even column, even row), a crossing (odd, odd) or a stretch of hallway between
/// them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Along x.
    pub columns: Bands,
    /// Along y.
    pub rows: Bands,
    /// Whether a cell is the floor of a hallway, row by row.
    is_floor: Vec<bool>,
}

impl Grid {
    /// Two or three hallways along each axis, all of them connected.
    pub fn draw(stream: &mut Stream, walls_mm: Millimetres) -> Self {
        let columns = 2 + stream.index(2);
        let columns = Bands::draw(stream, columns, walls_mm);
        let rows = 2 + stream.index(2);
        let rows = Bands::draw(stream, rows, walls_mm);
        let cells = columns.count() * rows.count();
        let mut grid = Self { columns, rows, is_floor: vec![false; cells] };
        for cell in 0..cells {
            grid.is_floor[cell] =
                grid.is_crossing(cell) || grid.is_stretch(cell) && { !grid.is_outer(cell) || stream.chance(BLIND_END) };
        }
        for cell in 0..cells {
            if grid.is_stretch(cell) && !grid.is_outer(cell) && stream.chance(LEFT_OUT) {
                grid.is_floor[cell] = false;
                grid.is_floor[cell] = !grid.is_connected();
            }
        }
        grid
    }

    /// One hallway along x with stubs of others to both sides: where each crosses is given by the columns, and
    /// whether it goes up and down from there.
    pub fn street(columns: Bands, rows: Bands, stubs: &[(bool, bool)]) -> Self {
        let is_floor = vec![false; columns.count() * rows.count()];
        let mut grid = Self { columns, rows, is_floor };
        for column in 0..grid.columns.count() {
            let cell = grid.columns.count() + column;
            grid.is_floor[cell] = true;
        }
        for (stub, &(up, down)) in stubs.iter().enumerate() {
            let column = 2 * stub + 1;
            let above = 2 * grid.columns.count() + column;
            grid.is_floor[column] = down;
            grid.is_floor[above] = up;
        }
        grid
    }

    fn place(&self, cell: usize) -> (usize, usize) {
        (cell % self.columns.count(), cell / self.columns.count())
    }

    fn is_crossing(&self, cell: usize) -> bool {
        let (column, row) = self.place(cell);
        column % 2 == 1 && row % 2 == 1
    }

    fn is_stretch(&self, cell: usize) -> bool {
        let (column, row) = self.place(cell);
        (column + row) % 2 == 1
    }

    fn is_block(&self, cell: usize) -> bool {
        !self.is_crossing(cell) && !self.is_stretch(cell)
    }

    fn is_outer(&self, cell: usize) -> bool {
        let (column, row) = self.place(cell);
        column == 0 || row == 0 || column + 1 == self.columns.count() || row + 1 == self.rows.count()
    }

    fn is_corner(&self, cell: usize) -> bool {
        let (column, row) = self.place(cell);
        (column == 0 || column + 1 == self.columns.count()) && (row == 0 || row + 1 == self.rows.count())
    }

    /// The cells beside one.
    fn beside(&self, cell: usize) -> impl Iterator<Item = usize> {
        let (column, row) = self.place(cell);
        let (columns, rows) = (self.columns.count(), self.rows.count());
        let left = (column > 0).then(|| cell - 1);
        let right = (column + 1 < columns).then_some(cell + 1);
        let below = (row > 0).then(|| cell - columns);
        let above = (row + 1 < rows).then_some(cell + columns);
        [left, right, below, above].into_iter().flatten()
    }

    /// Whether one can walk from every hallway to every other.
    fn is_connected(&self) -> bool {
        let Some(first) = self.is_floor.iter().position(|is_floor| *is_floor) else { return false };
        let mut seen = vec![false; self.is_floor.len()];
        let mut open = vec![first];
        seen[first] = true;
        while let Some(cell) = open.pop() {
            for next in self.beside(cell) {
                if self.is_floor[next] && !seen[next] {
                    seen[next] = true;
                    open.push(next);
                }
            }
        }
        seen == self.is_floor
    }

    /// The hallways: the longest runs of floor along each axis that are more than a crossing.
    pub fn hallways(&self, walls_mm: Millimetres) -> Vec<Hallway> {
        let (columns, rows) = (self.columns.count(), self.rows.count());
        let mut hallways = Vec::new();
        for row in (1..rows).step_by(2) {
            let is_floor = |column: usize| self.is_floor[row * columns + column];
            for run in runs(columns, is_floor) {
                hallways.push(hallway(Axis::X, &self.columns, run, self.rows.band_mm(row), walls_mm));
            }
        }
        for column in (1..columns).step_by(2) {
            let is_floor = |row: usize| self.is_floor[row * columns + column];
            for run in runs(rows, is_floor) {
                hallways.push(hallway(Axis::Y, &self.rows, run, self.columns.band_mm(column), walls_mm));
            }
        }
        hallways
    }

    /// What is no hallway, as rectangles: each block with the stretches beside it that are left out.
    pub fn blocks(&self) -> Vec<Area> {
        let mut is_taken = self.is_floor.clone();
        let mut blocks = Vec::new();
        let inner = (0..is_taken.len()).filter(|&cell| self.is_block(cell) && !self.is_corner(cell));
        let rest = (0..is_taken.len()).filter(|&cell| !self.is_block(cell) || self.is_corner(cell));
        for cell in inner.chain(rest) {
            if !is_taken[cell] {
                blocks.push(self.grown(cell, &mut is_taken));
            }
        }
        blocks
    }

    /// The rectangle of a cell and of what can be joined to it along one axis, all of which is taken.
    fn grown(&self, cell: usize, is_taken: &mut [bool]) -> Area {
        let (column, row) = self.place(cell);
        let columns = self.columns.count();
        let can_join = |cell: usize, taken: &[bool]| !taken[cell] && (!self.is_block(cell) || self.is_corner(cell));
        let reach = |place: usize, count: usize, free: &dyn Fn(usize) -> bool| {
            let from = (0..place).rev().take_while(|&place| free(place)).last().unwrap_or(place);
            let to = (place + 1..count).take_while(|&place| free(place)).last().unwrap_or(place);
            (from, to)
        };
        let across = reach(column, columns, &|column| can_join(row * columns + column, is_taken));
        let upwards = reach(row, self.rows.count(), &|row| can_join(row * columns + column, is_taken));
        // Outer blocks lie along an edge of the world and grow along it.
        let is_beside = row == 0 || row + 1 == self.rows.count() || upwards == (row, row);
        let ((left, right), (low, high)) = if is_beside { (across, (row, row)) } else { ((column, column), upwards) };
        for row in low..=high {
            for column in left..=right {
                is_taken[row * columns + column] = true;
            }
        }
        let x_mm = (self.columns.band_mm(left).0, self.columns.band_mm(right).1);
        let y_mm = (self.rows.band_mm(low).0, self.rows.band_mm(high).1);
        Area { x_mm, y_mm }
    }
}

/// Maximal runs of more than one band of floor.
fn runs(count: usize, is_floor: impl Fn(usize) -> bool) -> Vec<(usize, usize)> {
    let mut runs = Vec::new();
    let mut from = 0;
    for band in 0..=count {
        if band == count || !is_floor(band) {
            if band > from + 1 {
                runs.push((from, band - 1));
            }
            from = band + 1;
        }
    }
    runs
}

fn hallway(
    axis: Axis,
    along: &Bands,
    (first, last): (usize, usize),
    across_mm: Interval,
    walls_mm: Millimetres,
) -> Hallway {
    let half_mm = walls_mm / 2;
    let clear = |(from_mm, to_mm): Interval| (from_mm + half_mm, to_mm - half_mm);
    Hallway {
        axis,
        along_mm: clear((along.band_mm(first).0, along.band_mm(last).1)),
        across_mm: clear(across_mm),
        sides: [Vec::new(), Vec::new()],
    }
}
