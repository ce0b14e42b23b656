//! Merging sonar and vision (Gutierrez-Osuna and Luo, Table 1): a marker lies on the floor beside every doorway, and
//! none beside a hallway or a foyer.
//!
//! | | opening | indentation | neither |
//! | --- | --- | --- | --- |
//! | marker | open door | closed door | closed door, or open if there is any sign of it |
//! | no marker | hallway or foyer by its width; as wide as a door, an open door | closed door, not marked | |
//!
//! # Deviation
//! The paper's table has no last column: its robot passes nothing by that the sonars miss. A box before a
//! closed door and a leaf flush with its wall are such things, and the marker still tells of them. An opening without
//! a marker is a hallway or a foyer in the paper; here one as wide as a door is a door whose marker somebody stands
//! on. Closed doors without markers, disabled at the competition, are told as not marked, and count for less.

use super::contour::{ContourPoint, Heard};
use super::openings::Found;
use super::parameters::PARAMETERS;
use crate::feature::{Feature, Side};
use rpl_robot::geometry::Point;

/// The markers on a side, as places along the axis: those that lie near its wall. Markers are given along the axis and
/// to the left of the line on which the detection was started.
pub(super) fn markers_beside(markers_in_hallway: &[Point], side: Side, wall_aside_m: Option<f64>) -> Vec<f64> {
    let is_beside = |marker: &&Point| {
        wall_aside_m.is_some_and(|wall_m| (side.sign() * marker.y - wall_m).abs() <= PARAMETERS.marker_aside_m)
    };
    markers_in_hallway.iter().filter(is_beside).map(|marker| marker.x).collect()
}

/// What the sonars found, with the markers of its side: what it is, and whether it is marked.
pub(super) fn merged(found: &Found, markers_m: &[f64]) -> (Feature, bool) {
    let is_at = |marker_m: &f64| is_of((found.from_m, found.to_m), *marker_m);
    let marked = markers_m.iter().any(is_at);
    match found.seen {
        // Somebody who walks through makes of a door a wider opening than one.
        Feature::Hallway if marked && found.to_m - found.from_m < PARAMETERS.marked_hallway_m => {
            (Feature::OpenDoor, true)
        }
        Feature::Hallway | Feature::Foyer => (found.seen, false),
        Feature::Wall | Feature::ClosedDoor | Feature::OpenDoor => (found.seen, marked),
    }
}

/// Whether a marker is of a door between these places.
fn is_of((from_m, to_m): (f64, f64), marker_m: f64) -> bool {
    marker_m >= from_m - PARAMETERS.marker_beside_m && marker_m <= to_m + PARAMETERS.marker_beside_m
}

/// The door of a marker that was passed without a find of the sonars.
pub(super) fn door_of_marker(
    markers_m: &[f64],
    along_m: f64,
    kept: &[ContourPoint],
    taken_m: &[(f64, f64)],
) -> Option<Found> {
    let p = &PARAMETERS;
    let was_passed = |marker_m: f64| marker_m >= p.marker_beside_m && marker_m <= along_m - p.marker_behind_m;
    let is_kept = |marker_m: f64| kept.first().is_some_and(|first| first.robot_along_m <= marker_m - p.door_m.0 / 2.0);
    let is_told = |marker_m: f64| taken_m.iter().any(|&taken_m| is_of(taken_m, marker_m));
    let mut alone = markers_m.iter().copied().filter(|&marker_m| was_passed(marker_m) && is_kept(marker_m));
    let marker_m = alone.find(|&marker_m| !is_told(marker_m))?;
    let half_m = (p.door_m.0 + p.door_m.1) / 4.0;
    let (from_m, to_m) = (marker_m - half_m, marker_m + half_m);
    let (mut wall, mut beyond, mut depth_m) = (0, 0, f64::INFINITY);
    for point in kept.iter().filter(|point| (from_m..=to_m).contains(&point.foot_m())) {
        match point.heard() {
            Heard::Wall => wall += 1,
            Heard::Beyond => (beyond, depth_m) = (beyond + 1, point.depth_m().min(depth_m)),
            Heard::Obstacle => {}
        }
    }
    let seen = if beyond > wall { Feature::OpenDoor } else { Feature::ClosedDoor };
    let depth_m = if seen == Feature::OpenDoor { depth_m } else { 0.0 };
    Some(Found { seen, from_m, to_m, depth_m })
}
