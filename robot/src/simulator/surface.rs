//! Surfaces that sensors see and the robot cannot pass.

use crate::geometry::{Point, Vector, distance_m};
use crate::world::{Outline, Rect, SeenBy, Solid, SolidOrigin, distance_to_segment_m, nearest_on_segment};

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
pub(super) fn surfaces_of(solid: &Solid) -> impl Iterator<Item = Surface> + '_ {
    forms_of(&solid.outline).map(|form| Surface { form, origin: solid.origin, seen_by: solid.seen_by })
}

pub(super) fn forms_of(outline: &Outline) -> impl Iterator<Item = SurfaceForm> + '_ {
    let disc = match outline {
        Outline::Disc { centre, radius_m } => Some(SurfaceForm::Disc { centre: *centre, radius_m: *radius_m }),
        Outline::Polygon(_) => None,
    };
    disc.into_iter().chain(outline.edges().map(|(a, b)| SurfaceForm::Edge { a, b }))
}
