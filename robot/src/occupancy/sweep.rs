//! Distances along many parallel rays at once. The map is sheared by whole cells until the rays run along its
//! columns or rows; then one pass from the far end tells each ray, cell by cell, where it last met something.

use super::grid::{Cell, OccupancyGrid};
use crate::geometry::Point;
use std::ops::Range;

/// Far above rounding, far below anything that matters.
const NUDGE_CELLS: f64 = 1e-6;

/// Points are rounded to parts of a cell, whose number along it is this power of two, so that two that mirror each
/// other do so exactly.
const PARTS_LOG2: u32 = 16;
const PARTS: f64 = (1 << PARTS_LOG2) as f64;

/// How far beyond the edge of a cell its surface is told, as rays that feel their way end on the average: what is
/// fitted to such rays, like the depth of walls, holds for sweeps as well.
const DEPTH_CELLS: f64 = 0.25;

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
    /// Where things stand, layer by layer.
    runs: Vec<Run>,
    /// `[layer][block]` the first run that goes on in a block of lanes or comes after it; the last one of a layer is where
    /// its runs end.
    begins: Vec<u32>,
}

/// Lanes of a block: within them runs are looked for one by one.
const BLOCK: usize = 64;

/// Lanes of a layer, one beside the other, in which something stands.
#[derive(Clone, Copy, Debug)]
struct Run {
    first: u32,
    end: u32,
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
    /// Where each lies across in parts of a cell, growing, and its number.
    points: Vec<(i64, usize)>,
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
    /// By how many parts of a cell a ray through a point of a line is to be moved to where it passes the middle of the map.
    fn parts_to_middle(self, along: f64) -> i64 {
        floor((self.aside - self.slope * (along - self.middle)) * PARTS)
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
    /// Cost: a pass over the cells, and memory for what stands on the map.
    pub fn new(map: &OccupancyGrid) -> Self {
        let (mut columns, mut rows) = (vec![Vec::new(); map.columns], vec![Vec::new(); map.rows]);
        for (row, cells) in map.cells.chunks_exact(map.columns.max(1)).enumerate() {
            for (column, _) in cells.iter().enumerate().filter(|&(_, &cell)| cell == Cell::Occupied) {
                add_lane(&mut rows[row], column as u32);
                add_lane(&mut columns[column], row as u32);
            }
        }
        Self {
            resolution_m: map.resolution_m,
            origin_in_frame: map.origin_in_frame,
            columns: Layers::new(map.rows, &columns),
            rows: Layers::new(map.columns, &rows),
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
    /// map and rays that are turned by 180°. Space outside the map is empty. `found` is told the number of each point and what
    /// `of_range_m` makes of its distance, which is asked once for many that are alike. Cost: some
    /// nanoseconds for each column or row of the map up to `max_m` from the points and for what stands there, and a
    /// nanosecond for each point.
    pub fn sweep<T: Copy>(
        &self,
        points: &SweepPoints,
        (cos, sin): (f64, f64),
        max_m: f64,
        of_range_m: impl Fn(f64) -> T,
        mut found: impl FnMut(usize, T),
    ) {
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
        // By layers up to what is met: the same for all lines that begin alike in their cells, as they do where they are a
        // whole number of cells apart.
        let (mut known, mut known_begin) = (Vec::new(), f64::NAN);
        let nothing = of_range_m(max_m);
        let (length_m, depth_m) = (self.resolution_m / libm::fabs(ahead), DEPTH_CELLS * self.resolution_m);
        for number in 0..lines.len() {
            let line = &lines[if goes_up { lines.len() - 1 - number } else { number }];
            let here = shear.layer(line.along);
            while (layer - here) * onward <= 0 {
                lanes.pass(layers, layer, shear.lanes(layer));
                layer += onward;
            }
            let to_middle = shear.parts_to_middle(line.along);
            let begin = if goes_up { here as f64 - line.along } else { line.along - (here + 1) as f64 };
            if begin != known_begin {
                known_begin = begin;
                known.clear();
                known.resize(reach as usize + 1, None);
            }
            for &(across, number) in &line.points {
                let of_steps = |steps: u32| match steps {
                    0 => of_range_m(0.0),
                    steps => of_range_m(((begin + f64::from(steps)) * length_m + depth_m).min(max_m)),
                };
                let steps = lanes.at((across + to_middle) >> PARTS_LOG2);
                let value = match known.get_mut(steps as usize) {
                    Some(known) => *known.get_or_insert_with(|| of_steps(steps)),
                    // Farther than `max_m`.
                    None => nothing,
                };
                found(number, value);
            }
        }
    }
}

/// Lanes are added one after the other.
fn add_lane(runs: &mut Vec<Run>, lane: u32) {
    match runs.last_mut() {
        Some(run) if run.end == lane => run.end += 1,
        _ => runs.push(Run { first: lane, end: lane + 1 }),
    }
}

impl Layers {
    fn new(lanes: usize, layers: &[Vec<Run>]) -> Self {
        let (mut begins, mut before) = (Vec::new(), 0);
        for runs in layers {
            let mut passed = 0;
            for block in 0..Self::blocks(lanes) {
                passed += runs[passed..].iter().take_while(|run| run.end as usize <= block * BLOCK).count();
                begins.push((before + passed) as u32);
            }
            before += runs.len();
            begins.push(before as u32);
        }
        Self { lanes, runs: layers.concat(), begins }
    }

    fn blocks(lanes: usize) -> usize {
        lanes.div_ceil(BLOCK)
    }

    fn count(&self) -> usize {
        self.begins.len() / (Self::blocks(self.lanes) + 1)
    }

    /// In which of some lanes of a layer things stand, counted from the first of them.
    fn occupied(&self, layer: i64, lanes: Range<i64>) -> impl Iterator<Item = Range<usize>> {
        let on_map = |lane: i64| lane.clamp(0, self.lanes as i64) as u32;
        let [begin, end] = [lanes.start, lanes.end].map(on_map);
        let layer = usize::try_from(layer).ok().filter(|&layer| layer < self.count() && begin < end);
        let runs = layer.map_or(&[][..], |layer| {
            let blocks = &self.begins[layer * (Self::blocks(self.lanes) + 1)..];
            &self.runs[blocks[begin as usize / BLOCK] as usize..blocks[Self::blocks(self.lanes)] as usize]
        });
        let lane = move |lane: u32| (i64::from(lane) - lanes.start) as usize;
        runs.iter()
            .skip_while(move |run| run.end <= begin)
            .take_while(move |run| run.first < end)
            .map(move |run| lane(run.first.max(begin))..lane(run.end.min(end)))
    }
}

/// Rays side by side, and where each meets something.
struct Lanes {
    /// The lane of the first at the middle of the map.
    first: i64,
    /// How many layers had been passed, this one included, when something was met; 0 where nothing was.
    met_at: Vec<u32>,
    passed: u32,
}

impl Lanes {
    /// All that begin at some point.
    fn of(lines: &[Line], shear: Shear) -> Self {
        let edges = lines.iter().filter_map(|line| {
            let lane = |(across, _): &(i64, usize)| (across + shear.parts_to_middle(line.along)) >> PARTS_LOG2;
            Some([line.points.first().map(lane)?, line.points.last().map(lane)?])
        });
        let [first, last] = edges.fold([i64::MAX, i64::MIN], |[a, b], [first, last]| [a.min(first), b.max(last)]);
        Self { first, met_at: vec![0; (last - first + 1) as usize], passed: 0 }
    }

    /// Goes one layer back.
    fn pass(&mut self, layers: &Layers, layer: i64, aside: i64) {
        self.passed += 1;
        let from = self.first + aside;
        for occupied in layers.occupied(layer, from..from + self.met_at.len() as i64) {
            self.met_at[occupied].fill(self.passed);
        }
    }

    /// How many layers on something is met; more than there are if nothing is.
    fn at(&self, lane: i64) -> u32 {
        match self.met_at[(lane - self.first) as usize] {
            0 => u32::MAX,
            met_at => self.passed - met_at,
        }
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
        points: line.iter().map(|&(_, across, number)| ((across * PARTS) as i64, number)).collect(),
    };
    points.chunk_by(|a, b| a.0 == b.0).map(of).collect()
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
        sweeps.sweep(
            &sweeps.points(points),
            ray,
            MAX_M,
            |range_m| range_m,
            |number, range_m| found_m[number] = range_m,
        );
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
