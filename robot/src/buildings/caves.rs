//! Rough outlines, as a recorded map has them: what a walk at random has dug out, disc by disc.

use super::draft::{Draft, mostly_short, people};
use super::furniture::furnish;
use crate::geometry::{Point, Vector};
use crate::occupancy::{Cell, OccupancyGrid};
use crate::world::Rect;
use rpl_random::Stream;

/// Edge of a cell of the map.
const CELL_M: f64 = 0.1;

/// Rock is seen so deep; behind it nothing is known.
const ROCK_CELLS: usize = 2;

/// From one disc to the next.
const STEP_M: f64 = 0.4;

/// This share of the ground is dug out.
const DUG: f64 = 0.35;

pub(super) fn draw(stream: &mut Stream, robot_radius_m: f64) -> Draft {
    let size_m = Vector::new(mostly_short(stream, 12.0, 50.0), mostly_short(stream, 12.0, 50.0));
    let (columns, rows) = ((size_m.x / CELL_M) as usize, (size_m.y / CELL_M) as usize);
    let mut grid = OccupancyGrid::filled(Point::origin(), CELL_M, columns, rows, Cell::Unknown);
    dig(&mut grid, stream, robot_radius_m);
    face(&mut grid);
    let size_m = Vector::new(columns as f64, rows as f64) * CELL_M;
    let mut draft = Draft { recorded: Some(grid), ..Draft::new(size_m) };
    draft.floors.push(Rect { min: Point::origin(), max: Point::from(size_m) });
    let boulders = stream.index(8);
    furnish(&mut draft, stream, boulders);
    draft.people = people(stream);
    draft
}

/// Digs discs out along a walk that turns at random and comes back from the edge.
fn dig(grid: &mut OccupancyGrid, stream: &mut Stream, robot_radius_m: f64) {
    let narrowest_m = robot_radius_m + 0.45;
    let edge_m = narrowest_m + 2.2;
    let size = Vector::new(grid.columns as f64, grid.rows as f64) * grid.resolution_m;
    let mut at = Point::from(size / 2.0);
    let (mut heading_rad, mut radius_m) = (stream.uniform_in(-3.0, 3.0), narrowest_m + 0.5);
    let mut left = (DUG * grid.cells.len() as f64) as usize;
    // A walk over ground that is dug out already ends, too.
    for _ in 0..grid.cells.len() / 10 {
        left = left.saturating_sub(dig_disc(grid, stream, at, radius_m));
        if left == 0 {
            return;
        }
        heading_rad += 0.35 * stream.normal();
        radius_m = (radius_m + 0.12 * stream.normal()).clamp(narrowest_m, narrowest_m + 1.4);
        let next = at + Vector::new(libm::cos(heading_rad), libm::sin(heading_rad)) * STEP_M;
        let is_inside = |at: f64, size: f64| (edge_m..size - edge_m).contains(&at);
        if is_inside(next.x, size.x) && is_inside(next.y, size.y) {
            at = next;
        } else {
            heading_rad += stream.uniform_in(1.5, 4.5);
        }
    }
}

/// Digs a disc with a ragged edge; answers how many cells that are new.
fn dig_disc(grid: &mut OccupancyGrid, stream: &mut Stream, centre: Point, radius_m: f64) -> usize {
    let reach = (radius_m / grid.resolution_m) as usize + 1;
    let Some((column, row)) = grid.cell_at(centre) else { return 0 };
    let mut dug = 0;
    for row in row.saturating_sub(reach)..(row + reach + 1).min(grid.rows) {
        for column in column.saturating_sub(reach)..(column + reach + 1).min(grid.columns) {
            let ragged_m = radius_m - stream.uniform_in(0.0, 0.15);
            let is_new = grid.get(column, row) != Cell::Free;
            if is_new && (grid.centre(column, row) - centre).norm() <= ragged_m {
                grid.set(column, row, Cell::Free);
                dug += 1;
            }
        }
    }
    dug
}

/// Makes the cells beside the floor rock.
fn face(grid: &mut OccupancyGrid) {
    let mut edge: Vec<(usize, usize)> = (0..grid.cells.len())
        .map(|index| (index % grid.columns, index / grid.columns))
        .filter(|&(column, row)| grid.get(column, row) == Cell::Free)
        .collect();
    for _ in 0..ROCK_CELLS {
        let beside: Vec<(usize, usize)> =
            edge.iter().flat_map(|&(column, row)| grid.beside(column, row).collect::<Vec<_>>()).collect();
        edge.clear();
        for (column, row) in beside {
            if grid.get(column, row) == Cell::Unknown {
                grid.set(column, row, Cell::Occupied);
                edge.push((column, row));
            }
        }
    }
}
