//! A projection at the prompt: made at once, or, while the clock runs, on a thread of its own, so that the run
//! goes on meanwhile.

use rpl_runtime::run::projection::ProjectableRun;
use rpl_runtime::state::figures::Figures;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

/// Runs that are projected, and how far.
const RUNS: u32 = 60;
const HORIZON_US: u64 = 3_600_000_000;

/// What came of a projection; none if it was given up.
pub type Projected = Option<Result<Figures, String>>;

/// How a run would go on; none if it was given up.
pub fn projected(run: ProjectableRun, seed: u64, is_given_up: &dyn Fn() -> bool) -> Projected {
    run.figures(RUNS, HORIZON_US, seed, is_given_up)
}

/// A projection under way.
pub struct Projecting {
    thread: Option<JoinHandle<Projected>>,
    is_given_up: Arc<AtomicBool>,
}

impl Projecting {
    /// On a thread of its own.
    pub fn begin(run: ProjectableRun, seed: u64) -> Self {
        let is_given_up = Arc::new(AtomicBool::new(false));
        let given_up = is_given_up.clone();
        let thread = thread::spawn(move || projected(run, seed, &|| given_up.load(Ordering::Relaxed)));
        Self { thread: Some(thread), is_given_up }
    }

    pub fn has_ended(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// What came of it, when it has ended.
    pub fn end(mut self) -> Projected {
        // A panic has been told by the thread.
        self.thread.take().and_then(|thread| thread.join().ok().flatten())
    }
}

impl Drop for Projecting {
    /// No thread is left behind.
    fn drop(&mut self) {
        self.is_given_up.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.join().ok();
        }
    }
}
