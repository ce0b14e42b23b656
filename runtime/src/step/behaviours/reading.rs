//! Readings become values of plans.

use crate::robot::reading::Reading;
use crate::robot::{Ending, Outbox};
use crate::state::machine::Machine;
use crate::state::value::Value;

impl Outbox {
    /// Bytes that its readings will take of a plan's memory.
    fn bytes(&self) -> usize {
        let endings = self.endings.iter().map(|(_, ending)| match ending {
            Ending::Success(reading) => reading.bytes(),
            Ending::Failure { slots, .. } => slots.iter().map(|(_, reading)| reading.bytes()).sum(),
        });
        self.fluents.iter().map(|(_, reading)| reading.bytes()).chain(endings).sum()
    }
}

impl Machine {
    /// A reading as plans have it. Its bytes count like those that plans make themselves.
    pub(in crate::step) fn value_of_reading(&mut self, reading: &Reading) -> Value {
        match reading {
            Reading::Truth(truth) => Value::truth(*truth),
            Reading::Int(value) => Value::Int(*value),
            Reading::Float(value) => Value::Float(*value),
            Reading::Symbol(name) => Value::Symbol(self.symbols.intern(name)),
            Reading::Text(text) => self.heap.string(text),
            Reading::List(list) => {
                let values: Vec<Value> = list.items().iter().map(|item| self.value_of_reading(item)).collect();
                self.heap.list(&values)
            }
        }
    }

    /// Collects garbage, if it is time to, before the robot's step brings more: a robot that says much
    /// while all tasks wait would otherwise fill the memory with what it has said before. No task runs.
    pub(crate) fn make_room_for(&mut self, outbox: &Outbox) {
        let bytes = outbox.bytes();
        if bytes > 0 && (self.heap.is_full() || !self.has_room(bytes)) {
            self.scratch.top = 0;
            self.collect();
        }
    }
}
