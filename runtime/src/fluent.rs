//! Fluents, networks of fluents, and their glitch-free propagation.
//!
//! One propagation: the changed fluents are marked, every network that depends on them is
//! evaluated once in the order of dependency heights, then waiters and watches of what is true
//! now are served. A pulse makes its fluent true for one propagation; when it is over, what read
//! it is brought up to date once more, and that is no event.

use crate::failure::Raise;
use crate::machine::{Machine, Surroundings};
use crate::memory;
use crate::scheduler::Line;
use crate::small_set::SmallSet;
use crate::task::{NONE, Waiting, Wake};
use crate::value::Value;
use rpl_lang::code::Missed;
use rpl_lang::symbol::Symbol;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// When a network is brought up to date: its height, its number; and its slot.
type Turn = (u32, u64, u32);

/// Where a fluent's value comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Origin {
    /// A plan assigns it.
    Plan,
    /// The robot or the system assigns it; a plan cannot.
    System,
    /// Code computes it from other fluents.
    Network {
        /// The code.
        code: u32,
        /// The values it captured.
        captured: Box<[Value]>,
    },
    /// True in the propagation of a pulse of its input.
    Pulsed,
    /// True in the propagation of a change of its input.
    Changed,
    /// Counts the pulses of its input.
    Count,
}

/// A value that changes over time and can wake tasks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fluent {
    /// Grows from fluent to fluent: networks of one height are brought up to date and served in
    /// this order, whatever their slots.
    pub number: u64,
    /// The name of its global, for traces and errors.
    pub name: Option<Symbol>,
    /// Its value.
    pub value: Value,
    /// Where the value comes from.
    pub origin: Origin,
    /// The failure of a network that could not be evaluated.
    pub failure: Option<Value>,
    /// Networks that read it.
    pub dependents: SmallSet<u32>,
    /// Fluents a network read when it was last evaluated.
    pub inputs: Vec<u32>,
    /// Longest chain of inputs below it.
    pub height: u32,
    /// Tasks that wait for it, in the order in which they began to.
    pub waiters: Line,
    /// Watches of it, in the order in which they began: number and slot.
    pub watches: SmallSet<(u64, u32)>,
    /// It is pulsed in the propagation under way.
    pub is_pulsed: bool,
    /// It changed in the propagation under way.
    pub is_changed: bool,
}

impl Fluent {
    /// A fluent with a value.
    pub fn new(name: Option<Symbol>, value: Value, origin: Origin) -> Self {
        Self {
            number: 0,
            name,
            value,
            origin,
            failure: None,
            dependents: SmallSet::default(),
            inputs: Vec::new(),
            height: 0,
            waiters: Line::default(),
            watches: SmallSet::default(),
            is_pulsed: false,
            is_changed: false,
        }
    }

    /// What is read now: in the propagation of its pulse, a fluent that is nil reads as t.
    pub fn reading(&self) -> Value {
        if self.is_pulsed && self.value == Value::Nil { Value::True } else { self.value }
    }

    /// Whether what is read now is true.
    pub fn is_true(&self) -> bool {
        self.is_pulsed || self.value.is_true()
    }

    /// Whether it is a plan's, no network reads it and nothing watches it: a new value concerns
    /// nobody but those who wait for it.
    #[inline]
    pub(crate) fn is_plain(&self) -> bool {
        matches!(self.origin, Origin::Plan) && self.dependents.is_empty() && self.watches.is_empty()
    }

    fn is_computed(&self) -> bool {
        !matches!(self.origin, Origin::Plan | Origin::System)
    }
}

/// A `whenever` that counts how often its fluent becomes true.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Watch {
    /// Grows from watch to watch.
    pub number: u64,
    /// The fluent.
    pub fluent: u32,
    /// The task.
    pub task: u32,
    /// Whether the fluent was true last.
    pub was_true: bool,
    /// Events not served yet.
    pub events: u32,
    /// What happens with events during the body.
    pub missed: Missed,
    /// Whether the fluent dies with the watch.
    pub owned: bool,
    /// Whether the task waits for the next event now.
    pub waits: bool,
}

/// A network that computes itself from itself is cut after this many evaluations.
const MAX_EVALUATIONS: usize = 1_000_000;

impl Machine {
    /// Makes a fluent.
    pub fn create_fluent(&mut self, mut fluent: Fluent) -> Value {
        let captured = match &fluent.origin {
            Origin::Network { captured, .. } => captured.len(),
            Origin::Plan | Origin::System | Origin::Pulsed | Origin::Changed | Origin::Count => 0,
        };
        self.heap.allocated += memory::fluent(captured);
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
            self.set_inputs(index, vec![input]);
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
        let Value::Fluent(fluent) = fluent else {
            return Err(self.wrong_type("what is assigned", rpl_lang::kind::Kind::Fluent.noun(), fluent));
        };
        match self.fluents[fluent].origin {
            Origin::Plan => {}
            Origin::System => {
                let name = self.fluent_name(fluent);
                return Err(Raise::type_error(format!("`{name}` is set by the robot; a plan can only read it")));
            }
            _ => return Err(Raise::type_error("a network cannot be assigned; assign one of the fluents it reads")),
        }
        self.assign(around, fluent, value);
        Ok(())
    }

    /// Assigns one fluent.
    pub(crate) fn assign(&mut self, around: &mut Surroundings<'_>, fluent: u32, value: Value) {
        let entry = &mut self.fluents[fluent];
        if self.heap.equal(entry.value, value) {
            return;
        }
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
        if let Some(reads) = &mut self.scratch.reads {
            reads.push(fluent);
        }
        let fluent = &self.fluents[fluent];
        match fluent.failure {
            Some(failure) => Err(Raise::Again(failure)),
            None => Ok(fluent.reading()),
        }
    }

    fn propagate(&mut self, around: &mut Surroundings<'_>, roots: Vec<u32>) {
        self.scratch.event_readers.clear();
        self.scratch.rereading.clear();
        let is_pulse = roots.iter().any(|&root| self.fluents[root].is_pulsed);
        let mut touched = roots;
        let mut dirty: BTreeSet<Turn> = BTreeSet::new();
        for &root in &touched {
            self.mark_dependents(root, &mut dirty);
        }
        let mut evaluations = 0;
        while let Some((_, _, network)) = dirty.pop_first() {
            evaluations += 1;
            if evaluations > MAX_EVALUATIONS {
                break;
            }
            let before = (self.fluents[network].value, self.fluents[network].failure);
            self.evaluate(around, network);
            let inputs_wait = self.fluents[network].inputs.iter().any(|&input| dirty.contains(&self.turn(input)));
            if inputs_wait {
                dirty.insert(self.turn(network));
                continue;
            }
            let after = (self.fluents[network].value, self.fluents[network].failure);
            let changed = before.1 != after.1 || !self.heap.equal(before.0, after.0);
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

    fn turn(&self, network: u32) -> Turn {
        let fluent = &self.fluents[network];
        (fluent.height, fluent.number, network)
    }

    fn mark_dependents(&mut self, fluent: u32, dirty: &mut BTreeSet<Turn>) {
        self.scratch.work += self.fluents[fluent].dependents.len() as u64;
        self.fluents[fluent].dependents.for_each(|dependent| {
            dirty.insert(self.turn(dependent));
        });
    }

    /// Releases waiters and counts events of fluents that have changed together. Whoever is released
    /// is woken in the order in which they began to wait.
    fn serve(&mut self, fluents: &[u32], is_pulse: bool) {
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

    /// Notes who is released by one fluent, with the number of its wait, and counts events.
    fn release(&mut self, fluent: u32, is_pulse: bool, released: &mut Vec<(u32, u32, Wake)>) {
        let reading = self.fluents[fluent].reading();
        let failure = self.fluents[fluent].failure;
        let is_true = reading.is_true() || failure.is_some();
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
        if is_true {
            let wake = failure.map_or(Wake::Value(reading), Wake::Raise);
            let waiters = self.fluents[fluent].waiters.tasks(&self.tasks);
            released.extend(waiters.into_iter().map(|task| (self.tasks[task].wait_number, task, wake)));
        }
    }

    /// Wakes all waiters of a fluent, in the order of their waiting.
    pub(crate) fn wake_waiters(&mut self, fluent: u32, wake: Wake) {
        let mut task = std::mem::take(&mut self.fluents[fluent].waiters).first;
        let mut was_owned = false;
        while task != NONE {
            let record = &mut self.tasks[task];
            let next = record.next;
            record.set_wake(wake);
            if let Waiting::Fluent { owned, timed, .. } = std::mem::take(&mut record.waiting) {
                was_owned |= owned;
                if timed {
                    self.forget_timer();
                }
            }
            self.number_wait(task);
            self.trace_woken(task);
            self.make_ready(task);
            task = next;
        }
        if was_owned {
            self.free_network(fluent);
        }
    }

    /// Events of a fluent's watches count from its value now.
    fn end_event(&mut self, fluent: u32) {
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
        let mut again: BTreeSet<Turn> = BTreeSet::new();
        for &fluent in &touched {
            let Some(entry) = self.fluents.get_mut(fluent) else { continue };
            let (pulsed, changed) = (entry.is_pulsed, entry.is_changed);
            entry.is_pulsed = false;
            entry.is_changed = false;
            self.fluents[fluent].dependents.for_each(|dependent| {
                let reads_events = matches!(self.fluents[dependent].origin, Origin::Changed | Origin::Pulsed)
                    || self.scratch.event_readers.contains(&dependent);
                if pulsed || (changed && reads_events) {
                    again.insert(self.turn(dependent));
                }
            });
        }
        while let Some((_, _, network)) = again.pop_first() {
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
    fn evaluate(&mut self, around: &mut Surroundings<'_>, network: u32) {
        self.scratch.work += 1;
        let input = self.fluents[network].inputs.first().copied();
        let input_is = |machine: &Machine, test: fn(&Fluent) -> bool| {
            input.and_then(|input| machine.fluents.get(input)).is_some_and(test)
        };
        let value = match self.fluents[network].origin.clone() {
            Origin::Plan | Origin::System => return,
            Origin::Pulsed => Value::truth(input_is(self, |fluent| fluent.is_pulsed)),
            Origin::Changed => Value::truth(input_is(self, |fluent| fluent.is_changed)),
            Origin::Count => match (self.fluents[network].value, input_is(self, |fluent| fluent.is_pulsed)) {
                (Value::Int(count), true) => Value::Int(count + 1),
                (value, _) => value,
            },
            Origin::Network { code, captured } => {
                let outer = self.scratch.reads.replace(Vec::new());
                let outer_event = std::mem::replace(&mut self.scratch.reads_event, false);
                let result = self.evaluate_code(around, code, &captured);
                let mut reads = std::mem::replace(&mut self.scratch.reads, outer).unwrap_or_default();
                if std::mem::replace(&mut self.scratch.reads_event, outer_event) {
                    self.scratch.event_readers.insert(network);
                }
                reads.sort_unstable();
                reads.dedup();
                if self.trace.enabled && self.fluents[network].inputs != reads {
                    self.scratch.rereading.push(network);
                }
                self.set_inputs(network, reads);
                match result {
                    Ok(value) => {
                        self.fluents[network].failure = None;
                        value
                    }
                    Err(failure) => {
                        self.fluents[network].failure = Some(failure);
                        Value::Nil
                    }
                }
            }
        };
        self.fluents[network].value = value;
    }

    fn set_inputs(&mut self, network: u32, inputs: Vec<u32>) {
        let height = inputs.iter().map(|&input| self.fluents[input].height + 1).max().unwrap_or(0);
        if self.fluents[network].inputs != inputs {
            for input in std::mem::take(&mut self.fluents[network].inputs) {
                if let Some(fluent) = self.fluents.get_mut(input) {
                    fluent.dependents.remove(&network);
                }
            }
            self.heap.allocated += 2 * memory::EDGE * inputs.len();
            for &input in &inputs {
                self.fluents[input].dependents.insert(network);
            }
            self.fluents[network].inputs = inputs;
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
            self.set_inputs(network, Vec::new());
            self.fluents.remove(network);
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

    /// Starts to watch a fluent.
    pub(crate) fn start_watch(&mut self, task: u32, fluent: u32, missed: Missed, owned: bool) -> u32 {
        let is_true = self.fluents[fluent].reading().is_true() || self.fluents[fluent].failure.is_some();
        let events = u32::from(is_true);
        let number = self.next_identity;
        self.next_identity += 1;
        let entry = Watch { number, fluent, task, was_true: is_true, events, missed, owned, waits: false };
        self.heap.allocated += memory::WATCH;
        let watch = self.watches.insert(entry);
        self.fluents[fluent].watches.insert((number, watch));
        watch
    }

    /// Ends a watch.
    pub(crate) fn end_watch(&mut self, watch: u32) {
        let Some(entry) = self.watches.remove(watch) else { return };
        if let Some(fluent) = self.fluents.get_mut(entry.fluent) {
            fluent.watches.remove(&(entry.number, watch));
            if entry.owned {
                self.free_network(entry.fluent);
            }
        }
    }

    /// Takes the next event of a watch, or waits for it.
    pub(crate) fn next_event(&mut self, watch: u32) -> Result<bool, Raise> {
        let entry = self.watches[watch];
        if entry.events == 0 {
            self.watches[watch].waits = true;
            let task = entry.task;
            self.tasks[task].waiting = Waiting::Watch(watch);
            self.number_wait(task);
            return Ok(false);
        }
        self.watches[watch].events = match entry.missed {
            Missed::Always => entry.events - 1,
            Missed::Once | Missed::Never => 0,
        };
        match self.fluents[entry.fluent].failure {
            Some(failure) => Err(Raise::Again(failure)),
            None => Ok(true),
        }
    }

    /// The body of a `whenever` has run.
    pub(crate) fn event_served(&mut self, watch: u32) {
        if self.watches[watch].missed == Missed::Never {
            self.watches[watch].events = 0;
        }
    }

    pub(crate) fn fluent_name(&self, fluent: u32) -> String {
        match self.fluents[fluent].name {
            Some(name) => self.symbols.name(name).to_string(),
            None => format!("fluent {fluent}"),
        }
    }
}
