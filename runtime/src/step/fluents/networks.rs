//! Networks brought up to date in the order of dependency; then waiters are served.

use crate::state::failure::Raise;
use crate::state::fluent::Origin;
use crate::state::machine::Machine;
use crate::state::memory;
use crate::state::slab::NONE;
use crate::state::task::Wake;
use crate::state::value::Value;
use crate::step::fluents::agenda::{Agenda, Turn};
use crate::step::fluents::read;
use crate::step::native::Surroundings;
use rpl_lang::code::Program;

/// Whether two lists, mostly of one fluent, are the same.
#[inline]
fn is_same(one: &[u32], other: &[u32]) -> bool {
    match (one, other) {
        ([one], [other]) => one == other,
        _ => one == other,
    }
}

/// After this many evaluations for one change, or this many for each fluent if there are more of these, networks count
/// as computed from themselves.
const MAX_EVALUATIONS: usize = 1_000_000;

/// Evaluations of a network for one change, where there are many networks.
const MAX_EVALUATIONS_OF_ONE: usize = 16;

impl Machine {
    pub(crate) fn propagate(&mut self, around: &mut Surroundings<'_>, roots: Vec<u32>) {
        self.scratch.event_readers.clear();
        self.scratch.are_events_read = false;
        self.scratch.rereading.clear();
        let is_pulse = roots.iter().any(|&root| self.fluents[root].is_pulsed);
        let mut touched = roots;
        let mut dirty = self.dependents_of(&touched);
        let mut evaluations_left = self.most_evaluations();
        while let Some((_, _, network)) = dirty.pop_first() {
            if evaluations_left == 0 {
                let circle = std::iter::once(network).chain(dirty.networks()).collect();
                touched.extend(self.fail_circle(around, circle));
                break;
            }
            evaluations_left -= 1;
            let changed = match self.evaluate_again(around.program, network) {
                Some(changed) => changed,
                None => {
                    let fluent = &self.fluents[network];
                    let before = (fluent.value, fluent.failure);
                    self.evaluate(around, network);
                    let fluent = &self.fluents[network];
                    let waits = |&input: &u32| self.fluents[input].is_computed() && dirty.contains(self.turn(input));
                    if fluent.inputs.iter().any(waits) {
                        dirty.insert(self.turn(network));
                        continue;
                    }
                    before.1 != fluent.failure || !self.heap.equal(before.0, fluent.value)
                }
            };
            self.fluents[network].is_changed = changed;
            if changed {
                self.trace_fluent(around.program, network);
            }
            // What a pulse reaches is served even if its value is the same: true again is true.
            if changed || is_pulse {
                touched.push(network);
                self.mark_dependents(network, &mut dirty);
            }
        }
        let rereading = std::mem::take(&mut self.scratch.rereading);
        self.serve(&touched, is_pulse);
        self.trace_rereading(around.program, &rereading);
        self.settle(around, touched);
    }

    fn most_evaluations(&self) -> usize {
        MAX_EVALUATIONS.max(MAX_EVALUATIONS_OF_ONE * self.fluents.slots())
    }

    /// Networks that come to no end fail, with all that is computed from them; gives them back.
    fn fail_circle(&mut self, around: &Surroundings<'_>, circle: Vec<u32>) -> Vec<u32> {
        let message = "this network is computed from itself, and its value never settles";
        let failure = self.failure_from(Raise::new("network-error", message));
        self.scratch.are_events_read = true;
        for &network in &circle {
            let fluent = &mut self.fluents[network];
            (fluent.value, fluent.failure, fluent.is_changed) = (Value::Nil, Some(failure), true);
            self.trace_fluent(around.program, network);
        }
        circle
    }

    fn turn(&self, network: u32) -> Turn {
        let fluent = &self.fluents[network];
        (fluent.height, fluent.number, network)
    }

    /// The networks that read one of some fluents.
    fn dependents_of(&mut self, fluents: &[u32]) -> Agenda {
        let mut turns = Vec::with_capacity(fluents.iter().map(|&fluent| self.fluents[fluent].dependents.len()).sum());
        for &fluent in fluents {
            self.fluents[fluent].dependents.for_each(|dependent| turns.push(self.turn(dependent)));
        }
        self.scratch.work += turns.len() as u64;
        Agenda::new(turns)
    }

    fn mark_dependents(&mut self, fluent: u32, dirty: &mut Agenda) {
        self.scratch.work += self.fluents[fluent].dependents.len() as u64;
        self.fluents[fluent].dependents.for_each(|dependent| {
            dirty.insert(self.turn(dependent));
        });
    }

    /// Releases waiters and counts events of fluents that have changed together. Whoever is released
    /// is woken in the order in which they began to wait.
    pub(crate) fn serve(&mut self, fluents: &[u32], is_pulse: bool) {
        // Those in one line stand in that order, and need not be gathered.
        if let &[fluent] = fluents
            && self.fluents[fluent].watches.is_empty()
        {
            if let Some(wake) = self.releases(fluent) {
                self.wake_waiters(fluent, wake);
            }
            return;
        }
        let mut released = Vec::new();
        for &fluent in fluents {
            self.release(fluent, is_pulse, &mut released);
        }
        let now = self.waits;
        released.sort_by_key(|&(number, ..)| std::cmp::Reverse(now.wrapping_sub(number)));
        for (_, task, wake) in released {
            self.wake(task, wake);
        }
    }

    /// What the waiters of a fluent find that is true now, or that has failed.
    fn releases(&self, fluent: u32) -> Option<Wake> {
        let fluent = &self.fluents[fluent];
        match fluent.failure {
            Some(failure) => Some(Wake::Raise(failure)),
            None => fluent.reading().is_true().then(|| Wake::Value(*fluent.reading())),
        }
    }

    /// Notes who is released by one fluent, with the number of its wait, and counts events.
    fn release(&mut self, fluent: u32, is_pulse: bool, released: &mut Vec<(u32, u32, Wake)>) {
        let failure = self.fluents[fluent].failure;
        let is_true = self.fluents[fluent].reading().is_true() || failure.is_some();
        self.fluents[fluent].watches.for_each(|(_, watch)| {
            let Some(entry) = self.watches.get_mut(watch) else { return };
            if is_true && (!entry.was_true || is_pulse) {
                entry.events = entry.events.saturating_add(1);
                if std::mem::take(&mut entry.waits) {
                    let wake = failure.map_or(Wake::Value(Value::Nil), Wake::Raise);
                    released.push((self.tasks[entry.task].wait_number, entry.task, wake));
                }
            }
            entry.was_true = is_true;
        });
        if let Some(wake) = self.releases(fluent) {
            let waiters = self.fluents[fluent].waiters.tasks(&self.tasks);
            released.extend(waiters.into_iter().map(|task| (self.tasks[task].wait_number, task, wake)));
        }
    }

    /// Events of a fluent's watches count from its value now.
    pub(crate) fn end_event(&mut self, fluent: u32) {
        let Some(entry) = self.fluents.get(fluent) else { return };
        let is_true = entry.reading().is_true();
        entry.watches.for_each(|(_, watch)| {
            if let Some(entry) = self.watches.get_mut(watch) {
                entry.was_true = is_true;
            }
        });
    }

    /// Ends pulses and changes: what read them is evaluated again, silently.
    fn settle(&mut self, around: &mut Surroundings<'_>, touched: Vec<u32>) {
        let mut again = Vec::new();
        for &fluent in &touched {
            let Some(entry) = self.fluents.get_mut(fluent) else { continue };
            let (pulsed, changed) = (entry.is_pulsed, entry.is_changed);
            entry.is_pulsed = false;
            entry.is_changed = false;
            // Who only reads values is as far as the propagation has brought it.
            if !(pulsed || changed && self.scratch.are_events_read) {
                continue;
            }
            self.fluents[fluent].dependents.for_each(|dependent| {
                let readers = &self.scratch.event_readers;
                let reads_events = || {
                    matches!(self.fluents[dependent].origin, Origin::Changed | Origin::Pulsed)
                        || !readers.is_empty() && readers.contains(&dependent)
                };
                if pulsed || reads_events() {
                    again.push(self.turn(dependent));
                }
            });
        }
        let mut again = Agenda::new(again);
        let mut evaluations_left = self.most_evaluations();
        while let Some((_, _, network)) = again.pop_first() {
            if evaluations_left == 0 {
                let circle = std::iter::once(network).chain(again.networks()).collect();
                self.fail_circle(around, circle);
                break;
            }
            evaluations_left -= 1;
            let before = self.fluents[network].value;
            self.evaluate(around, network);
            self.fluents[network].is_changed = false;
            self.end_event(network);
            if !self.heap.equal(before, self.fluents[network].value) {
                self.mark_dependents(network, &mut again);
            }
        }
        // The end of a pulse of a fluent that is watched itself is no event either.
        for fluent in touched {
            self.end_event(fluent);
        }
    }

    /// Brings one network up to date.
    pub(crate) fn evaluate(&mut self, around: &mut Surroundings<'_>, network: u32) {
        self.scratch.work += 1;
        let fluent = &mut self.fluents[network];
        if let Origin::Network { code, captured } = &mut fluent.origin {
            // Nobody else looks at the values meanwhile.
            let (code, lent) = (*code, std::mem::take(captured));
            let result = self.evaluate_network(around, network, code, &lent);
            let fluent = &mut self.fluents[network];
            (fluent.value, fluent.failure) = match result {
                Ok(value) => (value, None),
                Err(failure) => (Value::Nil, Some(failure)),
            };
            if let Origin::Network { captured, .. } = &mut fluent.origin {
                *captured = lent;
            }
            return;
        }
        self.scratch.are_events_read = true;
        let (value, input) = (fluent.value, fluent.inputs.first().copied());
        let input = input.and_then(|input| self.fluents.get(input));
        let is_pulsed = input.is_some_and(|input| input.is_pulsed);
        self.fluents[network].value = match (&self.fluents[network].origin, value) {
            (Origin::Plan | Origin::System | Origin::Network { .. }, value) => value,
            (Origin::Pulsed, _) => Value::truth(is_pulsed),
            (Origin::Changed, _) => Value::truth(input.is_some_and(|input| input.is_changed)),
            (Origin::Count, Value::Int(count)) => Value::Int(count + i64::from(is_pulsed)),
            (Origin::Count, value) => value,
        };
    }

    /// Brings one network up to date that is plain and reads, in the order in which they are kept, the fluents that it has
    /// read the last time, none of them computed; tells whether it has changed. None, and nothing done, of another one.
    #[inline]
    fn evaluate_again(&mut self, program: &Program, network: u32) -> Option<bool> {
        let fluent = &self.fluents[network];
        let Origin::Network { code, captured } = &fluent.origin else { return None };
        let mut inputs = fluent.inputs.iter();
        let value = self.evaluate_plainly(program, *code, captured, |input| {
            let fluent = &self.fluents[input];
            let is_expected = inputs.next() == Some(&input) && !fluent.is_computed();
            is_expected.then(|| fluent.reading())
        })?;
        if inputs.next().is_some() {
            return None;
        }
        self.scratch.work += 1;
        let fluent = &mut self.fluents[network];
        let has_changed = fluent.failure.is_some() || !self.heap.equal(fluent.value, value);
        (fluent.value, fluent.failure) = (value, None);
        Some(has_changed)
    }

    /// The value of a network that is code, or its failure; notes what it read.
    #[inline]
    fn evaluate_network(
        &mut self,
        around: &mut Surroundings<'_>,
        network: u32,
        code: u32,
        captured: &[Value],
    ) -> Result<Value, Value> {
        let mut reads = std::mem::take(&mut self.scratch.reads);
        let first = reads.fluents.len();
        let outer = std::mem::replace(&mut reads.are_noted, true);
        let note = |input| read(&self.fluents, &mut reads, input).ok();
        let plain = self.evaluate_plainly(around.program, code, captured, note);
        self.scratch.reads = reads;
        let outer_event = std::mem::replace(&mut self.scratch.reads_event, false);
        let result = match plain {
            Some(value) => Ok(value),
            None => {
                self.scratch.reads.fluents.truncate(first);
                self.evaluate_code(around, code, captured)
            }
        };
        self.scratch.reads.are_noted = outer;
        if std::mem::replace(&mut self.scratch.reads_event, outer_event) {
            self.scratch.event_readers.insert(network);
            self.scratch.are_events_read = true;
        }
        let reads = &self.scratch.reads.fluents[first..];
        if is_same(&self.fluents[network].inputs, reads) {
            self.fluents[network].height = self.height_above(reads);
            self.scratch.reads.fluents.truncate(first);
        } else {
            let mut reads = self.scratch.reads.fluents.split_off(first);
            reads.sort_unstable();
            reads.dedup();
            if self.trace.enabled && self.fluents[network].inputs != reads {
                self.scratch.rereading.push(network);
            }
            self.set_inputs(network, &reads);
        }
        result
    }

    /// How high a network stands that reads these fluents.
    #[inline]
    fn height_above(&self, inputs: &[u32]) -> u32 {
        inputs.iter().map(|&input| self.fluents[input].height + 1).max().unwrap_or(0)
    }

    pub(crate) fn set_inputs(&mut self, network: u32, inputs: &[u32]) {
        let height = self.height_above(inputs);
        if self.fluents[network].inputs != inputs {
            for input in std::mem::take(&mut self.fluents[network].inputs) {
                if let Some(fluent) = self.fluents.get_mut(input) {
                    fluent.dependents.remove(&network);
                }
            }
            self.heap.allocated += 2 * memory::EDGE * inputs.len();
            for &input in inputs {
                self.fluents[input].dependents.insert(network);
            }
            self.fluents[network].inputs = inputs.to_vec();
        }
        self.fluents[network].height = height;
    }

    /// Frees a network made for one wait.
    pub(crate) fn free_network(&mut self, network: u32) {
        let is_network = self.fluents.get(network).is_some_and(|fluent| {
            fluent.is_computed()
                && fluent.waiters.first == NONE
                && fluent.watches.is_empty()
                && fluent.dependents.is_empty()
        });
        if is_network {
            self.set_inputs(network, &[]);
            self.fluents.remove(network);
        }
    }
}
