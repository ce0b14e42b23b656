//! Fluents about tasks follow their state.

use crate::state::machine::Machine;
use crate::state::task::State;
use crate::state::value::Value;
use crate::step::native::Surroundings;

impl Machine {
    /// Notes that the state of a task has changed, for its status fluent.
    pub(crate) fn note_status(&mut self, task: u32) {
        if self.tasks[task].rare.as_ref().is_some_and(|rare| rare.fluents.status.is_some()) {
            let task = self.tasks.reference(task);
            self.scratch.status_changed.push(task);
        }
    }

    /// Brings the status fluents of the tasks whose state has changed up to date.
    #[inline]
    pub(crate) fn flush_status(&mut self, around: &mut Surroundings<'_>) {
        if !self.scratch.status_changed.is_empty() {
            self.flush_changed_status(around);
        }
    }

    #[cold]
    fn flush_changed_status(&mut self, around: &mut Surroundings<'_>) {
        while !self.scratch.status_changed.is_empty() {
            for task in std::mem::take(&mut self.scratch.status_changed) {
                if let Some(task) = self.tasks.find_alive(task) {
                    self.update_task_fluents(around, task);
                }
            }
        }
    }

    /// The fluents about a task follow its state.
    pub(crate) fn update_task_fluents(&mut self, around: &mut Surroundings<'_>, task: u32) {
        let Some(rare) = &self.tasks[task].rare else { return };
        let fluents = rare.fluents.clone();
        let record = &self.tasks[task];
        let (state, result) = (record.state(), *record.value());
        let suspended = record.is_held() && !state.is_dead() && state != State::Created;
        let begun = Value::truth(state != State::Created);
        let name = if suspended { "suspended" } else { state.name() };
        let status = Value::Symbol(self.symbols.intern(name));
        let ended = Value::truth(state.is_dead());
        let pairs = [
            (fluents.status, status),
            (fluents.result, if state.is_dead() { result } else { Value::Nil }),
            (fluents.begin, begun),
            (fluents.end, ended),
        ];
        let values: Vec<(u32, Value)> =
            pairs.into_iter().filter_map(|(fluent, value)| Some((fluent?, value))).collect();
        if !values.is_empty() {
            self.assign_all(around, &values);
        }
    }
}
