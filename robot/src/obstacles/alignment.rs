//! Where the estimate must be moved to for the remembered obstacle points to lie on those of the map.

use super::memory::ObstacleMemory;
use crate::geometry::{Point, Pose, Transform, Vector};
use crate::planning::{Patch, PlannerModel};

/// Shifts by up to this many steps along x and y are tried.
const STEPS: i32 = 5;
const STEP_M: f64 = 0.04;

/// Only readings this short are sharp enough.
const SHARP_RANGE_M: f64 = 1.2;

/// A point this far from every obstacle of the map is an unmapped thing and has no say.
const OUTLIER_M: f64 = 0.3;

/// The steps, the outliers and the inertia in a narrow place, where surfaces are near to each other and few points tell
/// of them.
const NARROW: Search = Search { step_m: 0.02, outlier_m: 0.1, inertia: 0.05 };
const NARROW_FINELY: Search = Search { step_m: 0.005, ..NARROW };

/// What a metre of shift costs in metres of mean distance: without evidence the estimate stays.
const INERTIA: f64 = 0.25;

/// How shifts are tried.
#[derive(Clone, Copy)]
struct Search {
    step_m: f64,
    outlier_m: f64,
    inertia: f64,
}

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
    let off_map_m = |point: Point| planner.obstacle_distance_m(point);
    let search = Search { step_m: STEP_M, outlier_m: OUTLIER_M, inertia: INERTIA };
    shifted(memory, odometry_in_odom, estimated_in_map, search, off_map_m)
}

/// The same in a narrow place, by its surfaces in small cells: to a centimetre, and by at most 10 cm. Also points inside
/// obstacles bring it back. Points beside the patches have no say.
pub fn aligned_in_narrow(
    patches: &[&Patch],
    memory: &ObstacleMemory,
    odometry_in_odom: Pose,
    estimated_in_map: Pose,
) -> Pose {
    let off_map_m =
        |point: Point| patches.iter().find_map(|patch| patch.off_surface_m(point)).unwrap_or(NARROW.outlier_m);
    let roughly = shifted(memory, odometry_in_odom, estimated_in_map, NARROW, off_map_m);
    shifted(memory, odometry_in_odom, roughly, NARROW_FINELY, off_map_m)
}

/// The estimate shifted by at most [`STEPS`] along x and y so that points lie on the map as well as they can.
fn shifted(
    memory: &ObstacleMemory,
    odometry_in_odom: Pose,
    estimated_in_map: Pose,
    Search { step_m, outlier_m, inertia }: Search,
    off_map_m: impl Fn(Point) -> f64,
) -> Pose {
    let odom_in_map = Transform::new(estimated_in_map.compose(odometry_in_odom.inverse()));
    let sharp = memory.points().iter().filter(|point| point.range_m <= SHARP_RANGE_M);
    let points: Vec<_> = sharp.map(|point| odom_in_map.apply(point.point_in_odom)).collect();
    if points.len() < LEAST_POINTS {
        return estimated_in_map;
    }
    let misfit_m = |shift: Vector| {
        let sum_m: f64 = points.iter().map(|&point| off_map_m(point + shift).min(outlier_m)).sum();
        sum_m / points.len() as f64 + inertia * shift.norm()
    };
    let mut best = (misfit_m(Vector::zeros()), Vector::zeros());
    for step_y in -STEPS..=STEPS {
        for step_x in -STEPS..=STEPS {
            let shift = Vector::new(f64::from(step_x), f64::from(step_y)) * step_m;
            let misfit_m = misfit_m(shift);
            if misfit_m < best.0 {
                best = (misfit_m, shift);
            }
        }
    }
    Pose::new(estimated_in_map.x_m + best.1.x, estimated_in_map.y_m + best.1.y, estimated_in_map.heading_rad)
}
