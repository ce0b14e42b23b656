//! What comes back from a surface, and where a line of sight meets one.

use crate::geometry::Vector;

/// The nearest point of a cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Echo {
    /// Distance from the apex of the cone; infinite if the cone is empty.
    pub range_m: f64,
    /// Cosine of the angle between the way to the point and the surface's normal there.
    pub incidence_cos: f64,
    /// Whether the point is the corner of a body, which scatters instead of reflecting.
    pub corner: bool,
}

/// Where a ray from the middle of the robot first meets a disc.
pub(super) fn disc_along(direction: Vector, centre: Vector, radius_m: f64) -> Option<Echo> {
    let along_m = direction.dot(&centre);
    let aside_m = cross(direction, centre);
    let depth2 = radius_m * radius_m - aside_m * aside_m;
    if along_m <= 0.0 || depth2 < 0.0 {
        return None;
    }
    let depth_m = depth2.sqrt();
    Some(Echo { range_m: along_m - depth_m, incidence_cos: depth_m / radius_m, corner: false })
}

pub(super) fn cross(a: Vector, b: Vector) -> f64 {
    a.x * b.y - a.y * b.x
}
