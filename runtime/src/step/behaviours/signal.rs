//! Signals: how a task learns that its behaviour has ended.

use crate::robot::reading::Reading;
use crate::state::failure::Raise;
use crate::state::machine::Machine;
use crate::state::task::{Waiting, Wake};
use crate::state::value::Value;
use crate::step::native::Surroundings;

impl Machine {
    /// The failure of a behaviour, at the place of the task that activated it.
    pub(super) fn behaviour_failure(
        &mut self,
        behaviour: u16,
        class: &str,
        message: String,
        slots: Vec<(String, Reading)>,
    ) -> Value {
        let class = self.symbols.intern(class);
        let mut values = vec![(self.symbols.intern("behaviour"), Value::Behaviour(behaviour))];
        for (name, reading) in slots {
            values.push((self.symbols.intern(&name), self.value_of_reading(&reading)));
        }
        let owner = self.activation(behaviour).task.and_then(|task| self.tasks.find(task));
        self.new_failure(owner.unwrap_or(self.current), class, message, values)
    }

    /// Keeps a signal until somebody takes it, and wakes who waits for it.
    pub(super) fn signal(&mut self, around: &mut Surroundings<'_>, behaviour: u16, signal: Result<Value, Value>) {
        self.trace_signal(around, behaviour, &signal);
        let waiting = self
            .living_tasks()
            .into_iter()
            .find(|&task| self.tasks[task].waiting() == Some(Waiting::Signal(behaviour)));
        match waiting {
            Some(task) => {
                let wake = match signal {
                    Ok(value) => Wake::Value(value),
                    Err(failure) => Wake::Raise(failure),
                };
                self.wake(task, wake);
            }
            None => self.activation(behaviour).signal = Some(signal),
        }
    }

    /// `(await-signal B)`: takes the signal, or waits for it.
    pub(crate) fn await_signal(&mut self, behaviour: u16) -> Result<Option<Value>, Raise> {
        match self.take_signal(behaviour) {
            Some(Ok(value)) => Ok(Some(value)),
            Some(Err(failure)) => Err(Raise::Again(failure)),
            None => {
                let task = self.current;
                self.tasks[task].wait(Waiting::Signal(behaviour));
                Ok(None)
            }
        }
    }

    /// The signal that an earlier activation left to a task above or below the current one, or the
    /// signal of the activation of now.
    fn take_signal(&mut self, behaviour: u16) -> Option<Result<Value, Value>> {
        let (current, tasks) = (self.current, &self.tasks);
        let kept = self.activations.get(usize::from(behaviour)).map_or(&[][..], |entry| &entry.kept);
        let own = kept.iter().position(|(owner, _)| {
            let owner = tasks.find(*owner);
            owner.is_some_and(|owner| self.is_within(owner, current) || self.is_within(current, owner))
        });
        let entry = self.activation(behaviour);
        match own {
            Some(at) => Some(entry.kept.remove(at).1),
            None => entry.signal.take(),
        }
    }
}
