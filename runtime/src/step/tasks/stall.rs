//! Stalls: with a robot the world may always change, so a run that waits in vain is no deadlock. It
//! is reported when nothing drives, no battery is charged, and no task but policies has gone on for a long time.

use crate::state::activation::Phase;
use crate::state::machine::Machine;
use crate::state::output::Channel;
use crate::state::slab::NONE;
use crate::state::stall::Stall;
use crate::state::task::{ScopeKind, State, Task, Waiting};
use crate::step::native::Surroundings;
use crate::step::time::timers::is_current;
use rpl_lang::code::{Program, Successes};

/// How long nothing may happen.
const PATIENCE_US: u64 = 120_000_000;

/// Tasks whose waits are told; the others are counted.
const MAX_TOLD: usize = 50;

impl Machine {
    /// Notes that a task runs. Cost: its depth in the task tree, once in each instant.
    pub(crate) fn note_progress(&mut self, task: u32) {
        if (self.stall.since_us < self.now_us || self.stall.is_reported) && !self.belongs_to_policy(task) {
            self.stall = Stall { since_us: self.now_us, ..Stall::default() };
        }
    }

    /// Reports once that nothing happens any more. Called after each step of the robot.
    pub(crate) fn look_for_stall(&mut self, around: &Surroundings<'_>) {
        if self.drives(around) {
            self.stall = Stall { since_us: self.now_us, ..Stall::default() };
        }
        let charge = around.outside.charge_permille();
        let before = *self.stall.charge_permille.get_or_insert(charge.unwrap_or_default());
        if self.stall.is_reported
            || self.now_us - self.stall.since_us < PATIENCE_US
            || self.awaits_time()
            || self.thinks()
        {
            return;
        }
        if charge.is_some_and(|charge| charge > before) {
            // The battery is being charged, and that has an end.
            self.stall = Stall { since_us: self.now_us, ..Stall::default() };
            return;
        }
        self.stall.is_reported = true;
        let text = format!(
            "stalled: for {} s nothing drives and no task but policies goes on: {}",
            PATIENCE_US / 1_000_000,
            self.what_tasks_wait_for(around.program)
        );
        self.put_out(Channel::Log, format!("warning: {text}"));
        self.trace_warning(&text);
    }

    /// What each task that can go no further by itself waits for, the first in the tree first.
    pub(crate) fn what_tasks_wait_for(&self, program: &Program) -> String {
        let is_stuck = |task: &Task| {
            task.state() != State::Created
                && ((task.state() == State::Blocked && task.first_child == NONE) || task.is_held())
        };
        let stuck: Vec<u32> = self.living_tasks().into_iter().filter(|&task| is_stuck(&self.tasks[task])).collect();
        let told = stuck.iter().take(MAX_TOLD).map(|&task| match self.tasks[task].is_held() {
            true => format!("{} is suspended", self.path(task)),
            false => format!("{} waits for {}", self.path(task), self.describe(program, self.tasks[task].waiting())),
        });
        let more = stuck.len().saturating_sub(MAX_TOLD);
        told.chain((more > 0).then(|| format!("and {more} more"))).collect::<Vec<_>>().join("; ")
    }

    fn drives(&self, around: &Surroundings<'_>) -> bool {
        let specs = &around.outside.tables().behaviours;
        self.activations
            .iter()
            .zip(specs)
            .any(|(activation, spec)| activation.phase == Phase::Active && spec.valve.is_some())
    }

    /// Whether a task that is no policy goes on at a known time: a wait ends, or a deadline comes.
    fn awaits_time(&self) -> bool {
        self.timers.iter().any(|timer| {
            is_current(&self.tasks, timer)
                && !self.tasks[timer.task.index].is_held()
                && !self.belongs_to_policy(timer.task.index)
        })
    }

    /// Whether a question is being thought about. Cost: a look at all tasks.
    fn thinks(&self) -> bool {
        self.tasks.iter().any(|(_, task)| task.waiting() == Some(Waiting::Answer))
    }

    /// Whether a task is a policy, or below one.
    fn belongs_to_policy(&self, task: u32) -> bool {
        let mut at = task;
        while let Some(record) = self.tasks.get(at) {
            let scope =
                self.tasks.get(record.parent).and_then(|parent| parent.scopes.get(record.parent_scope as usize));
            if let Some(ScopeKind::Children(children)) = scope.map(|scope| &scope.kind)
                && children.quorum.successes == Successes::Last
                && record.position + 1 < children.total
            {
                return true;
            }
            at = record.parent;
        }
        false
    }
}
