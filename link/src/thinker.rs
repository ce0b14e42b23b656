//! Who thinks beside a run: one thread of this process, which takes the questions in their order. It is there from
//! the first question on, and ends soon when nobody listens any more.

use crate::transcript::Live;
use crossbeam::channel::{Receiver, Sender, unbounded};
use rpl_protocol::line::LineFault;
use rpl_protocol::thinking::{AnsweredQuestion, AskedQuestion, ThinkingAnswer, ThinkingWords};
use rpl_runtime::robot::thinking::Thought;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Weak};
use std::thread::{self, JoinHandle};

/// A question on its way to the thread.
#[derive(Debug)]
struct Job {
    number: u64,
    thought: Arc<dyn Thought>,
    is_given_up: Arc<AtomicBool>,
}

/// Thinks about questions.
#[derive(Debug, Default)]
pub struct Thinker {
    worker: Option<Worker>,
    /// Of each question that is not answered, what tells the thread that nobody wants to know any more.
    given_up: BTreeMap<u64, Arc<AtomicBool>>,
}

#[derive(Debug)]
struct Worker {
    jobs: Sender<Job>,
    answers: Receiver<AnsweredQuestion>,
    thread: JoinHandle<()>,
}

impl Worker {
    fn start() -> Self {
        let (jobs, asked) = unbounded::<Job>();
        let (answer, answers) = unbounded();
        let thread = thread::spawn(move || think(&asked, &answer));
        Self { jobs, answers, thread }
    }
}

/// Thinks about one question after the other, until there will be none.
fn think(asked: &Receiver<Job>, answers: &Sender<AnsweredQuestion>) {
    for Job { number, thought, is_given_up } in asked {
        let insight = thought.think(&|| is_given_up.load(Ordering::Relaxed));
        let Some(insight) = insight else { continue };
        let question = thought.checksum();
        if answers.send(AnsweredQuestion { number, question, insight }).is_err() {
            return;
        }
    }
}

impl Thinker {
    /// Whether the question can be thought about: one of a run that was saved is not there any more.
    fn ask(&mut self, AskedQuestion { number, thought }: &AskedQuestion) -> bool {
        let Some(thought) = thought.as_ref().and_then(Weak::upgrade) else { return false };
        let is_given_up = Arc::new(AtomicBool::new(false));
        self.given_up.insert(*number, is_given_up.clone());
        let worker = self.worker.get_or_insert_with(Worker::start);
        // That a thread is gone is told where answers are taken.
        worker.jobs.send(Job { number: *number, thought, is_given_up }).ok();
        true
    }

    fn give_up(&mut self, number: u64) {
        if let Some(is_given_up) = self.given_up.remove(&number) {
            is_given_up.store(true, Ordering::Relaxed);
        }
    }

    /// What has come since the last time.
    fn come(&mut self) -> Result<Vec<AnsweredQuestion>, LineFault> {
        let Some(worker) = &self.worker else { return Ok(Vec::new()) };
        let mut answered: Vec<AnsweredQuestion> = worker.answers.try_iter().collect();
        // One that was given up may have been on its way.
        answered.retain(|answer| self.given_up.remove(&answer.number).is_some());
        if !self.given_up.is_empty() && worker.thread.is_finished() && worker.answers.is_empty() {
            return Err(LineFault("thinking has ended before its answer: this is a fault of rpl".to_string()));
        }
        Ok(answered)
    }
}

impl Live<ThinkingWords, ThinkingAnswer> for Thinker {
    /// Does not wait.
    fn answer(&mut self, words: &ThinkingWords) -> Result<ThinkingAnswer, LineFault> {
        words.dropped.iter().for_each(|&number| self.give_up(number));
        let unknown = words.asked.iter().filter(|question| !self.ask(question)).map(|question| question.number);
        let unknown = unknown.collect();
        Ok(ThinkingAnswer { answered: self.come()?, unknown })
    }
}

impl Drop for Thinker {
    /// No thread is left behind.
    fn drop(&mut self) {
        self.given_up.values().for_each(|is_given_up| is_given_up.store(true, Ordering::Relaxed));
        if let Some(Worker { jobs, answers, thread }) = self.worker.take() {
            drop((jobs, answers));
            // It ends by itself, and has nothing to say.
            thread.join().ok();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_runtime::robot::thinking::Insight;

    /// Says when it is begun, and is answered with its number when it is told to, or when it is given up.
    #[derive(Debug)]
    struct Told {
        begun: Sender<u32>,
        go_on: Receiver<()>,
        number: u32,
    }

    impl Thought for Told {
        fn checksum(&self) -> u32 {
            self.number
        }

        fn think(&self, is_given_up: &dyn Fn() -> bool) -> Option<Insight> {
            self.begun.send(self.number).ok();
            loop {
                if is_given_up() {
                    return None;
                }
                if self.go_on.try_recv().is_ok() {
                    return Some(Insight::Failed { class: "failure".into(), message: self.number.to_string() });
                }
                thread::yield_now();
            }
        }
    }

    fn asked(number: u64, thought: &Arc<dyn Thought>) -> ThinkingWords {
        let thought = Some(Arc::downgrade(thought));
        ThinkingWords { asked: vec![AskedQuestion { number, thought }], dropped: Vec::new() }
    }

    fn numbers(answer: Result<ThinkingAnswer, LineFault>) -> Vec<u64> {
        answer.expect("it thinks").answered.iter().map(|answered| answered.number).collect()
    }

    #[test]
    fn questions_are_thought_about_one_after_the_other_and_nobody_waits_for_what_was_dropped() {
        let (begun, has_begun) = unbounded();
        let (go_on, told) = unbounded();
        let thoughts: Vec<Arc<dyn Thought>> = (0..3)
            .map(|number| Arc::new(Told { begun: begun.clone(), go_on: told.clone(), number }) as Arc<dyn Thought>)
            .collect();
        let mut thinker = Thinker::default();
        for (number, thought) in (0..).zip(&thoughts) {
            assert_eq!(numbers(thinker.answer(&asked(number, thought))), [0; 0]);
        }
        assert_eq!(has_begun.recv(), Ok(0));
        assert!(has_begun.is_empty(), "the others wait");
        let dropped = ThinkingWords { asked: Vec::new(), dropped: vec![0, 1] };
        assert_eq!(numbers(thinker.answer(&dropped)), [0; 0]);
        // The second is not begun in earnest: it was given up before.
        assert_eq!((has_begun.recv(), has_begun.recv()), (Ok(1), Ok(2)));
        go_on.send(()).expect("it listens");
        let mut heard = Vec::new();
        while heard.is_empty() {
            heard = numbers(thinker.answer(&ThinkingWords::default()));
        }
        assert_eq!(heard, [2]);
    }

    #[test]
    fn no_thread_is_left_behind() {
        let (begun, has_begun) = unbounded();
        let (_go_on, told) = unbounded();
        let thought: Arc<dyn Thought> = Arc::new(Told { begun, go_on: told, number: 0 });
        let mut thinker = Thinker::default();
        thinker.answer(&asked(0, &thought)).expect("it thinks");
        assert_eq!(has_begun.recv(), Ok(0));
        drop(thinker);
        assert_eq!(Arc::strong_count(&thought), 1, "the thread has let go of it");
    }

    #[test]
    fn what_is_not_there_any_more_is_to_be_asked_again() {
        let read: ThinkingWords = serde_json::from_str("{\"asked\":[{\"number\":7}]}").expect("it is written so");
        let answer = Thinker::default().answer(&read).expect("it answers");
        assert_eq!((answer.unknown, answer.answered.len()), (vec![7], 0));
    }
}
