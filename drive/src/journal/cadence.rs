//! When a checkpoint is due: when so much was computed since the last one that doing it again would be felt. What
//! checkpoints cost follows from that, about a hundredth of the work in an office; it is bounded where a state is dear
//! to write, as that of a robot that is lost in a large building.
//!
//! Work and costs are what was computed, by processor time: waiting for the disk, or for the clock, does not count.

use rustix::time::ClockId;
use std::time::{Duration, Instant};

/// The work that is done without a checkpoint. A run stands where it was within a second: reading the journal and
/// building the models of an office takes a third of that.
const WORK: Duration = Duration::from_millis(700);

/// What a checkpoint costs is at no time more than one part in this many of the work since the last one.
const WORK_FOR_COST: u32 = 20;

/// How often it is asked what was computed, by the clock: asking at each instant would cost more than the checkpoints.
const LOOK: Duration = Duration::from_millis(20);

/// When the last checkpoint was made, and what it cost.
#[derive(Debug)]
pub struct Cadence {
    cost: Duration,
    /// What the process had computed then.
    since: Duration,
    looked: Instant,
}

impl Cadence {
    /// That of a run that begins or goes on now.
    pub fn new() -> Self {
        Self { cost: Duration::ZERO, since: by_process(), looked: Instant::now() }
    }

    /// Whether it is time for a checkpoint.
    pub fn is_due(&mut self) -> bool {
        if self.looked.elapsed() < LOOK {
            return false;
        }
        self.looked = Instant::now();
        by_process().saturating_sub(self.since) >= WORK.max(self.cost * WORK_FOR_COST)
    }

    /// A checkpoint is begun, and what was computed for it so far.
    pub fn begin(&mut self, cost: Duration) {
        self.since = by_process();
        self.cost = cost;
    }

    /// The same checkpoint has cost more.
    pub fn add(&mut self, cost: Duration) {
        self.cost += cost;
    }
}

/// What the process has computed so far.
fn by_process() -> Duration {
    computed(ClockId::ProcessCPUTime)
}

/// What this thread has computed so far.
pub fn by_thread() -> Duration {
    computed(ClockId::ThreadCPUTime)
}

fn computed(by: ClockId) -> Duration {
    let time = rustix::time::clock_gettime(by);
    Duration::new(time.tv_sec.unsigned_abs(), time.tv_nsec.unsigned_abs() as u32)
}
