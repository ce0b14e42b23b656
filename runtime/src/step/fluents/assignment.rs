//! Fluents made, read, assigned, pulsed.

use crate::state::failure::Raise;
use crate::state::fluent::{Fluent, Origin};
use crate::state::line::Line;
use crate::state::machine::Machine;
use crate::state::memory;
use crate::state::scratch::Reads;
use crate::state::slab::{NONE, Slab};
use crate::state::task::{State, Waiting, Wake};
use crate::state::value::Value;
use crate::step::native::Surroundings;
use rpl_lang::kind::Kind;

/// The value of a fluent as code reads it, or its failure; noted as an input of the network under evaluation.
#[inline]
pub(crate) fn read<'f>(fluents: &'f Slab<Fluent>, reads: &mut Reads, fluent: u32) -> Result<&'f Value, Value> {
    if reads.are_noted {
        reads.fluents.push(fluent);
    }
    let fluent = &fluents[fluent];
    fluent.failure.map_or(Ok(fluent.reading()), Err)
}

impl Machine {
    /// Makes a fluent.
    pub fn create_fluent(&mut self, mut fluent: Fluent) -> Value {
        let captured = match &fluent.origin {
            Origin::Network { captured, .. } => captured.len(),
            Origin::Plan | Origin::System | Origin::Pulsed | Origin::Changed | Origin::Count => 0,
        };
        self.heap.allocated += memory::fluent(captured);
        self.scratch.work += self.heap.freeze(fluent.value);
        fluent.number = self.next_identity;
        self.next_identity += 1;
        Value::Fluent(self.fluents.insert(fluent))
    }

    /// Makes a network and evaluates it for the first time.
    pub(crate) fn create_network(&mut self, around: &mut Surroundings<'_>, code: u32, captured: Box<[Value]>) -> Value {
        let origin = Origin::Network { code, captured };
        let fluent = self.create_fluent(Fluent::new(None, Value::Nil, origin));
        if let Value::Fluent(index) = fluent {
            self.evaluate(around, index);
        }
        fluent
    }

    /// Makes a fluent derived from one input: `pulsed`, `changed`, `count-pulses`.
    pub(crate) fn derived_fluent(&mut self, input: u32, origin: Origin) -> Value {
        let value = if origin == Origin::Count { Value::Int(0) } else { Value::Nil };
        let fluent = self.create_fluent(Fluent::new(None, value, origin));
        if let Value::Fluent(index) = fluent {
            // It can be made in the midst of a propagation.
            self.scratch.are_events_read = true;
            self.set_inputs(index, &[input]);
        }
        fluent
    }

    /// Assigns one fluent from a plan.
    pub(crate) fn assign_fluent(
        &mut self,
        around: &mut Surroundings<'_>,
        fluent: Value,
        value: Value,
    ) -> Result<(), Raise> {
        let fluent = self.assignable(fluent)?;
        self.assign(around, fluent, value);
        Ok(())
    }

    /// The fluent that this value is, if a plan may assign it.
    pub(crate) fn assignable(&self, fluent: Value) -> Result<u32, Raise> {
        let Value::Fluent(fluent) = fluent else {
            return Err(self.wrong_type("what is assigned", Kind::Fluent.noun(), fluent));
        };
        match self.fluents[fluent].origin {
            Origin::Plan => Ok(fluent),
            Origin::System => {
                let name = self.fluent_name(fluent);
                Err(Raise::type_error(format!("`{name}` is set by the robot; a plan can only read it")))
            }
            Origin::Network { .. } | Origin::Pulsed | Origin::Changed | Origin::Count => {
                Err(Raise::type_error("a network cannot be assigned; assign one of the fluents it reads"))
            }
        }
    }

    /// Assigns one fluent.
    pub(crate) fn assign(&mut self, around: &mut Surroundings<'_>, fluent: u32, value: Value) {
        let entry = &mut self.fluents[fluent];
        if self.heap.equal(entry.value, value) {
            return;
        }
        self.scratch.work += self.heap.freeze(value);
        let entry = &mut self.fluents[fluent];
        entry.value = value;
        let is_alone = entry.dependents.is_empty();
        entry.is_changed = !is_alone;
        self.trace_fluent(around.program, fluent);
        if !is_alone {
            self.propagate(around, vec![fluent]);
        } else if value.is_true() || !self.fluents[fluent].watches.is_empty() {
            self.serve(&[fluent], false);
        }
    }

    /// Assigns several fluents as one: nobody sees a mixture of old and new.
    pub fn assign_all(&mut self, around: &mut Surroundings<'_>, values: &[(u32, Value)]) {
        let mut touched = Vec::new();
        for &(fluent, value) in values {
            if self.heap.equal(self.fluents[fluent].value, value) {
                continue;
            }
            self.scratch.work += self.heap.freeze(value);
            self.fluents[fluent].value = value;
            self.fluents[fluent].is_changed = true;
            touched.push(fluent);
            self.trace_fluent(around.program, fluent);
        }
        if !touched.is_empty() {
            self.propagate(around, touched);
        }
    }

    /// Pulses a fluent.
    pub(crate) fn pulse_fluent(&mut self, around: &mut Surroundings<'_>, fluent: u32) -> Result<(), Raise> {
        if self.fluents[fluent].is_computed() {
            return Err(Raise::type_error("a network cannot be pulsed; pulse one of the fluents it reads"));
        }
        self.fluents[fluent].is_pulsed = true;
        self.trace_pulse(fluent);
        if self.fluents[fluent].dependents.is_empty() {
            self.serve(&[fluent], true);
            self.fluents[fluent].is_pulsed = false;
            self.end_event(fluent);
        } else {
            self.propagate(around, vec![fluent]);
        }
        Ok(())
    }

    /// The value of a fluent as code reads it, noted as an input of the network under evaluation.
    pub fn read_fluent(&mut self, fluent: u32) -> Result<Value, Raise> {
        read(&self.fluents, &mut self.scratch.reads, fluent).copied().map_err(Raise::Again)
    }

    /// Wakes all waiters of a fluent, in the order of their waiting.
    pub(crate) fn wake_waiters(&mut self, fluent: u32, wake: Wake) {
        let mut task = std::mem::take(&mut self.fluents[fluent].waiters).first;
        let mut was_owned = false;
        // Those of one priority that stand behind one another go over into the run queue as they stand.
        let mut stretch: Option<(u32, Line)> = None;
        while task != NONE {
            if let Some(Waiting::Fluent { owned, timed, .. }) = self.tasks[task].waiting() {
                was_owned |= owned;
                if timed {
                    self.forget_timer();
                }
            }
            self.waits = self.waits.wrapping_add(1);
            let record = &mut self.tasks[task];
            record.wait_number = self.waits;
            record.set_wake(wake);
            let (next, is_plain) = (record.next, record.rare.is_none() && self.claims == 0);
            let priority = record.priority;
            if is_plain {
                record.enter(State::Ready);
            }
            self.trace_woken(task);
            match &mut stretch {
                Some((of, line)) if is_plain && *of == priority => line.last = task,
                _ => {
                    if let Some((of, line)) = stretch.take() {
                        self.enqueue_all(line, of);
                    }
                    match is_plain {
                        true => stretch = Some((priority, Line { first: task, last: task })),
                        false => self.make_ready(task),
                    }
                }
            }
            task = next;
        }
        if let Some((of, line)) = stretch {
            self.enqueue_all(line, of);
        }
        if was_owned {
            self.free_network(fluent);
        }
    }

    /// Ends a task's wait for a fluent.
    pub(crate) fn leave_fluent(&mut self, task: u32, fluent: u32, owned: bool) {
        let mut line = self.fluents[fluent].waiters;
        line.remove(&mut self.tasks, task);
        self.fluents[fluent].waiters = line;
        if owned {
            self.free_network(fluent);
        }
    }

    pub(crate) fn fluent_name(&self, fluent: u32) -> String {
        match self.fluents[fluent].name {
            Some(name) => self.symbols.name(name).to_string(),
            None => format!("fluent {fluent}"),
        }
    }
}
