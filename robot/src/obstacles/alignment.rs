//! Where the estimate must be moved to for the remembered obstacle points to lie on those of the map.

use super::memory::ObstacleMemory;
use crate::geometry::{Pose, Transform, Vector};
use crate::planning::PlannerModel;

/// Shifts up to so many steps along x and y are tried.
const STEPS: i32 = 5;
const STEP_M: f64 = 0.04;

/// Only readings this short are sharp enough.
const SHARP_RANGE_M: f64 = 1.2;

/// A point this far from every obstacle of the map is an unmapped thing and has no say.
const OUTLIER_M: f64 = 0.3;

/// What a metre of shift costs in metres of mean distance: without evidence the estimate stays.
const INERTIA: f64 = 0.25;

/// With fewer points the estimate stays.
const LEAST_POINTS: usize = 12;

/// The estimate shifted by at most 20 cm along x and y so that the mean distance of the remembered
/// points to the obstacles of the map is least. Cost: 121 look-ups for each sharp point.
///
/// A robot that drives through a door with its sonars off has nothing but its estimate and what it
/// remembers. The memory is exact in `odom` but ends at the door; the map goes on behind it.
///
/// Points inside obstacles count as lying on them: an estimate that puts the points beyond a wall is
/// not brought back, one that puts them before it is.
pub fn aligned(
    planner: &PlannerModel,
    memory: &ObstacleMemory,
    odometry_in_odom: Pose,
    estimated_in_map: Pose,
) -> Pose {
    let odom_in_map = Transform::new(estimated_in_map.compose(odometry_in_odom.inverse()));
    let sharp = memory.points().iter().filter(|point| point.range_m <= SHARP_RANGE_M);
    let points: Vec<_> = sharp.map(|point| odom_in_map.apply(point.point_in_odom)).collect();
    if points.len() < LEAST_POINTS {
        return estimated_in_map;
    }
    let misfit_m = |shift: Vector| {
        let sum_m: f64 = points.iter().map(|&point| planner.obstacle_distance_m(point + shift).min(OUTLIER_M)).sum();
        sum_m / points.len() as f64 + INERTIA * shift.norm()
    };
    let mut best = (misfit_m(Vector::zeros()), Vector::zeros());
    for step_y in -STEPS..=STEPS {
        for step_x in -STEPS..=STEPS {
            let shift = Vector::new(f64::from(step_x), f64::from(step_y)) * STEP_M;
            let misfit_m = misfit_m(shift);
            if misfit_m < best.0 {
                best = (misfit_m, shift);
            }
        }
    }
    Pose::new(estimated_in_map.x_m + best.1.x, estimated_in_map.y_m + best.1.y, estimated_in_map.heading_rad)
}
