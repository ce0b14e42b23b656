//! The machine: everything a run consists of, as one value.

use crate::behaviour::{Activation, Outside};
use crate::failure::{Failure, Raise};
use crate::fluent::{Fluent, Origin, Watch};
use crate::heap::Heap;
use crate::memory::block;
use crate::native::Native;
use crate::print;
use crate::registers::Registers;
use crate::scheduler::{Priorities, Timers};
use crate::slab::Slab;
use crate::stall::Stall;
use crate::task::{Call, Frame, NONE, Scope, ScopeKind, Task, Tasks};
use crate::trace::Trace;
use crate::unwind::Departure;
use crate::value::{TaskRef, Value};
use crate::valve::Valve;
use rpl_lang::code::{Atom, Constant, GlobalKind, Part, Program};
use rpl_lang::compile::NativeSignature;
use rpl_lang::kind::{Kind, time_in_string};
use rpl_lang::number::format_float;
use rpl_lang::symbol::{Symbol, Symbols};
use rpl_lang::visible::{quoted, shortened, with_short_words};
use rpl_random::Stream;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// What a machine runs with and does not own.
pub struct Surroundings<'a> {
    /// All code.
    pub program: &'a Program,
    /// The native functions, by number.
    pub natives: &'a [Native],
    /// How many arguments each of them takes.
    pub signatures: &'a [NativeSignature],
    /// The robot, or [`crate::behaviour::NoRobot`].
    pub outside: &'a mut dyn Outside,
    /// Steps a task takes before control goes back to the caller for a moment.
    pub slice_steps: u32,
}

/// Limits that turn endless plans into failures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Limits {
    /// Calls and loop turns of one task in one instant.
    pub steps: u32,
    /// Frames of one task.
    pub frames: u32,
    /// Bytes of everything it makes: [`crate::memory`].
    pub bytes: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self { steps: 100_000_000, frames: 1_000_000, bytes: 1 << 30 }
    }
}

/// A task that prints is switched out when so many lines have not been taken yet, so that an
/// endless loop that prints is seen and does not fill the memory. It stays at the front of its line.
pub const MAX_WAITING_OUTPUT: usize = 4096;

/// The same for so many bytes of lines.
pub const MAX_WAITING_OUTPUT_BYTES: usize = 1 << 20;

/// Where a line of output goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Channel {
    /// From `print`: to standard output.
    Print,
    /// From `log`, and warnings: to standard error.
    Log,
}

/// A line of output.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Output {
    /// Where it goes.
    pub channel: Channel,
    /// What it says.
    pub text: String,
    /// Virtual time.
    pub time_us: u64,
    /// The number of the next event of the trace: it stands before that one.
    pub sequence: u64,
}

/// What exists only while code runs; empty between two steps, and no part of the state.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// Registers of the running task, and of networks above them.
    pub(crate) stack: Vec<Value>,
    /// Frames below the current one.
    pub(crate) frames: Vec<Frame>,
    /// One past the registers in use, known before slow instructions.
    pub(crate) top: usize,
    /// Fluents the network under evaluation has read.
    pub(crate) reads: Option<Vec<u32>>,
    /// Whether it has asked for a pulse or a change.
    pub(crate) reads_event: bool,
    /// Networks that asked for a pulse or a change in this propagation.
    pub(crate) event_readers: BTreeSet<u32>,
    /// Networks that have come to read other fluents, while the trace is written.
    pub(crate) rereading: Vec<u32>,
    /// A more important task has become ready.
    pub(crate) switch: bool,
    /// Tasks whose status fluents are behind.
    pub(crate) status_changed: Vec<TaskRef>,
    /// Departures to be looked at, the next one last.
    pub(crate) departures: Vec<Departure>,
    /// Departures are being looked at: further ones wait.
    pub(crate) is_departing: bool,
    /// When a timer ends the wait that the running task begins: until that is in the trace.
    pub(crate) wake_at: Option<u64>,
    /// Bytes of the output that was added since there was none.
    pub(crate) output_bytes: usize,
    /// Where the running task goes on when the datum it asked for is compiled.
    pub(crate) asked: Option<(crate::exec::Place, rpl_lang::code::Reg)>,
    /// Turns of the runtime's own loops: how they grow with a plan is told by it, and not by time.
    pub(crate) work: u64,
    /// Evaluations of networks and macros that are under way, one inside the other.
    pub(crate) evaluations: u32,
    /// Valves about which something has changed.
    pub(crate) restless: BTreeSet<u32>,
    /// They are being served.
    pub(crate) is_serving: bool,
    /// How often boosts have changed meanwhile.
    pub(crate) boost_changes: BTreeMap<u32, u32>,
    /// Links and waiters that were looked at for valves.
    pub(crate) valve_looks: u64,
    /// Steps that networks took on behalf of the running task.
    pub(crate) burned: u32,
    /// The running task goes to the end of its line.
    pub(crate) gives_way: bool,
    /// Somebody steps through the run, and how far.
    pub(crate) stepping: crate::stepping::Stepping,
}

/// Scratch is no part of a state.
impl PartialEq for Scratch {
    fn eq(&self, _other: &Self) -> bool {
        true
    }
}

/// Everything a run consists of, save the robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// Names.
    pub symbols: Symbols,
    /// Heap objects.
    pub heap: Heap,
    /// Fluents.
    pub fluents: Slab<Fluent>,
    /// Watches of `whenever`.
    pub watches: Slab<Watch>,
    /// Tasks; task 0 is the scratch task in which networks and macros are evaluated.
    pub tasks: Tasks,
    /// Valves, by the order of their definition.
    pub valves: Vec<Valve>,
    /// Activations, by the number of the behaviour.
    pub activations: Vec<Activation>,
    /// Priorities and the run queue.
    pub priorities: Priorities,
    /// Timers.
    pub timers: Timers,
    /// Values of the globals.
    pub globals: Vec<Value>,
    /// Values of the constants.
    pub constants: Vec<Value>,
    /// Virtual time.
    pub now_us: u64,
    /// Counts the instants.
    pub instant: u32,
    /// The next identity of a block.
    pub(crate) next_identity: u64,
    /// The task that runs; [`NONE`] between two steps.
    pub(crate) current: u32,
    /// How many tasks wait for others to be at rest.
    pub(crate) waits_for_rest: u32,
    /// How many valves have somebody waiting for clean-ups or hooks to end.
    pub(crate) claims: u32,
    /// Waits there have been.
    pub(crate) waits: u32,
    /// Since when nothing has happened, with a robot.
    pub stall: Stall,
    /// The main task.
    pub main: u32,
    /// Events.
    pub trace: Trace,
    /// Output not yet taken.
    pub output: Vec<Output>,
    /// Bytes of the code made at run time.
    pub(crate) unit_bytes: usize,
    /// Limits.
    pub limits: Limits,
    /// Calls and loop turns of all tasks since the start.
    pub steps: u64,
    /// What `random` draws from.
    pub(crate) random: Stream,
    #[serde(skip)]
    pub(crate) scratch: Scratch,
}

/// The task in which networks and macros are evaluated.
pub(crate) const SCRATCH_TASK: u32 = 0;

impl Machine {
    /// A machine at time 0 for a program, before its first step.
    pub fn new(program: &Program, symbols: Symbols, random: Stream) -> Self {
        let mut machine = Self {
            symbols,
            heap: Heap::new(),
            fluents: Slab::default(),
            watches: Slab::default(),
            tasks: Tasks::default(),
            valves: Vec::new(),
            activations: Vec::new(),
            priorities: Priorities::default(),
            timers: Timers::default(),
            globals: Vec::new(),
            constants: Vec::new(),
            now_us: 0,
            instant: 1,
            next_identity: 0,
            current: NONE,
            waits_for_rest: 0,
            claims: 0,
            waits: 0,
            stall: Stall::default(),
            main: NONE,
            trace: Trace::default(),
            output: Vec::new(),
            unit_bytes: 0,
            limits: Limits::default(),
            steps: 0,
            random,
            scratch: Scratch::default(),
        };
        let name = machine.symbols.intern("network");
        machine.tasks.insert(Task::new(0, Registers::default(), name, 0));
        machine.bring_up_to(program, &[]);
        machine
    }

    /// Makes room for what has been added to the program: constants, globals, valves. `objects`
    /// are the run-time objects that new constants name.
    pub fn bring_up_to(&mut self, program: &Program, objects: &[Value]) {
        for constant in &program.constants[self.constants.len()..] {
            let value = self.constant(constant, objects);
            self.constants.push(value);
        }
        self.globals.resize(program.globals.len(), Value::Unbound);
        for (index, global) in program.globals.iter().enumerate() {
            let known = self.globals[index];
            self.globals[index] = match global.kind {
                GlobalKind::Function(code) if code != u32::MAX => Value::Function(code),
                GlobalKind::Valve => match known {
                    Value::Valve(_) => known,
                    _ => {
                        self.valves.push(Valve::new(global.name));
                        Value::Valve(self.valves.len() as u32 - 1)
                    }
                },
                GlobalKind::Behaviour(number) => Value::Behaviour(number),
                _ => known,
            };
        }
    }

    /// The same for constants whose places were used before.
    pub(crate) fn renew_constants(&mut self, program: &Program, constants: &[u32], objects: &[Value]) {
        for &at in constants {
            if (at as usize) < self.constants.len() {
                self.constants[at as usize] = self.constant(&program.constants[at as usize], objects);
            }
        }
    }

    fn constant(&mut self, constant: &Constant, objects: &[Value]) -> Value {
        let parts = match constant {
            Constant::Atom(atom) => return self.atom(atom, objects),
            Constant::List(parts) => parts,
        };
        let mut values = Vec::new();
        for part in parts {
            let value = match part {
                Part::Atom(atom) => self.atom(atom, objects),
                Part::List { length, dotted } => {
                    let tail = if *dotted { values.pop().unwrap_or_default() } else { Value::Nil };
                    let items = values.split_off(values.len().saturating_sub(*length as usize));
                    self.heap.list_with_tail(&items, tail)
                }
            };
            values.push(value);
        }
        values.pop().unwrap_or_default()
    }

    fn atom(&mut self, atom: &Atom, objects: &[Value]) -> Value {
        match atom {
            Atom::Int(value) => Value::Int(*value),
            Atom::Float(value) => Value::Float(*value),
            Atom::Str(text) => self.heap.string(text),
            Atom::Symbol(symbol) => Value::Symbol(*symbol),
            Atom::Keyword(symbol) => Value::Keyword(*symbol),
            Atom::Nil => Value::Nil,
            Atom::True => Value::True,
            Atom::Native(number) => Value::Native(*number),
            Atom::Object(index) => objects.get(*index as usize).copied().unwrap_or(Value::Nil),
        }
    }

    /// Gives a global of the robot its fluent.
    pub fn define_system_fluent(&mut self, global: u32, name: Symbol, value: Value) -> u32 {
        let fluent = self.fluents.insert(Fluent::new(Some(name), value, Origin::System));
        self.globals[global as usize] = Value::Fluent(fluent);
        fluent
    }

    /// Starts the main task on code without parameters.
    pub fn start_main(&mut self, code: u32) {
        let name = self.symbols.intern("main");
        let mut task = Task::new(code, Registers::default(), name, 0);
        let call = Call {
            name,
            occurrence: 1,
            span: None,
            counters: BTreeMap::new(),
            spawned: 0,
            tags: Vec::new(),
            most_tags: 0,
            failure: None,
        };
        task.scopes.push(Scope { kind: ScopeKind::Call(Box::new(call)), depth: 0 });
        task.exposed = true;
        self.main = self.tasks.insert(task);
        self.make_ready(self.main);
        self.trace_task_begin(self.main);
    }

    /// Writes a line of output; it waits to be taken.
    pub fn put_out(&mut self, channel: Channel, text: String) {
        if self.output.is_empty() {
            self.scratch.output_bytes = 0;
        }
        self.heap.allocated += size_of::<Output>() + block(text.len());
        self.scratch.output_bytes += text.len();
        self.output.push(Output { channel, text, time_us: self.now_us, sequence: self.trace.next_sequence });
        self.scratch.switch |= self.is_output_full();
    }

    /// Whether so much output waits to be taken that a task gives way for it.
    pub fn is_output_full(&self) -> bool {
        let bytes = if self.output.is_empty() { 0 } else { self.scratch.output_bytes };
        self.output.len() >= MAX_WAITING_OUTPUT || bytes >= MAX_WAITING_OUTPUT_BYTES
    }

    /// Seconds of virtual time.
    pub fn now_s(&self) -> f64 {
        self.now_us as f64 / 1e6
    }

    /// A value as `print` shows it.
    pub fn show(&self, program: &Program, value: Value) -> String {
        print::display(self, program, value)
    }

    /// A value as it could be read.
    pub fn write(&self, program: &Program, value: Value) -> String {
        print::readable(self, program, value)
    }

    /// A `type-error` about something that was found where something else was expected.
    pub fn wrong_type(&self, what: &str, expected: &str, found: Value) -> Raise {
        let message = match (found, self.heap.length(found)) {
            (Value::Cons(_), Err(Value::Cons(_))) => {
                format!("{what} must be {expected}, and it is a list that runs in a circle")
            }
            (Value::Cons(_), Err(end)) => format!(
                "{what} must be {expected}, and it is a list that ends in {} instead of nil",
                self.described(end)
            ),
            _ => format!("{what} must be {expected}, and it is {}", self.described(found)),
        };
        Raise::type_error(match found {
            Value::Fluent(fluent) if expected != Kind::Fluent.noun() => {
                format!("{message}; write `(value {})` for the fluent's value", self.fluent_name(fluent))
            }
            Value::Str(text) if expected == Kind::Seconds.noun() => match time_in_string(&self.heap.strings[text]) {
                Some(time) => format!("{message}; write `{time}`, without quotes"),
                None => message,
            },
            _ => message,
        })
    }

    /// A value in a message: its type, and what it is where that is short.
    pub fn described(&self, value: Value) -> String {
        match value {
            Value::Int(number) => format!("the integer {number}"),
            Value::Float(number) if number.is_nan() => "+nan.0, which is no number".to_string(),
            Value::Float(number) => format!("the float {}", format_float(number)),
            Value::Symbol(name) => format!("the symbol {}", shortened(self.symbols.name(name))),
            Value::Keyword(name) => format!("the keyword :{}", shortened(self.symbols.name(name))),
            Value::Str(text) => format!("the string {}", quoted(&self.heap.strings[text])),
            Value::Fluent(fluent) if self.fluents[fluent].name.is_some() => {
                format!("the fluent `{}`", self.fluent_name(fluent))
            }
            Value::Valve(valve) => format!("the valve `{}`", self.valve_name(valve)),
            other => other.type_name().to_string(),
        }
    }

    /// Makes a failure object.
    pub(crate) fn failure_from(&mut self, raise: Raise) -> Value {
        match raise {
            Raise::Again(failure) => failure,
            Raise::NoRoom(_) => {
                let raise = self.out_of_memory();
                self.failure_from(raise)
            }
            Raise::New { class, message, slots } => {
                let class = self.symbols.intern(class);
                let slots = slots.into_iter().map(|(name, value)| (self.symbols.intern(name), value)).collect();
                self.new_failure(class, with_short_words(message), slots)
            }
        }
    }

    /// Makes a failure of a class, raised by the current task.
    pub(crate) fn new_failure(&mut self, class: Symbol, message: String, slots: Vec<(Symbol, Value)>) -> Value {
        // The current task may have ended just now, and what was around it with it.
        let (path, calls) = match self.tasks.get(self.current) {
            Some(task) if !task.state.is_dead() => (self.path(self.current), self.plan_calls(self.current)),
            _ => (String::new(), Vec::new()),
        };
        let is_runaway = self.symbols.name(class) == "runaway";
        self.heap.failure(Failure {
            class,
            message,
            slots,
            time_us: self.now_us,
            span: None,
            path,
            calls,
            parts: Vec::new(),
            while_cleaning_up: Vec::new(),
            is_runaway,
        })
    }

    /// A name for a task that a plan can keep.
    pub(crate) fn expose(&mut self, task: u32) -> Value {
        self.tasks[task].exposed = true;
        Value::Task(self.tasks.reference(task))
    }

    /// Turns of the runtime's own loops so far: tasks, scopes, registers, networks and priorities
    /// that were looked at. No part of the state.
    pub fn work(&self) -> u64 {
        self.scratch.work + self.priorities.work()
    }

    /// Whether no task is ready.
    pub fn is_idle(&self) -> bool {
        self.priorities.is_idle()
    }
}
