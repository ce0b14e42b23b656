//! The features of a situation, by name.

use rpl_robot::geometry::Point;
use serde::{Deserialize, Serialize};

/// A feature of a situation, in the order of the paper, then in the robot's frame, then of goals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Feature {
    /// What each sonar measured last.
    Sonars,
    /// The mean of the last readings of each sonar.
    MeanSonars,
    /// Speed ahead.
    Translation,
    /// Speed of turning.
    Rotation,
    /// Where the robot believes to be.
    Place,
    /// Where it is driving now.
    ShortTermGoal,
    /// Where its errand ends.
    LongTermGoal,
    /// How far off the short-term goal is.
    ShortTermGoalDistance,
    /// In which direction of the robot it lies.
    ShortTermGoalBearing,
    /// How important a goal is.
    Priority,
    /// By when a goal must be reached; now.
    Time,
}

impl Feature {
    /// How many there are.
    pub const COUNT: usize = 11;

    /// All of them, in their order; a feature is known by its place here.
    pub const ALL: [Feature; Self::COUNT] = [
        Self::Sonars,
        Self::MeanSonars,
        Self::Translation,
        Self::Rotation,
        Self::Place,
        Self::ShortTermGoal,
        Self::LongTermGoal,
        Self::ShortTermGoalDistance,
        Self::ShortTermGoalBearing,
        Self::Priority,
        Self::Time,
    ];

    /// As explanations and plans call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sonars => "sonars",
            Self::MeanSonars => "mean-sonars",
            Self::Translation => "translation",
            Self::Rotation => "rotation",
            Self::Place => "place",
            Self::ShortTermGoal => "short-term-goal",
            Self::LongTermGoal => "long-term-goal",
            Self::ShortTermGoalDistance => "short-term-goal-distance",
            Self::ShortTermGoalBearing => "short-term-goal-bearing",
            Self::Priority => "priority",
            Self::Time => "time",
        }
    }

    /// As the field of a situation is called in a file.
    pub fn key(self) -> &'static str {
        match self {
            Self::Sonars => "sonars_m",
            Self::MeanSonars => "mean_sonars_m",
            Self::Translation => "translation_mps",
            Self::Rotation => "rotation_radps",
            Self::Place => "place_in_map",
            Self::ShortTermGoal => "short_term_goal_in_map",
            Self::LongTermGoal => "long_term_goal_in_map",
            Self::ShortTermGoalDistance => "short_term_goal_distance_m",
            Self::ShortTermGoalBearing => "short_term_goal_bearing_rad",
            Self::Priority => "priority",
            Self::Time => "time_s",
        }
    }

    /// Whether cases can be compared by a value of it: missing, or finite and in its domain.
    pub(super) fn is_usable(self, value: Value) -> bool {
        let is_range = |metres: f64| metres.is_finite() && metres >= 0.0;
        match value {
            Value::Missing => true,
            Value::Ranges(ranges) => !ranges.is_empty() && ranges.iter().all(|&range_m| is_range(range_m)),
            Value::Point(point) => point.iter().all(|metres| metres.is_finite()),
            Value::Number(number) => match self {
                Self::ShortTermGoalDistance => is_range(number),
                Self::Priority => (0.0..=1.0).contains(&number),
                _ => number.is_finite(),
            },
        }
    }
}

/// What a feature is in a situation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<'s> {
    /// There is none.
    Missing,
    /// One for each sonar, in metres.
    Ranges(&'s [f64]),
    /// A place, in the map frame.
    Point(Point),
    /// In the unit of the feature.
    Number(f64),
}
