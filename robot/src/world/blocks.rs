//! A recorded map as bodies.

use super::Rect;
use crate::geometry::Vector;
use crate::occupancy::{Cell, OccupancyGrid};

/// More rectangles are those of noise: each is a body in the world.
const MOST_BLOCKS: usize = 1 << 20;

/// What is occupied in a map is in too many pieces to be walls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "what is occupied in it is in more than {MOST_BLOCKS} pieces, as noise is; smooth the image, or set `occupied_thresh` so that walls alone are occupied"
)]
pub struct Noise;

impl OccupancyGrid {
    /// Whether what is occupied can be the walls of a world. Cost: cells.
    ///
    /// # Errors
    /// It is in too many pieces.
    pub fn check_walls(&self) -> Result<(), Noise> {
        if blocks(self, MOST_BLOCKS).len() > MOST_BLOCKS { Err(Noise) } else { Ok(()) }
    }
}

/// The occupied cells as rectangles: runs along x, of which equal ones above each other are one. Where there are more
/// than `most`, only the first rows.
pub(super) fn blocks(map: &OccupancyGrid, most: usize) -> Vec<Rect> {
    let corner =
        |column: usize, row: usize| map.origin_in_frame + Vector::new(column as f64, row as f64) * map.resolution_m;
    let mut blocks: Vec<Rect> = Vec::new();
    // Columns of the runs that the row below ends with, and their rectangles.
    let mut below: Vec<(usize, usize, usize)> = Vec::new();
    for row in 0..map.rows {
        if blocks.len() > most {
            break;
        }
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
