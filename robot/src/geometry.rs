//! Points, poses, velocities and angles in the plane.

use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// A point, in metres, in the frame its variable names (`target_in_map`).
pub type Point = nalgebra::Point2<f64>;

/// A displacement, in metres.
pub type Vector = nalgebra::Vector2<f64>;

/// Position and heading in the plane; as a transform it carries points of its own frame into the
/// frame it is given in (`robot_in_map` carries `base` to `map`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Metres.
    pub x_m: f64,
    /// Metres.
    pub y_m: f64,
    /// Counter-clockwise from the x axis; kept in (−π, π] by every operation here.
    pub heading_rad: f64,
}

impl Pose {
    /// The pose at a point with a heading, the heading brought into (−π, π].
    pub fn new(x_m: f64, y_m: f64, heading_rad: f64) -> Self {
        Self { x_m, y_m, heading_rad: wrap_angle_rad(heading_rad) }
    }

    /// The position without the heading.
    pub fn point(self) -> Point {
        Point::new(self.x_m, self.y_m)
    }

    /// `self ∘ inner`: where a pose given in this pose's frame lies in the outer frame.
    pub fn compose(self, inner: Pose) -> Pose {
        let point = self.transform(inner.point());
        Pose::new(point.x, point.y, self.heading_rad + inner.heading_rad)
    }

    /// A point of this pose's frame, in the outer frame.
    pub fn transform(self, inner: Point) -> Point {
        Transform::new(self).apply(inner)
    }

    /// The inverse transform: `self.compose(self.inverse())` is the identity.
    pub fn inverse(self) -> Pose {
        let (sin, cos) = libm::sincos(self.heading_rad);
        Pose::new(-(cos * self.x_m + sin * self.y_m), sin * self.x_m - cos * self.y_m, -self.heading_rad)
    }

    /// This pose as seen from `origin`; both are given in one frame.
    pub fn relative_to(self, origin: Pose) -> Pose {
        origin.inverse().compose(self)
    }

    /// Distance between the positions.
    pub fn distance_m(self, other: Pose) -> f64 {
        distance_m(self.point(), other.point())
    }
}

/// How a robot moves that only drives ahead and turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Velocity {
    /// Ahead, negative backwards.
    pub translation_mps: f64,
    /// Counter-clockwise.
    pub rotation_radps: f64,
}

/// A pose with its sine and cosine taken once, for many points.
#[derive(Clone, Copy, Debug)]
pub struct Transform {
    x_m: f64,
    y_m: f64,
    sin: f64,
    cos: f64,
}

impl Transform {
    /// From the frame of a pose into the one it is given in.
    pub fn new(pose: Pose) -> Self {
        let (sin, cos) = libm::sincos(pose.heading_rad);
        Self { x_m: pose.x_m, y_m: pose.y_m, sin, cos }
    }

    /// [`Pose::transform`].
    pub fn apply(&self, inner: Point) -> Point {
        Point::new(
            self.x_m + self.cos * inner.x - self.sin * inner.y,
            self.y_m + self.sin * inner.x + self.cos * inner.y,
        )
    }
}

/// Euclidean distance.
pub fn distance_m(a: Point, b: Point) -> f64 {
    libm::hypot(a.x - b.x, a.y - b.y)
}

/// The same angle in (−π, π].
pub fn wrap_angle_rad(angle_rad: f64) -> f64 {
    let turned = libm::fmod(angle_rad, TAU);
    if turned > PI {
        turned - TAU
    } else if turned <= -PI {
        turned + TAU
    } else {
        turned
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_undoes_a_pose() {
        for (x, y, heading) in [(1.0, -2.0, 0.3), (0.0, 4.0, -3.0), (-7.5, 0.1, PI)] {
            let pose = Pose::new(x, y, heading);
            let identity = pose.compose(pose.inverse());
            assert!(identity.x_m.abs() < 1e-12 && identity.y_m.abs() < 1e-12);
            assert!(identity.heading_rad.abs() < 1e-12);
        }
    }

    #[test]
    fn left_is_positive_y() {
        let north = Pose::new(2.0, 3.0, PI / 2.0);
        let left = north.transform(Point::new(0.0, 1.0));
        assert!((left.x - 1.0).abs() < 1e-12 && (left.y - 3.0).abs() < 1e-12);
    }

    #[test]
    fn angles_wrap_into_the_half_open_turn() {
        assert_eq!(wrap_angle_rad(PI), PI);
        assert_eq!(wrap_angle_rad(-PI), PI);
        assert!((wrap_angle_rad(5.0 * PI / 2.0) - PI / 2.0).abs() < 1e-12);
    }
}
