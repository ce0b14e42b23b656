//! The direction that explains most.

use super::views::View;
use super::walls::{Explained, HallwayAxis, WallPoint, explain, explain_points, wall_points};
use crate::feature::Side;
use rpl_robot::geometry::wrap_angle_rad;
use rpl_robot::sensors::SonarArray;

/// Directions are tried in steps of this: what the farthest readings of a drive of a metre and a half tell apart.
const COARSE_RAD: f64 = 0.026;
/// And around the best of them.
const FINE_RAD: f64 = 0.005;
/// With fewer readings that agree there is no wall.
const LEAST_SCORE: f64 = 12.0;

/// The direction within a gate around another that explains most; none if there is no wall in any. The nearest to
/// the middle of the gate of those that explain the same. Cost: the gate in steps of 1.5°, times the readings.
pub(super) fn best_axis_within(views: &[View], sonars: &SonarArray, around_rad: f64, gate_rad: f64) -> Option<f64> {
    let score = |off_rad: f64| explain(views, sonars, around_rad + off_rad).score;
    let coarse = best_off_rad(0.0, gate_rad, COARSE_RAD, score);
    let fine = best_off_rad(coarse, COARSE_RAD, FINE_RAD, score);
    (score(fine) >= LEAST_SCORE && fine.abs() <= gate_rad).then(|| wrap_angle_rad(around_rad + fine))
}

fn best_off_rad(middle_rad: f64, reach_rad: f64, grain_rad: f64, score: impl Fn(f64) -> f64) -> f64 {
    let steps = (reach_rad / grain_rad) as i32;
    let mut best = (score(middle_rad), middle_rad);
    for step in 1..=steps {
        for off_rad in [middle_rad - f64::from(step) * grain_rad, middle_rad + f64::from(step) * grain_rad] {
            let scored = score(off_rad);
            if scored > best.0 {
                best = (scored, off_rad);
            }
        }
    }
    best.1
}

/// Readings of a side are averaged over this length of its wall: ten readings or so, whose mean tells the leaf of a
/// closed door from the wall, which no single reading does.
const SPOT_M: f64 = 0.1;
/// Readings within this distance of a wall are averaged: the leaf of a closed door among them.
const NEAR_M: f64 = 0.15;
/// Spots of one segment are within this distance of its line: less than the depth of a leaf.
const SEGMENT_M: f64 = 0.022;
/// Slopes are tried up to the first, in steps of the second, as tangents.
const SLOPE: f64 = 0.09;
const SLOPE_GRAIN: f64 = 0.004;
/// Rounds of least squares, each from the direction that the last has found.
const ROUNDS: usize = 3;

/// Line segments fitted to the walls by least squares, the ones of both sides sharing one direction. The
/// boundary of a side has several: the wall, and parallel to it the leaves of closed doors. On each side the segment with
/// most of it and the next are fitted, so that doors, jambs, boxes and people do not tilt the direction.
///
/// # Deviation
/// The paper fits segments to each boundary by plain least squares, which half a door tilts by some degrees.
pub(super) fn refined(views: &[View], sonars: &SonarArray, start_rad: f64) -> HallwayAxis {
    let mut axis_rad = start_rad;
    let mut deviation_rad = f64::INFINITY;
    for _ in 0..ROUNDS {
        let points = wall_points(views, sonars, axis_rad);
        let explained = explain_points(&points);
        let sides = Side::ALL.map(|side| {
            explained.walls_aside_m[side as usize].map_or_else(Vec::new, |wall_m| spots(&points, side, wall_m))
        });
        let slope = best_slope(&sides);
        let mut fit = SlopeFit::default();
        for spots in &sides {
            for (_, offset_m) in segments(spots, slope).into_iter().flatten().filter(|(on_line, _)| *on_line > 0.0) {
                fit.add_segment(spots, slope, offset_m);
            }
        }
        let Some((slope, deviation)) = fit.slope() else { break };
        axis_rad = wrap_angle_rad(axis_rad + libm::atan(slope));
        deviation_rad = deviation;
    }
    let explained: Explained = explain(views, sonars, axis_rad);
    HallwayAxis {
        heading_in_odom_rad: axis_rad,
        deviation_rad,
        wall_m: explained.wall_m,
        width_m: explained.walls_apart_m(),
        walls_aside_m: explained.walls_aside_m,
    }
}

/// The mean of the readings on a bit of wall.
#[derive(Clone, Copy, Debug, Default)]
struct Spot {
    /// Along the axis, positive ahead on the left and back on the right, so that a slope is the same on both sides.
    along_m: f64,
    /// How far outside of the wall.
    off_m: f64,
    count: f64,
}

fn spots(points: &[WallPoint], side: Side, wall_m: f64) -> Vec<Spot> {
    let mut here: Vec<(i64, f64, f64)> = points
        .iter()
        .filter(|point| point.side == side && (point.aside_m - wall_m).abs() <= NEAR_M)
        .map(|point| (libm::floor(point.along_m / SPOT_M) as i64, side.sign() * point.along_m, point.aside_m - wall_m))
        .collect();
    here.sort_by_key(|point| point.0);
    let spot = |run: &[(i64, f64, f64)]| {
        let count = run.len() as f64;
        let mean = |of: fn(&(i64, f64, f64)) -> f64| run.iter().map(of).sum::<f64>() / count;
        Spot { along_m: mean(|point| point.1), off_m: mean(|point| point.2), count }
    };
    here.chunk_by(|a, b| a.0 == b.0).filter(|run| run.len() >= LEAST_READINGS).map(spot).collect()
}

/// Fewer readings have no mean worth the name.
const LEAST_READINGS: usize = 3;

/// Tukey's biweight.
fn nearness(off_m: f64) -> f64 {
    let off = off_m / SEGMENT_M;
    let nearness = (1.0 - off * off).max(0.0);
    nearness * nearness
}

/// What of a side lies on each of the parallel lines through its spots, whose offsets are given. Cost: their square.
fn on_lines(spots: &[Spot], offsets_m: &[f64]) -> Vec<f64> {
    let mut on_lines = vec![0.0; offsets_m.len()];
    // Spot by spot, so that the lines are independent of each other and several are counted at once.
    for (spot, spot_m) in spots.iter().zip(offsets_m) {
        let count = spot.count.min(MOST_COUNTED);
        for (on_line, line_m) in on_lines.iter_mut().zip(offsets_m) {
            *on_line += count * nearness(spot_m - line_m);
        }
    }
    on_lines
}

/// The two segments of a side with this slope that have most of it, each with how much that is: of the lines through
/// its spots the best, and the best that is not the same. None of a side without spots.
fn segments(spots: &[Spot], slope: f64) -> Option<[(f64, f64); 2]> {
    let offsets_m: Vec<f64> = spots.iter().map(|spot| spot.off_m - slope * spot.along_m).collect();
    let lines: Vec<(f64, f64)> = on_lines(spots, &offsets_m).into_iter().zip(offsets_m).collect();
    let best_of = |those: &mut dyn Iterator<Item = &(f64, f64)>| those.max_by(|a, b| a.0.total_cmp(&b.0)).copied();
    let first = best_of(&mut lines.iter())?;
    let second = best_of(&mut lines.iter().filter(|(_, offset_m)| (offset_m - first.1).abs() >= 2.0 * SEGMENT_M));
    Some([first, second.unwrap_or((0.0, first.1))])
}

/// More readings of a spot are not more of the wall: where the robot stood, there are many.
const MOST_COUNTED: f64 = 12.0;

fn best_slope(sides: &[Vec<Spot>; 2]) -> f64 {
    let on_segments =
        |spots: &Vec<Spot>, slope: f64| segments(spots, slope).map_or(0.0, |[first, second]| first.0 + second.0);
    let score = |slope: f64| sides.iter().map(|spots| on_segments(spots, slope)).sum::<f64>();
    best_off_rad(0.0, SLOPE, SLOPE_GRAIN, score)
}

/// Sums of a weighted fit of one slope to several segments, each with an offset of its own.
#[derive(Default)]
struct SlopeFit {
    along2: f64,
    along_off: f64,
    off2: f64,
    weights: f64,
    spots: f64,
}

impl SlopeFit {
    fn add_segment(&mut self, spots: &[Spot], slope: f64, offset_m: f64) {
        let weight =
            |spot: &Spot| spot.count.min(MOST_COUNTED) * nearness(spot.off_m - slope * spot.along_m - offset_m);
        let sum = |of: &dyn Fn(&Spot) -> f64| spots.iter().map(|spot| weight(spot) * of(spot)).sum::<f64>();
        let weights = sum(&|_| 1.0);
        if weights == 0.0 {
            return;
        }
        let (along_m, off_m) = (sum(&|spot| spot.along_m) / weights, sum(&|spot| spot.off_m) / weights);
        self.along2 += sum(&|spot| (spot.along_m - along_m) * (spot.along_m - along_m));
        self.along_off += sum(&|spot| (spot.along_m - along_m) * (spot.off_m - off_m));
        self.off2 += sum(&|spot| (spot.off_m - off_m) * (spot.off_m - off_m));
        self.weights += weights;
        self.spots += spots.iter().filter(|spot| weight(spot) > 0.0).count() as f64 - 1.0;
    }

    /// The slope and its standard deviation; none without extent.
    fn slope(&self) -> Option<(f64, f64)> {
        if self.along2 <= 0.0 || self.spots < 2.0 {
            return None;
        }
        let slope = self.along_off / self.along2;
        // Of one spot, by how far the spots are off the line.
        let spot2 = (self.off2 - slope * self.along_off).max(0.0) / self.spots;
        Some((slope, (spot2 / self.along2).sqrt()))
    }
}
