//! The states of the control, and what leads from one to another.

use serde::{Deserialize, Serialize};

/// A state of the control (Fox and Anderson-Sprecher, Fig. 2).
///
/// # Deviation
/// The paper's Track, Loc1 and Loc2, which localize by landmarks, are missing: the position comes from the grid.
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
}

impl State {
    /// All of them.
    pub const ALL: [State; 4] = [Self::NoGoal, Self::NewGoal, Self::Wander, Self::Bump];

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
}

/// From which state a trigger leads to which.
pub const TRANSITIONS: [(State, Trigger, State); 9] = {
    use State::{Bump, NewGoal, NoGoal, Wander};
    use Trigger::{BackedOff, Bumped, GoalFaced, GoalGiven, GoalReached};
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
}
