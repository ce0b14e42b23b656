//! A run as a value: program, machine and robot, stepped from instant to instant.

use crate::behaviour::{NoRobot, Outbox, Outside};
use crate::datum::{self, MAX_NODES, Origins, Unfit};
use crate::exec::Ran;
use crate::failure::Raise;
use crate::library::{Library, Loaded, has_error};
use crate::machine::{Machine, Surroundings};
use crate::macro_host::MacroMachine;
use crate::save::Base;
use crate::scheduler::Alarm;
use crate::task::{Leaving, State, Wake};
use crate::tree::is_current;
use crate::units::{Units, give_back};
use crate::value::Value;
use rpl_lang::code::Program;
use rpl_lang::pretty;
use rpl_lang::source::{SourceId, Span};
use rpl_lang::syntax::{NodeId, Tree};
use rpl_random::Stream;
use std::sync::Arc;

/// Whether a run goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// There is more to do.
    Running,
    /// The main task is dead.
    Ended,
}

/// What became of a turn of a ready task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// No task is ready.
    Idle,
    /// A task ran until it blocked, ended or was switched out.
    Over,
    /// A slice of steps is over; the run goes on in the next turn as if nothing had been.
    Cut,
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// With a value.
    Succeeded(Value),
    /// With a failure.
    Failed(Value),
    /// It was told to stop.
    Evaporated,
}

/// Steps that compiling a datum takes, and each of its parts.
const STEPS_A_UNIT: usize = 500;
const STEPS_A_NODE: usize = 20;

/// What a part of a datum takes at most while it is compiled.
const BYTES_A_NODE: usize = 512;

/// The machine that expands macros in data, kept from one datum to the next: it has taken in the
/// constants of the program so far. No part of the state.
#[derive(Default)]
pub(crate) struct Macros(Option<Box<MacroMachine>>);

impl Clone for Macros {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// A run: cloning it is a fork.
#[derive(Clone)]
pub struct System<O> {
    /// All code; shared between forks until one of them adds to it.
    pub program: Arc<Program>,
    pub(crate) units: Arc<Units>,
    /// Everything else but the robot.
    pub machine: Machine,
    /// The robot.
    pub outside: O,
    /// What the program was compiled with.
    pub library: Arc<Library>,
    /// The program it started from.
    pub(crate) base: Arc<Base>,
    /// When the robot's next step is due.
    pub(crate) next_step_us: u64,
    /// Steps that tasks take before [`System::step_slice`] tells that a slice is over, at least 1. It
    /// makes no difference to the run, unless that comes close to the limit of memory: what is laid
    /// aside counts. It is not saved with the run.
    pub slice_steps: u32,
    /// Steps left of the slice.
    pub(crate) slice_left: u32,
    pub(crate) macros: Macros,
}

/// So many steps take some ten milliseconds, and switching a task out and in again costs little
/// beside them, however deep its calls are.
pub(crate) const SLICE_STEPS: u32 = 1 << 20;

/// Width at which plans made at run time are printed for their errors.
const PLAN_WIDTH: usize = 100;

/// A datum with more characters than this is not kept for being used again.
const MAX_SHARED_TEXT: usize = 1 << 16;

impl<O: Outside> System<O> {
    /// A run at its start: the robot has made one step, no form has run. All that its plans leave to
    /// chance follows from the seed.
    pub fn new(library: Arc<Library>, loaded: Loaded, outside: O, seed: u64) -> Self {
        Self::start(library, loaded, outside, seed, false)
    }

    /// The same with the trace switched on from the first event.
    pub fn traced(library: Arc<Library>, loaded: Loaded, outside: O, seed: u64) -> Self {
        Self::start(library, loaded, outside, seed, true)
    }

    fn start(library: Arc<Library>, loaded: Loaded, outside: O, seed: u64, traced: bool) -> Self {
        let Loaded { program, symbols, main, .. } = loaded;
        let mut machine = Machine::new(&program, symbols, Stream::new(seed, outside.stream()));
        machine.trace.enabled = traced;
        for fluent in outside.fluents() {
            let known = machine.symbols.find(fluent.name).and_then(|name| Some((name, *program.names.get(&name)?)));
            if let Some((name, global)) = known {
                machine.define_system_fluent(global, name, Value::Nil);
            }
        }
        let base = Arc::new(Base::new(program.clone()));
        let mut system = Self {
            program,
            units: Arc::default(),
            machine,
            outside,
            library,
            base,
            next_step_us: 0,
            slice_steps: SLICE_STEPS,
            slice_left: SLICE_STEPS,
            macros: Macros::default(),
        };
        system.step_robot();
        system.machine.start_main(main);
        system
    }

    /// Calls something of the machine that needs its surroundings.
    pub fn with_machine<T>(&mut self, act: impl FnOnce(&mut Machine, &mut Surroundings<'_>) -> T) -> T {
        let mut around = Surroundings {
            program: &self.program,
            natives: &self.library.natives,
            signatures: &self.library.signatures,
            outside: &mut self.outside,
            slice_steps: self.slice_steps,
        };
        let answer = act(&mut self.machine, &mut around);
        // What is behind between two steps is no part of the state, and would be lost with a save.
        self.machine.flush_status(&mut around);
        answer
    }

    fn step_robot(&mut self) {
        let Some(period) = self.outside.period_us() else { return };
        let mut outbox = Outbox::default();
        self.outside.step(&mut outbox);
        self.next_step_us = self.machine.now_us + period;
        self.with_machine(|machine, around| {
            machine.apply_outbox(around, outbox);
            machine.look_for_stall(around);
        });
    }

    /// A second run from here on. The two share code and nothing else: each goes on as if it were
    /// alone, and the same steps give the same trace. Cost: a copy of the state.
    #[must_use]
    pub fn fork(&self) -> Self
    where
        O: Clone,
    {
        self.clone()
    }

    /// Runs one ready task until it blocks; tells whether there was one.
    pub fn step_task(&mut self) -> bool {
        loop {
            match self.step_slice() {
                Turn::Idle => return false,
                Turn::Over => return true,
                Turn::Cut => {}
            }
        }
    }

    /// The same, but comes back after a slice of steps, however long the task goes on, and tells when
    /// all tasks together have taken one: for those who must look at something else now and then.
    pub fn step_slice(&mut self) -> Turn {
        if self.slice_left == 0 {
            self.slice_left = self.slice_steps;
            return Turn::Cut;
        }
        let slice_left = self.slice_left.min(self.slice_steps);
        let before = self.machine.steps;
        let ran = self.with_machine(|machine, around| {
            around.slice_steps = slice_left;
            machine.run_next(around)
        });
        let turn = self.answer_asked(ran);
        let taken = u32::try_from(self.machine.steps - before).unwrap_or(u32::MAX);
        self.slice_left = match turn {
            Turn::Cut => self.slice_steps,
            Turn::Idle | Turn::Over => slice_left.saturating_sub(taken),
        };
        turn
    }

    /// Compiles what the task that runs asks for, as often as it does; tells what became of its turn.
    pub(crate) fn answer_asked(&mut self, mut ran: Ran) -> Turn {
        loop {
            match ran {
                Ran::Nothing => return Turn::Idle,
                Ran::Task => return Turn::Over,
                Ran::Slice => return Turn::Cut,
                Ran::Asked(datum) => ran = self.execute_datum(datum),
            }
        }
    }

    /// Runs ready tasks until all are blocked.
    pub fn settle(&mut self) {
        loop {
            let asked = self.with_machine(|machine, around| {
                loop {
                    match machine.run_next(around) {
                        Ran::Nothing => return None,
                        Ran::Task | Ran::Slice => {}
                        Ran::Asked(datum) => return Some(datum),
                    }
                }
            });
            let Some(datum) = asked else { return };
            self.answer_asked(Ran::Asked(datum));
        }
    }

    /// Goes on to the end of the next instant.
    pub fn advance(&mut self) -> Progress {
        self.settle();
        if self.outcome().is_some() {
            return Progress::Ended;
        }
        self.next_instant();
        self.settle();
        if self.outcome().is_some() { Progress::Ended } else { Progress::Running }
    }

    /// Moves the clock to the next timer or robot step and lets that take effect, while all tasks
    /// are blocked; no task runs yet. If nothing can come any more, the main task fails.
    pub fn next_instant(&mut self) {
        match self.next_instant_us() {
            Some(next_us) => self.enter_instant(next_us),
            None => self.fail_deadlocked(),
        }
    }

    /// Goes through all instants up to a time, as long as the main task lives.
    pub fn advance_to(&mut self, time_us: u64) {
        self.settle();
        while self.outcome().is_none()
            && let Some(next_us) = self.next_instant_us()
            && next_us <= time_us
        {
            self.enter_instant(next_us);
            self.settle();
        }
    }

    /// When something happens next: a timer is due, or the robot makes a step.
    pub fn next_instant_us(&mut self) -> Option<u64> {
        let tasks = &self.machine.tasks;
        let timer = self.machine.timers.next(|timer| is_current(tasks, timer)).map(|timer| timer.deadline_us);
        let step = self.outside.period_us().map(|_| self.next_step_us);
        [timer, step].into_iter().flatten().min()
    }

    fn enter_instant(&mut self, time_us: u64) {
        // Budgets are counted in one point of time, however often it is gone to.
        if self.machine.now_us < time_us {
            self.machine.instant = self.machine.instant.wrapping_add(1);
            self.machine.now_us = time_us;
        }
        if self.outside.period_us().is_some() && self.next_step_us <= time_us {
            self.step_robot();
        }
        self.fire_timers();
        self.with_machine(Machine::flush_status);
    }

    /// Fires the timers that are due: all waits that end now, or, when nothing is left to run, the
    /// first timeout.
    fn fire_timers(&mut self) {
        let now = self.machine.now_us;
        let mut is_quiet = true;
        loop {
            let tasks = &self.machine.tasks;
            let Some(timer) = self.machine.timers.next(|timer| is_current(tasks, timer)) else { return };
            if timer.deadline_us > now {
                return;
            }
            let task = timer.task.index;
            match timer.alarm {
                Alarm::Wake(_) => {
                    self.machine.timers.take();
                    self.machine.wake(task, Wake::Value(Value::Nil));
                    is_quiet = false;
                }
                Alarm::Deadline if is_quiet && self.machine.is_idle() => {
                    self.machine.timers.take();
                    self.with_machine(|machine, around| machine.deadline(around, task, timer.number));
                    return;
                }
                // What is ready may be done in time: the timeout is looked at when it has run.
                Alarm::Deadline => return,
            }
        }
    }

    /// Runs to the end, or to a time. Tells how it ended, if it did.
    pub fn run_until(&mut self, until_us: u64) -> Option<Outcome> {
        while self.machine.now_us < until_us {
            if self.advance() == Progress::Ended {
                return self.outcome();
            }
        }
        self.outcome()
    }

    /// How the main task ended, once it has.
    pub fn outcome(&self) -> Option<Outcome> {
        let main = &self.machine.tasks[self.machine.main];
        match main.state {
            State::Succeeded => Some(Outcome::Succeeded(main.value)),
            State::Failed => Some(Outcome::Failed(main.value)),
            State::Evaporated => Some(Outcome::Evaporated),
            _ => None,
        }
    }

    /// Tells the main task to stop: its clean-ups still run.
    pub fn stop(&mut self) {
        self.with_machine(|machine, around| {
            let main = machine.main;
            machine.evaporate(around, main);
        });
    }

    /// Nothing can happen any more: the main task fails with what every task waits for. If it is
    /// leaving already, the clean-up it waits for does.
    fn fail_deadlocked(&mut self) {
        self.with_machine(|machine, around| {
            let waits = machine.what_tasks_wait_for(around.program);
            let message = format!("every task is blocked and no timer runs: {waits}");
            let failing = machine.deadlocked_task();
            let failure = machine.failure_from(Raise::new("deadlock", message));
            if let Value::Failure(index) = failure {
                let (path, calls) = (machine.path(failing), machine.plan_calls(failing));
                let record = &mut machine.heap.failures[index];
                (record.path, record.calls, record.is_runaway) = (path, calls, true);
            }
            let strikes = machine.strikes_now(failing).saturating_add(1);
            machine.strike(failing, strikes);
            machine.depart(around, failing, Leaving::Fail(failure));
        });
    }

    /// Compiles a datum for the running task, which asked for it, and lets the task go on in it.
    fn execute_datum(&mut self, datum: Value) -> Ran {
        let (outcome, steps) = self.compile_datum(datum);
        self.with_machine(|machine, around| machine.enter(around, outcome, steps))
    }

    /// The code of a datum, or what is wrong with it; and how many steps that takes.
    fn compile_datum(&mut self, datum: Value) -> (Result<u32, Raise>, usize) {
        let (mut tree, root, objects, source) = match self.tree_of(datum) {
            Ok(made) => made,
            Err(raise) => return (Err(raise), STEPS_A_UNIT),
        };
        let nodes = tree.nodes.len();
        let text = pretty::pretty(&mut tree, &self.machine.symbols, root, PLAN_WIDTH, source);
        let may_share = objects.is_empty() && text.len() <= MAX_SHARED_TEXT;
        if may_share && let Some(code) = self.units.find(&text) {
            return (Ok(code), nodes);
        }
        let unit = self.compile_unit(tree, root, &text, &objects, may_share);
        (unit, STEPS_A_UNIT + nodes * STEPS_A_NODE)
    }

    /// A datum as a tree, if there is room for what becomes of it; with the objects in it, and the name
    /// its text will have.
    fn tree_of(&mut self, datum: Value) -> Result<(Tree, NodeId, Vec<Value>, SourceId), Raise> {
        if self.units.are_due(self.machine.unit_bytes) {
            self.sweep_units();
        }
        let mut has_collected = false;
        loop {
            // A text that is given back leaves its name to the next one.
            let source = self.program.sources.next();
            let span = Span { source, start: 0, end: 0 };
            let machine = &mut self.machine;
            let most = (machine.room() / BYTES_A_NODE).min(MAX_NODES);
            let (mut tree, mut objects, origins) = (Tree::default(), Vec::new(), Origins::new());
            let Machine { heap, symbols, .. } = machine;
            match datum::to_node(heap, symbols, &mut tree, datum, span, &origins, &mut objects, most) {
                Ok(root) => return Ok((tree, root, objects, source)),
                Err(Unfit::Circle) => {
                    return Err(Raise::new("error", "the datum is a circular list and cannot be a plan"));
                }
                Err(Unfit::TooLarge) if most == MAX_NODES => {
                    let message = format!("the datum has more than {MAX_NODES} parts and cannot be a plan");
                    return Err(Raise::new("error", message));
                }
                Err(Unfit::TooLarge) if has_collected => return Err(machine.out_of_memory()),
                Err(Unfit::TooLarge) => {
                    self.sweep_units();
                    has_collected = true;
                }
            }
        }
    }

    /// Adds the code of a datum to the program.
    fn compile_unit(
        &mut self,
        tree: Tree,
        root: NodeId,
        text: &str,
        objects: &[Value],
        may_share: bool,
    ) -> Result<u32, Raise> {
        let program = Arc::make_mut(&mut self.program);
        let machine = &mut self.machine;
        let globals = program.globals.len();
        let name = format!("plan#{}", program.sources.made());
        let source = program.sources.add(&name, text);
        let mut macros = self.macros.0.take().unwrap_or_else(|| Box::new(self.library.macros(program)));
        macros.begin();
        let compiled = self.library.compile_datum(program, &mut machine.symbols, &mut macros, tree, root);
        // Macros may come to use what it defines, in places that were used before.
        self.macros.0 = (!compiled.defines()).then_some(macros);
        machine.renew_constants(program, &compiled.constants, objects);
        if has_error(&compiled.diagnostics) {
            let drawn = rpl_lang::diagnostic::render(&compiled.diagnostics, &program.sources, false);
            if !compiled.defines() {
                program.globals.truncate(globals);
                give_back(program, machine, &compiled.codes, &compiled.constants, source);
            }
            machine.bring_up_to(program, objects);
            return Err(Raise::new("error", format!("the datum cannot be executed:\n{drawn}")));
        }
        machine.bring_up_to(program, objects);
        let bytes = Arc::make_mut(&mut self.units).add(program, &compiled, source, may_share);
        machine.unit_bytes += bytes;
        machine.heap.allocated += bytes;
        Ok(compiled.main)
    }

    /// Gives back code that was made at run time and that nothing refers to.
    fn sweep_units(&mut self) {
        let marks = self.machine.collect_for(&self.program);
        let (program, units) = (Arc::make_mut(&mut self.program), Arc::make_mut(&mut self.units));
        units.sweep(program, &mut self.machine, &marks);
        self.macros = Macros::default();
        // What was given back is found out by a collection.
        self.machine.collect();
    }
}

impl System<NoRobot> {
    /// Compiles and starts a text without a robot.
    ///
    /// # Errors
    /// The findings in the text.
    pub fn without_robot(
        library: &Arc<Library>,
        name: &str,
        text: &str,
        seed: u64,
    ) -> Result<Self, crate::library::Rejected> {
        let loaded = library.load(name, text, &mut rpl_lang::compile::NoFiles)?;
        Ok(Self::new(library.clone(), loaded, NoRobot, seed))
    }
}
