//! Lines: conversations by turns with what lies outside the deterministic core.
//!
//! A run is a value and may be copied, and the process at the other end of a line may not. So a turn has a
//! number: what was answered at it stays what was answered, for every copy that asks the same, and only a
//! turn nobody has reached yet is spoken. From this follow forks, going back, and hearing a recording again.

use std::fmt;
use std::sync::Arc;

/// Something outside that answers, turn by turn.
pub trait Line<Q, A>: fmt::Debug + Send + Sync {
    /// The answer at a turn, counted from 0. The same turn and the same words give the same answer.
    ///
    /// # Errors
    /// Nobody answers, or not so that it could be understood; or the turn is over, and other words were
    /// said at it.
    fn exchange(&self, turn: u64, words: &Q) -> Result<A, LineFault>;
}

/// Why there is no answer: one sentence that names who should have given it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LineFault(pub String);

/// Where a run stands in a conversation.
#[derive(Clone, Debug)]
pub struct Conversation<Q, A> {
    line: Arc<dyn Line<Q, A>>,
    turn: u64,
}

impl<Q, A> Conversation<Q, A> {
    /// A conversation at its start.
    pub fn new(line: Arc<dyn Line<Q, A>>) -> Self {
        Self { line, turn: 0 }
    }

    /// Says something and hears the answer.
    ///
    /// # Errors
    /// As for [`Line::exchange`]; the turn is then not over.
    pub fn say(&mut self, words: &Q) -> Result<A, LineFault> {
        let answer = self.line.exchange(self.turn, words)?;
        self.turn += 1;
        Ok(answer)
    }

    /// A conversation that was saved after `turn` turns goes on there.
    pub fn go_on_at(&mut self, turn: u64) {
        self.turn = turn;
    }

    /// Turns that are over.
    pub fn turn(&self) -> u64 {
        self.turn
    }
}
