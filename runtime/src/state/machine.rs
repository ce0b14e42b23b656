//! The machine: everything a run consists of, as one value.

use crate::state::activation::Activation;
use crate::state::fluent::{Fluent, Watch};
use crate::state::heap::Heap;
use crate::state::limits::{Limits, Spent};
use crate::state::measures::Measures;
use crate::state::output::Output;
use crate::state::priorities::Priorities;
use crate::state::projected::ProjectedRun;
use crate::state::registers::Registers;
use crate::state::schedule::Schedule;
use crate::state::scratch::Scratch;
use crate::state::slab::{NONE, Slab};
use crate::state::stall::Stall;
use crate::state::task::Task;
use crate::state::tasks::Tasks;
use crate::state::timers::Timers;
use crate::state::trace::Trace;
use crate::state::value::Value;
use crate::state::valve::Valve;
use crate::state::valve_place::Place;
use rpl_lang::code::Program;
use rpl_lang::symbol::Symbols;
use rpl_random::Stream;
use serde::{Deserialize, Serialize};

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
    /// Their places, those of a valve one after the other.
    pub places: Vec<Place>,
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
    /// What is spent of the steps of this instant.
    pub spent: Spent,
    /// The next identity of a block.
    pub(crate) next_identity: u64,
    /// The task that runs; [`NONE`] between two steps.
    pub(crate) current: u32,
    /// How many tasks wait for others to be at rest.
    pub(crate) waits_for_rest: u32,
    /// How many tasks are to be given other plans as soon as nothing is in the way.
    pub(crate) swaps_pending: u32,
    /// How many places of valves have somebody waiting for clean-ups or hooks to end.
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
    /// What the plan has measured of itself.
    pub measures: Measures,
    /// Bytes of the code made at run time.
    pub(crate) unit_bytes: usize,
    /// Limits.
    pub limits: Limits,
    /// Calls and loop turns of all tasks since the start.
    pub steps: u64,
    /// What `random` draws from.
    pub(crate) random: Stream,
    /// What the seeds of projected runs are drawn from: to project leaves what plans draw as it is.
    pub(crate) foresight: Stream,
    /// What is chosen where the order is not promised; a run by itself has none, and takes the first.
    pub schedule: Option<Box<Schedule>>,
    /// What is noted of a projected run; none in a run that is real.
    #[serde(skip)]
    pub projected: Option<Box<ProjectedRun>>,
    #[serde(skip)]
    pub(crate) scratch: Scratch,
}

/// The task in which networks and macros are evaluated.
pub(crate) const SCRATCH_TASK: u32 = 0;

/// Its name, and its path.
pub(crate) const NETWORK: &str = "network";

impl Machine {
    /// A machine at time 0 for a program, before its first step.
    pub fn new(program: &Program, symbols: Symbols, random: Stream, foresight: Stream) -> Self {
        let mut machine = Self {
            symbols,
            heap: Heap::new(),
            fluents: Slab::default(),
            watches: Slab::default(),
            tasks: Tasks::default(),
            valves: Vec::new(),
            places: Vec::new(),
            activations: Vec::new(),
            priorities: Priorities::default(),
            timers: Timers::default(),
            globals: Vec::new(),
            constants: Vec::new(),
            now_us: 0,
            instant: 1,
            spent: Spent::default(),
            next_identity: 0,
            current: NONE,
            waits_for_rest: 0,
            swaps_pending: 0,
            claims: 0,
            waits: 0,
            stall: Stall::default(),
            main: NONE,
            trace: Trace::default(),
            output: Vec::new(),
            measures: Measures::default(),
            unit_bytes: 0,
            limits: Limits::default(),
            steps: 0,
            random,
            foresight,
            schedule: None,
            projected: None,
            scratch: Scratch::default(),
        };
        let name = machine.symbols.intern(NETWORK);
        machine.tasks.insert(Task::new(0, Registers::default(), name, 0));
        machine.bring_up_to(program, &[]);
        machine
    }

    /// Seconds of virtual time.
    pub fn now_s(&self) -> f64 {
        self.now_us as f64 / 1e6
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
