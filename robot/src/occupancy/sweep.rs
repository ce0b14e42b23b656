//! Distances along many parallel rays at once. The map is sheared by whole cells until the rays run along its
//! columns or rows; then one pass from the far end tells every cell how far the next surface is.

use super::grid::{Cell, OccupancyGrid};
use crate::geometry::Point;
use std::ops::Range;

/// Far above rounding, far below anything that matters.
const NUDGE_CELLS: f64 = 1e-6;

/// Points are rounded to such parts of a cell, so that two that mirror each other do so exactly.
const PARTS: f64 = 65536.0;

/// How far beyond the edge of a cell its surface is told, as rays that feel their way end on the average: what is
/// fitted to such rays, like the depth of walls, holds for sweeps as well.
const DEPTH_CELLS: f64 = 0.25;

/// A ray that meets nothing.
const NOTHING: u16 = u16::MAX;

/// A map to be swept.
#[derive(Debug)]
pub struct SweepMap {
    resolution_m: f64,
    origin_in_frame: Point,
    /// Its columns, for rays that go rather along x.
    columns: Layers,
    /// Its rows, for the others.
    rows: Layers,
}

/// Columns or rows of a map, which a sweep passes one after the other.
#[derive(Debug)]
struct Layers {
    /// Cells of one.
    lanes: usize,
    /// `[layer][lane]`: 0 where something stands, else all bits.
    free: Vec<u8>,
}

/// Points from which distances are wanted.
#[derive(Debug, Default)]
pub struct SweepPoints {
    /// By columns of the map, from west to east.
    columns: Vec<Line>,
    /// By rows, from south to north.
    rows: Vec<Line>,
}

/// Points in a line across the rays, in cells of the map from its corner.
#[derive(Debug)]
struct Line {
    along: f64,
    /// Where each lies across, growing, and its number.
    points: Vec<(f64, usize)>,
}

/// Which lane of a layer a ray passes.
#[derive(Clone, Copy)]
struct Shear {
    /// Lanes for each layer.
    slope: f64,
    /// The middle of the map, along the rays: about it two mirror rays are sheared alike.
    middle: f64,
    /// A point between two cells belongs to the one ahead and to the left of the ray, so that a map and a ray
    /// turned by 180° give the same distance.
    aside: f64,
    ahead: f64,
}

impl Shear {
    /// Where a ray through a point passes the middle of the map.
    fn across_middle(self, along: f64, across: f64) -> f64 {
        across - self.slope * (along - self.middle) + self.aside
    }

    /// By how many lanes rays have gone aside in a layer.
    fn lanes(self, layer: i64) -> i64 {
        floor(0.5 + self.slope * (layer as f64 + 0.5 - self.middle) + self.aside)
    }

    /// The layer a point lies in.
    fn layer(self, along: f64) -> i64 {
        floor(along + self.ahead)
    }
}

impl SweepMap {
    /// Cost: two passes over the cells, and two bytes for each.
    pub fn new(map: &OccupancyGrid) -> Self {
        let free = |cell: Cell| if cell == Cell::Occupied { 0 } else { u8::MAX };
        let rows: Vec<u8> = map.cells.iter().map(|&cell| free(cell)).collect();
        let mut columns = vec![0; rows.len()];
        transpose(&rows, map.columns, map.rows, &mut columns);
        Self {
            resolution_m: map.resolution_m,
            origin_in_frame: map.origin_in_frame,
            columns: Layers { lanes: map.rows, free: columns },
            rows: Layers { lanes: map.columns, free: rows },
        }
    }

    /// Numbered points, ready to be swept; the fewer columns and rows they lie in, the faster.
    pub fn points(&self, points_in_frame: &[(usize, Point)]) -> SweepPoints {
        let cells = |from: f64, to: f64| libm::round((to - from) / self.resolution_m * PARTS) / PARTS;
        let of = |&(number, point): &(usize, Point)| {
            (cells(self.origin_in_frame.x, point.x), cells(self.origin_in_frame.y, point.y), number)
        };
        let by_column = points_in_frame.iter().map(of).collect();
        let by_row = points_in_frame.iter().map(of).map(|(x, y, number)| (y, x, number)).collect();
        SweepPoints { columns: lines(by_column), rows: lines(by_row) }
    }

    /// Distance from each point to the first occupied cell in a direction `(cos, sin)`, at most `max_m`: to half a
    /// cell and without bias like that of [`DistanceField::cast_m`](super::DistanceField::cast_m), and the same for a
    /// map and rays that are turned by 180°. Space outside the map is empty. `found` is told the number of each point and its
    /// distance. Cost: some tenths of a nanosecond for each cell of the map between the points and `max_m` from
    /// them, and a few nanoseconds for each point.
    pub fn sweep(&self, points: &SweepPoints, (cos, sin): (f64, f64), max_m: f64, mut found: impl FnMut(usize, f64)) {
        let is_steep = libm::fabs(sin) > libm::fabs(cos);
        let (layers, lines) = if is_steep { (&self.rows, &points.rows) } else { (&self.columns, &points.columns) };
        let (ahead, aside) = if is_steep { (sin, cos) } else { (cos, sin) };
        let goes_up = ahead > 0.0;
        let shear = Shear {
            slope: aside / ahead,
            middle: layers.count() as f64 / 2.0,
            aside: if goes_up == is_steep { -NUDGE_CELLS } else { NUDGE_CELLS },
            ahead: if goes_up { NUDGE_CELLS } else { -NUDGE_CELLS },
        };
        let (Some(first), Some(last)) = (lines.first(), lines.last()) else { return };
        let reach = libm::ceil(max_m / self.resolution_m * libm::fabs(ahead)) as i64 + 1;
        let mut layer = if goes_up { shear.layer(last.along) + reach } else { shear.layer(first.along) - reach };
        layer = layer.clamp(0, (layers.count() as i64 - 1).max(0));
        let onward = if goes_up { -1 } else { 1 };
        let mut lanes = Lanes::of(lines, shear);
        let (length_m, depth_m) = (self.resolution_m / libm::fabs(ahead), DEPTH_CELLS * self.resolution_m);
        for number in 0..lines.len() {
            let line = &lines[if goes_up { lines.len() - 1 - number } else { number }];
            let here = shear.layer(line.along);
            while (layer - here) * onward <= 0 {
                lanes.pass(layers, layer, shear.lanes(layer));
                layer += onward;
            }
            let begin = if goes_up { here as f64 - line.along } else { line.along - (here + 1) as f64 };
            for &(across, number) in &line.points {
                let distance_m = match lanes.at(shear.across_middle(line.along, across)) {
                    NOTHING => max_m,
                    0 => 0.0,
                    steps => ((begin + f64::from(steps)) * length_m + depth_m).min(max_m),
                };
                found(number, distance_m);
            }
        }
    }
}

impl Layers {
    fn count(&self) -> usize {
        self.free.len() / self.lanes.max(1)
    }

    /// Those of the lanes of a layer that are on the map.
    fn free(&self, layer: i64, lanes: Range<i64>) -> &[u8] {
        if !(0..self.count() as i64).contains(&layer) {
            return &[];
        }
        let on_map = |lane: i64| lane.clamp(0, self.lanes as i64) as usize;
        &self.free[layer as usize * self.lanes..][on_map(lanes.start)..on_map(lanes.end)]
    }
}

/// Rays side by side: how many layers on each of them meets something.
struct Lanes {
    /// The lane of the first at the middle of the map.
    first: i64,
    steps: Vec<u16>,
}

impl Lanes {
    /// All that begin at some point.
    fn of(lines: &[Line], shear: Shear) -> Self {
        let edges = |line: &Line| {
            let ends = [line.points.first(), line.points.last()];
            ends.map(|end| end.map_or(0.0, |end| shear.across_middle(line.along, end.0)))
        };
        let least = lines.iter().map(|line| edges(line)[0]).fold(f64::INFINITY, f64::min);
        let most = lines.iter().map(|line| edges(line)[1]).fold(f64::NEG_INFINITY, f64::max);
        let first = floor(least);
        Self { first, steps: vec![NOTHING; (floor(most) - first + 1).max(0) as usize] }
    }

    /// Goes one layer back.
    fn pass(&mut self, layers: &Layers, layer: i64, aside: i64) {
        let from = self.first + aside;
        let free = layers.free(layer, from..from + self.steps.len() as i64);
        let begin = (-from).clamp(0, (self.steps.len() - free.len()) as i64) as usize;
        let onward = |steps: &mut u16| *steps = steps.saturating_add(1);
        self.steps[..begin].iter_mut().for_each(onward);
        self.steps[begin + free.len()..].iter_mut().for_each(onward);
        for (steps, &free) in self.steps[begin..].iter_mut().zip(free) {
            *steps = steps.saturating_add(1) & (u16::from(free) << 8 | u16::from(free));
        }
    }

    fn at(&self, across: f64) -> u16 {
        self.steps[(across - self.first as f64) as usize]
    }
}

/// The whole number below, of one that 64 bits hold: `libm::floor` would be called a hundred times for each direction
/// of a tile.
fn floor(number: f64) -> i64 {
    let cut = number as i64;
    cut - i64::from(number < cut as f64)
}

/// Points in lines of equal first coordinate.
fn lines(mut points: Vec<(f64, f64, usize)>) -> Vec<Line> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let of = |line: &[(f64, f64, usize)]| Line {
        along: line[0].0,
        points: line.iter().map(|&(_, across, number)| (across, number)).collect(),
    };
    points.chunk_by(|a, b| a.0 == b.0).map(of).collect()
}

/// Block by block, so that what is read and written stays in the cache.
fn transpose(rows: &[u8], columns: usize, count: usize, out: &mut [u8]) {
    const BLOCK: usize = 32;
    for row in (0..count).step_by(BLOCK) {
        for column in (0..columns).step_by(BLOCK) {
            for row in row..(row + BLOCK).min(count) {
                for column in column..(column + BLOCK).min(columns) {
                    out[column * count + row] = rows[row * columns + column];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::occupancy::DistanceField;
    use rpl_random::Stream;

    const MAX_M: f64 = 2.53;

    fn map(columns: usize, rows: usize, stream: &mut Stream) -> OccupancyGrid {
        let mut map = OccupancyGrid::filled(Point::new(-1.0, 2.0), 0.1, columns, rows, Cell::Free);
        for _ in 0..6 {
            let (column, row) = (stream.index(columns), stream.index(rows));
            for (c, r) in (0..5).flat_map(|c| (0..5).map(move |r| (column + c, row + r))) {
                if c < columns && r < rows {
                    map.set(c, r, Cell::Occupied);
                }
            }
        }
        map
    }

    fn ray(step: usize, steps: usize) -> (f64, f64) {
        let (sin, cos) = libm::sincos(step as f64 * std::f64::consts::TAU / steps as f64);
        (cos, sin)
    }

    fn swept(map: &OccupancyGrid, points: &[(usize, Point)], ray: (f64, f64)) -> Vec<f64> {
        let sweeps = SweepMap::new(map);
        let mut found_m = vec![f64::NAN; points.len()];
        sweeps.sweep(&sweeps.points(points), ray, MAX_M, |number, distance_m| found_m[number] = distance_m);
        found_m
    }

    #[test]
    fn a_sweep_finds_what_rays_meet() {
        let mut stream = Stream::new(10_310, "sweep");
        let (mut near, mut all, mut bias_m) = (0, 0, 0.0);
        for _ in 0..20 {
            let map = map(57, 43, &mut stream);
            let field = DistanceField::new(&map);
            let inside = |_| Point::new(stream.uniform_in(-0.9, 4.6), stream.uniform_in(2.1, 6.2));
            let points: Vec<(usize, Point)> = (0..60).map(inside).enumerate().collect();
            for step in 0..72 {
                let ray = ray(step, 72);
                for (found_m, (_, point)) in swept(&map, &points, ray).into_iter().zip(&points) {
                    let cast_m = field.cast_m(*point, ray, MAX_M);
                    all += 1;
                    // A surface that is met askew is met by half a cell sooner or later, or just passed.
                    if (found_m - cast_m).abs() < 0.1 {
                        near += 1;
                        bias_m += found_m - cast_m;
                    }
                }
            }
        }
        assert!(near * 100 > all * 95, "{near} of {all}");
        assert!((bias_m / f64::from(near)).abs() < 0.003, "{}", bias_m / f64::from(near));
    }

    #[test]
    fn straight_ahead_a_surface_is_told_at_its_depth() {
        let mut map = OccupancyGrid::filled(Point::origin(), 0.1, 30, 20, Cell::Free);
        (0..20).for_each(|row| map.set(25, row, Cell::Occupied));
        (0..30).for_each(|column| map.set(column, 3, Cell::Occupied));
        for (x, y) in [(1.0, 1.0), (0.55, 1.33), (2.2, 1.91), (2.41, 0.44)] {
            let ahead = |ray| swept(&map, &[(0, Point::new(x, y))], ray)[0];
            assert!((ahead((1.0, 0.0)) - (2.525 - x)).abs() < 1e-5, "{x}");
            assert!((ahead((0.0, -1.0)) - (y - 0.375)).abs() < 1e-5, "{y}");
            assert_eq!(ahead((0.0, 1.0)), MAX_M);
            assert_eq!(swept(&map, &[(0, Point::new(x, 0.35))], (0.6, 0.8)), [0.0]);
        }
    }

    #[test]
    fn a_map_turned_by_180_degrees_gives_the_same_distances() {
        let mut stream = Stream::new(10_311, "sweep");
        for (columns, rows) in [(40, 30), (41, 30), (40, 31), (41, 31)] {
            let map = map(columns, rows, &mut stream);
            let turned = OccupancyGrid { cells: map.cells.iter().rev().copied().collect(), ..map.clone() };
            let (width_m, height_m) = (columns as f64 * 0.1, rows as f64 * 0.1);
            // Corners and middles of cells, and what lies between.
            let points: Vec<(usize, Point)> = (0..(columns - 1) * (rows - 1) * 4)
                .map(|at| Point::new(-0.95 + (at % 78) as f64 * 0.05, 2.05 + (at / 78 % 58) as f64 * 0.05))
                .enumerate()
                .collect();
            let mirrored: Vec<(usize, Point)> = points
                .iter()
                .map(|&(number, at)| (number, Point::new(width_m - 2.0 - at.x, height_m + 4.0 - at.y)))
                .collect();
            for step in 0..36 {
                let (cos, sin) = ray(step, 72);
                assert_eq!(swept(&map, &points, (cos, sin)), swept(&turned, &mirrored, (-cos, -sin)), "{step}");
            }
        }
    }

    #[test]
    fn points_swept_together_are_those_swept_alone() {
        let mut stream = Stream::new(10_312, "sweep");
        let map = map(50, 60, &mut stream);
        let inside = |_| Point::new(stream.uniform_in(-0.9, 3.9), stream.uniform_in(2.1, 7.9));
        let points: Vec<(usize, Point)> = (0..200).map(inside).enumerate().collect();
        for step in 0..24 {
            let together = swept(&map, &points, ray(step, 24));
            for (found_m, (_, point)) in together.iter().zip(&points) {
                assert_eq!(*found_m, swept(&map, &[(0, *point)], ray(step, 24))[0]);
            }
        }
    }
}
