//! Which surfaces matter from where: for each cell of a uniform grid, the surfaces that can be seen
//! from some point of it, and those that can be touched.

use super::surface::{Surface, SurfaceForm};
use crate::geometry::{Point, Vector};
use crate::world::{Rect, SolidOrigin};

const CELL_M: f64 = 1.0;

/// More walls than this are not asked what they hide from one cell: asking takes the product of walls
/// and surfaces.
const MOST_HIDING: usize = 256;

/// Lists of surface indices per cell, row-major, flattened.
#[derive(Debug)]
pub(super) struct Candidates {
    cells: Cells,
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
    fn new(lists: &[Vec<u32>]) -> Self {
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

/// Where the cells lie.
#[derive(Clone, Copy, Debug)]
struct Cells {
    origin_in_map: Point,
    columns: usize,
    rows: usize,
}

impl Cells {
    fn over(bounds: Rect) -> Self {
        let size_m = bounds.max - bounds.min;
        let count = |length_m: f64| (libm::ceil(length_m / CELL_M) as usize).max(1);
        Self { origin_in_map: bounds.min, columns: count(size_m.x), rows: count(size_m.y) }
    }

    fn rect(&self, cell: usize) -> Rect {
        let (column, row) = ((cell % self.columns) as f64, (cell / self.columns) as f64);
        let min = self.origin_in_map + Vector::new(column, row) * CELL_M;
        Rect { min, max: min + Vector::new(CELL_M, CELL_M) }
    }

    /// Column and row around a point; one outside belongs to the cell at the edge.
    fn around(&self, point: Point) -> (usize, usize) {
        let from_origin = (point - self.origin_in_map) / CELL_M;
        let column = (from_origin.x.max(0.0) as usize).min(self.columns - 1);
        let row = (from_origin.y.max(0.0) as usize).min(self.rows - 1);
        (column, row)
    }

    fn cell(&self, point: Point) -> usize {
        let (column, row) = self.around(point);
        row * self.columns + column
    }

    /// The cells that may be within reach of a surface, and none far off, from the first column and
    /// row to the last: their number does not grow with the world.
    fn span(&self, form: &SurfaceForm, reach_m: f64) -> [(usize, usize); 2] {
        let bounds = form.bounds();
        // A cell is within reach by its middle, see `may_be_within`.
        let reach = Vector::new(reach_m + CELL_M, reach_m + CELL_M);
        [self.around(bounds.min - reach), self.around(bounds.max + reach)]
    }

    fn around_form(self, form: &SurfaceForm, reach_m: f64) -> impl Iterator<Item = usize> {
        let [(first_column, first_row), (last_column, last_row)] = self.span(form, reach_m);
        (first_row..=last_row)
            .flat_map(move |row| (first_column..=last_column).map(move |column| row * self.columns + column))
    }

    fn count_around(&self, form: &SurfaceForm, reach_m: f64) -> f64 {
        let [(first_column, first_row), (last_column, last_row)] = self.span(form, reach_m);
        (last_column - first_column + 1) as f64 * (last_row - first_row + 1) as f64
    }

    /// For each cell the numbers of the surfaces within reach of it, in their order.
    fn within(self, surfaces: &[Surface], reach_m: f64) -> Vec<Vec<u32>> {
        let mut lists = vec![Vec::new(); self.columns * self.rows];
        for (index, surface) in surfaces.iter().enumerate() {
            for cell in self.around_form(&surface.form, reach_m) {
                if may_be_within(&surface.form, &self.rect(cell), reach_m) {
                    lists[cell].push(index as u32);
                }
            }
        }
        lists
    }
}

impl Candidates {
    /// Lists for sensors, a body that touches, and people who walk by, that reach so far. Only the first of the
    /// surfaces are `seen`. Cost: surfaces, times the cells around each of them.
    pub fn new(surfaces: &[Surface], seen: usize, bounds: Rect, [range_m, touch_m, walk_m]: [f64; 3]) -> Self {
        let cells = Cells::over(bounds);
        let mut visible = cells.within(&surfaces[..seen], range_m);
        for (index, near) in visible.iter_mut().enumerate() {
            keep_seen(near, surfaces, &cells.rect(index));
        }
        let lists = |reach_m: f64| Lists::new(&cells.within(surfaces, reach_m));
        Self { cells, visible: Lists::new(&visible), touchable: lists(touch_m), walkable: lists(walk_m) }
    }

    /// How many entries the lists have at most.
    pub fn most_entries(surfaces: impl Iterator<Item = Surface>, bounds: Rect, reaches_m: [f64; 3]) -> f64 {
        let cells = Cells::over(bounds);
        let around =
            |form: &SurfaceForm| -> f64 { reaches_m.iter().map(|&reach_m| cells.count_around(form, reach_m)).sum() };
        surfaces.map(|surface| around(&surface.form)).sum()
    }

    /// Surfaces that a sensor at the point may see.
    pub fn visible(&self, point: Point) -> &[u32] {
        self.visible.of(self.cells.cell(point))
    }

    /// Surfaces that the body at the point may touch.
    pub fn touchable(&self, point: Point) -> &[u32] {
        self.touchable.of(self.cells.cell(point))
    }

    /// Surfaces that a person at the point must mind.
    pub fn walkable(&self, point: Point) -> &[u32] {
        self.walkable.of(self.cells.cell(point))
    }
}

/// Leaves out what no point of a cell can see. Cost: what is near, times at most [`MOST_HIDING`].
fn keep_seen(near: &mut Vec<u32>, surfaces: &[Surface], cell: &Rect) {
    let walls = hiding(near, surfaces);
    near.retain(|index| {
        let form = &surfaces[*index as usize].form;
        corners(cell).iter().any(|corner| form.faces(*corner)) && !walls.iter().any(|wall| hides(wall, form, cell))
    });
}

/// The walls that may hide something, of many the longest: what is not left out is only looked at in
/// vain.
fn hiding(near: &[u32], surfaces: &[Surface]) -> Vec<SurfaceForm> {
    let walls = near.iter().map(|index| &surfaces[*index as usize]).filter(|wall| may_hide(wall));
    let mut walls: Vec<SurfaceForm> = walls.map(|wall| wall.form).collect();
    if walls.len() > MOST_HIDING {
        walls.sort_by(|a, b| length2_m2(b).total_cmp(&length2_m2(a)));
        walls.truncate(MOST_HIDING);
    }
    walls
}

/// The square of the length of an edge.
fn length2_m2(form: &SurfaceForm) -> f64 {
    match form {
        SurfaceForm::Edge { a, b } => (b - a).norm_squared(),
        SurfaceForm::Disc { .. } => 0.0,
    }
}

fn corners(rect: &Rect) -> [Point; 4] {
    [rect.min, Point::new(rect.max.x, rect.min.y), rect.max, Point::new(rect.min.x, rect.max.y)]
}

/// Never false if some point of the cell is within reach of the surface.
fn may_be_within(form: &SurfaceForm, cell: &Rect, reach_m: f64) -> bool {
    let half_diagonal_m = (cell.max - cell.min).norm_squared().sqrt() / 2.0;
    form.distance_m(cell.centre()) <= reach_m + half_diagonal_m
}

/// Whether it is worth asking what a surface hides: only walls never go away, and one much shorter
/// than a cell hides next to nothing from all of the cell.
fn may_hide(surface: &Surface) -> bool {
    surface.origin == SolidOrigin::Wall && length2_m2(&surface.form) >= CELL_M * CELL_M / 4.0
}

/// Whether a wall's edge hides the whole surface from the whole cell. If every corner of the cell
/// sees every corner of the surface through the edge, so does every point in between: what a
/// point sees of the edge's line moves monotonically with either end of the view.
fn hides(wall: &SurfaceForm, form: &SurfaceForm, cell: &Rect) -> bool {
    let SurfaceForm::Edge { a, b } = *wall else { return false };
    let targets = match form {
        SurfaceForm::Edge { a, b } => [*a, *b, *a, *b],
        SurfaceForm::Disc { centre, radius_m } => {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::SeenBy;
    use rpl_random::Stream;

    fn surfaces(count: usize, bounds: Rect) -> Vec<Surface> {
        let mut stream = Stream::new(71, "surfaces");
        let mut draw = || {
            // Some begin or end outside the world.
            let a = Point::new(
                stream.uniform_in(bounds.min.x - 1.0, bounds.max.x + 1.0),
                stream.uniform_in(bounds.min.y - 1.0, bounds.max.y + 1.0),
            );
            let b = a + Vector::new(stream.uniform_in(-2.0, 2.0), stream.uniform_in(-2.0, 2.0));
            let disc = SurfaceForm::Disc { centre: a, radius_m: stream.uniform_in(0.1, 1.0) };
            let form = if stream.chance(0.3) { disc } else { SurfaceForm::Edge { a, b } };
            Surface { form, origin: SolidOrigin::Wall, seen_by: SeenBy { sonar: true, laser: true } }
        };
        (0..count).map(|_| draw()).collect()
    }

    #[test]
    fn the_lists_are_those_of_asking_every_surface_about_every_cell() {
        let bounds = Rect { min: Point::new(-3.0, 2.0), max: Point::new(14.5, 13.2) };
        let surfaces = surfaces(200, bounds);
        let cells = Cells::over(bounds);
        for reach_m in [0.35, 1.0, 5.0] {
            for (index, list) in cells.within(&surfaces, reach_m).into_iter().enumerate() {
                let rect = cells.rect(index);
                let near = (0..surfaces.len()).filter(|&at| may_be_within(&surfaces[at].form, &rect, reach_m));
                assert_eq!(list, near.map(|at| at as u32).collect::<Vec<_>>(), "cell {index}");
            }
        }
    }

    #[test]
    fn of_very_many_walls_only_the_longest_are_asked_what_they_hide() {
        let bounds = Rect { min: Point::origin(), max: Point::new(4.0, 4.0) };
        let surfaces = surfaces(4_000, bounds);
        let near: Vec<u32> = (0..4_000).collect();
        let asked = hiding(&near, &surfaces);
        let shortest = asked.iter().map(length2_m2).fold(f64::INFINITY, f64::min);
        let longer = surfaces.iter().filter(|wall| length2_m2(&wall.form) > shortest).count();
        assert_eq!((asked.len(), longer), (MOST_HIDING, MOST_HIDING - 1));
        assert!(hiding(&near[..100], &surfaces).len() <= 100);
    }

    #[test]
    fn a_surface_is_asked_about_no_more_cells_in_a_larger_world() {
        let wall = SurfaceForm::Edge { a: Point::new(10.2, 10.2), b: Point::new(11.7, 10.2) };
        let asked = |size_m: f64| {
            let cells = Cells::over(Rect { min: Point::origin(), max: Point::new(size_m, size_m) });
            cells.around_form(&wall, 5.0).count()
        };
        assert_eq!(asked(40.0), asked(400.0));
        assert!(asked(40.0) <= 14 * 14, "{}", asked(40.0));
    }
}
