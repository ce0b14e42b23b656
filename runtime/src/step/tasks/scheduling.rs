//! States of tasks, and the run queue.

use crate::state::line::Line;
use crate::state::machine::Machine;
use crate::state::slab::NONE;
use crate::state::task::State;
use crate::state::value::Value;

impl Machine {
    /// The priority a task runs at: its own, or that of a requester whose way it blocks.
    pub(crate) fn effective_priority(&self, task: u32) -> u32 {
        let record = &self.tasks[task];
        match record.rare.as_ref().and_then(|rare| rare.boost) {
            Some(boost) => self.priorities.higher(record.priority, boost),
            None => record.priority,
        }
    }

    /// Whether the task stands in the run queue: ready, and not held by a suspension.
    pub(crate) fn is_queued(&self, task: u32) -> bool {
        let record = &self.tasks[task];
        record.state() == State::Ready && !record.is_held()
    }

    #[inline]
    pub(crate) fn set_state(&mut self, task: u32, state: State) {
        let record = &mut self.tasks[task];
        if record.state() == state {
            return;
        }
        record.enter(state);
        if record.rare.is_some() {
            self.note_status(task);
        }
    }

    /// Makes a task ready; unless it is suspended it enters the run queue.
    #[inline]
    pub(crate) fn make_ready(&mut self, task: u32) {
        let record = &mut self.tasks[task];
        if record.rare.is_none() && self.claims == 0 {
            record.enter(State::Ready);
            let priority = record.priority;
            return self.enqueue(task, priority, false);
        }
        self.set_state(task, State::Ready);
        self.queue(task, false);
    }

    #[inline]
    pub(crate) fn queue(&mut self, task: u32, front: bool) {
        if self.claims > 0 {
            self.renew_boost(task);
        }
        let record = &self.tasks[task];
        let priority = if record.rare.is_none() && record.state() == State::Ready {
            record.priority
        } else if self.is_queued(task) {
            self.effective_priority(task)
        } else {
            return;
        };
        self.enqueue(task, priority, front);
    }

    /// Puts a task into the run queue, and has the running one look whether it must give way.
    #[inline]
    fn enqueue(&mut self, task: u32, priority: u32, front: bool) {
        self.priorities.enqueue(&mut self.tasks, task, priority, front);
        self.note_queued(priority);
    }

    /// Puts tasks that are ready and stand behind one another into the run queue, none of which has anything of what few
    /// have.
    #[inline]
    pub(crate) fn enqueue_all(&mut self, stretch: Line, priority: u32) {
        self.priorities.append(&mut self.tasks, stretch, priority);
        self.note_queued(priority);
    }

    /// Has the running task look whether it must give way to one of this priority.
    #[inline]
    fn note_queued(&mut self, priority: u32) {
        if self.current == NONE || self.scratch.switch {
            return;
        }
        let current = &self.tasks[self.current];
        if (current.priority != priority || current.rare.is_some())
            && self.priorities.is_higher(priority, self.effective_priority(self.current))
        {
            self.scratch.switch = true;
        }
    }

    /// Puts the running task back: at the front of its line, or aside if it is suspended.
    pub(crate) fn requeue_running(&mut self, task: u32) {
        self.set_state(task, State::Ready);
        self.queue(task, true);
        self.note_preempted(task);
    }

    /// Puts the running task back as if nothing had happened: no fluent tells of it.
    pub(crate) fn set_aside(&mut self, task: u32) {
        self.tasks[task].enter(State::Ready);
        self.queue(task, true);
        self.note_preempted(task);
    }

    /// Takes a task out of the run queue, if it stands there.
    pub(crate) fn unqueue(&mut self, task: u32) {
        if self.is_queued(task) {
            let priority = self.effective_priority(task);
            self.priorities.withdraw(&mut self.tasks, task, priority);
            self.note_left(task);
        }
    }

    /// Lets the running task go to the end of the line of its priority, and go on with a value: its wait is over already.
    pub(crate) fn give_way(&mut self, value: Value) {
        self.tasks[self.current].end_wait();
        self.scratch.gives_way = Some(value);
    }
}
