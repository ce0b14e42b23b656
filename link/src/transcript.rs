//! Transcripts: what was said on a line and what was answered, turn by turn. A run that is repeated from a
//! copy hears the same again; only what nobody has said yet is spoken. A transcript without anybody behind
//! it is a recording heard again.

use crate::recording::{Recorder, Stretch, Turn};
use rpl_protocol::line::{Line, LineFault};
use serde::Serialize;
use std::collections::VecDeque;
use std::fmt::Debug;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Somebody outside who answers now.
pub trait Live<Q, A>: Debug + Send {
    /// The answer to some words; may wait for it, but not without end.
    ///
    /// # Errors
    /// There is none, and there will be none.
    fn answer(&mut self, words: &Q) -> Result<A, LineFault>;
}

/// How many turns stay in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    /// The last one: for runs that never go back.
    Last,
    /// This many of the newest: for sessions. Going back further is refused, and says so.
    Newest(usize),
}

/// Where a run wants to say something else than the transcript has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Divergence {
    /// The turn.
    pub turn: u64,
    /// What was said then, as JSON.
    pub recorded: String,
    /// What the run would say now, as JSON.
    pub now: String,
}

/// A line with its memory.
#[derive(Debug)]
pub struct Transcript<Q, A> {
    /// By which messages and recordings call the line.
    name: String,
    said: Mutex<Said<Q, A>>,
}

#[derive(Debug)]
struct Said<Q, A> {
    turns: VecDeque<Turn<Q, A>>,
    /// The number of the first turn in memory.
    first: u64,
    most: usize,
    live: Option<Box<dyn Live<Q, A>>>,
    recorder: Option<Arc<Recorder>>,
    divergence: Option<Divergence>,
}

impl<Q, A> Transcript<Q, A> {
    /// A line to somebody, called by a name; every turn is handed to the recorder as it ends.
    pub fn live(name: &str, live: Box<dyn Live<Q, A>>, kept: Kept, recorder: Option<Arc<Recorder>>) -> Self {
        let most = match kept {
            Kept::Last => 1,
            Kept::Newest(most) => most.max(1),
        };
        let said = Said { turns: VecDeque::new(), first: 0, most, live: Some(live), recorder, divergence: None };
        Self { name: name.to_string(), said: Mutex::new(said) }
    }

    /// What a recording has of a line, with nobody behind it.
    pub fn recorded(name: &str, turns: Vec<Turn<Q, A>>) -> Self {
        let turns = VecDeque::from(turns);
        let said = Said { turns, first: 0, most: usize::MAX, live: None, recorder: None, divergence: None };
        Self { name: name.to_string(), said: Mutex::new(said) }
    }

    /// Somebody was heard on this line before, who is not there any more: those turns are heard again, and the
    /// first that is new is spoken, and handed to the recorder. They stay as long as nothing new is spoken.
    ///
    /// # Panics
    /// Something was said already.
    pub fn go_on(&self, past: Stretch<Q, A>, recorder: Option<Arc<Recorder>>) {
        let mut said = self.said();
        assert!(said.turns.is_empty(), "`{}` goes on before anything is said", self.name);
        (said.first, said.turns, said.recorder) = (past.first, past.turns.into(), recorder);
    }

    /// Where a run first wanted to say something else, if one did.
    pub fn divergence(&self) -> Option<Divergence> {
        self.said().divergence.clone()
    }

    /// A thread that panicked while it held the lock has left whole turns: a turn is added when it is over.
    fn said(&self) -> MutexGuard<'_, Said<Q, A>> {
        self.said.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<Q, A> Line<Q, A> for Transcript<Q, A>
where
    Q: Clone + Debug + PartialEq + Send + Serialize,
    A: Clone + Debug + Send + Serialize,
{
    fn exchange(&self, turn: u64, words: &Q) -> Result<A, LineFault> {
        let mut said = self.said();
        let Some(at) = turn.checked_sub(said.first) else {
            let (name, most) = (&self.name, said.most);
            return Err(LineFault(format!(
                "`{name}` was heard more than {most} turns ago, and what it said then is not kept"
            )));
        };
        match said.turns.get(at as usize) {
            Some(past) if past.words == *words => past.answer.clone(),
            Some(past) => {
                let (recorded, now) = (as_json(&past.words), as_json(words));
                let fault = LineFault(format!(
                    "`{}` cannot answer: at turn {turn} it was told {recorded}, and now it would be told {now}",
                    self.name
                ));
                said.divergence.get_or_insert(Divergence { turn, recorded, now });
                Err(fault)
            }
            None => said.speak(&self.name, turn, words),
        }
    }
}

impl<Q, A> Said<Q, A>
where
    Q: Clone + Serialize,
    A: Clone + Serialize,
{
    fn speak(&mut self, name: &str, turn: u64, words: &Q) -> Result<A, LineFault> {
        // Nobody answers after a fault: the turn was the last.
        let Some(live) = &mut self.live else {
            return Err(LineFault(format!("the recording of `{name}` ends after {turn} turns")));
        };
        let answer = live.answer(words);
        if let Some(recorder) = &self.recorder {
            recorder.turn(name, turn, words, &answer);
        }
        if self.turns.is_empty() {
            self.first = turn;
        }
        self.turns.push_back(Turn { words: words.clone(), answer: answer.clone() });
        let forgotten = self.turns.len().saturating_sub(self.most);
        self.turns.drain(..forgotten);
        self.first += forgotten as u64;
        answer
    }
}

fn as_json(value: &impl Serialize) -> String {
    serde_json::to_string(value).unwrap_or_else(|error| format!("what cannot be written: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_protocol::line::Conversation;

    /// Counts what it is asked, and has had enough at some time.
    #[derive(Debug)]
    struct Counter {
        asked: u64,
        most: u64,
    }

    impl Live<String, u64> for Counter {
        fn answer(&mut self, _: &String) -> Result<u64, LineFault> {
            self.asked += 1;
            if self.asked > self.most { Err(LineFault("`counter` has had enough".into())) } else { Ok(self.asked) }
        }
    }

    fn conversation(kept: Kept) -> Conversation<String, u64> {
        let counter = Box::new(Counter { asked: 0, most: 3 });
        Conversation::new(Arc::new(Transcript::live("counter", counter, kept, None)))
    }

    fn say(conversation: &mut Conversation<String, u64>, words: &str) -> Result<u64, String> {
        conversation.say(&words.to_string()).map_err(|LineFault(why)| why)
    }

    #[test]
    fn a_copy_hears_what_was_answered_and_only_what_is_new_is_spoken() {
        let mut one = conversation(Kept::Newest(10));
        let mut other = one.clone();
        assert_eq!([say(&mut one, "a"), say(&mut one, "b")], [Ok(1), Ok(2)]);
        assert_eq!([say(&mut other, "a"), say(&mut other, "b"), say(&mut other, "c")], [Ok(1), Ok(2), Ok(3)]);
        assert_eq!(say(&mut one, "c"), Ok(3));
    }

    #[test]
    fn a_copy_that_says_something_else_is_told_both() {
        let mut one = conversation(Kept::Newest(10));
        let mut other = one.clone();
        assert_eq!(say(&mut one, "a"), Ok(1));
        let why = say(&mut other, "x").expect_err("it cannot be known");
        assert!(why.contains("\"a\"") && why.contains("\"x\"") && why.contains("turn 0"), "{why}");
        assert_eq!(other.turn(), 0);
    }

    #[test]
    fn a_fault_is_a_part_of_what_was_heard() {
        let mut one = conversation(Kept::Newest(10));
        let mut other = one.clone();
        let heard: Vec<_> = (0..4).map(|_| say(&mut one, "a")).collect();
        assert_eq!(heard[3], Err("`counter` has had enough".to_string()));
        assert_eq!((0..4).map(|_| say(&mut other, "a")).collect::<Vec<_>>(), heard);
    }

    #[test]
    fn what_is_not_kept_is_not_made_up() {
        let mut one = conversation(Kept::Last);
        let mut other = one.clone();
        assert_eq!([say(&mut one, "a"), say(&mut one, "b")], [Ok(1), Ok(2)]);
        let why = say(&mut other, "a").expect_err("the first turn is forgotten");
        assert!(why.contains("`counter`") && why.contains("not kept"), "{why}");
    }

    #[test]
    fn what_was_heard_of_somebody_else_is_heard_again_and_then_it_goes_on() {
        let turn = |words: &str, answer| Turn { words: words.to_string(), answer: Ok(answer) };
        let past = Stretch { first: 40, turns: vec![turn("a", 7), turn("b", 8)] };
        let counter = Box::new(Counter { asked: 0, most: 3 });
        let line = Arc::new(Transcript::live("counter", counter, Kept::Last, None));
        line.go_on(past, None);
        let mut resumed = Conversation::new(line as Arc<dyn Line<String, u64>>);
        let mut early = resumed.clone();
        resumed.go_on_at(40);
        early.go_on_at(39);
        assert_eq!([say(&mut resumed, "a"), say(&mut resumed, "b"), say(&mut resumed, "c")], [Ok(7), Ok(8), Ok(1)]);
        assert!(say(&mut early, "a").expect_err("it is before all that is known").contains("not kept"));
        assert_eq!(say(&mut resumed, "d"), Ok(2));
    }

    #[test]
    fn a_recording_ends_where_it_ends() {
        let turns = vec![Turn { words: "a".to_string(), answer: Ok(1_u64) }];
        let transcript = Arc::new(Transcript::recorded("counter", turns));
        let mut again = Conversation::new(transcript.clone() as Arc<dyn Line<String, u64>>);
        assert_eq!(say(&mut again, "a"), Ok(1));
        assert!(say(&mut again, "a").expect_err("it is over").contains("ends after 1 turn"));
        assert_eq!(transcript.divergence(), None);
        let mut fork = Conversation::new(transcript.clone() as Arc<dyn Line<String, u64>>);
        say(&mut fork, "b").expect_err("it was something else");
        let Some(Divergence { turn, recorded, now }) = transcript.divergence() else { panic!("it went astray") };
        assert_eq!((turn, &*recorded, &*now), (0, "\"a\"", "\"b\""));
    }
}
