//! Who thinks beside a run: one thread of this process, which takes the questions in their order. It is there from
//! the first question on, and ends soon when nobody listens any more.

use crate::transcript::Live;
use crossbeam::channel::{Receiver, Sender, TryRecvError, unbounded};
use rpl_protocol::line::LineFault;
use rpl_protocol::thinking::{AnsweredQuestion, AskedQuestion, ThinkingAnswer, ThinkingWords};
use rpl_runtime::robot::thinking::Thought;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
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
        if answers.send(AnsweredQuestion { number, question: thought.checksum(), insight }).is_err() {
            return;
        }
    }
}

impl Thinker {
    fn ask(&mut self, AskedQuestion { number, thought }: &AskedQuestion) {
        // Who does not want the answer any more has let go of the question.
        let Some(thought) = thought.as_ref().and_then(|thought| thought.upgrade()) else { return };
        let is_given_up = Arc::new(AtomicBool::new(false));
        self.given_up.insert(*number, is_given_up.clone());
        let worker = self.worker.get_or_insert_with(Worker::start);
        // A thread that is gone is told of where answers are taken.
        worker.jobs.send(Job { number: *number, thought, is_given_up }).ok();
    }

    fn drop_question(&mut self, number: u64) {
        if let Some(is_given_up) = self.given_up.remove(&number) {
            is_given_up.store(true, Ordering::Relaxed);
        }
    }
}

impl Live<ThinkingWords, ThinkingAnswer> for Thinker {
    /// Does not wait.
    fn answer(&mut self, words: &ThinkingWords) -> Result<ThinkingAnswer, LineFault> {
        words.dropped.iter().for_each(|&number| self.drop_question(number));
        words.asked.iter().for_each(|question| self.ask(question));
        let mut answered = Vec::new();
        let Some(worker) = &self.worker else { return Ok(ThinkingAnswer { answered }) };
        loop {
            match worker.answers.try_recv() {
                Ok(answer) => {
                    // One that was dropped may have been on its way.
                    if self.given_up.remove(&answer.number).is_some() {
                        answered.push(answer);
                    }
                }
                Err(TryRecvError::Empty) => return Ok(ThinkingAnswer { answered }),
                Err(TryRecvError::Disconnected) => {
                    return Err(LineFault(
                        "thinking has come to an end before its answer: this is a fault of rpl".into(),
                    ));
                }
            }
        }
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
