//! How far the robot gets on an arc before an obstacle point is too near.

use super::limits::DriveLimits;
use crate::geometry::{Point, Vector, Velocity};
use std::f64::consts::PI;

/// Clearance beyond this is of no further use.
pub(super) const CLEARANCE_HORIZON_M: f64 = 1.2;

/// At which speed the robot looks for a way out: it keeps the margin of that.
const CREEPING_MPS: f64 = 0.1;

/// How far the robot could go straight in a direction, at most `horizon_m`.
pub fn open_distance_m(limits: &DriveLimits, obstacles_in_base: &[Point], direction_rad: f64, horizon_m: f64) -> f64 {
    let safe_radius_m = limits.safe_radius_m(CREEPING_MPS);
    let (sin, cos) = libm::sincos(direction_rad);
    let turned = |point: &Point| Point::new(cos * point.x + sin * point.y, cos * point.y - sin * point.x);
    obstacles_in_base
        .iter()
        .map(|point| Obstacle::new(limits, turned(point)).free_distance_m(safe_radius_m, 0.0))
        .fold(horizon_m, f64::min)
}

/// An obstacle point with its distance taken once.
#[derive(Clone, Copy, Debug)]
pub(super) struct Obstacle {
    in_base: Point,
    away_m: f64,
    /// From here on it is not come nearer to.
    hard_radius_m: f64,
    /// So near the robot may come on its way, within that radius.
    least_m: f64,
}

impl Obstacle {
    /// One that may be glanced past.
    pub fn new(limits: &DriveLimits, in_base: Point) -> Self {
        const GLANCING_M: f64 = 0.002;
        Self::with_air(in_base, limits.hard_radius_m(), GLANCING_M)
    }

    /// One that is kept off by this much air; where there is less, nothing brings the robot nearer to it.
    pub fn kept_off(limits: &DriveLimits, in_base: Point, air_m: f64) -> Self {
        const ROUNDING_M: f64 = 1e-6;
        Self::with_air(in_base, limits.robot_radius_m + air_m, ROUNDING_M)
    }

    fn with_air(in_base: Point, hard_radius_m: f64, nearer_m: f64) -> Self {
        let away_m = in_base.coords.norm();
        Self { in_base, away_m, hard_radius_m, least_m: hard_radius_m.min(away_m - nearer_m) }
    }

    /// How far the robot gets along its arc before this point is within its safe
    /// radius; infinite if never. A point that is within the safe radius already may come slightly
    /// nearer, but not nearer than the hard radius; one within that is at most glanced past.
    pub fn free_distance_m(&self, safe_radius_m: f64, curvature_per_m: f64) -> f64 {
        const SLACK_M: f64 = 0.005;
        // Passing a point at its side brings the robot nearer by less than two millimetres.
        const GLANCING: f64 = 0.1;
        if self.away_m <= self.hard_radius_m {
            return if self.in_base.x > GLANCING * self.away_m { 0.0 } else { f64::INFINITY };
        }
        let radius_m = safe_radius_m.min(self.hard_radius_m.max(self.away_m - SLACK_M));
        if curvature_per_m.abs() < 1e-3 {
            self.along_line_m(radius_m)
        } else {
            self.along_arc_m(radius_m, curvature_per_m)
        }
    }

    /// Whether the robot is within the hard radius at a place, or nearer than it is now if it is
    /// within it already.
    fn is_touched_from(&self, at_in_base: Point) -> bool {
        (self.in_base - at_in_base).norm_squared() < self.least_m * self.least_m
    }

    /// Whether it is as near as anything may be, and straight driving brings it nearer.
    pub(super) fn is_driven_at(&self, translation_mps: f64) -> bool {
        self.away_m <= self.hard_radius_m && self.in_base.x * translation_mps > 0.0
    }

    fn along_line_m(&self, radius_m: f64) -> f64 {
        if self.in_base.x <= 0.0 || self.in_base.y.abs() >= radius_m {
            return f64::INFINITY;
        }
        (self.in_base.x - (radius_m * radius_m - self.in_base.y * self.in_base.y).sqrt()).max(0.0)
    }

    /// The circle of the robot's middle, cut with the circle around the point.
    fn along_arc_m(&self, radius_m: f64, curvature_per_m: f64) -> f64 {
        let arc_radius_m = 1.0 / curvature_per_m.abs();
        let inward_m = arc_radius_m - if curvature_per_m > 0.0 { self.in_base.y } else { -self.in_base.y };
        let squared = self.in_base.x * self.in_base.x + inward_m * inward_m;
        let (least_m, most_m) = ((arc_radius_m - radius_m).max(0.0), arc_radius_m + radius_m);
        if squared >= most_m * most_m || squared <= least_m * least_m {
            return f64::INFINITY;
        }
        let from_centre_m = squared.sqrt();
        let cosine =
            (arc_radius_m * arc_radius_m + squared - radius_m * radius_m) / (2.0 * arc_radius_m * from_centre_m);
        if cosine <= -1.0 {
            return f64::INFINITY;
        }
        let along_rad = libm::atan2(self.in_base.x, inward_m) - libm::acos(cosine.min(1.0));
        arc_radius_m * if along_rad < 0.0 { along_rad + 2.0 * PI } else { along_rad }
    }
}

/// Whether the robot, from its present velocity, can do as wanted for two steps, which a command needs to
/// take effect, and then stop without coming too near to anything on the way: driven ahead step by
/// step with the accelerations there are.
pub(super) fn stops_in_time(limits: &DriveLimits, near: &[Obstacle], now: Velocity, wanted: Velocity) -> bool {
    const COMMAND_STEPS: u32 = 2;
    const MOST_STEPS: u32 = 200;
    let (mut velocity, mut heading_rad, mut at, mut way_m) = (now, 0.0, Point::origin(), 0.0);
    for step in 0..MOST_STEPS {
        velocity = limits.towards(velocity, if step < COMMAND_STEPS { wanted } else { Velocity::default() });
        if velocity.translation_mps == 0.0 && (step >= COMMAND_STEPS || wanted.translation_mps == 0.0) {
            return true;
        }
        let (sin, cos) = libm::sincos(heading_rad + velocity.rotation_radps * limits.step_s / 2.0);
        let step_m = velocity.translation_mps * limits.step_s;
        at += Vector::new(cos, sin) * step_m;
        way_m += step_m.abs();
        heading_rad += velocity.rotation_radps * limits.step_s;
        let mut within_reach = near.iter().take_while(|obstacle| obstacle.away_m <= obstacle.hard_radius_m + way_m);
        if within_reach.any(|obstacle| obstacle.is_touched_from(at)) {
            return false;
        }
    }
    false
}

/// The obstacles that matter up to a speed, nearest first; `obstacle` says how near the robot may come to each.
pub(super) fn near_obstacles(
    limits: &DriveLimits,
    obstacles_in_base: &[Point],
    fastest_mps: f64,
    obstacle: impl Fn(Point) -> Obstacle,
) -> Vec<Obstacle> {
    let reach_m = CLEARANCE_HORIZON_M.max(limits.stopping_distance_m(fastest_mps)) + limits.safe_radius_m(fastest_mps);
    let mut near: Vec<Obstacle> = obstacles_in_base
        .iter()
        .filter(|point| point.coords.norm_squared() < reach_m * reach_m)
        .map(|&point| obstacle(point))
        .collect();
    near.sort_by(|a, b| a.away_m.total_cmp(&b.away_m));
    near
}

/// How far the robot gets along its arc, at most the horizon; the horizon when it only turns. `None`
/// if it could not stop within that.
pub(super) fn clearance_m(limits: &DriveLimits, near: &[Obstacle], velocity: Velocity) -> Option<f64> {
    if velocity.translation_mps <= 0.0 {
        return Some(CLEARANCE_HORIZON_M);
    }
    let stopping_m = limits.stopping_distance_m(velocity.translation_mps);
    let curvature_per_m = velocity.rotation_radps / velocity.translation_mps;
    let safe_radius_m = limits.safe_radius_m(velocity.translation_mps);
    let mut clearance_m = CLEARANCE_HORIZON_M.max(stopping_m);
    for obstacle in near {
        // The arc is no shorter than its chord, and the obstacles that follow are farther away.
        if obstacle.away_m - safe_radius_m >= clearance_m {
            break;
        }
        clearance_m = clearance_m.min(obstacle.free_distance_m(safe_radius_m, curvature_per_m));
        if clearance_m < stopping_m {
            return None;
        }
    }
    Some(clearance_m.min(CLEARANCE_HORIZON_M))
}
