//! The robot's map of a world.

use super::solid::{Outline, Solid, SolidOrigin, part_within};
use super::{Rect, SeenBy, World};
use crate::geometry::{Point, Vector};
use crate::occupancy::{Cell, OccupancyGrid, flood};

/// A body must reach this far into a cell to occupy it, so that a wall along a cell's edge does
/// not depend on the last bit of its coordinates.
pub(crate) const TOUCH_M: f64 = 1e-6;

/// What is free so near to the start or to a place is floor: the map may show the cell around it as
/// occupied by a wall close by.
const AROUND_M: f64 = 0.265;

impl World {
    /// The robot's map, with the lower left corner of cell (0, 0) at that of the world: cells that a wall,
    /// a mapped object or a door mapped as closed reaches into are occupied, those that cannot be
    /// reached from the start, a room or a place are unknown. Cost: cells + outline length.
    pub fn map(&self, resolution_m: f64) -> OccupancyGrid {
        self.map_seen(resolution_m, |_| true)
    }

    /// The map of what some sensor sees: mapped objects that are not `seen` are left out.
    pub fn map_seen(&self, resolution_m: f64, seen: impl Fn(SeenBy) -> bool) -> OccupancyGrid {
        self.draw(self.origin_in_map, resolution_m, |solid| self.is_mapped(solid.origin) && seen(solid.seen_by))
    }

    /// What really stands there, whatever the map says, on the grid of [`World::map`]: walls, all
    /// objects, and the doors that are not open. Cost: as for the map.
    pub fn floor(&self, resolution_m: f64, is_open: impl Fn(usize) -> bool) -> OccupancyGrid {
        self.draw(self.origin_in_map, resolution_m, |solid| match solid.origin {
            SolidOrigin::Door(index) => !is_open(index),
            SolidOrigin::Wall | SolidOrigin::Object(_) => true,
        })
    }

    /// The same with all doors open, and wherever the robot starts: what cannot be reached from there is free, too.
    /// Cost: as for the map.
    pub fn open_floor(&self, resolution_m: f64) -> OccupancyGrid {
        self.draw_all(self.origin_in_map, resolution_m, |solid| !matches!(solid.origin, SolidOrigin::Door(_)))
    }

    /// The same map on a grid centred on the middle of the world, so that the pose mirrored by 180°
    /// falls on the mirrored cell: (column, row) on (columns − 1 − column, rows − 1 − row).
    pub fn map_centred(&self, resolution_m: f64) -> OccupancyGrid {
        self.map_centred_seen(resolution_m, |_| true)
    }

    /// The centred map of what some sensor sees: mapped objects that are not `seen` are left out.
    pub fn map_centred_seen(&self, resolution_m: f64, seen: impl Fn(SeenBy) -> bool) -> OccupancyGrid {
        let (columns, rows) = self.cells(resolution_m);
        let half = Vector::new(columns as f64, rows as f64) * (resolution_m / 2.0);
        let origin_in_map = self.bounds().centre() - half;
        self.draw(origin_in_map, resolution_m, |solid| self.is_mapped(solid.origin) && seen(solid.seen_by))
    }

    fn cells(&self, resolution_m: f64) -> (usize, usize) {
        assert!(resolution_m > 0.0, "a cell needs a size");
        let count = |length_m: f64| libm::ceil(length_m / resolution_m - TOUCH_M) as usize;
        (count(self.size_m.x), count(self.size_m.y))
    }

    /// Whether the robot's map shows a body.
    pub(crate) fn is_mapped(&self, origin: SolidOrigin) -> bool {
        match origin {
            SolidOrigin::Wall => true,
            SolidOrigin::Door(index) => !self.doors[index].mapped_open,
            SolidOrigin::Object(index) => self.objects[index].mapped,
        }
    }

    fn draw(&self, origin_in_map: Point, resolution_m: f64, is_there: impl Fn(&Solid) -> bool) -> OccupancyGrid {
        let mut grid = self.draw_all(origin_in_map, resolution_m, is_there);
        self.forget_outside(&mut grid);
        grid
    }

    fn draw_all(&self, origin_in_map: Point, resolution_m: f64, is_there: impl Fn(&Solid) -> bool) -> OccupancyGrid {
        let (columns, rows) = self.cells(resolution_m);
        let mut grid = OccupancyGrid::filled(origin_in_map, resolution_m, columns, rows, Cell::Free);
        for solid in self.solids().iter().filter(|solid| is_there(solid)) {
            occupy(&mut grid, &solid.outline, self.bounds());
        }
        beyond_edge(&mut grid, self.bounds());
        self.forget_unrecorded(&mut grid);
        grid
    }

    /// Turns the free cells that a recorded map does not know into unknown ones.
    pub(super) fn forget_unrecorded(&self, grid: &mut OccupancyGrid) {
        let Some(recorded) = &self.recorded else { return };
        for row in 0..grid.rows {
            for column in 0..grid.columns {
                if grid.get(column, row) == Cell::Free && recorded.at(grid.centre(column, row)) == Cell::Unknown {
                    grid.set(column, row, Cell::Unknown);
                }
            }
        }
    }

    /// Turns the free cells that nothing the robot knows is connected with into unknown ones.
    fn forget_outside(&self, grid: &mut OccupancyGrid) {
        let points = self.places.iter().map(|place| place.pose_in_map.point()).chain([self.start_in_map.point()]);
        let mut known: Vec<(usize, usize)> = points.flat_map(|point| cells_around(grid, point)).collect();
        for room in &self.rooms {
            known.extend(cells_within(grid, room.rect));
        }
        let mut is_closed: Vec<bool> = grid.cells.iter().map(|&cell| cell != Cell::Free).collect();
        flood(grid.columns, &mut is_closed, known, |_, _| {});
        for (cell, is_closed) in grid.cells.iter_mut().zip(is_closed) {
            if !is_closed {
                *cell = Cell::Unknown;
            }
        }
    }
}

/// The cell around a point and those whose centres are near to it.
fn cells_around(grid: &OccupancyGrid, point: Point) -> Vec<(usize, usize)> {
    let reach = Vector::new(AROUND_M, AROUND_M);
    let mut cells = cells_within(grid, Rect { min: point - reach, max: point + reach });
    cells.retain(|(column, row)| (grid.centre(*column, *row) - point).norm_squared() < AROUND_M * AROUND_M);
    cells.extend(grid.cell_at(point));
    cells
}

fn cells_within(grid: &OccupancyGrid, rect: Rect) -> Vec<(usize, usize)> {
    let columns = span(grid.origin_in_frame.x, grid.resolution_m, grid.columns, rect.min.x, rect.max.x);
    let rows = span(grid.origin_in_frame.y, grid.resolution_m, grid.rows, rect.min.y, rect.max.y);
    rows.flat_map(|row| columns.clone().map(move |column| (column, row))).collect()
}

fn span(origin_m: f64, resolution_m: f64, count: usize, from_m: f64, to_m: f64) -> std::ops::Range<usize> {
    let first = libm::floor((from_m - origin_m - TOUCH_M) / resolution_m).max(0.0);
    let last = libm::floor((to_m - origin_m + TOUCH_M) / resolution_m).min(count as f64 - 1.0);
    if last < first { 0..0 } else { first as usize..last as usize + 1 }
}

/// Turns the free cells that the edge of the world cuts, or that lie beyond it, into unknown ones: nobody gets there.
pub(super) fn beyond_edge(grid: &mut OccupancyGrid, bounds: Rect) {
    let half = Vector::new(grid.resolution_m, grid.resolution_m) / 2.0 - Vector::new(TOUCH_M, TOUCH_M);
    let within = Rect { min: bounds.min + half, max: bounds.max - half };
    for row in 0..grid.rows {
        for column in 0..grid.columns {
            if grid.get(column, row) == Cell::Free && !within.contains(grid.centre(column, row)) {
                grid.set(column, row, Cell::Unknown);
            }
        }
    }
}

/// What stands beyond the edge of the world is not there.
pub(super) fn occupy(grid: &mut OccupancyGrid, outline: &Outline, bounds: Rect) {
    for (column, row) in cells_within(grid, outline.bounds()) {
        let centre = grid.centre(column, row);
        let half = Vector::new(grid.resolution_m, grid.resolution_m) / 2.0;
        let (min, max) = ((centre - half).sup(&bounds.min), (centre + half).inf(&bounds.max));
        if reaches_into(outline, Rect { min, max }) {
            grid.set(column, row, Cell::Occupied);
        }
    }
}

fn reaches_into(outline: &Outline, cell: Rect) -> bool {
    match outline {
        Outline::Disc { centre, radius_m } => {
            let nearest = centre.sup(&cell.min).inf(&cell.max);
            (nearest - centre).norm_squared().sqrt() < radius_m - TOUCH_M
        }
        Outline::Polygon(corners) => {
            // A wall without thickness occupies the cells on both sides of an edge it runs along.
            let margin = if corners.len() < 3 { -TOUCH_M } else { TOUCH_M };
            let shrink = Vector::new(margin, margin);
            let inner = Rect { min: cell.min + shrink, max: cell.max - shrink };
            outline.edges().any(|(a, b)| part_within(a, b, inner).is_some()) || outline.contains(inner.centre())
        }
    }
}
