//! The value of every cell for a target, and the paths that follow from it.

use super::planner::{CostGrid, MOVES, OPEN_FLOOR};
use crate::geometry::{Point, distance_m};
use std::sync::Arc;

/// Value of a cell from which the target cannot be reached.
const UNREACHABLE: u32 = u32::MAX;

/// A straight move on open floor, the least a move can cost. A diagonal one costs 19,601, which is
/// √2 times as much to 2 · 10⁻⁹.
const STRAIGHT: u32 = 13_860;

/// Farther than this is unreachable: some 300,000 cells of open floor. Going on from a value up to
/// this does not overflow.
const FARTHEST: u32 = u32::MAX - 32 * STRAIGHT;

/// More than the dearest move, divided by the cheapest: 16 · √2, rounded up to a power of two.
const BUCKETS: usize = 32;

/// How far a start that the robot does not fit at may be from free floor.
pub(super) const ESCAPE_REACH_M: f64 = 1.0;

/// For every cell the cost of the cheapest way to a target by straight and diagonal moves, each
/// move weighed with the mean price of its two cells; diagonal moves do not cut corners.
///
/// A pure function of map, target and blocked points. Cost: one pass of a bucket queue whose
/// buckets are as wide as the cheapest move is dear, so that whatever is in the foremost bucket is
/// final (Dinic 1978); exact, and linear in the cells: some 10 ns each. That is less than the way
/// back from a change takes in most of a building, so there is no repair (D* Lite and its kind): a
/// change of the map is a new field.
#[derive(Clone, Debug, PartialEq)]
pub struct ValueField {
    grid: Arc<CostGrid>,
    target_in_map: Option<Point>,
    /// Framed like the grid, in 1/[`STRAIGHT`] cells of open floor.
    values: Vec<u32>,
}

impl ValueField {
    pub(super) fn new(grid: Arc<CostGrid>, target_in_map: Option<Point>) -> Self {
        let mut values = vec![UNREACHABLE; grid.prices.len()];
        if let Some(target) = target_in_map.and_then(|target| grid.cell_at(target)) {
            spread(&grid, target, &mut values);
        }
        Self { grid, target_in_map, values }
    }

    /// Bytes of its values.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.values.as_slice())
    }

    /// The target, where the robot fits.
    pub fn target_in_map(&self) -> Option<Point> {
        self.target_in_map
    }

    /// Cost of the way from the cell around a point, in metres of open floor; `None` if there is
    /// no way or the robot does not fit at the point.
    pub fn cost_m(&self, from_in_map: Point) -> Option<f64> {
        let value = self.values[self.grid.cell_at(from_in_map)?];
        (value != UNREACHABLE).then(|| f64::from(value) / f64::from(STRAIGHT) * self.grid.resolution_m)
    }

    /// The way from a point to the target: the point itself, corners, the target. Straightened
    /// wherever the straight way is free and costs no more than the way along the cells, so that it
    /// keeps as clear of obstacles as that. A start the robot does not fit at is left for the
    /// nearest free cell first. `None` if there is no way.
    pub fn path(&self, from_in_map: Point) -> Option<Vec<Point>> {
        let (mut path, cells) = self.approach(from_in_map, f64::INFINITY)?;
        path.extend(straightened(&self.grid, &cells));
        Some(path)
    }

    /// The farthest point of the way from a point that can be reached in a straight line and lies at
    /// most `reach_m` along it; beyond the next corner if that is nearer than `least_m`. Cheap: looks
    /// only that far ahead.
    pub fn lookahead(&self, from_in_map: Point, least_m: f64, reach_m: f64) -> Option<Point> {
        let (escape, cells) = self.approach(from_in_map, reach_m)?;
        let corner = if escape.is_empty() { farthest_straight(&self.grid, &cells, 0) } else { 0 };
        let beyond = cells[corner..].iter().find(|&&cell| distance_m(from_in_map, cell) >= least_m);
        beyond.or(cells.last()).copied()
    }

    /// The next `reach_m` of the way from a point, cell by cell, not straightened.
    pub fn way_ahead(&self, from_in_map: Point, reach_m: f64) -> Option<Vec<Point>> {
        let (mut way, cells) = self.approach(from_in_map, reach_m)?;
        way.extend(cells);
        Some(way)
    }

    /// The escape from an inflated cell (the start, or nothing), and the way along the cells from
    /// there, cut off after `reach_m`.
    fn approach(&self, from_in_map: Point, reach_m: f64) -> Option<(Vec<Point>, Vec<Point>)> {
        let start = self.grid.cell_at(from_in_map)?;
        if self.values[start] != UNREACHABLE {
            return Some((Vec::new(), self.descend(start, from_in_map, reach_m)?));
        }
        if self.grid.prices[start] > 0 {
            return None;
        }
        let free = self.escape(start)?;
        Some((vec![from_in_map], self.descend(free, self.grid.centre(free), reach_m)?))
    }

    fn descend(&self, start: usize, start_in_map: Point, reach_m: f64) -> Option<Vec<Point>> {
        let target_in_map = self.target_in_map?;
        let mut points = vec![start_in_map];
        let (mut cell, mut along_m) = (start, 0.0);
        while self.values[cell] > 0 && along_m < reach_m {
            let (next, length) = self.best_move(cell)?;
            along_m += length * self.grid.resolution_m;
            cell = next;
            points.push(self.grid.centre(cell));
        }
        if self.values[cell] == 0 {
            if points.len() > 1 {
                points.pop();
            }
            points.push(target_in_map);
        }
        Some(points)
    }

    /// The neighbour on the cheapest way and the length of the move in cells; of equals the first
    /// in the order of the moves.
    fn best_move(&self, cell: usize) -> Option<(usize, f64)> {
        let mut best: Option<(u32, usize, f64)> = None;
        for (bit, &step) in MOVES.iter().enumerate() {
            if self.grid.moves[cell] & (1 << bit) == 0 {
                continue;
            }
            let next = self.grid.neighbour(cell, step);
            let through = self.values[next].saturating_add(move_cost(self.grid.prices_of(cell, next), bit));
            if self.values[next] < self.values[cell] && best.is_none_or(|(least, _, _)| through < least) {
                best = Some((through, next, if bit < 4 { 1.0 } else { std::f64::consts::SQRT_2 }));
            }
        }
        best.map(|(_, next, length)| (next, length))
    }

    /// The nearest cell with a value that can be got to without crossing an obstacle of the map; of
    /// equals the first found. A start inside an obstacle, where only the estimate can be, may be
    /// left across it.
    fn escape(&self, start: usize) -> Option<usize> {
        let reach = ESCAPE_REACH_M / self.grid.resolution_m;
        let position = |cell: usize| ((cell % self.grid.stride) as f64, (cell / self.grid.stride) as f64);
        let (column, row) = position(start);
        let away = |cell: usize| {
            let (x, y) = position(cell);
            (x - column) * (x - column) + (y - row) * (y - row)
        };
        let may_cross = self.grid.is_obstacle[start];
        let mut seen = std::collections::BTreeSet::from([start]);
        let mut found = vec![start];
        let mut nearest: Option<usize> = None;
        let mut next_found = 0;
        while next_found < found.len() {
            let cell = found[next_found];
            next_found += 1;
            if self.values[cell] != UNREACHABLE && nearest.is_none_or(|best| away(cell) < away(best)) {
                nearest = Some(cell);
            }
            if self.grid.is_frame(cell) {
                continue;
            }
            for step in MOVES {
                let next = self.grid.neighbour(cell, step);
                let is_open = may_cross || !self.grid.is_obstacle[next];
                if is_open && away(next) <= reach * reach && seen.insert(next) {
                    found.push(next);
                }
            }
        }
        nearest
    }
}

/// What move `bit` costs between two cells whose prices sum to this.
fn move_cost(prices: u32, bit: usize) -> u32 {
    const PER_PRICE: u32 = STRAIGHT / (2 * OPEN_FLOOR as u32);
    /// √2 · 1024 times that, rounded so that a diagonal move on open floor is exact.
    const DIAGONAL_PER_PRICE: u32 = 47_790;
    if bit < 4 { prices * PER_PRICE } else { (prices * DIAGONAL_PER_PRICE) >> 10 }
}

fn bucket(value: u32) -> u32 {
    value / STRAIGHT
}

/// Cells by the bucket of their value, all of them within [`BUCKETS`] of the foremost.
struct Buckets {
    cells: [Vec<u32>; BUCKETS],
    waiting: usize,
}

impl Buckets {
    fn push(&mut self, cell: usize, value: u32) {
        self.cells[bucket(value) as usize % BUCKETS].push(cell as u32);
        self.waiting += 1;
    }

    /// Takes a bucket out, in exchange for an empty one.
    fn take(&mut self, bucket: u32, batch: &mut Vec<u32>) {
        std::mem::swap(batch, &mut self.cells[bucket as usize % BUCKETS]);
        self.waiting -= batch.len();
    }
}

fn spread(grid: &CostGrid, target: usize, values: &mut [u32]) {
    let mut buckets = Buckets { cells: std::array::from_fn(|_| Vec::new()), waiting: 0 };
    values[target] = 0;
    buckets.push(target, 0);
    let (mut foremost, mut batch) = (0, Vec::new());
    while buckets.waiting > 0 {
        buckets.take(foremost, &mut batch);
        for cell in batch.drain(..) {
            // A cell that was improved since lies in an earlier bucket too.
            let value = values[cell as usize];
            if bucket(value) == foremost && value <= FARTHEST {
                spread_from(grid, cell as usize, values, &mut buckets);
            }
        }
        foremost += 1;
    }
}

/// Offers the neighbours the way over this cell. Nobody can predict which of the eight will take it,
/// so they are compared without branches first.
fn spread_from(grid: &CostGrid, cell: usize, values: &mut [u32], buckets: &mut Buckets) {
    let (here, price) = (values[cell], u32::from(grid.prices[cell]));
    let prices = neighbours(&grid.prices, cell, grid.stride);
    let before = neighbours(values, cell, grid.stride);
    let (mut offers, mut takers) = ([0; 8], 0);
    for (bit, offer) in offers.iter_mut().enumerate() {
        *offer = here + move_cost(price + u32::from(prices[bit]), bit);
        takers |= u8::from(*offer < before[bit]) << bit;
    }
    takers &= grid.moves[cell];
    while takers != 0 {
        let bit = takers.trailing_zeros() as usize;
        takers &= takers - 1;
        let next = cell.wrapping_add_signed(grid.offsets[bit]);
        values[next] = offers[bit];
        // One that waits in the same bucket already will be served with its new value.
        if bucket(before[bit]) != bucket(offers[bit]) {
            buckets.push(next, offers[bit]);
        }
    }
}

/// What is beside a cell, in the order of [`MOVES`]; the cell must not be in the frame.
fn neighbours<T: Copy>(of: &[T], cell: usize, stride: usize) -> [T; 8] {
    let below = &of[cell - stride - 1..][..3];
    let beside = &of[cell - 1..][..3];
    let above = &of[cell + stride - 1..][..3];
    [beside[2], above[1], beside[0], below[1], above[2], above[0], below[0], below[2]]
}

/// The corners that remain of a way when every stretch is straightened that can be.
fn straightened(grid: &CostGrid, points: &[Point]) -> Vec<Point> {
    let mut corners = vec![points[0]];
    let mut from = 0;
    while from + 1 < points.len() {
        from = farthest_straight(grid, points, from);
        corners.push(points[from]);
    }
    corners
}

/// The farthest point after `from` to which the straight way is free and no dearer than the way
/// along the points; the next point if there is none.
fn farthest_straight(grid: &CostGrid, points: &[Point], from: usize) -> usize {
    const PATIENCE: usize = 8;
    let (mut farthest, mut along_m) = ((from + 1).min(points.len() - 1), 0.0);
    for to in from + 1..points.len() {
        let Some(step_m) = grid.straight_cost_m(points[to - 1], points[to]) else { break };
        along_m += step_m;
        let straight_m = grid.straight_cost_m(points[from], points[to]);
        if straight_m.is_some_and(|straight_m| straight_m <= along_m * (1.0 + 1e-9)) {
            farthest = to;
        } else if to > farthest + PATIENCE {
            break;
        }
    }
    farthest
}

/// Length of a polyline.
pub fn path_length_m(path: &[Point]) -> f64 {
    path.windows(2).map(|pair| distance_m(pair[0], pair[1])).sum()
}

#[cfg(test)]
mod tests {
    use super::super::planner::{PlannerModel, PlannerParameters};
    use super::*;
    use crate::occupancy::{Cell, OccupancyGrid};
    use proptest::prelude::*;

    const POINT_ROBOT: PlannerParameters =
        PlannerParameters { robot_radius_m: 0.0, comfortable_distance_m: 0.0, closeness_weight: 0.0 };

    fn grid(columns: usize, rows: usize, occupied: &[u8]) -> OccupancyGrid {
        let mut map = OccupancyGrid::filled(Point::new(-1.0, 2.0), 0.1, columns, rows, Cell::Free);
        for (cell, _) in occupied.iter().take(columns * rows).enumerate().filter(|&(_, &value)| value == 0) {
            map.cells[cell] = Cell::Occupied;
        }
        map
    }

    /// V(s) = min over moves of cost + V(s'), swept until nothing changes.
    fn value_iteration(grid: &CostGrid, target: usize) -> Vec<u32> {
        let mut values = vec![UNREACHABLE; grid.prices.len()];
        values[target] = 0;
        loop {
            let mut changed = false;
            for cell in 0..values.len() {
                for (bit, &step) in MOVES.iter().enumerate() {
                    if grid.moves[cell] & (1 << bit) == 0 {
                        continue;
                    }
                    let next = grid.neighbour(cell, step);
                    let value = values[next].saturating_add(move_cost(grid.prices_of(cell, next), bit));
                    if value < values[cell] {
                        values[cell] = value;
                        changed = true;
                    }
                }
            }
            if !changed {
                return values;
            }
        }
    }

    proptest! {
        #[test]
        fn agrees_with_value_iteration(
            columns in 3usize..18,
            rows in 3usize..18,
            occupied in proptest::collection::vec(0u8..5, 324),
            target in 0usize..324,
            wide in proptest::bool::ANY,
        ) {
            let parameters = PlannerParameters { robot_radius_m: 0.04, comfortable_distance_m: 0.3, closeness_weight: 15.0 };
            let map = grid(columns, rows, &occupied);
            let model = PlannerModel::new(&map, if wide { parameters } else { POINT_ROBOT });
            let target = target % (columns * rows);
            let target_in_map = map.centre(target % columns, target / columns);
            let field = model.value_field(target_in_map);
            if let Some(moved) = field.target_in_map {
                let cell = model.grid.cell_at(moved);
                prop_assert_eq!(&field.values, &value_iteration(&model.grid, cell.unwrap_or(0)));
            }
        }

        #[test]
        fn paths_lead_through_free_cells_and_cost_no_more_than_the_value(
            occupied in proptest::collection::vec(0u8..9, 400),
            from in 0usize..400,
            to in 0usize..400,
        ) {
            let parameters = PlannerParameters { robot_radius_m: 0.06, comfortable_distance_m: 0.4, closeness_weight: 5.0 };
            let map = grid(20, 20, &occupied);
            let model = PlannerModel::new(&map, parameters);
            let (from, to) = (map.centre(from % 20, from / 20), map.centre(to % 20, to / 20));
            let field = model.value_field(to);
            let stands_free = model.is_traversable(from) && model.is_traversable(to);
            if stands_free {
                prop_assert_eq!(field.path(from).is_some(), field.cost_m(from).is_some());
            }
            if let Some(path) = field.path(from).filter(|_| stands_free) {
                prop_assert_eq!((path[0], path[path.len() - 1]), (from, to));
                let mut cost_m = 0.0;
                for leg in path.windows(2) {
                    for step in 0..=100 {
                        let point = leg[0] + (leg[1] - leg[0]) * f64::from(step) / 100.0;
                        // A way along the edge between two cells may be counted to either.
                        let sides = [-1e-9, 1e-9].map(|side| point + nalgebra::Vector2::repeat(side));
                        prop_assert!(sides.iter().any(|&side| model.is_traversable(side)), "{point}");
                    }
                    cost_m += model.grid.straight_cost_m(leg[0], leg[1]).unwrap_or(f64::INFINITY);
                }
                let value_m = field.cost_m(from).unwrap_or(0.0);
                prop_assert!(cost_m <= value_m * 1.0001 + 1e-9, "{cost_m} {value_m}");
            }
        }
    }

    #[test]
    fn open_floor_has_octile_distances() {
        let map = grid(60, 50, &[]);
        let model = PlannerModel::new(&map, POINT_ROBOT);
        let field = model.value_field(map.centre(7, 9));
        for (column, row) in [(7, 9), (59, 49), (0, 0), (30, 9), (8, 40)] {
            let (dx, dy) = (f64::from((column - 7_i32).abs()), f64::from((row - 9_i32).abs()));
            let octile_m = 0.1 * (dx.max(dy) + (std::f64::consts::SQRT_2 - 1.0) * dx.min(dy));
            let cost_m = field.cost_m(map.centre(column as usize, row as usize)).expect("a way");
            assert!((cost_m - octile_m).abs() <= 1e-4 * octile_m, "{cost_m} {octile_m}");
        }
    }

    #[test]
    fn open_floor_paths_are_straight() {
        let map = grid(60, 50, &[]);
        let model = PlannerModel::new(&map, POINT_ROBOT);
        let (from, to) = (Point::new(-0.73, 2.22), Point::new(4.61, 5.37));
        assert_eq!(model.value_field(to).path(from), Some(vec![from, to]));
    }

    #[test]
    fn blocked_points_close_a_door_and_leave_a_detour() {
        // Two rooms of 3 × 3 m side by side; two openings of 0.9 m in the wall between them.
        let mut map = grid(61, 30, &[]);
        for row in (0..30).filter(|row| !(3..12).contains(row) && !(18..27).contains(row)) {
            map.set(30, row, Cell::Occupied);
        }
        let model = PlannerModel::new(&map, PlannerParameters::default());
        let (from, to) = (map.centre(20, 7), map.centre(40, 7));
        let lower = map.centre(30, 7);
        let upper = map.centre(30, 22);
        let free = path_length_m(&model.value_field(to).path(from).expect("a way"));
        let detour = path_length_m(&model.value_field_around(to, &[lower]).path(from).expect("a way"));
        assert!(free < 2.1 && detour > 3.0, "{free} {detour}");
        assert_eq!(model.value_field_around(to, &[lower, upper]).path(from), None);
        assert_eq!(model.value_field_around(to, &[]), model.value_field(to));
    }

    #[test]
    fn unknown_cells_are_not_entered() {
        let mut map = grid(30, 10, &[]);
        for row in 0..10 {
            map.set(15, row, Cell::Unknown);
        }
        let model = PlannerModel::new(&map, POINT_ROBOT);
        assert_eq!(model.value_field(map.centre(25, 5)).path(map.centre(5, 5)), None);
    }

    #[test]
    fn a_start_too_near_the_wall_is_left_for_free_floor() {
        let map = grid(40, 40, &[]);
        let model = PlannerModel::new(&map, PlannerParameters::default());
        let (from, to) = (map.centre(0, 20), map.centre(30, 20));
        assert!(!model.is_traversable(from));
        let path = model.value_field(to).path(from).expect("a way");
        assert_eq!(path[0], from);
        assert!(path[1..].iter().all(|&point| model.is_traversable(point)));
        assert!(distance_m(path[0], path[1]) < 0.35);
    }

    #[test]
    fn paths_keep_clear_of_a_wall_they_could_graze() {
        // A wall reaching into the room; the shortest way grazes its tip.
        let mut map = grid(60, 60, &[]);
        for row in 0..30 {
            map.set(30, row, Cell::Occupied);
        }
        let model = PlannerModel::new(&map, PlannerParameters::default());
        let path = model.value_field(map.centre(55, 15)).path(map.centre(5, 15)).expect("a way");
        let least_m = path
            .windows(2)
            .flat_map(|leg| (0..=50).map(|step| leg[0] + (leg[1] - leg[0]) * f64::from(step) / 50.0))
            .map(|point| model.obstacle_distance_m(point))
            .fold(f64::INFINITY, f64::min);
        assert!(least_m > 0.4, "{least_m}");
    }
}
