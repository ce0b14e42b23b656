//! What the state Wander blends: Avoid, Escape and ToGoal.

use super::parameters::BehaviourParameters;
use super::surroundings::Surroundings;
use rpl_robot::geometry::{Velocity, wrap_angle_rad};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// ToGoal turns in inverse proportion to the distance of the goal; at this one with its whole strength ...
const FULL_STRENGTH_M: f64 = 2.0;

/// ... and with at least this share of it.
///
/// # Deviation
/// Unclamped, the paper's strength is nothing at the other end of a hallway, and all others are nothing at the
/// goal.
const LEAST_STRENGTH: f64 = 0.25;

/// Where the goal is aside by more than the first, ToGoal slows the robot, and lets it stand from the second on:
/// else it drives round its goal.
const ASIDE_RAD: [f64; 2] = [0.4, 1.0];

/// Escape looks for gaps that are off the goal by a quarter turn and more only where there are none before.
const TURN_FULLY_RAD: f64 = FRAC_PI_4;

/// What a behaviour recommends, and how much it is concerned.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Advice {
    /// How fast to drive, as a share of the fastest.
    pub speed: f64,
    /// How fast to turn, as a share of the fastest, counter-clockwise.
    pub turn: f64,
    /// To what degree the behaviour is concerned, 0 to 1.
    pub degree: f64,
}

/// The velocity that the three recommend together: the slowest speed, as far as those that want it are
/// concerned and count, and the weighted mean of the turns.
pub fn blend(parameters: &BehaviourParameters, around: &Surroundings<'_>) -> Velocity {
    let advice = [
        (parameters.avoid_weight, avoid(parameters, around)),
        (parameters.escape_weight, escape(parameters, around)),
        (parameters.to_goal_weight, to_goal(around)),
    ];
    let strength = |(weight, advice): (f64, Advice)| weight * advice.degree;
    let sum: f64 = advice.into_iter().map(strength).sum();
    let turn: f64 = advice.into_iter().map(|one| strength(one) * one.1.turn).sum();
    let slowest = advice.into_iter().map(|(_, advice)| advice.speed).fold(1.0, f64::min);
    let turn = if sum > 0.0 { turn / sum } else { 0.0 };
    Velocity { translation_mps: parameters.translation_mps * slowest, rotation_radps: parameters.rotation_radps * turn }
}

/// To what degree something is near.
fn nearness(off_m: f64, near_m: f64) -> f64 {
    if near_m > 0.0 { (1.0 - off_m / near_m).clamp(0.0, 1.0) } else { 0.0 }
}

/// Drives ahead where nothing is near, slows down and turns away where something is.
fn avoid(parameters: &BehaviourParameters, around: &Surroundings<'_>) -> Advice {
    let near_m = parameters.avoid_distance_m;
    let (right, left) = (around.nearest_m(-FRAC_PI_2, 0.0), around.nearest_m(0.0, FRAC_PI_2));
    let (right, left) = (nearness(right, near_m), nearness(left, near_m));
    let ahead = nearness(around.open_m(0.0, near_m), near_m);
    Advice { speed: 1.0 - ahead, turn: (right - left).clamp(-1.0, 1.0), degree: right.max(left) }
}

/// Turns to the gap that is least off the goal, the more the less the way to the goal is open.
fn escape(parameters: &BehaviourParameters, around: &Surroundings<'_>) -> Advice {
    let wanted_rad = around.goal_in_base.map_or(0.0, |goal| libm::atan2(goal.y, goal.x));
    let goal_m = around.goal_in_base.map_or(f64::INFINITY, |goal| goal.coords.norm());
    let gap_m = parameters.gap_distance_m.min(goal_m);
    let is_shut = 1.0 - around.open_m(wanted_rad, gap_m) / gap_m.max(f64::MIN_POSITIVE);
    let Some(gap_rad) = around.gap_rad(wanted_rad, gap_m) else {
        return Advice { speed: 1.0, turn: 1.0, degree: 0.0 };
    };
    let turn_rad = wrap_angle_rad(gap_rad);
    Advice { speed: 1.0, turn: (turn_rad / TURN_FULLY_RAD).clamp(-1.0, 1.0), degree: is_shut.clamp(0.0, 1.0) }
}

/// Turns to the short-term goal.
fn to_goal(around: &Surroundings<'_>) -> Advice {
    let Some(goal_in_base) = around.goal_in_base else { return Advice { speed: 1.0, ..Advice::default() } };
    let bearing_rad = libm::atan2(goal_in_base.y, goal_in_base.x);
    let strength = (FULL_STRENGTH_M / goal_in_base.coords.norm()).clamp(LEAST_STRENGTH, 1.0);
    let [slow_rad, stand_rad] = ASIDE_RAD;
    let aside = ((bearing_rad.abs() - slow_rad) / (stand_rad - slow_rad)).clamp(0.0, 1.0);
    Advice { speed: 1.0 - aside, turn: (bearing_rad / TURN_FULLY_RAD).clamp(-1.0, 1.0), degree: strength }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_robot::avoidance::DriveLimits;
    use rpl_robot::geometry::Point;

    fn wanted(obstacles_in_base: &[Point], goal_in_base: Option<Point>) -> Velocity {
        let limits = DriveLimits::default();
        blend(&BehaviourParameters::TUNED, &Surroundings { limits: &limits, obstacles_in_base, goal_in_base })
    }

    #[test]
    fn where_nothing_is_near_it_drives_straight_to_the_goal() {
        let Velocity { translation_mps, rotation_radps } = wanted(&[], Some(Point::new(5.0, 0.0)));
        assert_eq!((translation_mps, rotation_radps), (BehaviourParameters::TUNED.translation_mps, 0.0));
        assert!(wanted(&[], Some(Point::new(4.0, 2.0))).rotation_radps > 0.0, "the goal is to the left");
    }

    #[test]
    fn a_goal_behind_is_turned_to_before_it_is_driven_to() {
        let velocity = wanted(&[], Some(Point::new(-3.0, -0.5)));
        assert_eq!(velocity.translation_mps, 0.0);
        assert!(velocity.rotation_radps < -0.5, "{velocity:?}");
    }

    #[test]
    fn what_is_near_ahead_slows_it_and_turns_it_away() {
        let posts: Vec<Point> = (0..6).map(|post| Point::new(0.6, 0.02 + f64::from(post) * 0.05)).collect();
        let velocity = wanted(&posts, Some(Point::new(5.0, 0.0)));
        assert!(velocity.translation_mps < 0.4, "{velocity:?}");
        assert!(velocity.rotation_radps < 0.0, "to the right, where there is room: {velocity:?}");
        let mirrored: Vec<Point> = posts.iter().map(|post| Point::new(post.x, -post.y)).collect();
        let other = wanted(&mirrored, Some(Point::new(5.0, 0.0)));
        assert!((velocity.rotation_radps + other.rotation_radps).abs() < 0.2, "{velocity:?} {other:?}");
    }
}
