//! Rays through a map, from one guaranteed free place to the next.

use super::distance_field::DistanceField;
use crate::geometry::Point;

/// Far above rounding, far below anything that matters.
const NUDGE_CELLS: f64 = 1e-6;

impl DistanceField {
    /// Distance from a point to the first occupied cell along a ray, at most `max_m`, to half a
    /// map cell; space outside the map is empty. `(cos, sin)` is the direction.
    pub fn cast_m(&self, from_in_frame: Point, direction: (f64, f64), max_m: f64) -> f64 {
        let most_cells = max_m / self.resolution_m;
        let ray = Ray::new(self, from_in_frame, direction);
        ray.way_into_surface(most_cells).map_or(max_m, |cells| f64::min(cells, most_cells) * self.resolution_m)
    }

    /// The same to the edge of that cell, exactly; takes a little longer.
    pub fn surface_m(&self, from_in_frame: Point, direction: (f64, f64), max_m: f64) -> f64 {
        let most_cells = max_m / self.resolution_m;
        let ray = Ray::new(self, from_in_frame, direction);
        let Some(inside_cells) = ray.way_into_surface(most_cells) else { return max_m };
        let mut surface_cells = inside_cells;
        // In half a cell a ray that feels its way may also have gone through a corner of the cell before.
        for behind_cells in [0.0, NUDGE_CELLS] {
            let cells = surface_cells - behind_cells;
            if ray.free_at(cells).is_some_and(|free| free <= 0.0) {
                surface_cells = ray.entered_at(cells);
            }
        }
        surface_cells.clamp(0.0, most_cells) * self.resolution_m
    }
}

/// A ray through a map, in its cells.
struct Ray<'m> {
    map: &'m DistanceField,
    from: [f64; 2],
    /// Cosine and sine of the direction.
    along: [f64; 2],
}

impl<'m> Ray<'m> {
    #[inline(always)]
    fn new(map: &'m DistanceField, from_in_frame: Point, (cos, sin): (f64, f64)) -> Self {
        // A point between two cells belongs to the one ahead and to the left of the ray, so that a
        // map and a ray turned by 180° give the same distance.
        let x = (from_in_frame.x - map.origin_in_frame.x) / map.resolution_m + NUDGE_CELLS * (cos - 0.5 * sin);
        let y = (from_in_frame.y - map.origin_in_frame.y) / map.resolution_m + NUDGE_CELLS * (sin + 0.5 * cos);
        Self { map, from: [x, y], along: [cos, sin] }
    }

    #[inline(always)]
    fn at(&self, cells: f64) -> [f64; 2] {
        [self.from[0] + self.along[0] * cells, self.from[1] + self.along[1] * cells]
    }

    /// The distance to the nearest surface after a way; none outside the map.
    #[inline(always)]
    fn free_at(&self, cells: f64) -> Option<f32> {
        let [x, y] = self.at(cells);
        self.map.distance_at(x, y)
    }

    /// A way that ends less than half a cell inside the first surface; it, too, may be longer than the most. None if
    /// the map ends before.
    #[inline(always)]
    fn way_into_surface(&self, most_cells: f64) -> Option<f64> {
        let mut travelled_cells = 0.0;
        while travelled_cells < most_cells {
            let free = self.free_at(travelled_cells)?;
            if free <= 0.0 {
                break;
            }
            // Within a cell of a surface the middle-to-middle distance says too little, so the
            // ray feels its way; farther off it may go as far as the field guarantees.
            travelled_cells += (f64::from(free) - 1.0).max(0.5);
        }
        Some(travelled_cells)
    }

    /// The way after which the ray has entered the cell it is in after a longer one.
    fn entered_at(&self, cells: f64) -> f64 {
        let at = self.at(cells);
        let since = |axis: usize| {
            let (inside, along) = (at[axis] - libm::floor(at[axis]), self.along[axis]);
            (if along > 0.0 { inside } else { 1.0 - inside }) / libm::fabs(along)
        };
        cells - f64::min(since(0), since(1))
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

    #[test]
    fn the_surface_is_where_small_steps_end() {
        let map = random_map(10_004);
        let field = DistanceField::new(&map);
        let mut stream = Stream::new(10_005, "rays");
        let mut met = 0;
        for _ in 0..2000 {
            let from = Point::new(stream.uniform_in(-1.0, 2.7), stream.uniform_in(2.0, 4.3));
            let (sin, cos) = libm::sincos(stream.uniform_in(-4.0, 4.0));
            let at = |way_m: f64| map.at(Point::new(from.x + cos * way_m, from.y + sin * way_m));
            let surface_m = field.surface_m(from, (cos, sin), 1.5);
            if at(0.0) == Cell::Occupied {
                assert_eq!(surface_m, 0.0);
            } else if surface_m < 1.5 {
                met += 1;
                assert!(at(surface_m - 1e-6) != Cell::Occupied, "{from:?} {cos} {sin} {surface_m}");
                assert!(at(surface_m + 1e-6) == Cell::Occupied, "{from:?} {cos} {sin} {surface_m}");
            }
            assert!(surface_m <= field.cast_m(from, (cos, sin), 1.5) + 1e-9);
        }
        assert!(met > 200, "{met}");
    }

    fn grazes(map: &OccupancyGrid, from: Point, (cos, sin): (f64, f64), at_m: f64) -> bool {
        let deep = at_m + 0.05;
        map.at(Point::new(from.x + cos * deep, from.y + sin * deep)) != Cell::Occupied
    }
}
