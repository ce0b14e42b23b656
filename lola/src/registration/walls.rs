//! What a direction explains of a drive: the walls there would be.

use super::views::{View, Views};
use crate::beside::{aside_m, axes_in_odom, side_readings};
use crate::feature::Side;
use rpl_robot::geometry::{Pose, wrap_angle_rad};
use rpl_robot::sensors::SonarArray;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Transducers beside the one nearest to the perpendicular count up to here: their cones still reach to less
/// than 25° from it, where a wall reflects the pulse back.
pub(super) const WIDEST_RAD: f64 = 0.56;

/// Readings within this distance of a wall count as the wall's: twice the noise of an echo over a hallway, and less
/// than the depth of a closed door in a wall of 15 cm.
const WALL_M: f64 = 0.045;

/// Cells in which the readings of a side vote for the place of its wall.
const CELL_M: f64 = 0.03;

/// No wall is sought farther off: hallways are narrower.
const FARTHEST_M: f64 = 4.0;

/// The hallway's direction, and what it was fitted to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HallwayAxis {
    /// The direction, the way the robot drives along it, in `odom`.
    pub heading_in_odom_rad: f64,
    /// Its standard deviation, if the readings' errors are independent.
    pub deviation_rad: f64,
    /// The way on which a wall was heard that it was fitted to, on the side with more.
    pub wall_m: f64,
    /// How far its walls are apart, once both were heard.
    pub width_m: Option<f64>,
    /// Where the walls are, left and right: how far to their side of the line through the origin of `odom`
    /// along the axis. `None` where none was heard.
    pub walls_aside_m: [Option<f64>; 2],
}

impl HallwayAxis {
    /// One that was fitted to nothing, with how far from the robot its walls were heard, left and right.
    pub(super) fn guessed(heading_in_odom_rad: f64, here_in_odom: Pose, heard_m: [Option<f64>; 2]) -> Self {
        let walls_aside_m = Side::ALL.map(|side| {
            let wall_m = heard_m[side as usize]?;
            Some(aside_m(here_in_odom, heading_in_odom_rad, side) + wall_m)
        });
        let width_m = heard_m[0].zip(heard_m[1]).map(|(left_m, right_m)| left_m + right_m);
        Self { heading_in_odom_rad, deviation_rad: GUESS_RAD, wall_m: 0.0, width_m, walls_aside_m }
    }

    /// Distance to the wall on a side, from a pose in `odom`.
    pub fn wall_distance_m(&self, pose_in_odom: Pose, side: Side) -> Option<f64> {
        let wall_m = self.walls_aside_m[side as usize]?;
        Some(wall_m - aside_m(pose_in_odom, self.heading_in_odom_rad, side))
    }

    /// The same for one who goes the other way.
    pub(super) fn reversed(&self) -> Self {
        let [left_m, right_m] = self.walls_aside_m;
        Self {
            heading_in_odom_rad: wrap_angle_rad(self.heading_in_odom_rad + PI),
            walls_aside_m: [right_m, left_m],
            ..*self
        }
    }

    /// Itself, less sure by what dead reckoning may err on a way with turns.
    pub(super) fn after_driving(mut self, way_m: f64, turned_rad: f64) -> Self {
        let drift_rad2 = DRIFT2_RAD2PM * way_m + TURN_DRIFT2_RAD * turned_rad;
        self.deviation_rad = (self.deviation_rad * self.deviation_rad + drift_rad2).sqrt();
        self
    }

    /// How far another fit may be off if the difference is one of their errors.
    pub(super) fn agreement_rad(&self) -> f64 {
        AGREEMENT * (self.deviation_rad * self.deviation_rad + FIT_RAD * FIT_RAD).sqrt()
    }

    /// Whether the difference to another fit is one of their errors.
    pub(super) fn agrees_with(&self, fitted: &HallwayAxis) -> bool {
        wrap_angle_rad(fitted.heading_in_odom_rad - self.heading_in_odom_rad).abs() <= self.agreement_rad()
    }

    /// The mean of itself and a later fit, each by how sure it is, with the width of the hallway if that is known.
    pub(super) fn corrected_by(&self, fitted: &HallwayAxis, width_m: Option<f64>, here_in_odom: Pose) -> Self {
        let off_rad = wrap_angle_rad(fitted.heading_in_odom_rad - self.heading_in_odom_rad);
        let variance_rad2 = self.deviation_rad * self.deviation_rad;
        let gain = variance_rad2 / (variance_rad2 + fit_variance_rad2(fitted));
        let mut corrected = Self {
            heading_in_odom_rad: wrap_angle_rad(self.heading_in_odom_rad + gain * off_rad),
            deviation_rad: ((1.0 - gain) * variance_rad2).sqrt(),
            wall_m: fitted.wall_m,
            ..*self
        };
        let distances_m = |axis: &Self| Side::ALL.map(|side| axis.wall_distance_m(here_in_odom, side));
        let (width_m, walls_m) = walls_of_hallway(width_m, distances_m(self), distances_m(fitted));
        corrected.width_m = width_m;
        for side in Side::ALL {
            let here_m = aside_m(here_in_odom, corrected.heading_in_odom_rad, side);
            corrected.walls_aside_m[side as usize] = walls_m[side as usize].map(|wall_m| here_m + wall_m);
        }
        corrected
    }
}

/// Which of the walls that were heard last are those of the hallway, whose width is known, and not boxes or the
/// back of a foyer: two that are as far apart, or one where it was before. Distances from the robot, left and right.
fn walls_of_hallway(
    width_m: Option<f64>,
    held_m: [Option<f64>; 2],
    heard_m: [Option<f64>; 2],
) -> (Option<f64>, [Option<f64>; 2]) {
    let Some(width_m) = width_m else {
        // So far only one wall was heard.
        let walls_m = [0, 1].map(|side| heard_m[side].or(held_m[side]));
        return (walls_m[0].zip(walls_m[1]).map(|(left_m, right_m)| left_m + right_m), walls_m);
    };
    if let [Some(left_m), Some(right_m)] = heard_m
        && left_m + right_m < width_m + SAME_WALL_M
        && (left_m + right_m > width_m - SAME_WALL_M || held_m.iter().any(Option::is_none))
    {
        return (Some(width_m), heard_m);
    }
    let is_held = |side: usize| {
        let distances_m = held_m[side].zip(heard_m[side]);
        distances_m.is_some_and(|(held_m, heard_m)| (held_m - heard_m).abs() <= SAME_WALL_M)
    };
    let other_m = |wall_m: Option<f64>| wall_m.map(|wall_m| width_m - wall_m);
    let walls_m = match (is_held(0), is_held(1)) {
        (true, true) => heard_m,
        (true, false) => [heard_m[0], other_m(heard_m[0])],
        (false, true) => [other_m(heard_m[1]), heard_m[1]],
        (false, false) => held_m,
    };
    (Some(width_m), walls_m)
}

/// How far off a guessed direction usually is.
const GUESS_RAD: f64 = 0.17;

/// A wall is the same if it is heard within this distance of where it was.
const SAME_WALL_M: f64 = 0.15;

/// How much dead reckoning turns over a metre: 0.6°, squared.
const DRIFT2_RAD2PM: f64 = 0.0105 * 0.0105;

/// And how much over a turn: 2.3° after half a turn, squared.
const TURN_DRIFT2_RAD: f64 = 0.0225 * 0.0225;

/// The readings of a fit share errors, above all those of doors: it is no better than 1°, however many they are.
const FIT_RAD: f64 = 0.0175;

/// Two fits agree within this number of standard deviations.
const AGREEMENT: f64 = 3.0;

fn fit_variance_rad2(fitted: &HallwayAxis) -> f64 {
    fitted.deviation_rad * fitted.deviation_rad + FIT_RAD * FIT_RAD
}

/// Where a reading puts the wall: how far to its side of the line through the origin of `odom`.
#[derive(Clone, Copy, Debug)]
pub(super) struct WallPoint {
    pub side: Side,
    pub aside_m: f64,
    /// Along the axis, in `odom`.
    pub along_m: f64,
    /// Where along the axis the robot was.
    pub from_along_m: f64,
}

/// What a direction explains.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Explained {
    /// Readings that lie on one wall of their side, each counted by how near it is to it.
    pub score: f64,
    /// The way on which they were taken, on the side with more.
    pub wall_m: f64,
    /// The share of the readings that lie on them.
    pub share: f64,
    /// The walls, left and right.
    pub walls_aside_m: [Option<f64>; 2],
}

impl Explained {
    /// How far the walls are apart.
    pub fn walls_apart_m(&self) -> Option<f64> {
        let [left_m, right_m] = self.walls_aside_m;
        Some(left_m? + right_m?)
    }
}

/// All readings at the sides of a hallway of this direction. Cost: linear.
pub(super) fn wall_points(views: &[View], sonars: &SonarArray, axis_in_odom_rad: f64) -> Vec<WallPoint> {
    let (along, left) = axes_in_odom(axis_in_odom_rad);
    let mut points = Vec::with_capacity(views.len() * 12);
    for view in views {
        let at = view.from_in_odom.point().coords;
        let (at_along_m, at_left_m) = (along.dot(&at), left.dot(&at));
        let heading_rad = view.from_in_odom.heading_rad - axis_in_odom_rad;
        for side in Side::ALL {
            for reading in side_readings(view.scan(sonars), heading_rad, side, WIDEST_RAD) {
                let (ahead_m, perpendicular_m) = reading.echo_m();
                if perpendicular_m <= FARTHEST_M {
                    points.push(WallPoint {
                        side,
                        aside_m: side.sign() * at_left_m + reading.apex_aside_m + perpendicular_m,
                        along_m: at_along_m + reading.apex_along_m + ahead_m,
                        from_along_m: at_along_m,
                    });
                }
            }
        }
    }
    points
}

/// What a direction explains of some views. Cost: linear in them.
pub(super) fn explain(views: &[View], sonars: &SonarArray, axis_in_odom_rad: f64) -> Explained {
    explain_points(&wall_points(views, sonars, axis_in_odom_rad))
}

pub(super) fn explain_points(points: &[WallPoint]) -> Explained {
    let mut explained = Explained::default();
    let mut on_walls = 0.0;
    for side in Side::ALL {
        let Some(wall_m) = wall_aside_m(points, side) else { continue };
        let mut driven = Vec::new();
        for point in points.iter().filter(|point| point.side == side) {
            let off = (point.aside_m - wall_m) / WALL_M;
            if off.abs() < 1.0 {
                let nearness = 1.0 - off * off;
                explained.score += nearness * nearness;
                driven.push(libm::floor(point.from_along_m / VOTE_WAY_M) as i64);
            }
        }
        on_walls += driven.len() as f64;
        driven.sort_unstable();
        driven.dedup();
        explained.wall_m = explained.wall_m.max(driven.len() as f64 * VOTE_WAY_M);
        explained.walls_aside_m[side as usize] = Some(wall_m);
    }
    explained.share = on_walls / (points.len() as f64).max(1.0);
    explained
}

/// The grain in which the way along a wall is counted.
const VOTE_WAY_M: f64 = 0.05;

/// The place with most readings on a side, to the mean of those around it. A tie is the nearest one's.
fn wall_aside_m(points: &[WallPoint], side: Side) -> Option<f64> {
    let here = || points.iter().filter(|point| point.side == side);
    let least_m = here().map(|point| point.aside_m).fold(f64::INFINITY, f64::min);
    if least_m == f64::INFINITY {
        return None;
    }
    let most_m = here().map(|point| point.aside_m).fold(f64::NEG_INFINITY, f64::max);
    let mut votes = vec![0_u32; ((most_m - least_m) / CELL_M) as usize + 1];
    for point in here() {
        votes[((point.aside_m - least_m) / CELL_M) as usize] += 1;
    }
    let around = |cell: usize| {
        votes[cell] * 2 + cell.checked_sub(1).map_or(0, |before| votes[before]) + votes.get(cell + 1).unwrap_or(&0)
    };
    let most = (0..votes.len()).max_by(|&a, &b| around(a).cmp(&around(b)).then(b.cmp(&a)))?;
    let mut wall_m = least_m + (most as f64 + 0.5) * CELL_M;
    for _ in 0..3 {
        let (mut sum_m, mut weights) = (0.0, 0.0);
        for point in here() {
            let off = (point.aside_m - wall_m) / WALL_M;
            let weight = (1.0 - off * off).max(0.0);
            sum_m += weight * point.aside_m;
            weights += weight;
        }
        if weights > 0.0 {
            wall_m = sum_m / weights;
        }
    }
    Some(wall_m)
}

/// The side reference: the median over the last 25 cm of what the transducer nearest to the perpendicular heard.
pub(super) fn median_distance_m(
    views: &Views,
    sonars: &SonarArray,
    axis_in_odom_rad: f64,
    from_in_odom: Pose,
    side: Side,
) -> Option<f64> {
    let here_m = aside_m(from_in_odom, axis_in_odom_rad, side);
    let distance_m = |view: &View| {
        let heading_rad = view.from_in_odom.heading_rad - axis_in_odom_rad;
        let readings = side_readings(view.scan(sonars), heading_rad, side, WIDEST_RAD);
        let nearest = readings.min_by(|a, b| a.off_rad().total_cmp(&b.off_rad()))?;
        let heard_m = nearest.apex_aside_m + nearest.perpendicular_m();
        Some(aside_m(view.from_in_odom, axis_in_odom_rad, side) + heard_m - here_m)
    };
    let mut heard_m: Vec<f64> = views.latest(REFERENCE_M).iter().filter_map(distance_m).collect();
    heard_m.sort_by(f64::total_cmp);
    heard_m.get(heard_m.len() / 2).copied().filter(|distance_m| distance_m.is_finite())
}

/// The median is taken over this length of the way.
const REFERENCE_M: f64 = 0.25;
