//! Variables that a task sees where it stands.

use crate::state::machine::Machine;
use crate::state::task::Frame;
use crate::state::value::Value;
use rpl_lang::code::{Code, Local, Program};
use rpl_lang::source::Span;
use rpl_lang::symbol::Symbol;

/// A call that has not returned.
#[derive(Clone, Debug)]
pub struct StandingCall {
    /// The name of the function, plan or task body.
    pub name: Symbol,
    /// The form in it that comes next, or waits.
    pub span: Span,
    /// The variables of the text that are seen there.
    pub variables: Vec<(Symbol, Value)>,
}

impl Machine {
    /// The calls that a task stands in, innermost first. Cost: the depth of the calls.
    pub fn calls(&self, program: &Program, task: u32) -> Vec<StandingCall> {
        let Some(record) = self.tasks.get(task) else { return Vec::new() };
        let frames = std::iter::once(&record.frame).chain(record.frames.iter().rev());
        let calls = frames.filter_map(|frame| {
            let code = program.codes.get(frame.code as usize)?;
            // A call that waits for another stands behind it.
            let span = *code.spans.get((frame.pc as usize).saturating_sub(1))?;
            let variables = self.frame_variables(code, self.tasks.registers_of(task), frame);
            Some(StandingCall { name: code.name, span, variables })
        });
        calls.collect()
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
