//! The tree of tasks, their priorities and suspensions, and who runs next.

use super::{Frame, Id, Life, Model, Task, What};
use crate::valves::program::Act;

pub(super) fn longer(priority: &[i64], number: i64) -> Vec<i64> {
    let mut longer = priority.to_vec();
    longer.push(number);
    longer
}

/// Missing numbers count 0.
pub(super) fn is_higher(one: &[i64], other: &[i64]) -> bool {
    let at = |list: &[i64], at: usize| list.get(at).copied().unwrap_or(0);
    let first = (0..one.len().max(other.len())).find(|&index| at(one, index) != at(other, index));
    first.is_some_and(|index| at(one, index) > at(other, index))
}

impl<'p> Model<'p> {
    pub(super) fn begin(&mut self, parent: Option<Id>, in_clean_up: bool, priority: Vec<i64>, acts: &'p [Act]) {
        let id = self.tasks.len();
        self.tasks.push(Task {
            parent,
            in_clean_up,
            runs_at: priority.clone(),
            priority,
            frames: vec![Frame::Acts(acts)],
            life: Life::Ready,
            begun: false,
            leaving: None,
            raises: None,
            wanted_dead: false,
            own_stops: 0,
            stops: 0,
            turn: 0,
        });
        if self.all_stops(id) > 0 {
            self.tell(id, What::Suspended);
        }
        self.queue(id);
    }

    /// How many tasks have begun.
    pub fn tasks(&self) -> usize {
        self.tasks.len()
    }

    /// Whether a task lives.
    pub fn lives(&self, task: Id) -> bool {
        self.tasks.get(task).is_some_and(|task| task.life != Life::Dead)
    }

    pub(super) fn above(&self, task: Id) -> Vec<Id> {
        std::iter::successors(Some(task), |&task| self.tasks[task].parent).collect()
    }

    pub(super) fn is_within(&self, task: Id, other: Id) -> bool {
        self.above(task).contains(&other)
    }

    pub(super) fn children(&self, task: Id) -> Vec<Id> {
        (0..self.tasks.len()).filter(|&child| self.tasks[child].parent == Some(task) && self.lives(child)).collect()
    }

    pub(super) fn subtree(&self, root: Id) -> Vec<Id> {
        let mut all = vec![root];
        for child in self.children(root) {
            all.extend(self.subtree(child));
        }
        all
    }

    pub(super) fn cleans_up(&self, task: Id) -> bool {
        self.tasks[task].frames.iter().any(|frame| matches!(frame, Frame::CleansUp(_)))
    }

    pub(super) fn is_protected(&self, task: Id) -> bool {
        self.tasks[task].leaving.is_some() || self.cleans_up(task)
    }

    /// Its own suspensions, and those of the tasks above whose clean-up it does not belong to.
    fn all_stops(&self, task: Id) -> usize {
        let record = &self.tasks[task];
        let above = if record.in_clean_up { None } else { record.parent };
        record.own_stops + record.stops + above.map_or(0, |above| self.all_stops(above))
    }

    pub(super) fn is_held(&self, task: Id) -> bool {
        self.all_stops(task) > 0 && !self.is_protected(task)
    }

    /// To the end of the line of the ready.
    pub(super) fn queue(&mut self, task: Id) {
        self.turns += 1;
        self.tasks[task].turn = self.turns;
        self.tasks[task].life = Life::Ready;
    }

    pub(super) fn next_ready(&self) -> Option<Id> {
        let ready = (0..self.tasks.len())
            .filter(|&task| self.tasks[task].life == Life::Ready && !self.is_held(task) && self.running != Some(task));
        ready.reduce(|best, task| {
            let (one, other) = (&self.tasks[task], &self.tasks[best]);
            let is_first = is_higher(&one.runs_at, &other.runs_at)
                || (!is_higher(&other.runs_at, &one.runs_at) && one.turn < other.turn);
            if is_first { task } else { best }
        })
    }

    pub(super) fn change_stops(&mut self, root: Id, change: impl FnOnce(&mut Task<'p>)) {
        let subtree = self.subtree(root);
        let before: Vec<(usize, bool)> =
            subtree.iter().map(|&task| (self.all_stops(task), self.is_held(task))).collect();
        change(&mut self.tasks[root]);
        for (&task, (stops, was_held)) in subtree.iter().zip(before) {
            let now = self.all_stops(task);
            if was_held && !self.is_held(task) && self.tasks[task].life == Life::Ready {
                self.queue(task);
            }
            match (stops, now) {
                (0, 1..) => self.tell(task, What::Suspended),
                (1.., 0) => self.tell(task, What::Resumed),
                _ => {}
            }
        }
        self.serve();
    }
}
