//! A filter below whoever wants to drive and does not look where to.

use super::clearance::{Obstacle, near_obstacles, stops_in_time};
use super::limits::DriveLimits;
use crate::geometry::{Point, Velocity};

/// Air that is kept to what is remembered: about twice the noise of a reading nearby. What is beside the robot was
/// heard from elsewhere, and may be in no cone any more that could correct it.
const AIR_M: f64 = 0.03;

/// The number of equal steps in which the wanted speed is lowered.
const SHARES: u32 = 6;

/// The nearest thing to what is wanted from which the robot can stop short of everything known: as fast as
/// that, or slower on the way to where it turns, or turning alone, or a full stop. Where something is nearer than
/// it should be, nothing brings the robot nearer to it: on a narrow curve, what is beside it comes before it. Cost: the
/// obstacle points near enough for [`stops_in_time`], a few times.
pub fn braked_velocity(limits: &DriveLimits, obstacles_in_base: &[Point], now: Velocity, wanted: Velocity) -> Velocity {
    let fastest_mps = now.translation_mps.abs().max(wanted.translation_mps.abs());
    let kept_off = |point| Obstacle::kept_off(limits, point, AIR_M);
    let near = near_obstacles(limits, obstacles_in_base, fastest_mps, kept_off);
    let slowed = (0..=SHARES).map(|lost| {
        let share = f64::from(SHARES - lost) / f64::from(SHARES);
        Velocity { translation_mps: wanted.translation_mps * share, ..wanted }
    });
    // A robot that starts makes so little way in the steps that are foreseen that rounding hides it.
    let is_driven_at = |velocity: Velocity| near.iter().any(|obstacle| obstacle.is_driven_at(velocity.translation_mps));
    let is_safe = |velocity: &Velocity| !is_driven_at(*velocity) && stops_in_time(limits, &near, now, *velocity);
    slowed.into_iter().find(is_safe).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive(obstacles: &[Point], wanted: Velocity) -> Vec<(Point, Velocity)> {
        let limits = DriveLimits::default();
        let (mut at, mut heading_rad, mut now) = (Point::origin(), 0.0_f64, Velocity::default());
        let mut way = Vec::new();
        for _ in 0..400 {
            let (sin, cos) = libm::sincos(heading_rad);
            let in_base: Vec<Point> = obstacles
                .iter()
                .map(|point| point - at)
                .map(|off| Point::new(cos * off.x + sin * off.y, cos * off.y - sin * off.x))
                .collect();
            now = limits.towards(now, braked_velocity(&limits, &in_base, now, wanted));
            heading_rad += now.rotation_radps * limits.step_s;
            let (sin, cos) = libm::sincos(heading_rad);
            at += crate::geometry::Vector::new(cos, sin) * (now.translation_mps * limits.step_s);
            way.push((at, now));
        }
        way
    }

    #[test]
    fn whoever_drives_at_a_wall_stands_before_it() {
        let wall: Vec<Point> = (-60..=60).map(|step| Point::new(2.0, f64::from(step) * 0.05)).collect();
        for rotation_radps in [0.0, 0.1, -0.3] {
            let way = drive(&wall, Velocity { translation_mps: 0.6, rotation_radps });
            let nearest_m = way.iter().flat_map(|(at, _)| wall.iter().map(move |point| (point - at).norm()));
            let nearest_m = nearest_m.fold(f64::INFINITY, f64::min);
            assert!(nearest_m > DriveLimits::default().robot_radius_m, "{rotation_radps}: {nearest_m}");
        }
        let (at, velocity) = drive(&wall, Velocity { translation_mps: 0.6, rotation_radps: 0.0 })[399];
        assert!(at.x > 1.5 && velocity.translation_mps == 0.0, "{at} {velocity:?}");
    }

    /// The jamb of a door that the robot has just gone through, on the side to which it turns on a narrow curve.
    #[test]
    fn what_is_beside_the_robot_is_not_swept_by_its_curve() {
        let limits = DriveLimits::default();
        for (bearing_deg, off_m) in [(-93.0, 0.005), (-93.0, 0.02), (-100.0, 0.01), (-110.0, 0.03), (-130.0, 0.04)] {
            let (sin, cos) = libm::sincos(f64::to_radians(bearing_deg));
            let away_m = limits.robot_radius_m + off_m;
            let jamb = [Point::new(cos * away_m, sin * away_m)];
            for translation_mps in [0.1, 0.2, 0.4] {
                let way = drive(&jamb, Velocity { translation_mps, rotation_radps: -0.8 });
                let nearest_m = way.iter().map(|(at, _)| (jamb[0] - at).norm()).fold(f64::INFINITY, f64::min);
                let least_m = away_m.min(limits.robot_radius_m + AIR_M);
                assert!(nearest_m > least_m - 1e-3, "{bearing_deg}°, {off_m} m: {nearest_m}");
            }
        }
    }

    #[test]
    fn what_is_in_nobodys_way_changes_nothing() {
        let wanted = Velocity { translation_mps: 0.4, rotation_radps: 0.2 };
        let behind = [Point::new(-0.5, 0.0)];
        assert_eq!(braked_velocity(&DriveLimits::default(), &behind, wanted, wanted), wanted);
    }
}
