//! Cases: what was done in a situation, and how it went.

use crate::control::BehaviourParameters;
use crate::route::Route;
use crate::situation::Situation;
use rpl_robot::geometry::Point;
use serde::{Deserialize, Serialize};

/// What was done in a situation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// When it applies.
    pub index: Situation,
    /// What is to be done then.
    pub content: Content,
    /// How it went.
    pub counts: Counts,
}

impl Case {
    /// A case that was never used.
    pub fn new(index: Situation, content: Content) -> Self {
        Self { index, content, counts: Counts::default() }
    }
}

/// What is to be done: which of these comes back decides what the robot changes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Content {
    /// How to drive.
    Behaviour(BehaviourParameters),
    /// Where to go.
    Route(Route),
    /// What to go to next.
    Goal(Goal),
    /// What to learn or to find out first.
    MetaPlan(MetaPlan),
}

impl Content {
    /// What kind of case it makes.
    pub fn kind(&self) -> Kind {
        match self {
            Self::Behaviour(_) => Kind::Behaviour,
            Self::Route(_) => Kind::Route,
            Self::Goal(_) => Kind::Goal,
            Self::MetaPlan(_) => Kind::MetaPlan,
        }
    }
}

/// The kinds of cases.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Parameters of the reactive control.
    Behaviour,
    /// A sequence of places.
    Route,
    /// A place to reach, with its priority and deadline in the index.
    Goal,
    /// What directs the making of cases.
    MetaPlan,
}

impl Kind {
    /// All of them.
    pub const ALL: [Kind; 4] = [Self::Behaviour, Self::Route, Self::Goal, Self::MetaPlan];

    /// As explanations and plans call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Behaviour => "behaviour",
            Self::Route => "route",
            Self::Goal => "goal",
            Self::MetaPlan => "meta-plan",
        }
    }
}

/// A place to reach. How urgent that is stands in the index of the case, so that the most similar goal to one
/// who asks for priority 1 now is the next to go to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Goal {
    /// Where.
    pub place_in_map: Point,
}

/// What directs the making of cases (Fox and Anderson-Sprecher, RUPART Architecture).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MetaPlan {
    /// No case is good here: plan the route on the map alone.
    MakeRoute,
    /// No parameters are good here: train some.
    TrainBehaviour,
    /// Find out where the robot is first.
    LocalizeFirst,
}

impl MetaPlan {
    /// All of them.
    pub const ALL: [MetaPlan; 3] = [Self::MakeRoute, Self::TrainBehaviour, Self::LocalizeFirst];

    /// As explanations and plans call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::MakeRoute => "make-route",
            Self::TrainBehaviour => "train-behaviour",
            Self::LocalizeFirst => "localize-first",
        }
    }
}

/// How often a case was used, and how it went.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Counts {
    /// Times it was applied.
    pub used: u32,
    /// Times after which the goal was reached.
    pub succeeded: u32,
}

impl Counts {
    /// Notes one use.
    pub fn note(&mut self, succeeded: bool) {
        self.used = self.used.saturating_add(1);
        self.succeeded = self.succeeded.saturating_add(u32::from(succeeded));
    }

    /// The share of uses that succeeded, for a case of which nothing is known a half (Laplace).
    pub fn success_rate(&self) -> f64 {
        (f64::from(self.succeeded) + 1.0) / (f64::from(self.used) + 2.0)
    }
}
