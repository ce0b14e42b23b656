//! How tasks leave and die, and what their constructs make of it.

use super::{Exit, Fact, Frame, Id, Life, Model, On, What};
use crate::valves::program::Rule;

impl Model<'_> {
    pub(super) fn as_one(&mut self, act: impl FnOnce(&mut Self)) {
        self.decisions += 1;
        act(self);
        self.decisions -= 1;
        self.serve();
    }

    pub(super) fn evaporate(&mut self, task: Id) {
        let record = &self.tasks[task];
        if record.life == Life::Dead {
            return;
        }
        let is_decided = matches!(record.frames.last(), Some(Frame::Children { decided: Some(_), .. }));
        if !record.begun {
            self.die(task, What::Evaporated);
        } else if self.is_protected(task) || (is_decided && record.life == Life::Blocked(On::Children)) {
            self.tasks[task].wanted_dead = true;
        } else if record.raises == Some(true) {
            self.tasks[task].wanted_dead = true;
            self.leave(task, Exit::Fail);
        } else {
            self.leave(task, Exit::Evaporate);
        }
    }

    /// A task that does not run starts to leave.
    fn leave(&mut self, task: Id, exit: Exit) {
        if let Life::Blocked(On::Valve(valve)) = self.tasks[task].life {
            self.valves[valve].asked.retain(|&other| other != task);
        }
        self.timers.retain(|&(_, other)| other != task);
        self.tasks[task].raises = None;
        self.tasks[task].leaving = Some(exit);
        self.tasks[task].life = Life::Blocked(On::Children);
        self.as_one(|model| {
            if model.unwind(task) {
                model.queue(task);
            }
        });
    }

    /// Leaves frames until a clean-up is to run: tells whether there is one. It waits at children.
    pub(super) fn unwind(&mut self, task: Id) -> bool {
        loop {
            let Some(exit) = self.tasks[task].leaving else { return false };
            match self.tasks[task].frames.last().cloned() {
                None => {
                    self.die(task, if exit == Exit::Fail { What::Failed } else { What::Evaporated });
                    return false;
                }
                Some(Frame::Acts(_)) => {
                    self.tasks[task].frames.pop();
                }
                Some(Frame::Holds(valve)) => {
                    self.tasks[task].frames.pop();
                    self.release(task, valve);
                }
                Some(Frame::Children { .. }) => {
                    if let Some(Frame::Children { decided, .. }) = self.tasks[task].frames.last_mut() {
                        *decided = Some(true);
                    }
                    // It looks for itself when they are dead.
                    self.tasks[task].life = Life::Ready;
                    self.evaporate_children(task);
                    if let Some(Frame::Children { alive: 1.., .. }) = self.tasks[task].frames.last() {
                        self.tasks[task].life = Life::Blocked(On::Children);
                        return false;
                    }
                    self.tasks[task].frames.pop();
                }
                Some(Frame::Protect(_)) => return true,
                Some(Frame::CleansUp(then)) => {
                    self.tasks[task].frames.pop();
                    self.tasks[task].leaving = Some(then.unwrap_or(exit));
                }
            }
        }
    }

    /// The children of the innermost construct.
    fn evaporate_children(&mut self, task: Id) {
        let in_clean_up = self.cleans_up(task);
        self.decisions += 1;
        for child in self.children(task) {
            if self.tasks[child].in_clean_up == in_clean_up {
                self.evaporate(child);
            }
        }
        self.decisions -= 1;
    }

    pub(super) fn die(&mut self, task: Id, how: What) {
        self.tasks[task].life = Life::Dead;
        self.tasks[task].leaving = None;
        self.tell(task, how);
        for valve in &mut self.valves {
            valve.asked.retain(|&other| other != task);
            for place in &mut valve.places {
                place.facts.retain(|fact| {
                    let (Fact::Has(other, _) | Fact::TakenAway(other, _)) = *fact;
                    other != task
                });
            }
        }
        match self.tasks[task].parent {
            Some(parent) => self.as_one(|model| model.child_ended(parent, how)),
            None => self.serve(),
        }
    }

    fn child_ended(&mut self, parent: Id, how: What) {
        let Some(Frame::Children { rule, alive, decided }) = self.tasks[parent].frames.last_mut() else { return };
        *alive -= 1;
        let verdict = match (*rule, how) {
            (Rule::Par | Rule::One, What::Failed) => Some(false),
            (Rule::One, _) => Some(true),
            (Rule::Par, _) => None,
        };
        let decides = decided.is_none() && verdict.is_some();
        if decides {
            *decided = verdict;
            self.evaporate_children(parent);
        }
        self.end_construct(parent);
    }

    fn end_construct(&mut self, parent: Id) {
        let Some(Frame::Children { alive: 0, decided, .. }) = self.tasks[parent].frames.last() else { return };
        let decided = *decided;
        if self.tasks[parent].life != Life::Blocked(On::Children) {
            return;
        }
        if self.tasks[parent].leaving.is_some() {
            if self.unwind(parent) {
                self.queue(parent);
            }
            return;
        }
        self.tasks[parent].frames.pop();
        let is_wanted = self.tasks[parent].wanted_dead && !self.cleans_up(parent);
        match (decided, is_wanted) {
            (Some(false), true) => self.leave(parent, Exit::Fail),
            (_, true) => self.leave(parent, Exit::Evaporate),
            (Some(false), false) => {
                self.tasks[parent].raises = Some(true);
                self.queue(parent);
            }
            (_, false) => self.queue(parent),
        }
    }
}
