//! What it costs to go, beside value iteration.

use super::super::cost_grid::{CostGrid, MOVES};
use super::super::cost_to_go::{UNREACHABLE, move_cost};
use super::*;
use proptest::prelude::*;

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
        let inflation = Inflation { body_radius_m: 0.04, comfortable_distance_m: 0.3, closeness_weight: 15.0 };
        let map = grid(columns, rows, &occupied);
        let model = PlannerModel::new(&map, if wide { inflation } else { POINT });
        let target = target % (columns * rows);
        let target_in_map = map.centre(target % columns, target / columns);
        let costs = model.cost_to_go(target_in_map);
        if let Some(moved) = costs.target_in_frame() {
            let cell = model.grid.cell_at(moved);
            prop_assert_eq!(&costs.costs, &value_iteration(&model.grid, cell.unwrap_or(0)));
        }
    }
}

#[test]
fn open_floor_has_octile_distances() {
    let map = grid(60, 50, &[]);
    let model = PlannerModel::new(&map, POINT);
    let costs = model.cost_to_go(map.centre(7, 9));
    for (column, row) in [(7, 9), (59, 49), (0, 0), (30, 9), (8, 40)] {
        let (dx, dy) = (f64::from((column - 7_i32).abs()), f64::from((row - 9_i32).abs()));
        let octile_m = 0.1 * (dx.max(dy) + (std::f64::consts::SQRT_2 - 1.0) * dx.min(dy));
        let cost_m = costs.cost_m(map.centre(column as usize, row as usize)).expect("a way");
        assert!((cost_m - octile_m).abs() <= 1e-4 * octile_m, "{cost_m} {octile_m}");
    }
}
