//! Thinking beside a run: the questions that a run has under way with who thinks for it, and what is said on the
//! line to it.
//!
//! While something is under way there is a turn at each step of the robot: the run tells what it has come to ask and
//! what it wants to know no more, and hears what is answered. The question itself does not go over the line: who
//! thinks in this process is handed it ([`AskedQuestion::thought`]), and a recording needs none.
//!
//! It is one more conversation by turns; so copies, recordings and journals hear the answers again.

use crate::line::{Conversation, Line, LineFault};
use rpl_runtime::robot::thinking::{Insight, Thought, Ticket};
use rpl_runtime::state::failure::Raise;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::{Arc, Weak};

/// More questions are not under way at once: each holds a copy of the run.
pub const MOST_UNDER_WAY: usize = 64;

/// What a run says at a turn.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ThinkingWords {
    /// New questions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub asked: Vec<AskedQuestion>,
    /// Numbers of questions that are not to be thought about any more.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub dropped: Vec<u64>,
}

/// A question as it is said.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AskedQuestion {
    /// Counts the questions of a run.
    pub number: u64,
    /// The question itself, for as long as the run wants the answer; none where it is read again.
    #[serde(skip)]
    pub thought: Option<Weak<dyn Thought>>,
}

/// Questions are told by their numbers: one that is another than it was is found out by its answer.
impl PartialEq for AskedQuestion {
    fn eq(&self, other: &Self) -> bool {
        self.number == other.number
    }
}

/// What is answered at a turn.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ThinkingAnswer {
    /// What has come since the turn before, in its order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub answered: Vec<AnsweredQuestion>,
    /// Numbers of questions that are to be asked again: who is to think about them does not have them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unknown: Vec<u64>,
}

/// A question that is answered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AnsweredQuestion {
    /// Its number.
    pub number: u64,
    /// Its checksum.
    pub question: u32,
    /// The answer.
    pub insight: Insight,
}

/// The line to who thinks for a run.
pub type ThinkingLine = Arc<dyn Line<ThinkingWords, ThinkingAnswer>>;

/// The questions of a run that are thought about beside it. A copy shares the line, and hears what was said already.
#[derive(Clone, Debug)]
pub struct Thinking {
    conversation: Conversation<ThinkingWords, ThinkingAnswer>,
    /// The number of the next question.
    next: u64,
    under_way: BTreeMap<u64, UnderWay>,
    /// Those that were not told yet are from this number on.
    untold: u64,
}

/// A question under way.
#[derive(Clone, Debug)]
struct UnderWay {
    ticket: Ticket,
    question: u32,
    /// None in a run that was saved: only what was heard answers it there.
    thought: Option<Arc<dyn Thought>>,
}

/// What changes: turns that are over, the number of the next question, of the first that was not told, and those under
/// way with their checksums.
pub(crate) type Changing = (u64, u64, u64, Vec<(u64, Ticket, u32)>);

impl Thinking {
    /// A run that has not asked anything.
    pub fn new(line: ThinkingLine) -> Self {
        Self { conversation: Conversation::new(line), next: 0, under_way: BTreeMap::new(), untold: 0 }
    }

    /// Takes a question.
    ///
    /// # Errors
    /// There are too many.
    pub fn take(&mut self, ticket: Ticket, thought: Arc<dyn Thought>) -> Result<(), Raise> {
        if self.under_way.len() >= MOST_UNDER_WAY {
            return Err(Raise::new(
                "projection-failure",
                format!("{MOST_UNDER_WAY} questions are being thought about already; ask again when one is answered"),
            ));
        }
        let question = thought.checksum();
        self.under_way.insert(self.next, UnderWay { ticket, question, thought: Some(thought) });
        self.next += 1;
        Ok(())
    }

    /// A turn, if there is anything to say: what is answered now. What nobody waits for is dropped.
    pub fn hear(&mut self, is_awaited: &dyn Fn(Ticket) -> bool) -> Vec<(Ticket, Option<Insight>)> {
        let words = self.words(is_awaited);
        if self.under_way.is_empty() && words == ThinkingWords::default() {
            return Vec::new();
        }
        match self.conversation.say(&words) {
            Ok(ThinkingAnswer { answered, unknown }) => {
                let answers = answered.into_iter().filter_map(|answered| self.answer(answered));
                let mut answers: Vec<_> = answers.collect();
                let unknown = unknown.iter().filter_map(|number| self.under_way.remove(number));
                answers.extend(unknown.map(|one| (one.ticket, None)));
                answers
            }
            Err(LineFault(why)) => {
                let failed = || Insight::Failed { class: "projection-failure".to_string(), message: why.clone() };
                self.forget().into_iter().map(|ticket| (ticket, Some(failed()))).collect()
            }
        }
    }

    fn words(&mut self, is_awaited: &dyn Fn(Ticket) -> bool) -> ThinkingWords {
        let untold = std::mem::replace(&mut self.untold, self.next);
        let is_dropped = |under_way: &UnderWay| !is_awaited(under_way.ticket);
        let dropped: Vec<u64> =
            self.under_way.extract_if(.., |_, one| is_dropped(one)).map(|(number, _)| number).collect();
        let told = self
            .under_way
            .range(untold..)
            .map(|(&number, one)| AskedQuestion { number, thought: one.thought.as_ref().map(Arc::downgrade) });
        ThinkingWords {
            asked: told.collect(),
            dropped: dropped.into_iter().filter(|&number| number < untold).collect(),
        }
    }

    /// Hands out an answer. Where a run that is heard again asks something else than it did then, it is the moment
    /// that counts: the answer is thought about here.
    fn answer(
        &mut self,
        AnsweredQuestion { number, question, insight }: AnsweredQuestion,
    ) -> Option<(Ticket, Option<Insight>)> {
        let one = self.under_way.remove(&number)?;
        let insight = match one.question == question {
            true => Some(insight),
            false => one.thought.and_then(|thought| thought.think(&|| false)),
        };
        Some((one.ticket, insight))
    }

    /// Nothing is thought about any more: who waits.
    pub fn forget(&mut self) -> Vec<Ticket> {
        std::mem::take(&mut self.under_way).into_values().map(|one| one.ticket).collect()
    }

    pub(crate) fn changing(&self) -> Changing {
        let under_way = self.under_way.iter().map(|(&number, one)| (number, one.ticket, one.question));
        (self.conversation.turn(), self.next, self.untold, under_way.collect())
    }

    pub(crate) fn change(&mut self, (turn, next, untold, under_way): Changing) {
        self.conversation.go_on_at(turn);
        (self.next, self.untold) = (next, untold);
        let read = |(number, ticket, question)| (number, UnderWay { ticket, question, thought: None });
        self.under_way = under_way.into_iter().map(read).collect();
    }
}
