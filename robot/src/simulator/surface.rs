//! Surfaces that sensors see and the robot cannot pass.

use crate::geometry::{Point, Vector, distance_m};
use crate::world::{
    Outline, Rect, SeenBy, Solid, SolidOrigin, TOUCH_M, distance_to_segment_m, nearest_on_segment, part_within,
};

/// Geometry of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum SurfaceForm {
    /// A straight edge with its body on the left of `a` → `b`: only seen from the right.
    Edge {
        /// First corner.
        a: Point,
        /// Second corner.
        b: Point,
    },
    /// The outside of a disc.
    Disc {
        /// Its middle.
        centre: Point,
        /// Its radius.
        radius_m: f64,
    },
}

/// What a surface belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Body {
    /// Something of the world file.
    Solid(SolidOrigin),
    /// `state.objects_added[i]`.
    Added(usize),
    /// `state.people[i]`.
    Person(usize),
}

impl SurfaceForm {
    /// Whether the front of the surface is towards a point.
    pub fn faces(&self, point: Point) -> bool {
        match self {
            SurfaceForm::Edge { a, b } => (b - a).perp(&(point - a)) < 0.0,
            SurfaceForm::Disc { .. } => true,
        }
    }

    /// The point of the surface nearest to one outside the body.
    pub fn nearest_to(&self, point: Point) -> Point {
        match self {
            SurfaceForm::Edge { a, b } => nearest_on_segment(point, *a, *b),
            SurfaceForm::Disc { centre, radius_m } => {
                let out = point - centre;
                let length_m = out.norm_squared().sqrt();
                if length_m > 0.0 { centre + out * (radius_m / length_m) } else { *centre }
            }
        }
    }

    /// The smallest rectangle around it.
    pub fn bounds(&self) -> Rect {
        match self {
            SurfaceForm::Edge { a, b } => Rect { min: a.inf(b), max: a.sup(b) },
            SurfaceForm::Disc { centre, radius_m } => {
                let reach = Vector::new(*radius_m, *radius_m);
                Rect { min: centre - reach, max: centre + reach }
            }
        }
    }

    /// Distance from a point outside the body.
    pub fn distance_m(&self, point: Point) -> f64 {
        match self {
            SurfaceForm::Edge { a, b } => distance_to_segment_m(point, *a, *b),
            SurfaceForm::Disc { centre, radius_m } => distance_m(*centre, point) - radius_m,
        }
    }
}

/// A surface of the world file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Surface {
    pub form: SurfaceForm,
    pub origin: SolidOrigin,
    pub seen_by: SeenBy,
}

/// The surfaces of a body.
pub(super) fn surfaces_of(solid: &Solid, world: Rect) -> Vec<Surface> {
    let surface = |form| Surface { form, origin: solid.origin, seen_by: solid.seen_by };
    forms_of(&solid.outline, world).into_iter().map(surface).collect()
}

/// The corners of a disc that the edge of the world cuts.
const DISC_CORNERS: usize = 64;

/// The surfaces of an outline, as far as they are in the world: what lies beyond its edge is not there, as in its map.
pub(super) fn forms_of(outline: &Outline, world: Rect) -> Vec<SurfaceForm> {
    let Rect { min, max } = outline.bounds();
    let reaches_m = [max.x - world.min.x, max.y - world.min.y, world.max.x - min.x, world.max.y - min.y];
    let reaches_in = |least_m: f64| reaches_m.iter().all(|&reach_m| reach_m > least_m);
    let within = |outline: &Outline| outline.edges().filter_map(|(a, b)| edge_within(a, b, world)).collect();
    match outline {
        Outline::Disc { centre, radius_m } if world.contains(min) && world.contains(max) => {
            vec![SurfaceForm::Disc { centre: *centre, radius_m: *radius_m }]
        }
        Outline::Disc { centre, radius_m } if reaches_in(TOUCH_M) => within(&polygon(*centre, *radius_m)),
        // A wall without thickness is in the world also where it runs along its edge.
        Outline::Polygon(corners) if reaches_in(if corners.len() < 3 { -TOUCH_M } else { TOUCH_M }) => within(outline),
        Outline::Disc { .. } | Outline::Polygon(_) => Vec::new(),
    }
}

fn polygon(centre: Point, radius_m: f64) -> Outline {
    let corner = |number: usize| {
        let (sin, cos) = libm::sincos(number as f64 * std::f64::consts::TAU / DISC_CORNERS as f64);
        centre + Vector::new(cos, sin) * radius_m
    };
    Outline::Polygon((0..DISC_CORNERS).map(corner).collect())
}

fn edge_within(a: Point, b: Point, world: Rect) -> Option<SurfaceForm> {
    let touch = Vector::new(TOUCH_M, TOUCH_M);
    let (from, to) = part_within(a, b, Rect { min: world.min - touch, max: world.max + touch })?;
    let at = |share: f64, end: Point| if share == 0.0 || share == 1.0 { end } else { a + (b - a) * share };
    (from < to).then(|| SurfaceForm::Edge { a: at(from, a), b: at(to, b) })
}
