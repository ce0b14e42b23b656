//! What a run will do, and nothing of how it came there: two runs with the same canonical state go on
//! alike in every order.
//!
//! Left out are slots and generations of tasks, addresses in the heap, free lists, counters, the order of the
//! run queue, of a fluent's waiters and of timers of one instant, what is spent of limits, and what the run
//! can be seen to have done: its output, its trace, its measures. The time since the start and the numbers in
//! the names of tasks are left out unless the plan can see them.
//!
//! Tasks, fluents and objects of the heap are numbered in the order in which they are come upon, from the
//! main task and the variables on.

mod heap;
mod tasks;
mod valves;
mod visible;

pub use visible::Visible;

use crate::state::machine::Machine;
use crate::state::slab::NONE;
use crate::state::task::State;
use crate::state::timers::{Alarm, Timer};
use crate::state::value::{TaskRef, Value};
use crate::step::time::timers::is_current;
use foldhash::quality::FixedState;
use hashbrown::HashMap;
use rpl_lang::code::{GlobalKind, Program};
use serde::Serialize;
use std::collections::{BTreeMap, VecDeque};
use std::hash::BuildHasher;

/// Two halves of the hash, from seeds of their own.
const SEEDS: [u64; 2] = [0x243f_6a88_85a3_08d3, 0x1319_8a2e_0370_7344];

/// The hash of a canonical state, 128 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct StateHash(pub [u64; 2]);

impl StateHash {
    /// The hash of a state's bytes.
    pub fn of(bytes: &[u8]) -> Self {
        Self(SEEDS.map(|seed| FixedState::with_seed(seed).hash_one(bytes)))
    }
}

/// What a value may name that has parts of its own.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Object {
    Str(u32),
    Pair(u32),
    Cell(u32),
    Closure(u32),
    Table(u32),
    Vector(u32),
    Failure(u32),
    Fluent(u32),
    /// A task, dead or alive, by slot and generation.
    Task(u32, u32),
    /// A block that a closure can leave, by its identity.
    Block(u64),
}

/// Writes a machine down. Cost: linear in what the run can still reach.
struct Writer<'m> {
    machine: &'m Machine,
    program: &'m Program,
    visible: Visible,
    bytes: Vec<u8>,
    /// The number of each object that was come upon.
    numbers: HashMap<Object, u32, FixedState>,
    /// Those whose parts are still to be written.
    pending: VecDeque<Object>,
    /// The timers of each task, by slot.
    timers: BTreeMap<u32, Vec<Timer>>,
}

impl Machine {
    /// The canonical state, as bytes. `visible` says what the plan can see.
    pub(crate) fn canonical_bytes(&self, program: &Program, visible: Visible) -> Vec<u8> {
        let mut timers: BTreeMap<u32, Vec<Timer>> = BTreeMap::new();
        for timer in self.timers.iter().filter(|timer| is_current(&self.tasks, timer)) {
            timers.entry(timer.task.index).or_default().push(*timer);
        }
        timers.values_mut().for_each(|timers| timers.sort_unstable());
        let numbers = HashMap::with_hasher(FixedState::default());
        let (bytes, pending) = (Vec::with_capacity(512), VecDeque::new());
        let mut writer = Writer { machine: self, program, visible, bytes, numbers, pending, timers };
        writer.machine();
        writer.bytes
    }
}

impl Writer<'_> {
    fn machine(&mut self) {
        let (machine, program) = (self.machine, self.program);
        self.task(machine.main);
        for (global, value) in program.globals.iter().zip(&machine.globals) {
            if matches!(global.kind, GlobalKind::Variable | GlobalKind::Fluent) {
                self.value(*value);
            }
        }
        for activation in &machine.activations {
            self.plain(&activation.phase);
            self.optional_task(activation.task);
            for (task, signal) in activation
                .task
                .iter()
                .zip(&activation.signal)
                .chain(activation.kept.iter().map(|(task, signal)| (task, signal)))
            {
                self.reference(*task);
                self.byte(u8::from(signal.is_ok()));
                self.value(signal.unwrap_or_else(|failure| failure));
            }
            self.byte(0xff);
        }
        self.plain(&(&machine.random, &machine.foresight));
        if self.visible.time {
            self.number(machine.now_us);
        }
        self.valves();
        self.parts();
        self.lines();
    }

    /// What must stay of the order of ready tasks, if a schedule tries others: those that go on first, and those before
    /// each that has given way. All tasks have their numbers by now.
    fn lines(&mut self) {
        let machine = self.machine;
        let Some(schedule) = &machine.schedule else { return };
        for line in machine.priorities.lines() {
            let mut group = Vec::new();
            for task in line.tasks(&machine.tasks) {
                let task = machine.tasks.reference(task);
                let has_given_way = schedule.has_given_way(task);
                if has_given_way || schedule.is_preempted(task) {
                    self.group(&mut group, 1 + u8::from(has_given_way));
                    self.reference(task);
                } else {
                    group.push(self.numbers.get(&Object::Task(task.index, task.generation)).copied());
                }
            }
        }
        self.byte(0);
    }

    /// Tasks that may run in any order, and what follows them.
    fn group(&mut self, group: &mut Vec<Option<u32>>, followed_by: u8) {
        group.sort_unstable();
        group.drain(..).for_each(|number| self.number(number.map_or(1, |number| u64::from(number) + 2)));
        self.bytes.extend([0, followed_by]);
    }

    fn byte(&mut self, byte: u8) {
        self.bytes.push(byte);
    }

    /// A number in as few bytes as it needs.
    fn number(&mut self, mut number: u64) {
        while number >= 0x80 {
            self.bytes.push(number as u8 | 0x80);
            number >>= 7;
        }
        self.bytes.push(number as u8);
    }

    /// What names nothing else.
    fn plain(&mut self, value: &impl Serialize) {
        let bytes = std::mem::take(&mut self.bytes);
        // Writing into memory cannot fail.
        self.bytes = postcard::to_extend(value, bytes).unwrap_or_default();
    }

    fn text(&mut self, text: &str) {
        self.number(text.len() as u64);
        self.bytes.extend_from_slice(text.as_bytes());
    }

    /// The number of an object; its parts follow later if it is new.
    fn object(&mut self, object: Object) {
        let next = self.numbers.len() as u32;
        let number = *self.numbers.entry(object).or_insert(next);
        if number == next {
            self.pending.push_back(object);
        }
        self.number(u64::from(number));
    }

    fn task(&mut self, index: u32) {
        match index {
            NONE => self.byte(0),
            index => self.optional_task(Some(self.machine.tasks.reference(index))),
        }
    }

    fn optional_task(&mut self, task: Option<TaskRef>) {
        self.byte(u8::from(task.is_some()));
        if let Some(task) = task {
            self.reference(task);
        }
    }

    fn reference(&mut self, task: TaskRef) {
        self.object(Object::Task(task.index, task.generation));
    }

    fn values(&mut self, values: &[Value]) {
        self.number(values.len() as u64);
        values.iter().for_each(|&value| self.value(value));
    }

    /// How long it is until a time; what is past is now.
    fn time_left(&mut self, time_us: u64) {
        self.number(time_us.saturating_sub(self.machine.now_us));
    }

    /// The timers of a task, but those of its constructs.
    fn wake_timers(&mut self, index: u32) {
        let wakes: Vec<(u64, bool)> = self
            .timers
            .get(&index)
            .into_iter()
            .flatten()
            .filter(|timer| timer.alarm != Alarm::Deadline)
            .map(|timer| (timer.deadline_us, matches!(timer.alarm, Alarm::Request { .. })))
            .collect();
        self.number(wakes.len() as u64);
        for (deadline_us, is_request) in wakes {
            self.byte(u8::from(is_request));
            self.time_left(deadline_us);
        }
    }

    /// The parts of all objects that were come upon, and of those in them.
    fn parts(&mut self) {
        while let Some(object) = self.pending.pop_front() {
            match object {
                Object::Task(index, generation) => self.task_parts(TaskRef { index, generation }),
                Object::Fluent(fluent) => self.fluent_parts(fluent),
                Object::Block(_) => {}
                in_heap => self.heap_parts(in_heap),
            }
        }
    }

    /// A task that is known by name alone has no parts.
    fn task_parts(&mut self, task: TaskRef) {
        let Some(index) = self.machine.tasks.find(task) else { return self.byte(0xfe) };
        let record = &self.machine.tasks[index];
        self.plain(&record.state());
        let fluents = record.rare.as_ref().map(|rare| rare.fluents.clone()).unwrap_or_default();
        for fluent in [fluents.status, fluents.result, fluents.begin, fluents.end] {
            self.optional_fluent(fluent);
        }
        match record.state() {
            State::Succeeded | State::Failed | State::Evaporated => self.value(*record.value()),
            State::Created | State::Ready | State::Running | State::Blocked => self.living_task(index),
        }
    }
}
