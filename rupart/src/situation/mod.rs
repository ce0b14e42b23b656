//! The index of a case: what the robot perceives, where it is, and where it is going.

mod feature;
mod recent_sonars;

pub use feature::{Feature, Value};
pub use recent_sonars::{READINGS_AVERAGED, RecentSonars};

use rpl_robot::geometry::{Point, Pose, distance_m, wrap_angle_rad};
use serde::{Deserialize, Serialize};

/// What the robot perceives, where it is, and where it is going (Fox and Anderson-Sprecher, RUPART
/// Architecture). Each feature may be missing: without a route there is no short-term goal, a lost robot has
/// no place.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Situation {
    /// What each sonar measured last, in the order of the robot's description; the greatest range where
    /// nothing was heard.
    pub sonars_m: Option<Vec<f64>>,
    /// The mean of the last five readings of each sonar.
    pub mean_sonars_m: Option<Vec<f64>>,
    /// Speed ahead.
    pub translation_mps: Option<f64>,
    /// Speed of turning, counter-clockwise.
    pub rotation_radps: Option<f64>,
    /// Where the robot believes to be.
    pub place_in_map: Option<Point>,
    /// The place it is driving to now.
    pub short_term_goal_in_map: Option<Point>,
    /// The place where its errand ends.
    pub long_term_goal_in_map: Option<Point>,
    /// How far off the short-term goal is.
    pub short_term_goal_distance_m: Option<f64>,
    /// In which direction it lies, counter-clockwise from ahead.
    pub short_term_goal_bearing_rad: Option<f64>,
    /// How important a goal is, 0 to 1; one who looks for the next goal asks for 1.
    pub priority: Option<f64>,
    /// Time of the plan: by when a goal must be reached; for one who looks for the next goal, now.
    pub time_s: Option<f64>,
}

impl Situation {
    /// A situation in which only a way is asked for: from a place to a goal, and nothing is driven to yet.
    pub fn of_route(place_in_map: Point, long_term_goal_in_map: Point) -> Self {
        Self { place_in_map: Some(place_in_map), long_term_goal_in_map: Some(long_term_goal_in_map), ..Self::default() }
    }

    /// Sets the place, and distance and bearing of the short-term goal as seen from there.
    #[must_use]
    pub fn seen_from(mut self, robot_in_map: Pose) -> Self {
        self.place_in_map = Some(robot_in_map.point());
        let goal = self.short_term_goal_in_map;
        self.short_term_goal_distance_m = goal.map(|goal| distance_m(robot_in_map.point(), goal));
        self.short_term_goal_bearing_rad = goal.map(|goal| bearing_rad(robot_in_map, goal));
        self
    }

    /// What a feature is in this self.
    pub fn value(&self, feature: Feature) -> Value<'_> {
        let number = |number: Option<f64>| number.map_or(Value::Missing, Value::Number);
        let point = |point: Option<Point>| point.map_or(Value::Missing, Value::Point);
        match feature {
            Feature::Sonars => self.sonars_m.as_deref().map_or(Value::Missing, Value::Ranges),
            Feature::MeanSonars => self.mean_sonars_m.as_deref().map_or(Value::Missing, Value::Ranges),
            Feature::Translation => number(self.translation_mps),
            Feature::Rotation => number(self.rotation_radps),
            Feature::Place => point(self.place_in_map),
            Feature::ShortTermGoal => point(self.short_term_goal_in_map),
            Feature::LongTermGoal => point(self.long_term_goal_in_map),
            Feature::ShortTermGoalDistance => number(self.short_term_goal_distance_m),
            Feature::ShortTermGoalBearing => number(self.short_term_goal_bearing_rad),
            Feature::Priority => number(self.priority),
            Feature::Time => number(self.time_s),
        }
    }

    /// The features that are numbers no case can be compared by: not finite, or outside their domain.
    pub fn unusable_features(&self) -> Vec<Feature> {
        Feature::ALL.into_iter().filter(|feature| !feature.is_usable(self.value(*feature))).collect()
    }
}

/// In which direction of the robot a point lies, counter-clockwise from ahead, in (−π, π].
fn bearing_rad(robot_in_map: Pose, point_in_map: Point) -> f64 {
    let ahead = point_in_map - robot_in_map.point();
    wrap_angle_rad(libm::atan2(ahead.y, ahead.x) - robot_in_map.heading_rad)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    #[test]
    fn the_short_term_goal_is_seen_in_the_robots_frame() {
        let goal = Point::new(1.0, 4.0);
        let situation = Situation { short_term_goal_in_map: Some(goal), ..Situation::default() };
        let seen = situation.seen_from(Pose::new(1.0, 1.0, PI));
        assert_eq!(seen.short_term_goal_distance_m, Some(3.0));
        let bearing_rad = seen.short_term_goal_bearing_rad.expect("there is a goal");
        assert!((bearing_rad + FRAC_PI_2).abs() < 1e-12, "one who looks west has the north to the right");
        assert_eq!(Situation::default().seen_from(Pose::default()).short_term_goal_distance_m, None);
    }

    #[test]
    fn numbers_that_cannot_be_compared_are_named() {
        let situation = Situation {
            sonars_m: Some(vec![1.0, f64::NAN]),
            translation_mps: Some(f64::INFINITY),
            priority: Some(1.5),
            rotation_radps: Some(-3.0),
            ..Situation::default()
        };
        assert_eq!(situation.unusable_features(), [Feature::Sonars, Feature::Translation, Feature::Priority]);
    }
}
