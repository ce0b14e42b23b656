//! LIFE

use serde::{Deserialize, Serialize};

/// Where a task is in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum State {
    /// Known by its tag or held back by an order; has not started.
    Created,
    /// In the run queue, or would be if it were not suspended.
    Ready,
    /// Its code is being executed.
    Running,
    /// Waits for something.
    Blocked,
    /// Ended well.
    Succeeded,
    /// Ended with a failure.
    Failed,
    /// Was ended from outside.
    Evaporated,
}

impl State {
    /// Whether it never changes again.
    pub fn is_dead(self) -> bool {
        matches!(self, State::Succeeded | State::Failed | State::Evaporated)
    }

    /// The symbol `(status T)` holds.
    pub fn name(self) -> &'static str {
        match self {
            State::Created => "created",
            State::Ready => "ready",
            State::Running => "running",
            State::Blocked => "blocked",
            State::Succeeded => "succeeded",
            State::Failed => "failed",
            State::Evaporated => "evaporated",
        }
    }

    /// The table above.
    pub fn may_become(self, next: State) -> bool {
        use State::{Blocked, Created, Evaporated, Failed, Ready, Running, Succeeded};
        match self {
            Created => matches!(next, Ready | Evaporated),
            Ready => matches!(next, Running | Evaporated | Blocked),
            Running => matches!(next, Ready | Blocked | Succeeded | Failed | Evaporated),
            Blocked => matches!(next, Ready | Evaporated | Failed),
            Succeeded | Failed | Evaporated => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::State::{self, Blocked, Created, Evaporated, Failed, Ready, Running, Succeeded};

    #[test]
    fn the_dead_never_change() {
        let all = [Created, Ready, Running, Blocked, Succeeded, Failed, Evaporated];
        for from in all {
            for to in all {
                if from.is_dead() {
                    assert!(!from.may_become(to), "{from:?} became {to:?}");
                }
                assert!(!State::may_become(from, Created), "nothing becomes created again");
            }
        }
        assert!(!Created.may_become(Running) && !Blocked.may_become(Running));
    }
}
