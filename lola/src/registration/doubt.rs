//! Doubt: whether the robot still looks the way that it believes, told from single scans. Somebody may turn it by
//! hand, of which the odometry knows nothing.

use super::ring::Ring;
use super::walls::{HallwayAxis, WIDEST_RAD};
use crate::beside::{aside_m, side_readings};
use crate::feature::Side;
use rpl_robot::geometry::{Pose, wrap_angle_rad};
use rpl_robot::sensors::SonarScan;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI};

/// Echoes of one wall are within this distance of each other, beside an axis that is off by less than half a cone.
const SAME_WALL_M: f64 = 0.06;

/// A wall stands where it was if it is within this distance.
const WHERE_IT_WAS_M: f64 = 0.12;

/// A wall is not square to the hallway if it is off by more than this.
const ASLANT_RAD: f64 = 0.22;

/// What is off by less is put right by the fit to the walls.
const TURNED_RAD: f64 = 0.45;

/// Directions are tried in steps of this.
const GRAIN_RAD: f64 = 0.05;

/// How many scans in a row must show the hallway as it was known to end the doubt.
const CONFIRMING: u32 = 3;

/// Who is turned by hand is turned at once: the walls run another way as soon as the doubt begins. In a crossing they
/// end, and other walls come farther on.
const AT_ONCE_M: f64 = 0.3;

/// Another direction is believed when the scans that agree on it, to within the angle, outnumber the others by the
/// first number.
const SCANS: u32 = 8;
const AGREED_RAD: f64 = 0.3;

/// No wall of the hallway is heard where it was, and perhaps others are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Doubt {
    /// Where the robot was when it began, as far as it knew.
    pub since_in_odom: Pose,
    /// Another direction of the hallway that most scans agree on, in `odom`, and how many more than do not.
    found: Option<(f64, u32)>,
    /// What was heard before it began.
    before: Option<Ring>,
    /// How many scans before the last have shown the hallway as it was known, in a row.
    confirmed: u32,
}

impl Doubt {
    /// Takes in a scan: whether no wall of the hallway is heard where it is to be, by what was in doubt before, and
    /// what was heard in the scan before.
    pub fn after(
        before: Option<Self>,
        heard: Option<&Ring>,
        axis: &HallwayAxis,
        odometry_in_odom: Pose,
        scan: SonarScan<'_>,
    ) -> Option<Self> {
        let is_confirmed = is_confirmed(axis, odometry_in_odom, scan);
        if is_confirmed && before.as_ref().is_none_or(|before| before.confirmed + 1 >= CONFIRMING) {
            return None;
        }
        let mut doubt = before.unwrap_or_else(|| Self {
            since_in_odom: odometry_in_odom,
            found: None,
            before: heard.cloned(),
            confirmed: 0,
        });
        doubt.confirmed = if is_confirmed { doubt.confirmed + 1 } else { 0 };
        let is_at_once = odometry_in_odom.distance_m(doubt.since_in_odom) < AT_ONCE_M;
        let other_rad = doubt.hallway_around_rad(axis, odometry_in_odom, scan);
        let is_turned = |other_rad: &f64| {
            let by_rad = other_rad - axis.heading_in_odom_rad;
            doubt.before.as_ref().is_none_or(|before| before.is_turned(by_rad, odometry_in_odom, scan))
        };
        let is_believable = !is_confirmed && (is_at_once || doubt.has_found());
        if let Some(other_rad) = other_rad.filter(|other_rad| is_believable && is_turned(other_rad)) {
            doubt.found = Some(voted(doubt.found, other_rad));
        }
        Some(doubt)
    }

    /// The direction of the hallway, in `odom`, that this scan explains best, if that is another: of both ways that its
    /// walls run, the one that is nearer to how they ran. A hallway looks the same both ways, so who was turned by
    /// more than a right angle goes back.
    ///
    /// One wall alone must be aslant: the walls of crossings and foyers are square to the axis.
    fn hallway_around_rad(&self, axis: &HallwayAxis, odometry_in_odom: Pose, scan: SonarScan<'_>) -> Option<f64> {
        let steps = (PI / GRAIN_RAD) as i32;
        let tried = (0..=steps).filter_map(|step| {
            let off_rad = -FRAC_PI_2 + f64::from(step) * GRAIN_RAD;
            let walls = self.walls_beside(axis, off_rad, odometry_in_odom, scan);
            let nearness: Option<f64> = walls.iter().copied().flatten().reduce(|one, other| one + other);
            Some((nearness?, off_rad, walls.iter().all(Option::is_some)))
        });
        let (_, off_rad, both) = tried.max_by(|one, other| one.0.total_cmp(&other.0))?;
        let is_aslant = FRAC_PI_2 - off_rad.abs() >= ASLANT_RAD;
        let is_other = off_rad.abs() >= TURNED_RAD && (both || is_aslant);
        is_other.then(|| wrap_angle_rad(axis.heading_in_odom_rad + off_rad))
    }

    /// How well each wall of the hallway is heard beside the robot if it runs so far off its axis; none if not where
    /// it was.
    fn walls_beside(
        &self,
        axis: &HallwayAxis,
        off_rad: f64,
        odometry_in_odom: Pose,
        scan: SonarScan<'_>,
    ) -> [Option<f64>; 2] {
        let axis_rad = axis.heading_in_odom_rad + off_rad;
        Side::ALL.map(|side| {
            let (heard_m, nearness) = wall_beside(scan, odometry_in_odom.heading_rad - axis_rad, side)?;
            self.is_where_it_was(axis, side, heard_m, axis_rad, odometry_in_odom).then_some(nearness)
        })
    }

    /// Whether a wall that is heard beside an axis is as far off as that of the hallway was, if the robot was turned on
    /// the spot: at some moment since it is in doubt, after which it went another way than it believed.
    fn is_where_it_was(
        &self,
        axis: &HallwayAxis,
        side: Side,
        heard_m: f64,
        axis_rad: f64,
        odometry_in_odom: Pose,
    ) -> bool {
        let gone_m = aside_m(odometry_in_odom, axis_rad, side) - aside_m(self.since_in_odom, axis_rad, side);
        let (least_m, most_m) = (gone_m.min(0.0) - WHERE_IT_WAS_M, gone_m.max(0.0) + WHERE_IT_WAS_M);
        let expected_m = axis.wall_distance_m(self.since_in_odom, side);
        expected_m.is_some_and(|expected_m| (least_m..=most_m).contains(&(expected_m - heard_m)))
    }

    /// Whether another direction was found at all.
    pub fn has_found(&self) -> bool {
        self.found.is_some()
    }

    /// The direction that the hallway has instead, in `odom`, once enough scans agree on it.
    pub fn other_axis_in_odom_rad(&self) -> Option<f64> {
        self.found.filter(|(_, scans)| *scans >= SCANS).map(|(axis_rad, _)| axis_rad)
    }
}

/// The direction that most scans agree on after one more (Boyer and Moore's majority vote), and by how many.
fn voted(before: Option<(f64, u32)>, other_rad: f64) -> (f64, u32) {
    match before {
        Some((known_rad, lead)) if wrap_angle_rad(other_rad - known_rad).abs() < AGREED_RAD => {
            let share = 1.0 / f64::from(lead + 1);
            (wrap_angle_rad(known_rad + share * wrap_angle_rad(other_rad - known_rad)), lead + 1)
        }
        Some((known_rad, lead)) if lead > 1 => (known_rad, lead - 1),
        Some(_) | None => (other_rad, 1),
    }
}

/// Whether a wall of the hallway is heard where it is to be.
fn is_confirmed(axis: &HallwayAxis, odometry_in_odom: Pose, scan: SonarScan<'_>) -> bool {
    let heading_rad = odometry_in_odom.heading_rad - axis.heading_in_odom_rad;
    Side::ALL.into_iter().any(|side| {
        let heard = wall_beside(scan, heading_rad, side);
        let expected_m = axis.wall_distance_m(odometry_in_odom, side);
        heard.zip(expected_m).is_some_and(|(heard, expected_m)| (heard.0 - expected_m).abs() < WHERE_IT_WAS_M)
    })
}

/// A wall on a side of a robot with this heading in a hallway: how far off, if more than half of the sonars that look
/// there hear it, and how well these agree.
fn wall_beside(scan: SonarScan<'_>, heading_in_hallway_rad: f64, side: Side) -> Option<(f64, f64)> {
    let readings = side_readings(scan, heading_in_hallway_rad, side, WIDEST_RAD);
    let heard_m: Vec<f64> = readings.map(|reading| reading.apex_aside_m + reading.perpendicular_m()).collect();
    let agreeing = |at_m: f64| heard_m.iter().copied().filter(move |heard_m| (heard_m - at_m).abs() < SAME_WALL_M);
    let most_m = heard_m.iter().copied().max_by_key(|&at_m| agreeing(at_m).count())?;
    let count = agreeing(most_m).count();
    if 2 * count <= heard_m.len() {
        return None;
    }
    let mean_m = agreeing(most_m).sum::<f64>() / count as f64;
    let nearness = |heard_m: f64| {
        let off = (heard_m - mean_m) / SAME_WALL_M;
        1.0 - off * off
    };
    Some((mean_m, agreeing(most_m).map(nearness).sum()))
}
