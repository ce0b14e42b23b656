//! Stepping: a run looked at before each form that calls, waits, assigns or opens a construct.
//!
//! Stepping changes nothing: a run that is stepped through has the same trace as one that is not,
//! unless it comes close to the limit of memory.

use crate::behaviour::Outside;
use crate::machine::{Machine, SCRATCH_TASK};
use crate::system::{System, Turn};
use crate::task::Frame;
use crate::value::{TaskRef, Value};
use rpl_lang::code::{Code, Local, NO_REG, Op, Program, Reg};
use rpl_lang::source::Span;
use rpl_lang::symbol::Symbol;

/// How far a stepper has come.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Stepping {
    /// Whether the run is stepped through now.
    pub(crate) is_on: bool,
    /// Whether it stops before every instruction.
    is_fine: bool,
    /// The task and the instruction it stopped before: the next time it goes on from there.
    stopped: Option<(TaskRef, Frame)>,
    /// It has stopped in this step.
    has_stopped: bool,
    /// Where a value will be found that somebody wants to see, and the register.
    wanted: Option<(TaskRef, Frame, Reg)>,
    /// That value, as it could be read.
    found: Option<String>,
}

/// What became of one step.
#[derive(Clone, Debug, PartialEq)]
pub enum Stepped {
    /// No task is ready.
    Settled,
    /// A task ran until it blocked, ended or was switched out, or its slice was over.
    Ran,
    /// A task stands before a form.
    Before(Stop),
}

/// A place where a task stands before a form.
#[derive(Clone, Debug, PartialEq)]
pub struct Stop {
    /// The task.
    pub task: TaskRef,
    /// The form.
    pub span: Span,
    /// Name of the function, plan or task body the form is in.
    pub name: Symbol,
    /// The place of that whole body.
    pub body: Span,
    /// Whether nothing of the body has been stopped at before.
    pub is_entry: bool,
    /// Calls below it in the same task.
    pub depth: u32,
    pub(crate) frame: Frame,
}

impl Machine {
    /// Whether the stepper stops the running task before this instruction.
    pub(crate) fn stops_before(&mut self, program: &Program, op: &Op, frame: Frame) -> bool {
        let task = self.current;
        if task == SCRATCH_TASK {
            return false;
        }
        let here = (self.tasks.reference(task), frame);
        if let Some((task, frame, register)) = self.scratch.stepping.wanted
            && (task, frame) == here
        {
            let value =
                self.scratch.stack.get(frame.base as usize + usize::from(register)).copied().unwrap_or_default();
            self.scratch.stepping.wanted = None;
            self.scratch.stepping.found = Some(self.write(program, value));
        }
        if !op.is_step() && !self.scratch.stepping.is_fine {
            return false;
        }
        let stepping = &mut self.scratch.stepping;
        stepping.has_stopped = stepping.stopped != Some(here);
        stepping.stopped = stepping.has_stopped.then_some(here);
        stepping.has_stopped
    }

    /// A slice of steps ends before the instruction of a frame: when the stepper comes back it has
    /// stopped there already, if it did.
    pub(crate) fn end_slice<const STEPPING: bool>(&mut self, frame: Frame) {
        if STEPPING {
            self.scratch.stepping.stopped = Some((self.tasks.reference(self.current), frame));
        }
    }

    /// Variables of the text that a task sees where it stands, innermost call first: the function's
    /// name and its variables. Cost: the depth of the calls.
    pub fn variables(&self, program: &Program, task: u32) -> Vec<(Symbol, Vec<(Symbol, Value)>)> {
        let Some(record) = self.tasks.get(task) else { return Vec::new() };
        let frames = std::iter::once(&record.frame).chain(record.frames.iter().rev());
        frames
            .filter_map(|frame| {
                let code = program.codes.get(frame.code as usize)?;
                Some((code.name, self.frame_variables(code, self.tasks.registers_of(task), frame)))
            })
            .collect()
    }

    /// Assigns a variable that the innermost call of a waiting task sees. What has been read before
    /// keeps its value, as the arguments of the form the task stands before.
    pub(crate) fn assign_variable(&mut self, program: &Program, task: u32, name: Symbol, value: Value) {
        let frame = self.tasks[task].frame;
        let Some(code) = program.codes.get(frame.code as usize) else { return };
        let is_seen = |local: &&Local| local.name == name && local.from <= frame.pc && frame.pc < local.to;
        let Some(local) = code.locals.iter().rfind(is_seen) else { return };
        let register = frame.base as usize + usize::from(local.register);
        let mut registers = self.tasks.registers_of(task).to_vec();
        if let Some(&Value::Cell(cell)) = registers.get(register) {
            self.heap.cells[cell] = value;
            return;
        }
        registers.resize(registers.len().max(register + 1), Value::Nil);
        registers[register] = value;
        self.tasks.set_registers(task, &registers);
    }

    fn frame_variables(&self, code: &Code, registers: &[Value], frame: &Frame) -> Vec<(Symbol, Value)> {
        let is_seen = |from: u32, to: u32| from <= frame.pc && frame.pc < to;
        let mut seen: Vec<(Symbol, Value)> = Vec::new();
        for local in code.locals.iter().filter(|local| is_seen(local.from, local.to)) {
            // Registers behind the last that is not nil are not kept.
            let register = frame.base as usize + usize::from(local.register);
            let value = match registers.get(register).copied().unwrap_or_default() {
                Value::Cell(cell) => self.heap.cells[cell],
                value => value,
            };
            seen.retain(|&(name, _)| name != local.name);
            seen.push((local.name, value));
        }
        seen
    }
}

impl<O: Outside> System<O> {
    /// Runs the first ready task up to the next form that calls, waits, assigns or opens a
    /// construct, at most for a slice; does not enter networks. [`System::step_task`] goes on from there in one go.
    pub fn step_form(&mut self) -> Stepped {
        self.step(false)
    }

    /// The same, up to the next instruction.
    pub(crate) fn step_instruction(&mut self) -> Stepped {
        self.step(true)
    }

    fn step(&mut self, is_fine: bool) -> Stepped {
        self.machine.scratch.stepping.is_fine = is_fine;
        self.machine.scratch.stepping.is_on = true;
        self.machine.scratch.stepping.has_stopped = false;
        let turn = self.step_slice();
        let stepping = &mut self.machine.scratch.stepping;
        stepping.is_on = false;
        match (stepping.stopped, turn) {
            (Some((task, frame)), _) if stepping.has_stopped => {
                self.stop_at(task, frame).map_or(Stepped::Ran, Stepped::Before)
            }
            (_, Turn::Over | Turn::Cut) => Stepped::Ran,
            (_, Turn::Idle) => Stepped::Settled,
        }
    }

    /// From now on the value of the form that a task stands before is looked out for.
    pub fn want_value(&mut self, stop: &Stop) {
        let op = self.program.codes.get(stop.frame.code as usize).and_then(|code| code.ops.get(stop.frame.pc as usize));
        let register = op.and_then(Op::value_register).filter(|&register| register != NO_REG);
        let after = Frame { pc: stop.frame.pc + 1, ..stop.frame };
        let stepping = &mut self.machine.scratch.stepping;
        stepping.found = None;
        stepping.wanted = register.map(|register| (stop.task, after, register));
    }

    /// The value that was wanted, as it could be read, once the stepper has come past its form.
    pub fn wanted_value(&mut self) -> Option<String> {
        self.machine.scratch.stepping.found.take()
    }

    fn stop_at(&self, task: TaskRef, frame: Frame) -> Option<Stop> {
        let record = &self.machine.tasks[self.machine.tasks.find_alive(task)?];
        let code = self.program.codes.get(frame.code as usize)?;
        let first_step = code.ops.iter().position(Op::is_step);
        Some(Stop {
            task,
            span: *code.spans.get(frame.pc as usize)?,
            name: code.name,
            body: code.span,
            is_entry: first_step == Some(frame.pc as usize),
            depth: record.frames.len() as u32,
            frame,
        })
    }
}
