//! The states of the control, and what leads from one to another.

use serde::{Deserialize, Serialize};

/// A state of the control that drives (Fox and Anderson-Sprecher, Fig. 2). The paper's Track turns the camera, and is
/// active beside any of these: [`Track`](crate::landmarks::Track).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum State {
    /// Stands.
    #[default]
    NoGoal,
    /// Turns to where the short-term goal is.
    NewGoal,
    /// Drives to the short-term goal and keeps off what stands about.
    Wander,
    /// Backs off from what the robot ran into.
    Bump,
    /// Drives to before a landmark.
    Loc1,
    /// Turns perpendicular to its wall, and finds out where the robot is.
    Loc2,
}

impl State {
    /// All of them.
    pub const ALL: [State; 6] = [Self::NoGoal, Self::NewGoal, Self::Wander, Self::Bump, Self::Loc1, Self::Loc2];

    /// The state that a trigger leads to: this one, if it leads nowhere from here.
    #[must_use]
    pub fn after(self, trigger: Trigger) -> Self {
        let found = TRANSITIONS.iter().find(|(from, on, _)| (*from, *on) == (self, trigger));
        found.map_or(self, |(.., to)| *to)
    }
}

/// What leads from one state to another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trigger {
    /// There is a short-term goal to drive to.
    GoalGiven,
    /// The robot looks to where its goal is.
    GoalFaced,
    /// The short-term goal is reached.
    GoalReached,
    /// The robot has run into something.
    Bumped,
    /// It has backed off for long enough.
    BackedOff,
    /// There is a landmark to localize by.
    LandmarkNear,
    /// The robot is before it.
    LandmarkReached,
    /// The position is known.
    Localized,
    /// It will not be known by this landmark.
    LandmarkLost,
}

/// From which state a trigger leads to which.
pub const TRANSITIONS: [(State, Trigger, State); 17] = {
    use State::{Bump, Loc1, Loc2, NewGoal, NoGoal, Wander};
    use Trigger::{
        BackedOff, Bumped, GoalFaced, GoalGiven, GoalReached, LandmarkLost, LandmarkNear, LandmarkReached, Localized,
    };
    [
        (NoGoal, GoalGiven, NewGoal),
        (Wander, GoalGiven, NewGoal),
        (NewGoal, GoalFaced, Wander),
        (NewGoal, GoalReached, NoGoal),
        (NewGoal, Bumped, Bump),
        (Wander, GoalReached, NoGoal),
        (Wander, Bumped, Bump),
        (Bump, GoalReached, NoGoal),
        (Bump, BackedOff, Wander),
        (NewGoal, LandmarkNear, Loc1),
        (Wander, LandmarkNear, Loc1),
        (Loc1, LandmarkReached, Loc2),
        (Loc1, LandmarkLost, NewGoal),
        (Loc1, Bumped, Bump),
        (Loc2, Localized, NewGoal),
        (Loc2, LandmarkLost, NewGoal),
        (Loc2, Bumped, Bump),
    ]
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_state_is_left_by_something_and_come_to_by_something() {
        for state in State::ALL {
            assert!(TRANSITIONS.iter().any(|(from, ..)| *from == state), "{state:?}");
            assert!(TRANSITIONS.iter().any(|(.., to)| *to == state), "{state:?}");
        }
    }

    #[test]
    fn the_same_trigger_leads_out_of_a_state_once() {
        for (index, (from, on, _)) in TRANSITIONS.iter().enumerate() {
            assert!(TRANSITIONS[..index].iter().all(|(other, trigger, _)| (other, trigger) != (from, on)));
        }
    }

    #[test]
    fn who_ran_into_something_backs_off_and_drives_on() {
        let state = State::default().after(Trigger::GoalGiven).after(Trigger::GoalFaced);
        assert_eq!(state, State::Wander);
        assert_eq!(state.after(Trigger::Bumped).after(Trigger::GoalFaced).after(Trigger::BackedOff), State::Wander);
        assert_eq!(state.after(Trigger::Bumped).after(Trigger::GoalGiven), State::Bump, "it is not off yet");
    }

    #[test]
    fn localizing_holds_all_else_up_and_ends_with_the_goal() {
        let localizing = State::Wander.after(Trigger::LandmarkNear);
        for other in [Trigger::GoalGiven, Trigger::GoalFaced, Trigger::GoalReached, Trigger::LandmarkNear] {
            assert_eq!(localizing.after(other), State::Loc1);
            assert_eq!(localizing.after(Trigger::LandmarkReached).after(other), State::Loc2);
        }
        let localized = localizing.after(Trigger::LandmarkReached).after(Trigger::Localized);
        assert_eq!(localized.after(Trigger::GoalFaced), State::Wander);
    }
}
