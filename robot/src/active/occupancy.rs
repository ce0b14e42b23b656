//! P_occ(a): how probably a point relative to the robot is occupied.

use super::action::ActionGrid;
use super::parameters::ActiveParameters;
use crate::geometry::{Point, Pose, distance_m};
use crate::localization::{LocalizationModel, Maximum};

/// Radius of what is put where the robot found its way blocked.
const OBSTACLE_RADIUS_M: f64 = 0.45;

/// P_occ(l) of the robot's middle: 1 nearer to a surface than the radius, then from one quarter
/// down to 0 at the comfortable clearance.
fn occupied(clearance_m: f64, parameters: &ActiveParameters) -> f64 {
    if clearance_m < parameters.robot_radius_m {
        return 1.0;
    }
    let room_m = parameters.comfortable_m - parameters.robot_radius_m;
    if room_m <= 0.0 { 0.0 } else { 0.25 * (1.0 - (clearance_m - parameters.robot_radius_m) / room_m).max(0.0) }
}

/// P_occ(a) for every cell, Eq. (7): the map, grown by the robot, seen from each maximum and
/// weighted by its mass. Points in `obstacles_in_base` were found occupied.
pub(super) fn occupancy(
    model: &LocalizationModel,
    grid: ActionGrid,
    maxima: &[Maximum],
    obstacles_in_base: &[Point],
    parameters: &ActiveParameters,
) -> Vec<f32> {
    let total: f64 = maxima.iter().map(|maximum| maximum.mass).sum();
    let mut field = vec![0f32; grid.cells()];
    for maximum in maxima {
        add_seen_from(model, grid, maximum.pose_in_map, maximum.mass / total, parameters, &mut field);
    }
    for obstacle in obstacles_in_base {
        for (cell, value) in field.iter_mut().enumerate() {
            if distance_m(grid.point_in_base(cell), *obstacle) < OBSTACLE_RADIUS_M {
                *value = 1.0;
            }
        }
    }
    field
}

fn add_seen_from(
    model: &LocalizationModel,
    grid: ActionGrid,
    robot_in_map: Pose,
    weight: f64,
    parameters: &ActiveParameters,
    field: &mut [f32],
) {
    let (sin, cos) = libm::sincos(robot_in_map.heading_rad);
    for (row, values) in field.chunks_exact_mut(grid.side()).enumerate() {
        for (column, value) in values.iter_mut().enumerate() {
            let point = grid.point_at(column, row);
            let in_map = Point::new(
                robot_in_map.x_m + cos * point.x - sin * point.y,
                robot_in_map.y_m + sin * point.x + cos * point.y,
            );
            *value += (weight * occupied(model.distances.clearance_m(in_map), parameters)) as f32;
        }
    }
}
