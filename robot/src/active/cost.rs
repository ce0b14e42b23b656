//! v(a): what the way to a point costs.

use super::action::ActionGrid;
use super::parameters::ActiveParameters;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// No cell comes before the robot's.
const NO_CELL: u32 = u32::MAX;

/// Costs of all cells, and from where each is reached.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CostField {
    /// Metres of free way a way is worth; infinite where none leads.
    pub cost_m: Vec<f64>,
    previous: Vec<u32>,
}

/// WayCost of entering a cell over a distance: its length, and more where it may be occupied.
///
/// # Deviation
/// Eq. (8) as printed adds P_occ alone, so that any way through free space costs nothing and the
/// robot has no reason to prefer the near of two equal rooms; here length is added. Cells that are
/// almost certainly occupied are not entered at all, except around the robot, which may have been
/// placed near a wall.
fn entering(grid: ActionGrid, occupancy: &[f32], cell: usize, cells: f64, parameters: &ActiveParameters) -> f64 {
    let probability = f64::from(occupancy[cell]);
    let is_near_robot = || grid.point_in_base(cell).coords.norm_squared() < 0.6 * 0.6;
    if probability > parameters.blocked_probability && !is_near_robot() {
        return f64::INFINITY;
    }
    cells * grid.resolution_m * (1.0 + parameters.occupied_cost * probability)
}

/// A cost that can be ordered; costs are never NaN.
#[derive(PartialEq)]
struct WayCost(f64);

impl Eq for WayCost {}

impl PartialOrd for WayCost {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for WayCost {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

impl CostField {
    /// The fixed point of Eq. (8), by Dijkstra's algorithm from the robot. O(n log n).
    pub fn new(grid: ActionGrid, occupancy: &[f32], parameters: &ActiveParameters) -> Self {
        let mut cost_m = vec![f64::INFINITY; grid.cells()];
        let mut previous = vec![NO_CELL; grid.cells()];
        let mut open = BinaryHeap::new();
        cost_m[grid.robot()] = 0.0;
        open.push((Reverse(WayCost(0.0)), grid.robot()));
        while let Some((Reverse(WayCost(cost)), cell)) = open.pop() {
            if cost > cost_m[cell] {
                continue;
            }
            for (next, cells) in grid.neighbours(cell) {
                let reached = cost + entering(grid, occupancy, next, cells, parameters);
                if reached < cost_m[next] {
                    cost_m[next] = reached;
                    previous[next] = cell as u32;
                    open.push((Reverse(WayCost(reached)), next));
                }
            }
        }
        Self { cost_m, previous }
    }

    /// The cells from the robot's to this one; only this one if no way leads there.
    pub fn path(&self, cell: usize) -> Vec<usize> {
        let mut path = vec![cell];
        let mut at = cell;
        while self.previous[at] != NO_CELL {
            at = self.previous[at] as usize;
            path.push(at);
        }
        path.reverse();
        path
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_random::Stream;

    /// Eq. (8) iterated until nothing changes.
    fn value_iteration(grid: ActionGrid, occupancy: &[f32], parameters: &ActiveParameters) -> Vec<f64> {
        let mut value = vec![f64::INFINITY; grid.cells()];
        value[grid.robot()] = 0.0;
        loop {
            let mut changed = false;
            for cell in 0..grid.cells() {
                for (from, cells) in grid.neighbours(cell) {
                    let reached = value[from] + entering(grid, occupancy, cell, cells, parameters);
                    if reached < value[cell] {
                        value[cell] = reached;
                        changed = true;
                    }
                }
            }
            if !changed {
                return value;
            }
        }
    }

    fn random_field(seed: u64) -> (ActionGrid, Vec<f32>) {
        let grid = ActionGrid::new(0.3, 4.5);
        let mut stream = Stream::new(seed, "field");
        let field = (0..grid.cells()).map(|_| if stream.chance(0.3) { 1.0 } else { stream.uniform() as f32 }).collect();
        (grid, field)
    }

    #[test]
    fn value_iteration_reaches_the_same_costs() {
        let parameters = ActiveParameters::default();
        for seed in 10_000..10_005 {
            let (grid, field) = random_field(seed);
            let costs = CostField::new(grid, &field, &parameters);
            let values = value_iteration(grid, &field, &parameters);
            for (cost, value) in costs.cost_m.iter().zip(&values) {
                assert!(cost == value || (cost - value).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn a_path_adds_up_to_its_cost_and_free_space_costs_its_length() {
        let parameters = ActiveParameters::default();
        let (grid, field) = random_field(10_007);
        let costs = CostField::new(grid, &field, &parameters);
        for cell in (0..grid.cells()).filter(|&cell| costs.cost_m[cell].is_finite()) {
            let path = costs.path(cell);
            assert_eq!(path[0], grid.robot());
            let sum: f64 = path
                .windows(2)
                .map(|step| {
                    let cells = grid.neighbours(step[0]).find(|next| next.0 == step[1]).map_or(f64::NAN, |next| next.1);
                    entering(grid, &field, step[1], cells, &parameters)
                })
                .sum();
            assert!((sum - costs.cost_m[cell]).abs() < 1e-9);
        }
        let empty = CostField::new(grid, &vec![0.0; grid.cells()], &parameters);
        assert!((empty.cost_m[grid.robot() + 5] - 1.5).abs() < 1e-12);
    }
}
