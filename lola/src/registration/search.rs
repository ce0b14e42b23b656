//! The direction that explains most.

use super::views::View;
use super::walls::{Explained, HallwayAxis, WALL_M, explain, explain_points, wall_points};
use rpl_robot::geometry::wrap_angle_rad;
use rpl_robot::sensors::SonarArray;

/// Directions are tried so far apart: what the farthest readings of a drive of a metre and a half tell apart.
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

/// Rounds of least squares: each weighs the readings by their distance from the walls of the last.
const ROUNDS: usize = 6;

/// Least squares over all readings that lie on the walls, both sides sharing one direction: the line that
/// best fits, `aside = wall + slope · along` with the same slope, whose sign is that of the side. Readings
/// farther off weigh less, and from [`WALL_M`] on nothing (Tukey's biweight), so that leaves, jambs, boxes and people
/// do not tilt it.
///
/// # Deviation
/// The paper fits segments by plain least squares to each boundary, which a door's leaf tilts.
pub(super) fn refined(views: &[View], sonars: &SonarArray, start_rad: f64) -> HallwayAxis {
    let mut axis_rad = start_rad;
    let mut deviation_rad = f64::INFINITY;
    for _ in 0..ROUNDS {
        let points = wall_points(views, sonars, axis_rad);
        let explained = explain_points(&points);
        let mut fit = SlopeFit::default();
        for (side, wall_m) in crate::feature::Side::ALL.into_iter().zip(explained.walls_aside_m) {
            let Some(wall_m) = wall_m else { continue };
            let of_side = points.iter().filter(|point| point.side == side);
            fit.add_side(of_side.map(|point| (side.sign() * point.along_m, point.aside_m - wall_m)));
        }
        let Some((slope, deviation)) = fit.slope() else { break };
        axis_rad = wrap_angle_rad(axis_rad + libm::atan(slope));
        deviation_rad = deviation;
    }
    let Explained { wall_m, walls_aside_m, .. } = explain(views, sonars, axis_rad);
    let mut axis = HallwayAxis { heading_in_odom_rad: axis_rad, deviation_rad, wall_m, walls_aside_m, width_m: None };
    axis.width_m = axis.walls_apart_m();
    axis
}

/// Sums of a weighted fit of one slope to several walls, each with an offset of its own.
#[derive(Default)]
struct SlopeFit {
    along2: f64,
    along_off: f64,
    off2: f64,
    count: f64,
}

impl SlopeFit {
    /// Points as (along, off the wall).
    fn add_side(&mut self, points: impl Iterator<Item = (f64, f64)> + Clone) {
        let weight = |off_m: f64| {
            let off = off_m / WALL_M;
            let nearness = (1.0 - off * off).max(0.0);
            nearness * nearness
        };
        let (mut weights, mut along, mut off) = (0.0, 0.0, 0.0);
        for (along_m, off_m) in points.clone() {
            let weight = weight(off_m);
            weights += weight;
            along += weight * along_m;
            off += weight * off_m;
        }
        if weights == 0.0 {
            return;
        }
        let (along, off) = (along / weights, off / weights);
        for (along_m, off_m) in points {
            let weight = weight(off_m);
            self.along2 += weight * (along_m - along) * (along_m - along);
            self.along_off += weight * (along_m - along) * (off_m - off);
            self.off2 += weight * (off_m - off) * (off_m - off);
            self.count += weight;
        }
    }

    /// The slope and its standard deviation; none without extent.
    fn slope(&self) -> Option<(f64, f64)> {
        if self.along2 <= 0.0 || self.count < 3.0 {
            return None;
        }
        let slope = self.along_off / self.along2;
        let residual2 = (self.off2 - slope * self.along_off).max(0.0) / self.count;
        Some((slope, (residual2 / self.along2).sqrt()))
    }
}
