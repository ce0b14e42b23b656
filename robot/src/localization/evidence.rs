//! What rays say of a pose near which they were measured: the normal equations of Gauss and Newton's method.

use super::scan_parameters::BeamParameters;
use crate::geometry::{Point, Pose, wrap_angle_rad};
use crate::occupancy::DistanceField;
use nalgebra::{Matrix3, Vector3};

/// Standard deviation of a ray across the surface it meets: the noise of a laser, and half a cell of
/// the map the surface is drawn in.
const RAY_SIGMA_M: f64 = 0.03;

/// How far beside a ray its neighbours are cast at the least: where they would end less than a cell of the map beside
/// its end they are cast farther off, or the line through the ends tells of the cells and not of the surface.
const BESIDE_RAD: f64 = 1.0 / 180.0 * std::f64::consts::PI;

/// And at the most.
const MOST_BESIDE_RAD: f64 = 15.0 / 180.0 * std::f64::consts::PI;

/// A ray that ends, or whose neighbours end, farther than this from the line through the ends meets an edge.
const EDGE_M: f64 = 0.1;

/// What is known of x, y and heading around a pose: the matrix and the vector of the normal equations.
pub(super) struct Evidence {
    pub information: Matrix3<f64>,
    pub pull: Vector3<f64>,
}

impl Evidence {
    pub(super) fn of_pose(information: Matrix3<f64>, known_in_map: Pose, pose: Pose) -> Self {
        let off = Vector3::new(
            known_in_map.x_m - pose.x_m,
            known_in_map.y_m - pose.y_m,
            wrap_angle_rad(known_in_map.heading_rad - pose.heading_rad),
        );
        Self { information, pull: information * off }
    }

    /// Adds what a ray says whose end lies on a surface: its bearing and what it measured.
    pub(super) fn add_ray(
        &mut self,
        map: &DistanceField,
        beam: &BeamParameters,
        tempering: f64,
        pose: Pose,
        (bearing_rad, range_m): (f64, f64),
        scale_m: f64,
    ) {
        let direction_rad = pose.heading_rad + bearing_rad;
        let most_m = beam.max_range_m + beam.mount_radius_m;
        let Some(Surface { way_m, slope }) = Surface::met(map, pose.point(), direction_rad, most_m) else { return };
        let (sin, cos) = libm::sincos(direction_rad);
        let gradient = Vector3::new(-cos - slope * sin, -sin + slope * cos, slope * way_m);
        let across = 1.0 / (1.0 + slope * slope);
        // The depth of a wall is one across its surface.
        let depth_m = beam.wall_depth_m / libm::sqrt(across);
        let beyond_m = range_m + beam.mount_radius_m - depth_m - way_m;
        let kernel = 1.0 / (1.0 + across * beyond_m * beyond_m / (scale_m * scale_m));
        let weight = tempering * kernel * kernel * across / (RAY_SIGMA_M * RAY_SIGMA_M);
        self.information += gradient * gradient.transpose() * weight;
        self.pull += gradient * (beyond_m * weight);
    }
}

/// The straight piece of a wall that a ray meets.
struct Surface {
    /// The way to it.
    way_m: f64,
    /// How the way changes with the direction, by its length: the tangent of the incidence.
    slope: f64,
}

impl Surface {
    /// The line, by least squares, through the ends of a ray and of two beside it; none where they meet an edge or
    /// nothing.
    fn met(map: &DistanceField, from: Point, direction_rad: f64, most_m: f64) -> Option<Self> {
        let cast_m = |beside_rad: f64| {
            let (sin, cos) = libm::sincos(direction_rad + beside_rad);
            map.surface_m(from, (cos, sin), most_m)
        };
        let middle_m = cast_m(0.0);
        if middle_m >= most_m || middle_m <= 0.0 {
            return None;
        }
        let beside_rad = (map.resolution_m / middle_m).clamp(BESIDE_RAD, MOST_BESIDE_RAD);
        let (sin, cos) = libm::sincos(beside_rad);
        let [right_m, left_m] = [-beside_rad, beside_rad].map(cast_m);
        // Along the ray, and to the left of it.
        let ends = [(right_m * cos, -right_m * sin), (middle_m, 0.0), (left_m * cos, left_m * sin)];
        let mean = |of: fn(&(f64, f64)) -> f64| ends.iter().map(of).sum::<f64>() / ends.len() as f64;
        let (mean_ahead_m, mean_left_m) = (mean(|end| end.0), mean(|end| end.1));
        let off = ends.map(|(ahead_m, left_m)| (ahead_m - mean_ahead_m, left_m - mean_left_m));
        let sum = |of: fn(&(f64, f64)) -> f64| off.iter().map(of).sum::<f64>();
        let slope = sum(|off| off.0 * off.1) / sum(|off| off.1 * off.1);
        let way_m = mean_ahead_m - slope * mean_left_m;
        let most_off_m = EDGE_M * libm::sqrt(1.0 + slope * slope);
        let is_line = off.iter().all(|(ahead_m, left_m)| libm::fabs(ahead_m - slope * left_m) <= most_off_m);
        (is_line && way_m > 0.0).then_some(Self { way_m, slope })
    }
}
