//! Functions: their parameters, their body, the code they become.

use super::emitter::{Emitter, MAX_REGISTERS};
use crate::code::{ARRANGES, Atom, Code, CodeKind, Local, NO_REG, Op, PLAIN_REGISTERS, Reg, SlotAccess, are_plain};
use crate::compile::compiler::Compiler;
use crate::compile::ir::{Function, ParameterBinding, VarId};
use std::collections::BTreeMap;

/// Emits a function and adds it to the program. `outer` gives the registers of the variables of
/// the function around it, in which captured values are found.
pub(in crate::compile) fn emit(compiler: &mut Compiler<'_>, function: &Function, outer: &[(VarId, Reg)]) -> u32 {
    let captures = function
        .captures
        .iter()
        .map(|capture| outer.iter().find(|(variable, _)| variable == capture).map_or(NO_REG, |&(_, reg)| reg))
        .collect();
    let mut emitter = Emitter {
        compiler,
        ops: Vec::new(),
        spans: Vec::new(),
        span: function.span,
        registers: BTreeMap::new(),
        next: 0,
        most: 0,
        blocks: Vec::new(),
        scopes: 0,
        constructs: Vec::new(),
        handlers: Vec::new(),
        locals: Vec::new(),
        open_locals: Vec::new(),
        kind: function.kind,
        literals: BTreeMap::new(),
    };
    emitter.function(function);
    let Emitter { mut ops, spans, most, constructs, handlers, locals, compiler, .. } = emitter;
    // What was expanded too deep has been told, and leaves forms in forms behind.
    if most > MAX_REGISTERS && !compiler.expansion.is_over {
        let name = compiler.symbols.name(function.name).to_string();
        let message = format!("`{name}` needs {most} registers, and {MAX_REGISTERS} is the most");
        compiler.error("too-large", function.span, message, "too many variables or arguments at once").help =
            Some("split it into smaller functions or plans".into());
    }
    join_counts(&mut ops);
    let end = ops.len() as u32;
    let exact_count = function.parameters.exact_count();
    let slot = SlotAccess::of(&ops, &compiler.program.constants)
        .filter(|slot| exact_count == if slot.assigns { 2 } else { 1 });
    let code = Code {
        name: function.name,
        kind: function.kind,
        exact_count,
        framed_count: if slot.is_some() { ARRANGES } else { exact_count },
        slot,
        is_plain: function.kind == CodeKind::Network && most <= PLAIN_REGISTERS && are_plain(&ops),
        parameters: function.parameters.clone(),
        registers: most.min(255) as u8,
        captures,
        ops,
        spans,
        constructs,
        handlers,
        locals: locals.into_iter().map(|local| Local { to: local.to.min(end), ..local }).collect(),
        doc: function.doc.clone(),
        span: function.span,
    };
    compiler.add_code(code)
}

/// Lets counters jump back themselves where the test of a loop follows. That stays, for what jumps to it and for the end.
fn join_counts(ops: &mut [Op]) {
    for at in 1..ops.len() {
        let Op::AddInt(counter, from, 1) = ops[at - 1] else { continue };
        ops[at - 1] = match ops[at] {
            Op::JumpIfLess(tested, end, to) if (from, tested) == (counter, counter) => Op::Count(counter, end, to + 1),
            Op::JumpIfLessInt(tested, end, to) if (from, tested) == (counter, counter) => {
                Op::CountInt(counter, end, to + 1)
            }
            _ => continue,
        };
    }
}

impl Emitter<'_, '_> {
    fn function(&mut self, function: &Function) {
        for binding in &function.bindings {
            let reg = self.fresh();
            self.place(binding.variable, reg);
        }
        for &capture in &function.captures {
            let reg = self.fresh();
            self.place(capture, reg);
        }
        if self.kind == CodeKind::Plan {
            self.push(Op::EnterPlan);
            self.scopes += 1;
        }
        for &(name, tag) in &function.tags {
            let reg = self.fresh();
            let constant = self.compiler.constant(Atom::Symbol(name));
            self.push(Op::TagNew(reg, constant));
            self.place(tag, reg);
            self.put_in_cell(tag, reg);
        }
        for binding in &function.bindings {
            let reg = self.registers[&binding.variable];
            if binding.omissible {
                self.default_value(binding, reg);
            }
            self.put_in_cell(binding.variable, reg);
            self.bind(&binding.parts);
        }
        let result = self.fresh();
        let tail = self.scopes == 0;
        self.value(&function.body, result, tail);
        if self.kind == CodeKind::Plan {
            self.push(Op::LeavePlan(result));
        }
        self.push(Op::Return(result));
    }

    fn default_value(&mut self, binding: &ParameterBinding, reg: Reg) {
        let given = binding.given.map(|given| {
            let flag = self.fresh();
            self.place(given, flag);
            self.push(Op::True(flag));
            flag
        });
        let jump = self.push(Op::JumpIfGiven(reg, 0));
        match &binding.default {
            Some(default) => self.value(default, reg, false),
            None => drop(self.push(Op::Nil(reg))),
        }
        if let Some(flag) = given {
            self.push(Op::Nil(flag));
        }
        self.land(jump);
    }

    /// Emits a function inside this one.
    pub(super) fn inner(&mut self, function: &Function) -> u32 {
        let outer: Vec<(VarId, Reg)> = self.registers.iter().map(|(&variable, &reg)| (variable, reg)).collect();
        emit(self.compiler, function, &outer)
    }
}
