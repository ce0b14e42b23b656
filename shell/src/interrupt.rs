//! Ctrl-C and SIGTERM. What a signal does depends on what goes on:
//!
//! - Where there is nothing to clean up (reading, checking, compiling, building the models of a
//!   world, waiting for input) it ends the process at once.
//! - A run is told to stop, and its clean-ups run. The second signal ends the process at once; so
//!   does a run that gives no sign of life for too long, whatever it is busy with.
//! - While another program runs in the foreground, such as a pager, it is for that program.
//! - An experiment takes up no further run, and shows the table of those that are done; the second ends the process.
//! - At the prompt it gives the prompt back, and only the third without an answer ends the process.

use crate::status::Status;
use crate::terminal::console;
use rustix::termios::{OptionalActions, Termios};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::time::Duration;

/// A run that was told to stop and ends no instant for this time is not waited for.
const PATIENCE: Duration = Duration::from_millis(1_700);

/// Signals that have not been answered.
static ASKED: AtomicU32 = AtomicU32::new(0);

/// Runs under way.
static RUNS: AtomicU32 = AtomicU32::new(0);

/// Experiments under way.
static EXPERIMENTS: AtomicU32 = AtomicU32::new(0);

/// Prompts at which something is done.
static PROMPTS: AtomicU32 = AtomicU32::new(0);

/// Programs that are run and answer the signals themselves.
static OTHERS: AtomicU32 = AtomicU32::new(0);

/// Counts the signs of life.
static BEATS: AtomicU64 = AtomicU64::new(0);

/// How the terminal was set before lines were edited.
static TERMINAL: OnceLock<Termios> = OnceLock::new();

/// An end by a signal leaves the terminal as it is now. Called before lines are edited.
pub fn keep_terminal() {
    if let Ok(settings) = rustix::termios::tcgetattr(rustix::stdio::stdin()) {
        TERMINAL.set(settings).ok();
    }
}

/// Catches the signals from now on. Where that is impossible they keep their usual effect.
pub fn catch() {
    ctrlc::set_handler(answer).ok();
}

/// What is done at a signal, in a thread of its own.
fn answer() {
    if OTHERS.load(Ordering::SeqCst) > 0 {
        return;
    }
    let earlier = ASKED.fetch_add(1, Ordering::SeqCst);
    let is_run = RUNS.load(Ordering::SeqCst) > 0;
    let is_prompt = PROMPTS.load(Ordering::SeqCst) > 0;
    if EXPERIMENTS.load(Ordering::SeqCst) > 0 && earlier == 0 {
        console::note("stopping: what is done is put together; once more to exit at once");
        return;
    }
    match (is_run, is_prompt, earlier) {
        (true, _, 0) => {
            console::note("stopping: the clean-ups of the plan run; once more to exit at once");
            std::thread::spawn(watch);
        }
        (false, true, 0) => {}
        (false, true, 1) => console::note("still computing; once more ends rpl, and all that is in it"),
        _ => exit(),
    }
}

/// Ends the process when no run that was told to stop shows signs of life.
fn watch() {
    let mut seen = BEATS.load(Ordering::SeqCst);
    loop {
        std::thread::sleep(PATIENCE);
        if RUNS.load(Ordering::SeqCst) == 0 {
            return;
        }
        let now = BEATS.load(Ordering::SeqCst);
        if now == seen {
            exit();
        }
        seen = now;
    }
}

fn exit() -> ! {
    if let Some(settings) = TERMINAL.get() {
        // Where the terminal is gone nothing is left to be set.
        rustix::termios::tcsetattr(rustix::stdio::stdin(), OptionalActions::Now, settings).ok();
    }
    // Nothing is dropped from here on.
    rpl_link::process::end_all();
    std::process::exit(i32::from(Status::Interrupted.code()))
}

/// While it lives, a signal means this.
#[derive(Debug)]
pub struct SignalMeaning(&'static AtomicU32);

impl SignalMeaning {
    fn new(count: &'static AtomicU32) -> Self {
        count.fetch_add(1, Ordering::SeqCst);
        Self(count)
    }
}

impl Drop for SignalMeaning {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

/// While what is returned lives, there are runs that look at [`is_asked`] and stop, with a [`beat`]
/// at each instant.
#[must_use]
pub fn stops_runs() -> SignalMeaning {
    SignalMeaning::new(&RUNS)
}

/// While what is returned lives, there is an experiment that looks at [`is_asked`] and ends with what is done.
#[must_use]
pub fn ends_experiment() -> SignalMeaning {
    SignalMeaning::new(&EXPERIMENTS)
}

/// While what is returned lives, something is done at a prompt that is given back when [`is_asked`].
/// What was asked before is forgotten.
#[must_use]
pub fn gives_prompt_back() -> SignalMeaning {
    forget();
    SignalMeaning::new(&PROMPTS)
}

/// While what is returned lives, signals are for a program that this one has started.
#[must_use]
pub fn is_for_another() -> SignalMeaning {
    SignalMeaning::new(&OTHERS)
}

/// A run that was told to stop has come a step further.
pub fn beat() {
    BEATS.fetch_add(1, Ordering::SeqCst);
}

/// Asks what goes on to stop, as a signal does that is caught.
pub fn ask() {
    ASKED.fetch_add(1, Ordering::SeqCst);
}

/// What was asked has been done.
pub fn forget() {
    ASKED.store(0, Ordering::SeqCst);
}

/// Whether the process was told to stop.
pub fn is_asked() -> bool {
    ASKED.load(Ordering::SeqCst) > 0
}
