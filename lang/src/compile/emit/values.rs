//! Forms and their values: each form leaves its value in a register that is given.

use super::emitter::Emitter;
use super::value_facts::{Literal, has_no_code, has_no_effect, writes_once};
use crate::code::{Atom, NO_REG, Op, Reg};
use crate::compile::ir::{Callee, Ir, IrKind, Unary, VarId};
use crate::stack::deep;
use std::collections::BTreeSet;

impl Emitter<'_, '_> {
    /// Emits code that leaves the form's value in `into`.
    pub(super) fn value(&mut self, ir: &Ir, into: Reg, tail: bool) {
        let outer = std::mem::replace(&mut self.span, ir.span);
        deep(|| self.temporarily(|emitter| emitter.value_here(ir, into, tail)));
        self.span = outer;
    }

    fn value_here(&mut self, ir: &Ir, into: Reg, tail: bool) {
        match &ir.kind {
            IrKind::Nil => drop(self.push(Op::Nil(into))),
            IrKind::True => drop(self.push(Op::True(into))),
            IrKind::Int(value) => self.integer(*value, into),
            IrKind::Const(constant) => drop(self.push(Op::Const(into, *constant))),
            IrKind::Local(variable) => self.local(*variable, into),
            IrKind::Global(global) => drop(self.push(Op::Global(into, *global))),
            IrKind::SetLocal(variable, value) => self.set_local(*variable, value, into),
            IrKind::SetGlobal(global, value) => {
                self.value(value, into, false);
                self.push(Op::SetGlobal(into, *global));
            }
            IrKind::DefFluent(global, value) => {
                self.value(value, into, false);
                self.push(Op::DefFluent(into, *global));
            }
            IrKind::If(condition, then, otherwise) => self.conditional(condition, then, otherwise, into, tail),
            IrKind::And(items) => self.and(items, into, tail),
            IrKind::Or(items) => self.or(items, into, tail),
            IrKind::Seq(items) => self.sequence(items, into, tail),
            IrKind::Let(bindings, body) => self.let_form(bindings, body, into, tail),
            IrKind::Lambda(function) => {
                let code = self.inner(function);
                self.push(Op::Closure(into, code));
            }
            IrKind::Call(callee, arguments) => self.call(callee, arguments, into, tail),
            IrKind::Binary(operation, left, right) => self.binary(*operation, left, right, into, tail),
            IrKind::Unary(operation, operand) => {
                let operand = self.operand(operand, &[]);
                self.push(match operation {
                    Unary::Not => Op::Not(into, operand),
                    Unary::Car => Op::Car(into, operand),
                    Unary::Cdr => Op::Cdr(into, operand),
                    Unary::Deref => Op::Deref(into, operand),
                });
            }
            IrKind::Block { id, token, body } => self.block(*id, *token, body, into),
            IrKind::Leave(block, value) => self.leave(*block, value),
            IrKind::LeaveDynamic(token, value) => {
                let identity = self.fresh();
                self.local(*token, identity);
                self.value(value, into, false);
                self.push(Op::ReturnFrom(identity, into));
            }
            IrKind::Loop(body) => self.loop_form(body),
            IrKind::Construct(construct) => {
                let index = self.construct(construct);
                self.push(Op::Parallel(into, index));
            }
            IrKind::ConstructMap(construct, list) => {
                let list_reg = self.fresh();
                self.value(list, list_reg, false);
                let index = self.construct(construct);
                self.push(Op::ParallelMap(into, list_reg, index));
            }
            IrKind::Spawn(construct) => {
                let index = self.construct(construct);
                self.push(Op::Spawn(into, index));
            }
            IrKind::Handler { body, failure, clauses } => self.handler(body, *failure, clauses, into),
            IrKind::Refail(failure) => {
                let reg = self.fresh();
                self.local(*failure, reg);
                self.push(Op::Refail(reg));
            }
            IrKind::Cleanup { always, body, cleanup } => self.cleanup(*always, body, cleanup, into),
            IrKind::Scope(scope, body) => self.scope(scope, body, into),
            IrKind::Network(function) => {
                let code = self.inner(function);
                self.push(Op::Network(into, code));
            }
            IrKind::WaitFor { fluent, timeout, owned } => {
                let condition = self.fresh();
                self.value(fluent, condition, false);
                let seconds = match timeout {
                    Some(timeout) => {
                        let seconds = self.fresh();
                        self.value(timeout, seconds, false);
                        seconds
                    }
                    None => NO_REG,
                };
                self.push(Op::WaitFor(into, condition, seconds, *owned));
            }
            IrKind::Whenever { fluent, missed, owned, body } => {
                let condition = self.fresh();
                self.value(fluent, condition, false);
                self.push(Op::PushWatch(condition, *missed, *owned));
                self.scopes += 1;
                let start = self.ops.len();
                self.push(Op::WatchWait);
                self.value(body, into, false);
                self.push(Op::WatchDone);
                self.jump_back(start);
                self.scopes -= 1;
            }
        }
    }

    fn integer(&mut self, value: i64, into: Reg) {
        match i32::try_from(value) {
            Ok(value) => drop(self.push(Op::Int(into, value))),
            Err(_) => {
                let constant = self.compiler.constant(Atom::Int(value));
                self.push(Op::Const(into, constant));
            }
        }
    }

    pub(super) fn literal(&mut self, literal: Literal, into: Reg) {
        match literal {
            Literal::Int(value) => self.integer(value, into),
            Literal::Const(constant) => drop(self.push(Op::Const(into, constant))),
        }
    }

    pub(super) fn local(&mut self, variable: VarId, into: Reg) {
        let reg = self.registers.get(&variable).copied().unwrap_or(NO_REG);
        if self.compiler.variables[variable.0 as usize].in_cell() {
            self.push(Op::CellGet(into, reg));
        } else if reg != into {
            self.push(Op::Move(into, reg));
        }
    }

    fn set_local(&mut self, variable: VarId, value: &Ir, into: Reg) {
        let reg = self.registers.get(&variable).copied().unwrap_or(NO_REG);
        if self.compiler.variables[variable.0 as usize].in_cell() {
            self.value(value, into, false);
            self.push(Op::CellSet(reg, into));
        } else {
            self.assign(variable, value);
            self.take(reg, into);
        }
    }

    /// Assigns a variable that lives in a register.
    pub(super) fn assign(&mut self, variable: VarId, value: &Ir) {
        let reg = self.registers.get(&variable).copied().unwrap_or(NO_REG);
        if writes_once(value) {
            self.value(value, reg, false);
        } else {
            // The value may read the variable after a part of it has been written.
            let fresh = self.fresh();
            self.value(value, fresh, false);
            self.push(Op::Move(reg, fresh));
        }
    }

    /// A register that holds the form's value; a variable's own register where nothing evaluated
    /// after it (`later`) can change it.
    pub(super) fn operand(&mut self, ir: &Ir, later: &[&Ir]) -> Reg {
        self.own_register(ir, later.iter().copied()).unwrap_or_else(|| self.kept(ir))
    }

    /// The register of a variable, if the form is one and nothing evaluated after it (`later`) can change it; or of a
    /// constant that has one.
    pub(super) fn own_register<'i>(&self, ir: &Ir, mut later: impl Iterator<Item = &'i Ir>) -> Option<Reg> {
        if let Some(literal) = Literal::of(ir) {
            return self.literals.get(&literal).copied();
        }
        let IrKind::Local(variable) = ir.kind else { return None };
        let variable_info = &self.compiler.variables[variable.0 as usize];
        let is_stable = !variable_info.assigned || later.all(has_no_effect);
        (!variable_info.in_cell() && is_stable).then(|| self.registers.get(&variable).copied().unwrap_or(NO_REG))
    }

    /// A fresh register that holds the form's value.
    pub(super) fn kept(&mut self, ir: &Ir) -> Reg {
        let reg = self.fresh();
        self.value(ir, reg, false);
        reg
    }

    /// Emits a form whose value nobody wants.
    pub(super) fn effect(&mut self, ir: &Ir) {
        let outer = std::mem::replace(&mut self.span, ir.span);
        deep(|| self.temporarily(|emitter| emitter.effect_here(ir)));
        self.span = outer;
    }

    fn effect_here(&mut self, ir: &Ir) {
        match &ir.kind {
            IrKind::Nil | IrKind::True | IrKind::Int(_) | IrKind::Const(_) | IrKind::Local(_) => {}
            IrKind::Seq(items) => items.iter().for_each(|item| self.effect(item)),
            IrKind::Let(bindings, body) => {
                self.bind(bindings);
                self.effect(body);
            }
            IrKind::If(condition, then, otherwise) => {
                let skips = self.jump_unless(condition);
                self.effect(then);
                let exit = if has_no_code(otherwise) { None } else { Some(self.push(Op::Jump(0))) };
                for skip in skips {
                    self.land(skip);
                }
                self.effect(otherwise);
                exit.into_iter().for_each(|exit| self.land(exit));
            }
            IrKind::SetLocal(variable, value) if !self.compiler.variables[variable.0 as usize].in_cell() => {
                self.assign(*variable, value);
            }
            IrKind::Loop(body) => self.loop_form(body),
            IrKind::Call(Callee::Native(native), arguments) if self.store(*native, arguments).is_some() => {}
            _ => {
                let unused = self.fresh();
                self.value(ir, unused, false);
            }
        }
    }

    pub(super) fn sequence(&mut self, items: &[Ir], into: Reg, tail: bool) {
        let Some((last, before)) = items.split_last() else {
            self.push(Op::Nil(into));
            return;
        };
        for item in before {
            self.effect(item);
        }
        self.value(last, into, tail);
    }

    pub(super) fn let_form(&mut self, bindings: &[(VarId, Ir)], body: &Ir, into: Reg, tail: bool) {
        self.bind(bindings);
        self.value(body, into, tail);
    }

    pub(super) fn bind(&mut self, bindings: &[(VarId, Ir)]) {
        if may_call_later_ones(bindings) {
            return self.bind_functions(bindings);
        }
        for (variable, value) in bindings {
            let reg = self.fresh();
            self.value(value, reg, false);
            self.place(*variable, reg);
            self.put_in_cell(*variable, reg);
        }
    }

    /// Binds functions that capture one another: each is given those that are made after it when all are made.
    fn bind_functions(&mut self, functions: &[(VarId, Ir)]) {
        for (variable, _) in functions {
            let reg = self.fresh();
            self.place(*variable, reg);
        }
        let mut missing = Vec::new();
        let mut made = BTreeSet::new();
        for (variable, value) in functions {
            let reg = self.registers[variable];
            self.value(value, reg, false);
            if let IrKind::Lambda(function) = &value.kind {
                let captures = function.captures.iter().enumerate();
                let later = captures.filter(|(_, captured)| !made.contains(*captured));
                missing.extend(later.map(|(position, captured)| (*variable, position, *captured)));
            }
            made.insert(*variable);
        }
        let span = self.span;
        let of = |kind| Ir { span, kind };
        for (function, position, captured) in missing {
            if made.contains(&captured) {
                let position = IrKind::Int(position as i64);
                let arguments = vec![of(IrKind::Local(function)), of(position), of(IrKind::Local(captured))];
                let call = self.compiler.native_ir("%close-over", arguments, span);
                self.effect(&call);
            }
        }
    }
}

/// Whether a function among the values captures its own variable, or that of a later one: `letrec` has such.
fn may_call_later_ones(bindings: &[(VarId, Ir)]) -> bool {
    let is_function = |(_, value): &(VarId, Ir)| matches!(value.kind, IrKind::Lambda(_));
    if !bindings.iter().any(is_function) {
        return false;
    }
    let mut later: BTreeSet<VarId> = bindings.iter().map(|(variable, _)| *variable).collect();
    bindings.iter().any(|(variable, value)| {
        let captures = match &value.kind {
            IrKind::Lambda(function) => function.captures.as_slice(),
            _ => &[],
        };
        let found = captures.iter().any(|captured| later.contains(captured));
        later.remove(variable);
        found
    })
}
