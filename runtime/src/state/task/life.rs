//! The states of a task, and the transitions between them.
//!
//! | from | to |
//! | --- | --- |
//! | created | ready, evaporated |
//! | ready | running, blocked (on its way out before it runs again), evaporated (only before its first step) |
//! | running | ready (switched out), blocked, succeeded, failed, evaporated |
//! | blocked | ready, failed, evaporated |
//! | succeeded, failed, evaporated | – |
//!
//! `suspended` is not a state of its own here but a count ([`super::Rare::stop`]) over any living state: a
//! task runs when its own suspensions and its ancestors' are zero.

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

    /// Whether the table above has this transition.
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
    use crate::state::registers::Registers;
    use crate::state::task::Task;
    use rpl_lang::symbol::Symbols;
    use std::panic::{AssertUnwindSafe, catch_unwind};

    const ALL: [State; 7] = [Created, Ready, Running, Blocked, Succeeded, Failed, Evaporated];

    /// Row: from; column: to; both in the order of [`ALL`].
    const LEGAL: [[u8; 7]; 7] = [
        [0, 1, 0, 0, 0, 0, 1],
        [0, 0, 1, 1, 0, 0, 1],
        [0, 1, 0, 1, 1, 1, 1],
        [0, 1, 0, 0, 0, 1, 1],
        [0, 0, 0, 0, 0, 0, 0],
        [0, 0, 0, 0, 0, 0, 0],
        [0, 0, 0, 0, 0, 0, 0],
    ];

    #[test]
    fn a_task_makes_the_legal_transitions_and_no_others() {
        let name = Symbols::default().intern("task");
        for (from, row) in ALL.into_iter().zip(LEGAL) {
            for (to, legal) in ALL.into_iter().zip(row) {
                assert_eq!(from.may_become(to), legal == 1, "{from:?} to {to:?}");
                let mut task = Task::new(0, Registers::default(), name, 0);
                task.state = from;
                let entered = catch_unwind(AssertUnwindSafe(|| task.enter(to))).is_ok();
                assert_eq!(entered, legal == 1, "{from:?} to {to:?}");
            }
        }
    }
}
