//! Unmapped obstacles that are planned around for a while.

use crate::geometry::{Point, distance_m};
use serde::{Deserialize, Serialize};

/// They are planned around for this time, or until they are seen to be gone: a way around them may lead
/// out of sight of them.
const BLOCKAGE_S: f64 = 90.0;
/// From so near what stands at a blockage is seen, as a point at most so far off.
const BLOCKAGE_SIGHT_M: f64 = 1.0;
pub(super) const BLOCKAGE_OFF_M: f64 = 0.2;
/// And the length of their cells' edges.
const BLOCKAGE_GRAIN_M: f64 = 0.1;

/// An unmapped obstacle the planner is to avoid for a while.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Blockage {
    /// On a grid of 10 cm in the map, by which blockages are kept apart and in order.
    cell: (i32, i32),
    until_s: f64,
    /// No sensor tells that it is gone.
    is_felt: bool,
}

impl Blockage {
    fn point_in_map(&self) -> Point {
        let middle = |cell: i32| (f64::from(cell) + 0.5) * BLOCKAGE_GRAIN_M;
        Point::new(middle(self.cell.0), middle(self.cell.1))
    }
}

/// All of them, sorted by cell.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Blockages(Vec<Blockage>);

impl Blockages {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Where they are, in the map.
    pub fn points_in_map(&self) -> impl Iterator<Item = Point> {
        self.0.iter().map(Blockage::point_in_map)
    }

    /// Adds what stands at these points, or sees it again; with each whether it was felt.
    pub fn add(&mut self, points_in_map: &[(Point, bool)], now_s: f64) {
        let until_s = now_s + BLOCKAGE_S;
        for &(point, is_felt) in points_in_map {
            let cell = (libm::floor(point.x / BLOCKAGE_GRAIN_M) as i32, libm::floor(point.y / BLOCKAGE_GRAIN_M) as i32);
            match self.0.binary_search_by(|blockage| blockage.cell.cmp(&cell)) {
                Ok(index) => {
                    self.0[index].until_s = until_s;
                    self.0[index].is_felt |= is_felt;
                }
                Err(index) => self.0.insert(index, Blockage { cell, until_s, is_felt }),
            }
        }
    }

    /// Forgets those that are meant.
    pub fn forget_where(&mut self, is_meant: impl Fn(Point) -> bool) {
        self.0.retain(|blockage| !is_meant(blockage.point_in_map()));
    }

    /// Forgets what was added long ago, and what was seen and is seen to be gone: at these points something is seen.
    pub fn forget(&mut self, here: Point, seen_in_map: &[Point], now_s: f64) {
        self.0.retain(|blockage| {
            let at = blockage.point_in_map();
            let is_far = distance_m(here, at) > BLOCKAGE_SIGHT_M;
            let is_there =
                is_far || blockage.is_felt || seen_in_map.iter().any(|&point| distance_m(point, at) <= BLOCKAGE_OFF_M);
            is_there && blockage.until_s > now_s
        });
    }

    /// Forgets them all.
    pub fn clear(&mut self) {
        self.0.clear();
    }
}
