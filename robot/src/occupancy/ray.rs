//! Rays through a map, from one guaranteed free place to the next.

use super::distance_field::DistanceField;
use crate::geometry::Point;

/// Far above rounding, far below anything that matters.
const NUDGE_CELLS: f64 = 1e-6;

impl DistanceField {
    /// Distance from a point to the first occupied cell along a ray, at most `max_m`, to half a
    /// map cell; space outside the map is empty. `(cos, sin)` is the direction.
    pub fn cast_m(&self, from_in_frame: Point, (cos, sin): (f64, f64), max_m: f64) -> f64 {
        // A point between two cells belongs to the one ahead and to the left of the ray, so that a
        // map and a ray turned by 180° give the same distance.
        let from_x = (from_in_frame.x - self.origin_in_frame.x) / self.resolution_m + NUDGE_CELLS * (cos - 0.5 * sin);
        let from_y = (from_in_frame.y - self.origin_in_frame.y) / self.resolution_m + NUDGE_CELLS * (sin + 0.5 * cos);
        let most_cells = max_m / self.resolution_m;
        let mut travelled_cells = 0.0;
        while travelled_cells < most_cells {
            let (x, y) = (from_x + cos * travelled_cells, from_y + sin * travelled_cells);
            let Some(free) = self.distance_at(x, y) else { return max_m };
            if free <= 0.0 {
                break;
            }
            // Within a cell of a surface the middle-to-middle distance says too little, so the
            // ray feels its way; farther off it may go as far as the field guarantees.
            travelled_cells += (f64::from(free) - 1.0).max(0.5);
        }
        f64::min(travelled_cells, most_cells) * self.resolution_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::occupancy::{Cell, OccupancyGrid};
    use rpl_random::Stream;

    fn random_map(seed: u64) -> OccupancyGrid {
        let mut stream = Stream::new(seed, "map");
        let mut map = OccupancyGrid::filled(Point::new(-1.0, 2.0), 0.1, 37, 23, Cell::Free);
        for _ in 0..20 {
            map.set(stream.index(37), stream.index(23), Cell::Occupied);
        }
        map
    }

    #[test]
    fn a_ray_ends_within_a_cell_of_where_small_steps_end() {
        let map = random_map(10_002);
        let field = DistanceField::new(&map);
        let from = (0..map.cells.len())
            .map(|i| (i % map.columns, i / map.columns))
            .find(|&(x, y)| x > 10 && y > 10 && map.get(x, y) == Cell::Free);
        let (column, row) = from.expect("a free cell");
        let from = map.centre(column, row);
        for degrees in 0..360 {
            let (sin, cos) = libm::sincos(f64::from(degrees).to_radians());
            let mut small = 0.0;
            while small < 3.0 && map.at(Point::new(from.x + cos * small, from.y + sin * small)) != Cell::Occupied {
                small += 0.002;
            }
            let cast = field.cast_m(from, (cos, sin), 3.0);
            // A ray that grazes a corner may pass it; such rays are seen longer, never shorter.
            assert!(cast > small - 0.01 && (cast < small + 0.06 || grazes(&map, from, (cos, sin), small)));
        }
    }

    fn grazes(map: &OccupancyGrid, from: Point, (cos, sin): (f64, f64), at_m: f64) -> bool {
        let deep = at_m + 0.05;
        map.at(Point::new(from.x + cos * deep, from.y + sin * deep)) != Cell::Occupied
    }
}
