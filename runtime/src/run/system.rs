//! A run as a value: program, machine and robot, stepped from instant to instant.

use crate::robot::{NoRobot, Outbox, Outside};
use crate::run::base::Base;
use crate::run::library::Rejected;
use crate::run::library::{Library, Loaded};
use crate::run::macro_host::Macros;
use crate::run::units::Units;
use crate::state::failure::Raise;
use crate::state::machine::Machine;
use crate::state::projected::{Answered, Asked};
use crate::state::task::State;
use crate::state::value::Value;
use crate::step::exec::turn::Ran;
use crate::step::native::Surroundings;
use rpl_lang::code::Program;
use rpl_lang::compile::NoFiles;
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
    /// When the robot made its last step.
    pub(crate) stepped_us: u64,
    /// Steps that tasks take before [`System::step_slice`] tells that a slice is over, at least 1. It
    /// makes no difference to the run, unless that comes close to the limit of memory: what is laid
    /// aside counts. It is not saved with the run.
    pub slice_steps: u32,
    /// Steps left of the slice.
    pub(crate) slice_left: u32,
    pub(crate) macros: Macros,
}

/// This many steps take some ten milliseconds, and switching a task out and in again costs little
/// beside them, however deep its calls are.
pub(crate) const SLICE_STEPS: u32 = 1 << 20;

impl System<NoRobot> {
    /// Compiles and starts a text without a robot.
    ///
    /// # Errors
    /// The findings in the text.
    pub fn without_robot(library: &Arc<Library>, name: &str, text: &str, seed: u64) -> Result<Self, Rejected> {
        let loaded = library.load(name, text, &mut NoFiles)?;
        Ok(Self::new(library.clone(), loaded, NoRobot, seed))
    }
}

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
        let mut machine =
            Machine::new(&program, symbols, Stream::new(seed, outside.stream()), Stream::new(seed, "foresight"));
        machine.trace.enabled = traced;
        for (&global, spec) in library.robot.fluents.iter().zip(&outside.tables().fluents) {
            let first = spec.first.map_or(Value::Nil, Value::Int);
            machine.define_system_fluent(global, program.globals[global as usize].name, first);
        }
        let base = Arc::new(Base::new(program.clone()));
        let mut system = Self {
            program,
            units: Arc::default(),
            machine,
            outside,
            library,
            base,
            stepped_us: 0,
            slice_steps: SLICE_STEPS,
            slice_left: SLICE_STEPS,
            macros: Macros::default(),
        };
        let lost = system.step_robot();
        system.machine.start_main(main);
        system.end_without_robot(lost);
        system
    }

    /// Calls something of the machine that needs its surroundings.
    pub fn with_machine<T>(&mut self, act: impl FnOnce(&mut Machine, &mut Surroundings<'_>) -> T) -> T {
        let mut around = Surroundings {
            program: &self.program,
            natives: &self.library.natives,
            signatures: &self.library.signatures,
            outside: &mut self.outside,
            robot: &self.library.robot,
            slice_steps: self.slice_steps,
        };
        let answer = act(&mut self.machine, &mut around);
        // What is behind between two steps is no part of the state, and would be lost with a save.
        self.machine.flush_status(&mut around);
        answer
    }

    /// Lets the robot make a step; why there is none any more, if this was its last.
    pub(crate) fn step_robot(&mut self) -> Option<String> {
        let now_us = self.machine.now_us;
        self.outside.next_event_us(now_us)?;
        let mut outbox = Outbox::default();
        self.outside.step(now_us, self.machine.phases(), &mut outbox);
        let machine = &self.machine;
        self.outside.answers(&|ticket| machine.awaits(ticket), &mut outbox);
        self.machine.make_room_for(&outbox);
        self.stepped_us = now_us;
        let lost = outbox.lost.take();
        let answers = std::mem::take(&mut outbox.answers);
        self.with_machine(|machine, around| {
            machine.apply_outbox(around, outbox);
            machine.take_answers(answers);
            machine.look_for_stall(around);
        });
        lost
    }

    /// The run cannot go on where the robot is lost: it fails, and its clean-ups run. A session gives up
    /// the form that runs, and lives on.
    pub(crate) fn end_without_robot(&mut self, lost: Option<String>) {
        let Some(why) = lost else { return };
        let main = self.machine.main;
        let failure = self.machine.failure_of(main, Raise::robot_lost(why));
        self.with_machine(|machine, around| machine.trace_failed(around.program, main, failure));
        match self.is_session() {
            true => self.leave_form(failure),
            false => {
                self.with_machine(|machine, around| machine.fail_call(around, main, 0, failure));
            }
        }
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

    /// Answers what the task that runs asks for, as often as it does; tells what became of its turn.
    pub(crate) fn answer_asked(&mut self, mut ran: Ran) -> Turn {
        loop {
            match ran {
                Ran::Nothing => return Turn::Idle,
                Ran::Task => return Turn::Over,
                Ran::Slice => return Turn::Cut,
                Ran::Asked(Asked::Code(datum)) => ran = self.execute_datum(datum, Answered::Code),
                Ran::Asked(Asked::Function(datum)) => {
                    ran = self.execute_datum(datum, |code| Answered::Value(Value::Function(code)));
                }
                Ran::Asked(Asked::Projection(question)) => ran = self.project(*question),
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
                        Ran::Asked(asked) => return Some(asked),
                    }
                }
            });
            let Some(asked) = asked else { return };
            self.answer_asked(Ran::Asked(asked));
        }
    }

    /// How the main task ended, once it has.
    pub fn outcome(&self) -> Option<Outcome> {
        let main = &self.machine.tasks[self.machine.main];
        match main.state() {
            State::Succeeded => Some(Outcome::Succeeded(*main.value())),
            State::Failed => Some(Outcome::Failed(*main.value())),
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
}
