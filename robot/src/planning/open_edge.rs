//! Where a map ends and no wall: nobody gets beyond its edge, and no sensor finds anything there.

use crate::geometry::{Point, Vector};
use crate::occupancy::{Cell, OccupancyGrid};

/// A stretch along one side of a map with floor beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenEdge {
    /// Where it begins and ends.
    pub ends_in_frame: [Point; 2],
}

impl OpenEdge {
    /// How long it is.
    pub fn length_m(&self) -> f64 {
        let [from, to] = self.ends_in_frame;
        (to - from).norm()
    }

    /// The points along it, at most so far from each other, that are within reach of one.
    pub(super) fn points_near(
        &self,
        point_in_frame: Point,
        reach_m: f64,
        apart_m: f64,
    ) -> impl Iterator<Item = Point> + use<> {
        let [from, to] = self.ends_in_frame;
        let (length_m, offset) = (self.length_m(), point_in_frame - from);
        let along = (to - from) / length_m;
        let middle_m = offset.dot(&along);
        let half_m = libm::sqrt((reach_m * reach_m - offset.perp(&along) * offset.perp(&along)).max(0.0));
        let first = libm::ceil((middle_m - half_m).max(0.0) / apart_m) as usize;
        let last = libm::floor((middle_m + half_m).min(length_m) / apart_m);
        let is_near = offset.perp(&along).abs() <= reach_m && last >= first as f64;
        let numbers = if is_near { first..last as usize + 1 } else { 0..0 };
        numbers.map(move |number| from + along * (number as f64 * apart_m))
    }
}

/// All of them, side by side. What is not known in the outermost cells counts as beyond the edge: so are cells that
/// the edge of a world cuts. O(length of the edge).
pub(super) fn open_edges(map: &OccupancyGrid) -> Vec<OpenEdge> {
    let (columns, rows) = (map.columns, map.rows);
    let mut edges = Vec::new();
    // The cell of each side at a place along it and at a depth in cells from the edge.
    type CellOf<'m> = &'m dyn Fn(usize, usize) -> (usize, usize);
    let sides: [(usize, usize, Vector, CellOf<'_>); 4] = [
        (rows, columns, Vector::new(-1.0, 0.0), &|along, depth| (depth, along)),
        (columns, rows, Vector::new(0.0, -1.0), &|along, depth| (along, depth)),
        (rows, columns, Vector::new(1.0, 0.0), &|along, depth| (columns - 1 - depth, along)),
        (columns, rows, Vector::new(0.0, 1.0), &|along, depth| (along, rows - 1 - depth)),
    ];
    for (length, depths, outward, cell_of) in sides {
        let depth_of_floor = |along: usize| {
            let cell = |depth: usize| {
                let (column, row) = cell_of(along, depth);
                map.get(column, row)
            };
            match cell(0) {
                Cell::Free => Some(0),
                Cell::Unknown => (depths > 1 && cell(1) == Cell::Free).then_some(1),
                Cell::Occupied => None,
            }
        };
        let depths: Vec<Option<usize>> = (0..length).map(depth_of_floor).collect();
        let mut first = 0;
        for run in depths.chunk_by(|one, other| one == other) {
            let end = first + run.len();
            if let Some(depth) = run[0] {
                let middle = |along: usize| {
                    let (column, row) = cell_of(along, depth);
                    map.centre(column, row) + outward * (map.resolution_m / 2.0)
                };
                let half = Vector::new(outward.y.abs(), outward.x.abs()) * (map.resolution_m / 2.0);
                edges.push(OpenEdge { ends_in_frame: [middle(first) - half, middle(end - 1) + half] });
            }
            first = end;
        }
    }
    edges
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_the_map_ends_with_floor_it_is_open() {
        let mut map = OccupancyGrid::filled(Point::new(-1.0, 2.0), 0.5, 6, 4, Cell::Free);
        (0..6).for_each(|column| map.set(column, 0, Cell::Occupied));
        (0..6).for_each(|column| map.set(column, 3, Cell::Unknown));
        (0..4).for_each(|row| map.set(0, row, Cell::Occupied));
        map.set(5, 1, Cell::Unknown);
        map.set(4, 1, Cell::Unknown);
        map.set(2, 2, Cell::Occupied);
        let ends: Vec<[[f64; 2]; 2]> =
            open_edges(&map).iter().map(|edge| edge.ends_in_frame.map(|end| [end.x, end.y])).collect();
        // To the east one cell, at the top what lies below the row that is not known, but for the wall in it.
        assert_eq!(ends, [[[2.0, 3.0], [2.0, 3.5]], [[-0.5, 3.5], [0.0, 3.5]], [[0.5, 3.5], [2.0, 3.5]]]);
    }

    #[test]
    fn the_points_within_reach_are_those_of_trying_all() {
        let edge = OpenEdge { ends_in_frame: [Point::new(1.0, 0.0), Point::new(5.0, 0.0)] };
        for (x, y, reach_m) in [(0.0, 1.0, 1.2), (0.0, 1.0, 0.9), (3.0, 0.5, 1.0), (4.9, -0.3, 2.0), (9.0, 0.1, 1.0)] {
            let at = Point::new(x, y);
            let all = (0..=40).map(|step| Point::new(1.0 + 0.1 * f64::from(step), 0.0));
            let near = all.filter(|point| (point - at).norm() <= reach_m).count();
            assert_eq!(edge.points_near(at, reach_m, 0.1).count(), near, "{x} {y} {reach_m}");
        }
    }
}
