//! Reciprocal collision avoidance: which velocities of a walking disc keep it free of others for a
//! while, and which of them is nearest to the one it would like.
//!
//! J. van den Berg, S. J. Guy, M. Lin, D. Manocha, *Reciprocal n-Body Collision Avoidance*,
//! Robotics Research (ISRR 2009), Springer 2011. Everything here is a pure function.

use crate::geometry::{Point, Vector};

/// Below this two directions count as parallel: the cosine of the angle that is missing.
const PARALLEL: f64 = 1e-9;

/// The permitted velocities on the left of a directed line, in m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HalfPlane {
    /// A velocity on the line.
    pub on_line: Vector,
    /// Of unit length.
    pub along: Vector,
}

impl HalfPlane {
    /// The velocities v with (v − `on_line`) · `normal` ≥ 0.
    fn beyond(on_line: Vector, normal: Vector) -> Self {
        Self { on_line, along: Vector::new(normal.y, -normal.x) }
    }

    /// How far outside a velocity lies; negative inside.
    fn violation_mps(&self, velocity_mps: Vector) -> f64 {
        self.along.perp(&(self.on_line - velocity_mps))
    }
}

/// A disc that moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Disc {
    pub at_in_map: Point,
    pub velocity_mps: Vector,
    pub radius_m: f64,
}

/// ORCA of `a` against `b` (Eqs. 2 to 5): the velocities of `a` with which the two stay apart for
/// `horizon_s` if `b` does its part, `share` being the part of `a`: ½ of both, 1 if `b` does
/// nothing. Discs that overlap are to part within `step_s`.
pub(super) fn half_plane(a: Disc, b: Disc, share: f64, horizon_s: f64, step_s: f64) -> HalfPlane {
    let position = b.at_in_map - a.at_in_map;
    let velocity = a.velocity_mps - b.velocity_mps;
    let radius_m = a.radius_m + b.radius_m;
    let distance2 = position.norm_squared();
    let overlap = distance2 <= radius_m * radius_m;
    let within_s = if overlap { step_s } else { horizon_s };
    // The velocity obstacle is a cone cut off by the disc of radius r/τ around p/τ (Eq. 2).
    let from_centre = velocity - position / within_s;
    let towards = from_centre.dot(&position);
    let from_centre2 = from_centre.norm_squared();
    if overlap || towards < 0.0 && towards * towards > radius_m * radius_m * from_centre2 {
        let length = from_centre2.sqrt();
        // Two in one spot with one velocity may part anywhere, as long as they do.
        let normal = if length > 0.0 { from_centre / length } else { Vector::new(1.0, 0.0) };
        let change = normal * (radius_m / within_s - length);
        return HalfPlane::beyond(a.velocity_mps + change * share, normal);
    }
    let tangent_m = (distance2 - radius_m * radius_m).sqrt();
    let left = position.perp(&from_centre) > 0.0;
    let side = if left { 1.0 } else { -1.0 };
    let (x, y) = (position.x, position.y);
    let leg =
        Vector::new(x * tangent_m - side * y * radius_m, side * x * radius_m + y * tangent_m) * (side / distance2);
    let change = leg * velocity.dot(&leg) - velocity;
    HalfPlane { on_line: a.velocity_mps + change * share, along: leg }
}

/// The velocities that do not bring a disc at `from`, of this radius, across the tangent of a
/// convex body at its point `nearest` within `horizon_s`.
///
/// # Deviation
/// The paper gives bodies velocity obstacles of their own, with the tangents of the whole body as
/// legs. The tangent at the nearest point forbids more, never less, and cannot be entered.
pub(super) fn keep_off(from: Point, radius_m: f64, nearest: Point, horizon_s: f64) -> HalfPlane {
    let away = from - nearest;
    let distance_m = away.norm_squared().sqrt();
    let normal = if distance_m > 0.0 { away / distance_m } else { Vector::new(1.0, 0.0) };
    HalfPlane::beyond(normal * ((radius_m - distance_m) / horizon_s), normal)
}

/// The velocity nearest to the wanted one, of at most `limit_mps`, that all half-planes permit
/// (Eq. 6). If there is none, the first `fixed` half-planes are kept, and the others are violated
/// as little as possible (Sect. 5.3).
///
/// The linear programs are solved by adding one half-plane after the other (de Berg et al.,
/// *Computational Geometry*, ch. 4). O(n²) at worst, O(n) if few of them matter.
pub(super) fn best_velocity(half_planes: &[HalfPlane], fixed: usize, wanted_mps: Vector, limit_mps: f64) -> Vector {
    match in_plane(half_planes, limit_mps, Aim::Nearest(wanted_mps)) {
        Ok(velocity_mps) => velocity_mps,
        Err(Infeasible { at, before }) => least_violation(half_planes, fixed, at, before, limit_mps),
    }
}

/// What is optimized.
#[derive(Clone, Copy)]
enum Aim {
    /// The nearest to a velocity.
    Nearest(Vector),
    /// The farthest in a direction of unit length.
    Farthest(Vector),
}

/// The half-plane that left nothing, and the best before it.
struct Infeasible {
    at: usize,
    before: Vector,
}

/// The two-dimensional program: the best velocity in the disc of `limit_mps` and all half-planes.
fn in_plane(half_planes: &[HalfPlane], limit_mps: f64, aim: Aim) -> Result<Vector, Infeasible> {
    let mut best = match aim {
        Aim::Farthest(direction) => direction * limit_mps,
        Aim::Nearest(wanted) if wanted.norm_squared() > limit_mps * limit_mps => {
            wanted * (limit_mps / wanted.norm_squared().sqrt())
        }
        Aim::Nearest(wanted) => wanted,
    };
    for (at, half_plane) in half_planes.iter().enumerate() {
        if half_plane.violation_mps(best) > 0.0 {
            match on_line(half_plane, &half_planes[..at], limit_mps, aim) {
                Some(found) => best = found,
                None => return Err(Infeasible { at, before: best }),
            }
        }
    }
    Ok(best)
}

/// The one-dimensional program: the best velocity on a line, in the disc and the half-planes.
fn on_line(line: &HalfPlane, half_planes: &[HalfPlane], limit_mps: f64, aim: Aim) -> Option<Vector> {
    let middle = line.on_line.dot(&line.along);
    let reach2 = middle * middle + limit_mps * limit_mps - line.on_line.norm_squared();
    if reach2 < 0.0 {
        return None;
    }
    let reach = reach2.sqrt();
    let (mut from, mut to) = (-middle - reach, -middle + reach);
    for other in half_planes {
        let slope = line.along.perp(&other.along);
        let outside = other.along.perp(&(line.on_line - other.on_line));
        if slope.abs() <= PARALLEL {
            if outside < 0.0 {
                return None;
            }
            continue;
        }
        let at = outside / slope;
        if slope > 0.0 {
            to = to.min(at);
        } else {
            from = from.max(at);
        }
        if from > to {
            return None;
        }
    }
    let share = match aim {
        Aim::Farthest(direction) if direction.dot(&line.along) > 0.0 => to,
        Aim::Farthest(_) => from,
        Aim::Nearest(wanted) => (wanted - line.on_line).dot(&line.along).clamp(from, to),
    };
    Some(line.on_line + line.along * share)
}

/// The three-dimensional program: the velocity whose greatest violation is least. From the first
/// half-plane that could not be kept on, each that is violated more than the greatest so far is
/// made the greatest, the others being violated no more.
fn least_violation(half_planes: &[HalfPlane], fixed: usize, at: usize, mut best: Vector, limit_mps: f64) -> Vector {
    // If not even the fixed ones can all be kept, none is.
    let fixed = if at < fixed { 0 } else { fixed };
    let mut greatest_mps = 0.0;
    let mut no_worse: Vec<HalfPlane> = Vec::with_capacity(half_planes.len());
    for (index, half_plane) in half_planes.iter().enumerate().skip(at) {
        if half_plane.violation_mps(best) <= greatest_mps {
            continue;
        }
        no_worse.clear();
        no_worse.extend_from_slice(&half_planes[..fixed]);
        no_worse.extend(half_planes[fixed..index].iter().filter_map(|other| no_more_violated(other, half_plane)));
        let inwards = Vector::new(-half_plane.along.y, half_plane.along.x);
        if let Ok(found) = in_plane(&no_worse, limit_mps, Aim::Farthest(inwards)) {
            best = found;
        }
        greatest_mps = half_plane.violation_mps(best);
    }
    best
}

/// The velocities that violate `other` no more than `half_plane`: beyond the bisector of the two
/// lines. None if that is every velocity.
fn no_more_violated(other: &HalfPlane, half_plane: &HalfPlane) -> Option<HalfPlane> {
    let slope = half_plane.along.perp(&other.along);
    let on_line = if slope.abs() <= PARALLEL {
        if half_plane.along.dot(&other.along) > 0.0 {
            return None;
        }
        (half_plane.on_line + other.on_line) / 2.0
    } else {
        let at = other.along.perp(&(half_plane.on_line - other.on_line)) / slope;
        half_plane.on_line + half_plane.along * at
    };
    let along = other.along - half_plane.along;
    Some(HalfPlane { on_line, along: along / along.norm_squared().sqrt() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_random::Stream;

    const LIMIT_MPS: f64 = 1.2;

    fn random_vector(stream: &mut Stream, most: f64) -> Vector {
        Vector::new(stream.uniform_in(-most, most), stream.uniform_in(-most, most))
    }

    fn random_half_plane(stream: &mut Stream) -> HalfPlane {
        let (sin, cos) = libm::sincos(stream.uniform_in(-3.2, 3.2));
        HalfPlane { on_line: random_vector(stream, 1.0), along: Vector::new(cos, sin) }
    }

    /// All velocities of the disc on a fine grid.
    fn velocities() -> impl Iterator<Item = Vector> {
        let grid = (-120..=120).flat_map(|x| (-120..=120).map(move |y| Vector::new(f64::from(x), f64::from(y)) * 0.01));
        grid.filter(|velocity| velocity.norm_squared() <= LIMIT_MPS * LIMIT_MPS)
    }

    fn greatest_violation_mps(half_planes: &[HalfPlane], velocity: Vector) -> f64 {
        half_planes.iter().map(|half_plane| half_plane.violation_mps(velocity)).fold(0.0, f64::max)
    }

    #[test]
    fn no_permitted_velocity_of_a_fine_grid_is_nearer_to_the_wanted_one() {
        let mut stream = Stream::new(1, "test");
        let (mut feasible, mut infeasible) = (0, 0);
        for _ in 0..60 {
            let half_planes: Vec<_> = (0..5).map(|_| random_half_plane(&mut stream)).collect();
            let wanted = random_vector(&mut stream, 1.5);
            let best = best_velocity(&half_planes, 0, wanted, LIMIT_MPS);
            assert!(best.norm_squared() <= LIMIT_MPS * LIMIT_MPS + 1e-9);
            let permitted = |velocity: &Vector| greatest_violation_mps(&half_planes, *velocity) <= 0.0;
            let nearest2 = velocities()
                .filter(permitted)
                .map(|velocity| (velocity - wanted).norm_squared())
                .fold(f64::INFINITY, f64::min);
            if nearest2.is_finite() {
                feasible += 1;
                assert!(greatest_violation_mps(&half_planes, best) < 1e-9);
                assert!((best - wanted).norm_squared() <= nearest2 + 1e-9);
            } else {
                infeasible += 1;
                let least_mps = velocities()
                    .map(|velocity| greatest_violation_mps(&half_planes, velocity))
                    .fold(f64::INFINITY, f64::min);
                // The grid is 1 cm/s wide, and a permitted region may lie between its points.
                assert!(greatest_violation_mps(&half_planes, best) <= least_mps + 1e-9);
            }
        }
        assert!(feasible > 10 && infeasible > 10, "{feasible} {infeasible}");
    }

    #[test]
    fn fixed_half_planes_are_kept_when_not_all_can_be() {
        let beyond = |x: f64, y: f64, by: f64| HalfPlane::beyond(Vector::new(x, y) * by, Vector::new(x, y));
        // A wall to the east; somebody to the west wants it to go east at 0.5 m/s.
        let half_planes = [beyond(-1.0, 0.0, 0.0), beyond(1.0, 0.0, 0.5)];
        let best = best_velocity(&half_planes, 1, Vector::zeros(), LIMIT_MPS);
        assert!(best.x.abs() < 1e-9, "{best}");
        let best = best_velocity(&half_planes, 0, Vector::zeros(), LIMIT_MPS);
        assert!((best.x - 0.25).abs() < 1e-9, "{best}");
    }

    #[test]
    fn two_who_choose_from_their_half_planes_stay_apart_for_the_horizon() {
        const HORIZON_S: f64 = 2.0;
        let mut stream = Stream::new(2, "test");
        let mut avoided = 0;
        for _ in 0..1000 {
            let mut disc = || Disc {
                at_in_map: Point::from(random_vector(&mut stream, 2.0)),
                velocity_mps: random_vector(&mut stream, 0.8),
                radius_m: 0.25,
            };
            let (a, b) = (disc(), disc());
            if (a.at_in_map - b.at_in_map).norm_squared() < 0.25 {
                continue;
            }
            let chosen = |own: Disc, other: Disc| {
                let half_plane = half_plane(own, other, 0.5, HORIZON_S, 0.2);
                best_velocity(&[half_plane], 0, own.velocity_mps, LIMIT_MPS)
            };
            let (for_a, for_b) = (chosen(a, b), chosen(b, a));
            let apart2 = (0..=200)
                .map(|step| HORIZON_S * f64::from(step) / 200.0)
                .map(|time_s| ((b.at_in_map + for_b * time_s) - (a.at_in_map + for_a * time_s)).norm_squared())
                .fold(f64::INFINITY, f64::min);
            assert!(apart2 > 0.5 * 0.5 - 1e-6, "{a:?} {b:?} {apart2}");
            avoided += u32::from(for_a != a.velocity_mps);
        }
        assert!(avoided > 20, "{avoided}");
    }

    #[test]
    fn who_has_all_the_blame_passes_one_who_goes_on() {
        let own = Disc { at_in_map: Point::new(0.0, 0.0), velocity_mps: Vector::new(1.0, 0.0), radius_m: 0.25 };
        let other = Disc { at_in_map: Point::new(2.0, 0.1), velocity_mps: Vector::new(-0.5, 0.0), radius_m: 0.3 };
        let half_plane = half_plane(own, other, 1.0, 2.0, 0.2);
        let velocity = best_velocity(&[half_plane], 0, own.velocity_mps, LIMIT_MPS);
        let apart2 = (0..=200)
            .map(|step| f64::from(step) * 0.01)
            .map(|time_s| {
                ((other.at_in_map + other.velocity_mps * time_s) - (own.at_in_map + velocity * time_s)).norm_squared()
            })
            .fold(f64::INFINITY, f64::min);
        assert!(apart2 > 0.55 * 0.55 - 1e-6, "{apart2}");
        assert!(velocity.y < 0.0, "it passes on the side that is nearer: {velocity}");
    }

    #[test]
    fn a_wall_is_not_reached_within_the_horizon() {
        let wall = keep_off(Point::new(1.0, 1.0), 0.25, Point::new(1.0, 0.5), 0.5);
        let velocity = best_velocity(&[wall], 1, Vector::new(0.3, -1.0), LIMIT_MPS);
        assert!((velocity - Vector::new(0.3, -0.5)).norm_squared() < 1e-18, "{velocity}");
    }
}
