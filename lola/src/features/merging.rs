//! Merging sonar and vision (Gutierrez-Osuna and Luo, Table 1).

use super::openings::Found;
use super::parameters::PARAMETERS;
use crate::feature::{Feature, Side};
use rpl_robot::geometry::Point;

/// What a find of the sonars is, with the markers that the camera has seen: what was seen, and whether a marker
/// stands beside it. Without a camera it is what the sonars say.
///
/// | | opening | indentation |
/// | --- | --- | --- |
/// | marker | open door | closed door |
/// | no marker | hallway or foyer, by its width | closed door, which a person or a box before the marker explains |
///
/// # Deviation
/// An opening as wide as a door without a marker is an open door, whose marker was hidden: no hallway is that narrow.
/// One much wider than a door with a marker is a hallway, whose marker belongs to a door around the corner.
pub(super) fn merged(
    found: Found,
    side: Side,
    wall_aside_m: Option<f64>,
    markers_in_hallway: Option<&[Point]>,
) -> Option<(Feature, bool)> {
    let markers = markers_in_hallway.unwrap_or_default();
    let is_beside = |marker: &Point| {
        let p = &PARAMETERS;
        let is_along = marker.x >= found.from_m - p.marker_beside_m && marker.x <= found.to_m + p.marker_beside_m;
        let aside_m = side.sign() * marker.y;
        is_along && wall_aside_m.is_some_and(|wall_m| (aside_m - wall_m).abs() <= p.marker_aside_m)
    };
    Some((found.seen, markers.iter().any(is_beside)))
}
