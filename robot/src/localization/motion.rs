//! How the tiles of a plane move, spread, and get a share of other planes: each is made anew of what lies around it.

use super::grid::{BeliefGrid, TILE, TILE_EDGE};
use super::ground::{Cells, Ground};
use super::kernel::{WIDER, Wider};
use super::plane::Plane;
use super::simd::Instructions;
use super::tile::Tile;
use std::sync::Arc;

/// Pending noise is applied once it reaches this variance, in cells².
const BLUR_AT: f64 = 0.04;

/// Largest variance one pass of the three-point blur adds without overshooting.
const BLUR_MOST: f64 = 0.5;

const EDGE: i64 = TILE_EDGE as i64;

/// What lies around the tiles that are awake.
pub(super) struct Surroundings<'m> {
    pub grid: &'m BeliefGrid,
    pub ground: &'m Ground,
    /// What the loops over cells are run with.
    pub instructions: Instructions,
    /// What a cell that sleeps would be stored as.
    pub quiet: f32,
    /// What θ would be stored as: a tile wakes when a cell that can be stood in reaches it.
    pub loud: f32,
}

/// What a plane gets from another one.
pub(super) struct Share<'a> {
    /// The other plane.
    pub plane: &'a Plane,
    /// By how many columns and rows it is moved.
    pub by_cells: [i64; 2],
}

/// Tiles that nobody needs any more, to be written anew: to get memory for new ones and to give back that of old ones
/// takes longer than to write it.
#[derive(Debug, Default)]
pub(super) struct Spare(Vec<Arc<Cells>>);

impl Spare {
    /// Takes over those tiles that no fork shares.
    pub(super) fn keep(&mut self, tiles: Arc<Vec<Tile>>) {
        let cells = Arc::try_unwrap(tiles).unwrap_or_default().into_iter().map(|tile| tile.cells);
        self.0.extend(cells.filter_map(|mut cells| Arc::get_mut(&mut cells).is_some().then_some(cells)));
    }

    fn take(&mut self) -> Arc<Cells> {
        self.0.pop().unwrap_or_else(|| Arc::new([0.0; TILE]))
    }
}

impl Surroundings<'_> {
    /// Brings motion into the cells of a plane: whole cells of the offset, and noise once there is enough.
    pub(super) fn apply_motion(&self, plane: &mut Plane, spare: &mut Spare) {
        let whole = plane.offset_cells.map(libm::round);
        if whole != [0.0; 2] {
            if plane.is_active() {
                let shifted = self.shifted(plane, whole.map(|cells| cells as i64), spare);
                spare.keep(std::mem::replace(&mut plane.tiles, shifted));
            }
            plane.offset_cells[0] -= whole[0];
            plane.offset_cells[1] -= whole[1];
        }
        while plane.variance_cells[0].max(plane.variance_cells[1]) >= BLUR_AT {
            let [x, y] = plane.variance_cells.map(|variance| variance.min(BLUR_MOST));
            if plane.is_active() {
                let blurred = self.blurred(plane, [x, y].map(|variance| (variance / 2.0) as f32), spare);
                spare.keep(std::mem::replace(&mut plane.tiles, blurred));
            }
            plane.variance_cells[0] -= x;
            plane.variance_cells[1] -= y;
        }
    }

    /// The tiles of a plane moved by whole cells. What leaves the tiles in which somebody can stand is lost, and so is
    /// what comes into a tile that sleeps without waking it.
    fn shifted(&self, plane: &Plane, by_cells: [i64; 2], spare: &mut Spare) -> Arc<Vec<Tile>> {
        let reached = self.reached(plane, by_cells, 0);
        self.rebuilt(plane, reached, spare, |_, [column, row], is_awake, cells| {
            self.copy_moved(plane, [column - by_cells[0], row - by_cells[1]], cells);
            is_awake || self.can_wake(cells, 1.0)
        })
    }

    /// Every cell of a plane spread by `[g, 1 − 2g, g]` along each axis: mean 0, variance 2g cells².
    fn blurred(&self, plane: &Plane, spread: [f32; 2], spare: &mut Spare) -> Arc<Vec<Tile>> {
        let reached = self.reached(plane, [0, 0], 1);
        // Made once for a plane: to clear it takes as long as to work with it.
        let mut wider = [[0.0; WIDER]; WIDER];
        self.rebuilt(plane, reached, spare, |_, [column, row], is_awake, cells| {
            self.copy_wider(plane, [column / EDGE, row / EDGE], &mut wider);
            let is_due = is_awake || self.can_wake(wider.as_flattened(), spread[0] + spread[1]);
            if is_due {
                self.instructions.spread(&wider, spread, cells);
            }
            is_due
        })
    }

    /// 1 − 2g of a plane and g of each of two others.
    pub(super) fn blended(&self, own: &Plane, others: &[Share; 2], spread: f32, spare: &mut Spare) -> Arc<Vec<Tile>> {
        let mut reached = self.reached(own, [0, 0], 0);
        others.iter().for_each(|other| reached.extend(self.reached(other.plane, other.by_cells, 0)));
        reached.sort_unstable();
        reached.dedup();
        let shares = [&Share { plane: own, by_cells: [0, 0] }, &others[0], &others[1]];
        let mut copies = [[0.0; TILE]; 3];
        self.rebuilt(own, reached, spare, |number, corner, is_awake, cells| {
            let [copy, copy_before, copy_after] = &mut copies;
            let [of_own, of_before, of_after] = shares;
            let before = self.seen(of_before, number, corner, copy_before);
            let after = self.seen(of_after, number, corner, copy_after);
            if !(is_awake || self.can_wake(before, 2.0 * spread) || self.can_wake(after, 2.0 * spread)) {
                return false;
            }
            let own = self.seen(of_own, number, corner, copy);
            self.instructions.blend([own, before, after], spread, cells);
            true
        })
    }

    /// The cells of a tile as another plane has them: its own where they are awake and not moved, else a copy.
    fn seen<'a>(&self, share: &Share<'a>, number: u32, [column, row]: [i64; 2], copy: &'a mut Cells) -> &'a Cells {
        match share.plane.tile(number).filter(|_| share.by_cells == [0, 0]) {
            Some(tile) => &tile.cells,
            None => {
                self.copy_moved(share.plane, [column - share.by_cells[0], row - share.by_cells[1]], copy);
                copy
            }
        }
    }

    /// The mean of some planes.
    pub(super) fn averaged(&self, planes: &[Share]) -> Arc<Vec<Tile>> {
        let mut reached: Vec<u32> =
            planes.iter().flat_map(|share| self.reached(share.plane, share.by_cells, 0)).collect();
        reached.sort_unstable();
        reached.dedup();
        let each = 1.0 / planes.len() as f32;
        let mut moved = [0.0; TILE];
        self.rebuilt(&Plane::default(), reached, &mut Spare::default(), |_, [column, row], _, cells| {
            cells.fill(0.0);
            for Share { plane, by_cells } in planes {
                self.copy_moved(plane, [column - by_cells[0], row - by_cells[1]], &mut moved);
                cells.iter_mut().zip(&moved).for_each(|(cell, value)| *cell += each * value);
            }
            true
        })
    }

    /// The tiles that were awake, and those that wake: `make` writes the cells of the tile of a number and at a corner, and
    /// says whether it was awake or may wake.
    fn rebuilt(
        &self,
        plane: &Plane,
        reached: Vec<u32>,
        spare: &mut Spare,
        mut make: impl FnMut(u32, [i64; 2], bool, &mut Cells) -> bool,
    ) -> Arc<Vec<Tile>> {
        let [across, _] = self.grid.tiles_along().map(|count| count as i64);
        let mut made = spare.take();
        let tile = |number: u32| {
            let ground = self.ground.tile(number)?;
            let corner = [i64::from(number) % across * EDGE, i64::from(number) / across * EDGE];
            let is_awake = plane.tile(number).is_some();
            if !make(number, corner, is_awake, Arc::get_mut(&mut made)?) {
                return None;
            }
            let mut free = made.iter().zip(&ground.admissible);
            let stays = is_awake || free.any(|(cell, admissible)| cell * admissible >= self.loud);
            stays.then(|| Tile::to_be_weighed(number, std::mem::replace(&mut made, spare.take())))
        };
        Arc::new(reached.into_iter().filter_map(tile).collect())
    }

    /// Numbers of the tiles that the tiles of a plane get into when they are moved and spread by `around` cells,
    /// growing.
    fn reached(&self, plane: &Plane, by_cells: [i64; 2], around: i64) -> Vec<u32> {
        if plane.tiles.len() == self.ground.numbers().len() {
            return self.ground.numbers().to_vec();
        }
        let [across, up] = self.grid.tiles_along().map(|count| count as i64);
        let [columns, rows] =
            by_cells.map(|by| (by - around).div_euclid(EDGE)..=(by + around + EDGE - 1).div_euclid(EDGE));
        let mut reached = Vec::new();
        for tile in plane.tiles.iter() {
            let (column, row) = (i64::from(tile.number) % across, i64::from(tile.number) / across);
            for row in rows.clone().map(|by| row + by).filter(|row| (0..up).contains(row)) {
                let columns = columns.clone().map(|by| column + by).filter(|column| (0..across).contains(column));
                reached.extend(columns.map(|column| (row * across + column) as u32));
            }
        }
        reached.sort_unstable();
        reached.dedup();
        reached
    }

    /// Whether a share of some cells, beside ones that sleep, may reach θ.
    fn can_wake(&self, cells: &[f32], share: f32) -> bool {
        let bound = (self.loud - self.quiet) / share;
        cells.iter().fold(false, |any, &cell| any | (cell >= bound))
    }

    /// Writes the cells of a plane in the square of a tile whose first column and row are counted from the first tile.
    ///
    /// The square lies over four tiles of the plane, or fewer. Of two beside each other the one with more columns is
    /// copied in one run from its first cell to its last, over those of the other, which come after it column by column:
    /// most squares differ from a tile by a column or two, and to begin a copy anew for each row takes as long as the
    /// copies.
    fn copy_moved(&self, plane: &Plane, [column, row]: [i64; 2], cells: &mut Cells) {
        let [tile_column, tile_row] = [column, row].map(|first| first.div_euclid(EDGE));
        // Where the square begins in the first tiles, and also how many of its columns and rows lie beyond them.
        let [across, up] = [column, row].map(|first| first.rem_euclid(EDGE) as usize);
        let of_rows = [(tile_row, up, 0, TILE_EDGE - up), (tile_row + 1, 0, TILE_EDGE - up, up)];
        for (tile_row, from, to, rows) in of_rows.into_iter().filter(|&(.., rows)| rows > 0) {
            let [from, to] = [from, to].map(|row| row * TILE_EDGE);
            let cells = &mut cells[to..][..rows * TILE_EDGE];
            let part = |tile_column: i64| {
                let Stored { cells, factor } = self.stored(plane, [tile_column, tile_row]);
                (&cells[from..][..rows * TILE_EDGE], factor)
            };
            let (first, next) = (part(tile_column), (across > 0).then(|| part(tile_column + 1)));
            let columns = TILE_EDGE - across;
            match next {
                Some((next, factor)) if across > columns => {
                    copy_times(&next[..cells.len() - columns], factor, &mut cells[columns..]);
                    copy_columns(first.0, first.1, cells, [across, 0], columns);
                }
                _ => {
                    copy_times(&first.0[across..], first.1, &mut cells[..rows * TILE_EDGE - across]);
                    next.into_iter().for_each(|(next, factor)| copy_columns(next, factor, cells, [0, columns], across));
                }
            }
        }
    }

    /// Writes the cells of a tile of a plane, which is counted along columns and rows, and those around it.
    fn copy_wider(&self, plane: &Plane, [tile_column, tile_row]: [i64; 2], wider: &mut Wider) {
        for (by, from, to, rows) in [(-1, TILE_EDGE - 1, 0, 1), (0, 0, 1, TILE_EDGE), (1, 0, TILE_EDGE + 1, 1)] {
            let [west, here, east] = [-1, 0, 1].map(|along| self.stored(plane, [tile_column + along, tile_row + by]));
            let [west_rows, here_rows, east_rows] =
                [west, here, east].map(|stored| &stored.cells.as_chunks::<TILE_EDGE>().0[from..]);
            let beside = here_rows.iter().zip(west_rows.iter().zip(east_rows));
            for ([first, middle @ .., last], (row, (west_row, east_row))) in wider[to..][..rows].iter_mut().zip(beside)
            {
                *first = west.factor * west_row[TILE_EDGE - 1];
                copy_times(row, here.factor, middle);
                *last = east.factor * east_row[0];
            }
        }
    }

    /// A tile of a plane, counted along columns and rows, also beyond the map.
    fn stored<'a>(&'a self, plane: &'a Plane, [column, row]: [i64; 2]) -> Stored<'a> {
        let [across, up] = self.grid.tiles_along().map(|count| count as i64);
        let is_inside = (0..up).contains(&row) && (0..across).contains(&column);
        let number = (row * across + column) as u32;
        match self.ground.tile(number).filter(|_| is_inside) {
            Some(ground) => match plane.tile(number) {
                Some(tile) => Stored { cells: &tile.cells, factor: 1.0 },
                None => Stored { cells: &ground.admissible, factor: self.quiet },
            },
            None => Stored { cells: &NOBODY, factor: 1.0 },
        }
    }
}

/// A tile in which nobody can stand.
static NOBODY: Cells = [0.0; TILE];

/// The cells of a tile as they are stored, each times a factor.
#[derive(Clone, Copy)]
struct Stored<'a> {
    cells: &'a Cells,
    factor: f32,
}

fn copy_times(from: &[f32], factor: f32, to: &mut [f32]) {
    if factor == 1.0 {
        to.copy_from_slice(from);
    } else {
        to.iter_mut().zip(from).for_each(|(to, from)| *to = factor * from);
    }
}

/// Copies some columns of rows of tiles, from the first one to the second one.
fn copy_columns(from: &[f32], factor: f32, to: &mut [f32], [first_from, first_to]: [usize; 2], columns: usize) {
    let (from, to) = (from.as_chunks::<TILE_EDGE>().0, to.as_chunks_mut::<TILE_EDGE>().0);
    for column in 0..columns {
        let rows = to.iter_mut().zip(from);
        rows.for_each(|(to, from)| to[first_to + column] = factor * from[first_from + column]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;
    use crate::occupancy::{Cell, OccupancyGrid};
    use rpl_random::Stream;

    /// A grid of some tiles, with walls in it and a tile in which nobody can stand.
    fn grid_and_ground() -> (BeliefGrid, Ground) {
        let map = OccupancyGrid::filled(Point::origin(), 0.1, 107, 78, Cell::Free);
        let grid = BeliefGrid::over(&map, 0.1, 90, true);
        let ground = Ground::new(&grid, |column, row| (column > 35 || row > 40) && column % 13 != 0 && row % 17 != 3);
        assert!(ground.numbers().len() < grid.tiles());
        (grid, ground)
    }

    /// What one cell of a plane is stored as, also outside the map.
    fn stored(around: &Surroundings, plane: &Plane, [column, row]: [i64; 2]) -> f32 {
        let [across, up] = around.grid.tiles_along().map(|count| count as i64 * EDGE);
        if !(0..across).contains(&column) || !(0..up).contains(&row) {
            return 0.0;
        }
        let tile = (row / EDGE * (across / EDGE) + column / EDGE) as u32;
        let cell = (row % EDGE * EDGE + column % EDGE) as usize;
        let asleep = around.ground.tile(tile).map_or(0.0, |ground| ground.admissible[cell] * around.quiet);
        plane.tile(tile).map_or(asleep, |tile| tile.cells[cell])
    }

    /// Some tiles awake, with cells above θ and below it.
    fn plane(ground: &Ground, stream: &mut Stream) -> Plane {
        let awake = ground.tiles().filter(|_| stream.uniform() < 0.4).map(|(number, tile)| (number, tile.admissible));
        let awake: Vec<(u32, Cells)> = awake.collect();
        let value =
            |stream: &mut Stream| if stream.uniform() < 0.1 { stream.uniform() } else { 1e-4 * stream.uniform() };
        let tiles =
            awake.into_iter().map(|(number, cells)| Tile::new(number, cells.map(|cell| cell * value(stream) as f32)));
        Plane::of(tiles.collect())
    }

    /// Compares tiles with what each of their cells is to be; one that sleeps may have none at θ. Tells how many woke, and
    /// how many sleep.
    fn check(
        around: &Surroundings,
        before: &Plane,
        after: Arc<Vec<Tile>>,
        due: impl Fn([i64; 2]) -> f32,
    ) -> [usize; 2] {
        let after = Plane { tiles: after, ..Plane::default() };
        let (mut woken, mut slept) = (0, 0);
        for (number, ground) in around.ground.tiles() {
            let across = around.grid.tiles_along()[0] as u32;
            let corner = [number % across, number / across].map(|at| i64::from(at) * EDGE);
            let due = |cell: usize| due([corner[0] + cell as i64 % EDGE, corner[1] + cell as i64 / EDGE]);
            match after.tile(number) {
                Some(tile) => {
                    woken += usize::from(before.tile(number).is_none());
                    for (cell, found) in tile.cells.iter().enumerate() {
                        assert!(
                            (found - due(cell)).abs() <= 1e-6 * due(cell),
                            "{number} {cell}: {found} {}",
                            due(cell)
                        );
                    }
                }
                None => {
                    slept += 1;
                    ground.free().for_each(|cell| assert!(due(cell) < 1.000_001 * around.loud, "{number} {cell}"));
                }
            }
        }
        [woken, slept]
    }

    #[test]
    fn tiles_are_moved_spread_and_blended_like_a_plane_of_single_cells_and_wake_where_a_cell_reaches_the_threshold() {
        let (grid, ground) = grid_and_ground();
        let around = Surroundings {
            grid: &grid,
            ground: &ground,
            instructions: Instructions::fastest(),
            quiet: 1e-5,
            loud: 1e-2,
        };
        let mut stream = Stream::new(10_320, "tiles");
        // With what others have left in them.
        let mut spare = Spare::default();
        spare.keep(plane(&ground, &mut stream).tiles);
        let mut counts = [0, 0];
        let mut count = |more: [usize; 2]| counts = [counts[0] + more[0], counts[1] + more[1]];
        for by in [[1, 0], [-2, 3], [31, -33], [-40, 0], [0, 65]] {
            let [own, before, after] = [0; 3].map(|_| plane(&ground, &mut stream));
            let at = |plane: &Plane, [column, row]: [i64; 2], by: [i64; 2]| {
                stored(&around, plane, [column - by[0], row - by[1]])
            };
            count(check(&around, &own, around.shifted(&own, by, &mut spare), |place| at(&own, place, by)));
            let spread = [0.1, 0.2];
            count(check(&around, &own, around.blurred(&own, spread, &mut spare), |place| {
                let along_x = |dy: i64| {
                    let [left, middle, right] = [-1, 0, 1].map(|dx| at(&own, place, [-dx, -dy]));
                    (1.0 - 2.0 * spread[0]) * middle + spread[0] * (left + right)
                };
                (1.0 - 2.0 * spread[1]) * along_x(0) + spread[1] * (along_x(-1) + along_x(1))
            }));
            let back = by.map(|cells| -cells);
            let shares = [Share { plane: &before, by_cells: by }, Share { plane: &after, by_cells: back }];
            count(check(&around, &own, around.blended(&own, &shares, 0.2, &mut spare), |place| {
                0.6 * at(&own, place, [0, 0]) + 0.2 * (at(&before, place, by) + at(&after, place, back))
            }));
        }
        assert!(counts[0] > 10 && counts[1] > 10, "{counts:?} woke and sleep");
    }

    #[test]
    fn a_blur_keeps_mass_and_mean_and_adds_its_variance() {
        let (grid, ground) = grid_and_ground();
        let around = Surroundings {
            grid: &grid,
            ground: &ground,
            instructions: Instructions::fastest(),
            quiet: 0.0,
            loud: 1e-9,
        };
        // In the corner of a tile, so that it spreads over four.
        let mut cells = [0.0; TILE_EDGE * TILE_EDGE];
        cells[0] = 1.0;
        let across = grid.tiles_along()[0];
        let plane = Plane::of(vec![Tile::new(across as u32 + 2, cells)]);
        let blurred = around.blurred(&plane, [0.1, 0.2], &mut Spare::default());
        assert_eq!(blurred.len(), 4);
        let moment = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
            let of_tile = |tile: &Tile| -> f64 {
                let corner = [tile.number as usize % across, tile.number as usize / across];
                let [x, y] = [0, 1].map(|axis| (corner[axis] as f64 - [2.0, 1.0][axis]) * EDGE as f64);
                let cells = tile.cells.iter().enumerate();
                let at = |cell: usize| (x + (cell % TILE_EDGE) as f64, y + (cell / TILE_EDGE) as f64);
                cells.map(|(cell, &value)| f64::from(value) * of(at(cell).0, at(cell).1)).sum()
            };
            blurred.iter().map(of_tile).sum()
        };
        assert!((moment(&|_, _| 1.0) - 1.0).abs() < 1e-6);
        assert!(moment(&|x, _| x).abs() < 1e-6 && moment(&|_, y| y).abs() < 1e-6);
        assert!((moment(&|x, _| x * x) - 0.2).abs() < 1e-6 && (moment(&|_, y| y * y) - 0.4).abs() < 1e-6);
    }
}
