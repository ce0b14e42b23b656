//! What it costs to go to a target, from every cell.

use super::cost_grid::{CostGrid, OPEN_FLOOR};
use crate::geometry::Point;
use std::sync::Arc;

/// Cost of a cell from which the target cannot be reached.
pub(super) const UNREACHABLE: u32 = u32::MAX;

/// A straight move on open floor, the least a move can cost. A diagonal one costs 19,601, which is
/// √2 times as much to 2 · 10⁻⁹.
const STRAIGHT: u32 = 13_860;

/// Farther than this is unreachable: some 300,000 cells of open floor. Going on from a cost up to
/// this does not overflow.
const FARTHEST: u32 = u32::MAX - 32 * STRAIGHT;

/// More than the dearest move, divided by the cheapest: 16 · √2, rounded up to a power of two.
const BUCKETS: usize = 32;

/// A target that the body does not fit at may be moved so far.
pub(super) const TARGET_REACH_M: f64 = 0.3;

/// For every cell the cost of the cheapest way to a target by straight and diagonal moves, each
/// move weighed with the mean price of its two cells; diagonal moves do not cut corners.
///
/// A pure function of grid and target. Cost: one pass of a bucket queue whose buckets are as wide as
/// the cheapest move is dear, so that whatever is in the foremost bucket is final (Dinic 1978); exact,
/// and linear in the cells: some 10 ns each. That is less than the way back from a change takes in
/// most of a building, so there is no repair (D* Lite and its kind): a change of the map is a new pass.
#[derive(Clone, Debug, PartialEq)]
pub struct CostToGo {
    pub(super) grid: Arc<CostGrid>,
    target_in_frame: Option<Point>,
    /// Rimmed like the grid, in 1/[`STRAIGHT`] cells of open floor.
    pub(super) costs: Vec<u32>,
}

impl CostToGo {
    /// To a target in the frame of the grid. A target the body does not fit at is moved to the nearest
    /// cell within 0.3 m where it does; without one no cell has a cost.
    pub fn new(grid: Arc<CostGrid>, target_in_frame: Point) -> Self {
        let target_in_frame = grid.nearest_traversable(target_in_frame, TARGET_REACH_M);
        let mut costs = vec![UNREACHABLE; grid.prices.len()];
        if let Some(target) = target_in_frame.and_then(|target| grid.cell_at(target)) {
            spread(&grid, target, &mut costs);
        }
        Self { grid, target_in_frame, costs }
    }

    /// Bytes of its costs.
    pub fn bytes(&self) -> usize {
        size_of_val(self.costs.as_slice())
    }

    /// The target, where the body fits.
    pub fn target_in_frame(&self) -> Option<Point> {
        self.target_in_frame
    }

    /// Cost of the way from the cell around a point, in metres of open floor; `None` if there is
    /// no way or the body does not fit at the point.
    pub fn cost_m(&self, from_in_frame: Point) -> Option<f64> {
        let cost = self.costs[self.grid.cell_at(from_in_frame)?];
        (cost != UNREACHABLE).then(|| f64::from(cost) / f64::from(STRAIGHT) * self.grid.resolution_m)
    }
}

/// What move `bit` costs between two cells whose prices sum to this.
pub(super) fn move_cost(prices: u32, bit: usize) -> u32 {
    const PER_PRICE: u32 = STRAIGHT / (2 * OPEN_FLOOR as u32);
    /// √2 · 1024 times that, rounded so that a diagonal move on open floor is exact.
    const DIAGONAL_PER_PRICE: u32 = 47_790;
    if bit < 4 { prices * PER_PRICE } else { (prices * DIAGONAL_PER_PRICE) >> 10 }
}

fn bucket(cost: u32) -> u32 {
    cost / STRAIGHT
}

/// Cells by the bucket of their cost, all of them within [`BUCKETS`] of the foremost.
struct Buckets {
    cells: [Vec<u32>; BUCKETS],
    waiting: usize,
}

impl Buckets {
    fn push(&mut self, cell: usize, cost: u32) {
        self.cells[bucket(cost) as usize % BUCKETS].push(cell as u32);
        self.waiting += 1;
    }

    /// Takes a bucket out, in exchange for an empty one.
    fn take(&mut self, bucket: u32, batch: &mut Vec<u32>) {
        std::mem::swap(batch, &mut self.cells[bucket as usize % BUCKETS]);
        self.waiting -= batch.len();
    }
}

fn spread(grid: &CostGrid, target: usize, costs: &mut [u32]) {
    let mut buckets = Buckets { cells: std::array::from_fn(|_| Vec::new()), waiting: 0 };
    costs[target] = 0;
    buckets.push(target, 0);
    let (mut foremost, mut batch) = (0, Vec::new());
    while buckets.waiting > 0 {
        buckets.take(foremost, &mut batch);
        for cell in batch.drain(..) {
            // A cell that was improved since lies in an earlier bucket too.
            let cost = costs[cell as usize];
            if bucket(cost) == foremost && cost <= FARTHEST {
                spread_from(grid, cell as usize, costs, &mut buckets);
            }
        }
        foremost += 1;
    }
}

/// Offers the neighbours the way over this cell. Nobody can predict which of the eight will take it,
/// so they are compared without branches first.
fn spread_from(grid: &CostGrid, cell: usize, costs: &mut [u32], buckets: &mut Buckets) {
    let (here, price) = (costs[cell], u32::from(grid.prices[cell]));
    let prices = neighbours(&grid.prices, cell, grid.stride);
    let before = neighbours(costs, cell, grid.stride);
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
        costs[next] = offers[bit];
        // One that waits in the same bucket already will be served with its new cost.
        if bucket(before[bit]) != bucket(offers[bit]) {
            buckets.push(next, offers[bit]);
        }
    }
}

/// What is beside a cell, in the order of [`MOVES`]; the cell must not be in the rim.
fn neighbours<T: Copy>(of: &[T], cell: usize, stride: usize) -> [T; 8] {
    let below = &of[cell - stride - 1..][..3];
    let beside = &of[cell - 1..][..3];
    let above = &of[cell + stride - 1..][..3];
    [beside[2], above[1], beside[0], below[1], above[2], above[0], below[0], below[2]]
}
