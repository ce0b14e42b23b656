//! A recorded map as bodies.

use super::Rect;
use crate::geometry::Vector;
use crate::occupancy::{Cell, OccupancyGrid};

/// The occupied cells as rectangles: runs along x, of which equal ones above each other are one.
pub(super) fn blocks(map: &OccupancyGrid) -> Vec<Rect> {
    let corner =
        |column: usize, row: usize| map.origin_in_frame + Vector::new(column as f64, row as f64) * map.resolution_m;
    let mut blocks: Vec<Rect> = Vec::new();
    // Columns of the runs that the row below ends with, and their rectangles.
    let mut below: Vec<(usize, usize, usize)> = Vec::new();
    for row in 0..map.rows {
        let cells = &map.cells[row * map.columns..][..map.columns];
        let mut open = Vec::new();
        let mut first = 0;
        for run in cells.chunk_by(|a, b| a == b) {
            let end = first + run.len();
            if run[0] == Cell::Occupied {
                let above = below.binary_search_by_key(&(first, end), |(from, to, _)| (*from, *to));
                let block = above.map_or(blocks.len(), |run| below[run].2);
                match above {
                    Ok(_) => blocks[block].max = corner(end, row + 1),
                    Err(_) => blocks.push(Rect { min: corner(first, row), max: corner(end, row + 1) }),
                }
                open.push((first, end, block));
            }
            first = end;
        }
        below = open;
    }
    blocks
}
