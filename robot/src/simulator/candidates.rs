//! Which surfaces matter from where: for each cell of a uniform grid, the surfaces that can be seen
//! from some point of it, and those that can be touched.

use super::surface::{Form, Surface};
use crate::geometry::{Point, Vector};
use crate::world::{Origin, Rect};

const CELL_M: f64 = 1.0;

/// Lists of surface indices per cell, row-major, flattened.
#[derive(Debug)]
pub(super) struct Candidates {
    origin_in_map: Point,
    columns: usize,
    rows: usize,
    visible: Lists,
    touchable: Lists,
    walkable: Lists,
}

#[derive(Debug)]
struct Lists {
    starts: Vec<u32>,
    indices: Vec<u32>,
}

impl Lists {
    fn new(lists: impl Iterator<Item = Vec<u32>>) -> Self {
        let (mut starts, mut indices) = (vec![0], Vec::new());
        for list in lists {
            indices.extend(list);
            starts.push(indices.len() as u32);
        }
        Self { starts, indices }
    }

    fn of(&self, cell: usize) -> &[u32] {
        &self.indices[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }
}

impl Candidates {
    /// Lists for sensors that reach `range_m`, a body that touches within `touch_m`, and people who
    /// walk by within `walk_m`.
    pub fn new(surfaces: &[Surface], bounds: Rect, range_m: f64, touch_m: f64, walk_m: f64) -> Self {
        let size_m = bounds.max - bounds.min;
        let columns = (libm::ceil(size_m.x / CELL_M) as usize).max(1);
        let rows = (libm::ceil(size_m.y / CELL_M) as usize).max(1);
        let cells: Vec<Rect> = (0..rows * columns)
            .map(|cell| {
                let min = bounds.min + Vector::new((cell % columns) as f64 * CELL_M, (cell / columns) as f64 * CELL_M);
                Rect { min, max: min + Vector::new(CELL_M, CELL_M) }
            })
            .collect();
        let within = |cell: &Rect, reach_m: f64| -> Vec<u32> {
            let near = surfaces.iter().enumerate().filter(|(_, surface)| may_be_within(&surface.form, cell, reach_m));
            near.map(|(index, _)| index as u32).collect()
        };
        let seen_from = |cell: &Rect| -> Vec<u32> {
            let mut near = within(cell, range_m);
            let walls: Vec<Form> = near
                .iter()
                .map(|index| &surfaces[*index as usize])
                .filter(|wall| may_hide(wall))
                .map(|wall| wall.form)
                .collect();
            near.retain(|index| {
                let form = &surfaces[*index as usize].form;
                corners(cell).iter().any(|corner| form.faces(*corner))
                    && !walls.iter().any(|wall| hides(wall, form, cell))
            });
            near
        };
        let visible = Lists::new(cells.iter().map(seen_from));
        let touchable = Lists::new(cells.iter().map(|cell| within(cell, touch_m)));
        let walkable = Lists::new(cells.iter().map(|cell| within(cell, walk_m)));
        Self { origin_in_map: bounds.min, columns, rows, visible, touchable, walkable }
    }

    /// Surfaces that a sensor at the point may see.
    pub fn visible(&self, point: Point) -> &[u32] {
        self.visible.of(self.cell(point))
    }

    /// Surfaces that the body at the point may touch.
    pub fn touchable(&self, point: Point) -> &[u32] {
        self.touchable.of(self.cell(point))
    }

    /// Surfaces that a person at the point must mind.
    pub fn walkable(&self, point: Point) -> &[u32] {
        self.walkable.of(self.cell(point))
    }

    fn cell(&self, point: Point) -> usize {
        let from_origin = (point - self.origin_in_map) / CELL_M;
        let column = (from_origin.x.max(0.0) as usize).min(self.columns - 1);
        let row = (from_origin.y.max(0.0) as usize).min(self.rows - 1);
        row * self.columns + column
    }
}

fn corners(rect: &Rect) -> [Point; 4] {
    [rect.min, Point::new(rect.max.x, rect.min.y), rect.max, Point::new(rect.min.x, rect.max.y)]
}

/// Never false if some point of the cell is within reach of the surface.
fn may_be_within(form: &Form, cell: &Rect, reach_m: f64) -> bool {
    let half_diagonal_m = (cell.max - cell.min).norm_squared().sqrt() / 2.0;
    form.distance_m(cell.centre()) <= reach_m + half_diagonal_m
}

/// Whether it is worth asking what a surface hides: only walls never go away, and one much shorter
/// than a cell hides next to nothing from all of the cell.
fn may_hide(surface: &Surface) -> bool {
    let length2 = match surface.form {
        Form::Edge { a, b } => (b - a).norm_squared(),
        Form::Disc { .. } => 0.0,
    };
    surface.origin == Origin::Wall && length2 >= CELL_M * CELL_M / 4.0
}

/// Whether a wall's edge hides the whole surface from the whole cell. If every corner of the cell
/// sees every corner of the surface through the edge, so does every point in between: what a
/// point sees of the edge's line moves monotonically with either end of the view.
fn hides(wall: &Form, form: &Form, cell: &Rect) -> bool {
    let Form::Edge { a, b } = *wall else { return false };
    let targets = match form {
        Form::Edge { a, b } => [*a, *b, *a, *b],
        Form::Disc { centre, radius_m } => {
            let reach = Vector::new(*radius_m, *radius_m);
            corners(&Rect { min: centre - reach, max: centre + reach })
        }
    };
    corners(cell).iter().all(|from| targets.iter().all(|to| crosses(*from, *to, a, b)))
}

/// Whether the two segments cross at an inner point of both.
fn crosses(from: Point, to: Point, a: Point, b: Point) -> bool {
    let margin = 1e-9;
    let side = |p: Point| cross(b - a, p - a);
    let across = |p: Point| cross(to - from, p - from);
    let separated = |s: f64, t: f64| s > margin && t < -margin || s < -margin && t > margin;
    separated(side(from), side(to)) && separated(across(a), across(b))
}

fn cross(a: Vector, b: Vector) -> f64 {
    a.x * b.y - a.y * b.x
}
