//! Stepping: a run looked at before each form that calls, waits, assigns or opens a construct.
//!
//! Stepping changes nothing: a run that is stepped through has the same trace as one that is not,
//! unless it comes close to the limit of memory.
//!
//! The stepper is the interpreter loop, compiled a second time with a look before each of these instructions.

use crate::robot::Outside;
use crate::run::system::{System, Turn};
use crate::state::task::Frame;
use crate::state::value::TaskRef;
use rpl_lang::code::{NO_REG, Op};
use rpl_lang::source::Span;
use rpl_lang::symbol::Symbol;

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
