//! Resolved forms to register code. Registers are given out like a stack: parameters, captured
//! values, variables and temporaries in the order of their nesting.

use super::Compiler;
use super::ir::{Binary, BlockId, Callee, ConstructIr, Function, Ir, IrKind, ScopeIr, Unary, VarId};
use crate::code::{Atom, Child, Code, CodeKind, Construct, Local, NO_REG, Op, Parameters, Reg};
use crate::source::Span;
use crate::stack::deep;
use crate::symbol::Symbol;
use std::collections::BTreeMap;

/// Registers a function can have; two are kept free for calls at the edge of the window.
const MAX_REGISTERS: usize = 250;

/// Emits a function and adds it to the program. `outer` gives the registers of the variables of
/// the function around it, in which captured values are found.
pub(super) fn emit(compiler: &mut Compiler<'_>, function: &Function, outer: &[(VarId, Reg)]) -> u32 {
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
        is_plan: function.kind == CodeKind::Plan,
    };
    emitter.function(function);
    let Emitter { ops, spans, most, constructs, handlers, locals, compiler, .. } = emitter;
    if most > MAX_REGISTERS {
        let name = compiler.symbols.name(function.name).to_string();
        let message = format!("`{name}` needs {most} registers, and {MAX_REGISTERS} is the most");
        compiler.error("too-large", function.span, message, "too many variables or arguments at once").help =
            Some("split it into smaller functions or plans".into());
    }
    let end = ops.len() as u32;
    let code = Code {
        name: function.name,
        kind: function.kind,
        exact_count: function.parameters.exact_count(),
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

/// Code that runs codes without parameters one after the other, with the last one's value or a
/// constant's.
pub(super) fn sequence(name: Symbol, span: Span, calls: &[(u32, Span)], value: Option<u32>) -> Code {
    let mut ops = vec![Op::Nil(0)];
    let mut spans = vec![span];
    for &(code, place) in calls {
        ops.push(Op::CallCode(0, code));
        spans.push(place);
    }
    if let Some(constant) = value {
        ops.push(Op::Const(0, constant));
        spans.push(span);
    }
    ops.push(Op::Return(0));
    spans.push(span);
    Code {
        name,
        kind: CodeKind::Task,
        exact_count: 0,
        parameters: Parameters::default(),
        registers: 1,
        captures: Vec::new(),
        ops,
        spans,
        constructs: Vec::new(),
        handlers: Vec::new(),
        locals: Vec::new(),
        doc: None,
        span,
    }
}

struct BlockState {
    id: BlockId,
    result: Reg,
    scopes: usize,
    /// Jumps to the block's end that wait for its place.
    exits: Vec<usize>,
}

struct Emitter<'c, 'a> {
    compiler: &'c mut Compiler<'a>,
    ops: Vec<Op>,
    spans: Vec<Span>,
    span: Span,
    registers: BTreeMap<VarId, Reg>,
    next: usize,
    most: usize,
    blocks: Vec<BlockState>,
    /// Scopes this function has open at this place.
    scopes: usize,
    constructs: Vec<Construct>,
    handlers: Vec<Vec<Vec<Symbol>>>,
    locals: Vec<Local>,
    is_plan: bool,
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
        if self.is_plan {
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
        }
        let result = self.fresh();
        let tail = self.scopes == 0;
        self.value(&function.body, result, tail);
        self.push(if self.is_plan { Op::LeavePlan(result) } else { Op::Nil(NO_REG) });
        if !self.is_plan {
            self.ops.pop();
            self.spans.pop();
        }
        self.push(Op::Return(result));
    }

    fn default_value(&mut self, binding: &super::ir::ParameterBinding, reg: Reg) {
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

    /// Gives a variable its register. Its value is there from the next instruction on.
    fn place(&mut self, variable: VarId, register: Reg) {
        self.registers.insert(variable, register);
        let name = self.compiler.variables[variable.0 as usize].name;
        // What macros bind for themselves is no variable of the text.
        if !self.compiler.symbols.name(name).starts_with(['%', '#']) {
            self.locals.push(Local { name, register, from: self.ops.len() as u32, to: u32::MAX });
        }
    }

    fn put_in_cell(&mut self, variable: VarId, reg: Reg) {
        if self.compiler.variables[variable.0 as usize].in_cell() {
            self.push(Op::CellNew(reg, reg));
        }
    }

    fn push(&mut self, op: Op) -> usize {
        self.ops.push(op);
        self.spans.push(self.span);
        self.ops.len() - 1
    }

    fn fresh(&mut self) -> Reg {
        let reg = self.next;
        self.next += 1;
        self.most = self.most.max(self.next + 1);
        reg.min(MAX_REGISTERS) as Reg
    }

    /// Runs `inside` and gives its temporaries back.
    fn temporarily<T>(&mut self, inside: impl FnOnce(&mut Self) -> T) -> T {
        let before = self.next;
        let result = inside(self);
        self.next = before;
        let end = self.ops.len() as u32;
        let ended = self.locals.iter_mut().filter(|local| usize::from(local.register) >= before);
        ended.filter(|local| local.to == u32::MAX).for_each(|local| local.to = end);
        result
    }

    /// Points the jump at this index to the next instruction.
    fn land(&mut self, jump: usize) {
        let distance = (self.ops.len() - jump - 1) as i32;
        self.set_distance(jump, distance);
    }

    fn set_distance(&mut self, jump: usize, distance: i32) {
        match &mut self.ops[jump] {
            Op::Jump(to)
            | Op::JumpIfNil(_, to)
            | Op::JumpIfTrue(_, to)
            | Op::JumpIfGiven(_, to)
            | Op::JumpUnlessLess(_, _, to)
            | Op::JumpUnlessLessEq(_, _, to)
            | Op::JumpUnlessNumEq(_, _, to)
            | Op::JumpUnlessLessInt(_, _, to)
            | Op::JumpUnlessLessEqInt(_, _, to)
            | Op::JumpUnlessGreaterInt(_, _, to)
            | Op::JumpUnlessGreaterEqInt(_, _, to)
            | Op::JumpUnlessNumEqInt(_, _, to)
            | Op::PushBlock(_, _, to)
            | Op::PushHandler(_, _, to)
            | Op::PushCleanup(to)
            | Op::LeaveScopes(_, to) => *to = distance,
            other => unreachable!("{other:?} is no jump"),
        }
    }

    fn jump_back(&mut self, target: usize) {
        let distance = target as i32 - self.ops.len() as i32 - 1;
        self.push(Op::Jump(distance));
    }

    /// Emits code that leaves the form's value in `into`.
    fn value(&mut self, ir: &Ir, into: Reg, tail: bool) {
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
            IrKind::And(items) => self.and_or(items, into, tail, true),
            IrKind::Or(items) => self.and_or(items, into, tail, false),
            IrKind::Seq(items) => self.sequence(items, into, tail),
            IrKind::Let(bindings, body) => self.let_form(bindings, body, into, tail),
            IrKind::Lambda(function) => {
                let code = self.inner(function);
                self.push(Op::Closure(into, code));
            }
            IrKind::Call(callee, arguments) => self.call(callee, arguments, into, tail),
            IrKind::Binary(operation, left, right) => self.binary(*operation, left, right, into),
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

    fn local(&mut self, variable: VarId, into: Reg) {
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
    fn assign(&mut self, variable: VarId, value: &Ir) {
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
    fn operand(&mut self, ir: &Ir, later: &[&Ir]) -> Reg {
        if let IrKind::Local(variable) = ir.kind {
            let variable_info = &self.compiler.variables[variable.0 as usize];
            let is_stable = !variable_info.assigned || later.iter().all(|ir| has_no_effect(ir));
            if !variable_info.in_cell() && is_stable {
                return self.registers.get(&variable).copied().unwrap_or(NO_REG);
            }
        }
        let reg = self.fresh();
        self.value(ir, reg, false);
        reg
    }

    fn binary(&mut self, operation: Binary, left: &Ir, right: &Ir, into: Reg) {
        let immediate = |ir: &Ir| match ir.kind {
            IrKind::Int(value) => i16::try_from(value).ok().filter(|value| *value != i16::MIN),
            _ => None,
        };
        match (operation, immediate(left), immediate(right)) {
            (Binary::Add, _, Some(value)) => {
                let left = self.operand(left, &[]);
                self.push(Op::AddInt(into, left, value));
                return;
            }
            (Binary::Add, Some(value), _) => {
                let right = self.operand(right, &[]);
                self.push(Op::AddInt(into, right, value));
                return;
            }
            (Binary::Sub, _, Some(value)) => {
                let left = self.operand(left, &[]);
                self.push(Op::AddInt(into, left, -value));
                return;
            }
            _ => {}
        }
        let left_reg = self.operand(left, &[right]);
        let right_reg = self.operand(right, &[]);
        self.push(match operation {
            Binary::Add => Op::Add(into, left_reg, right_reg),
            Binary::Sub => Op::Sub(into, left_reg, right_reg),
            Binary::Mul => Op::Mul(into, left_reg, right_reg),
            Binary::Less => Op::Less(into, left_reg, right_reg),
            Binary::LessEq => Op::LessEq(into, left_reg, right_reg),
            Binary::NumEq => Op::NumEq(into, left_reg, right_reg),
            Binary::Eq => Op::Eq(into, left_reg, right_reg),
            Binary::Cons => Op::Cons(into, left_reg, right_reg),
        });
    }

    /// Emits a jump that is taken when the condition is nil; gives the jumps to land.
    fn jump_unless(&mut self, condition: &Ir) -> Vec<usize> {
        let outer = std::mem::replace(&mut self.span, condition.span);
        let jumps = deep(|| self.temporarily(|emitter| emitter.jump_unless_here(condition)));
        self.span = outer;
        jumps
    }

    fn jump_unless_here(&mut self, condition: &Ir) -> Vec<usize> {
        match &condition.kind {
            IrKind::And(items) => items.iter().flat_map(|item| self.jump_unless(item)).collect(),
            IrKind::Unary(Unary::Not, inner) => {
                let reg = self.operand(inner, &[]);
                vec![self.push(Op::JumpIfTrue(reg, 0))]
            }
            IrKind::Binary(operation @ (Binary::Less | Binary::LessEq | Binary::NumEq), left, right) => {
                vec![self.compare_and_jump(*operation, left, right)]
            }
            _ => {
                let reg = self.operand(condition, &[]);
                vec![self.push(Op::JumpIfNil(reg, 0))]
            }
        }
    }

    fn compare_and_jump(&mut self, operation: Binary, left: &Ir, right: &Ir) -> usize {
        let immediate = |ir: &Ir| match ir.kind {
            IrKind::Int(value) => i16::try_from(value).ok(),
            _ => None,
        };
        if let Some(value) = immediate(right) {
            let left = self.operand(left, &[]);
            return self.push(match operation {
                Binary::Less => Op::JumpUnlessLessInt(left, value, 0),
                Binary::LessEq => Op::JumpUnlessLessEqInt(left, value, 0),
                _ => Op::JumpUnlessNumEqInt(left, value, 0),
            });
        }
        if let Some(value) = immediate(left) {
            let right = self.operand(right, &[]);
            return self.push(match operation {
                Binary::Less => Op::JumpUnlessGreaterInt(right, value, 0),
                Binary::LessEq => Op::JumpUnlessGreaterEqInt(right, value, 0),
                _ => Op::JumpUnlessNumEqInt(right, value, 0),
            });
        }
        let left_reg = self.operand(left, &[right]);
        let right_reg = self.operand(right, &[]);
        self.push(match operation {
            Binary::Less => Op::JumpUnlessLess(left_reg, right_reg, 0),
            Binary::LessEq => Op::JumpUnlessLessEq(left_reg, right_reg, 0),
            _ => Op::JumpUnlessNumEq(left_reg, right_reg, 0),
        })
    }

    fn conditional(&mut self, condition: &Ir, then: &Ir, otherwise: &Ir, into: Reg, tail: bool) {
        let skips = self.jump_unless(condition);
        if tail {
            self.returned(then, into);
            for skip in skips {
                self.land(skip);
            }
            self.value(otherwise, into, true);
            return;
        }
        self.value(then, into, false);
        let exit = self.push(Op::Jump(0));
        for skip in skips {
            self.land(skip);
        }
        self.value(otherwise, into, false);
        self.land(exit);
    }

    /// Emits a form whose value ends the function.
    fn returned(&mut self, ir: &Ir, into: Reg) {
        let mut from = into;
        match ir.kind {
            IrKind::Local(variable) if !self.compiler.variables[variable.0 as usize].in_cell() => {
                from = self.registers.get(&variable).copied().unwrap_or(NO_REG);
            }
            _ => self.value(ir, into, true),
        }
        self.push(Op::Return(from));
    }

    /// Emits a form whose value nobody wants.
    fn effect(&mut self, ir: &Ir) {
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
            _ => {
                let unused = self.fresh();
                self.value(ir, unused, false);
            }
        }
    }

    /// Emits an endless loop. What leaves it at a condition stands behind it, out of the way.
    fn loop_form(&mut self, body: &Ir) {
        let items = match &body.kind {
            IrKind::Seq(items) => items.as_slice(),
            _ => std::slice::from_ref(body),
        };
        let mut exits = Vec::new();
        let start = self.ops.len();
        for item in items {
            match &item.kind {
                IrKind::If(condition, then, otherwise)
                    if has_no_code(then) && matches!(otherwise.kind, IrKind::Leave(..)) =>
                {
                    exits.push((self.jump_unless(condition), otherwise));
                }
                _ => self.effect(item),
            }
        }
        self.jump_back(start);
        for (skips, leave) in exits {
            for skip in skips {
                self.land(skip);
            }
            self.effect(leave);
        }
    }

    fn and_or(&mut self, items: &[Ir], into: Reg, tail: bool, and: bool) {
        let mut exits = Vec::new();
        for (index, item) in items.iter().enumerate() {
            let last = index + 1 == items.len();
            self.value(item, into, tail && last);
            if !last {
                exits.push(self.push(if and { Op::JumpIfNil(into, 0) } else { Op::JumpIfTrue(into, 0) }));
            }
        }
        for exit in exits {
            self.land(exit);
        }
    }

    fn sequence(&mut self, items: &[Ir], into: Reg, tail: bool) {
        let Some((last, before)) = items.split_last() else {
            self.push(Op::Nil(into));
            return;
        };
        for item in before {
            self.effect(item);
        }
        self.value(last, into, tail);
    }

    fn let_form(&mut self, bindings: &[(VarId, Ir)], body: &Ir, into: Reg, tail: bool) {
        self.bind(bindings);
        self.value(body, into, tail);
    }

    fn bind(&mut self, bindings: &[(VarId, Ir)]) {
        for (variable, value) in bindings {
            let reg = self.fresh();
            self.value(value, reg, false);
            self.place(*variable, reg);
            self.put_in_cell(*variable, reg);
        }
    }

    /// Emits a function inside this one.
    fn inner(&mut self, function: &Function) -> u32 {
        let outer: Vec<(VarId, Reg)> = self.registers.iter().map(|(&variable, &reg)| (variable, reg)).collect();
        emit(self.compiler, function, &outer)
    }

    /// Puts arguments into registers in a row and gives the first: `into` itself, if that is the
    /// topmost register and no variable's.
    fn arguments_from(&mut self, arguments: &[Ir], into: Reg) -> Reg {
        let is_free = usize::from(into) + 1 == self.next && !self.registers.values().any(|&reg| reg == into);
        match arguments.split_first() {
            Some((first, rest)) if is_free => {
                self.value(first, into, false);
                if !rest.is_empty() {
                    self.arguments(rest);
                }
                into
            }
            None if is_free => into,
            _ => self.arguments(arguments),
        }
    }

    /// Puts arguments into fresh registers in a row and gives the first.
    fn arguments(&mut self, arguments: &[Ir]) -> Reg {
        let first = self.next;
        for argument in arguments {
            let reg = self.fresh();
            self.value(argument, reg, false);
        }
        if arguments.is_empty() {
            self.fresh();
        }
        first.min(MAX_REGISTERS) as Reg
    }

    fn call(&mut self, callee: &Callee, arguments: &[Ir], into: Reg, tail: bool) {
        if arguments.len() > MAX_REGISTERS {
            let count = arguments.len();
            let span = self.span;
            self.compiler
                .error(
                    "too-large",
                    span,
                    format!("this call has {count} arguments, and {MAX_REGISTERS} is the most"),
                    "too many",
                )
                .help = Some("pass a list: `(apply f list)`".into());
            return;
        }
        let count = arguments.len() as u8;
        match callee {
            Callee::Native(native) if self.compiler.natives[usize::from(*native)].name == "%set-value" => {
                let [fluent, value] = arguments else { return };
                let fluent_reg = self.operand(fluent, &[value]);
                let value_reg = self.operand(value, &[]);
                self.push(Op::Assign(into, fluent_reg, value_reg));
            }
            Callee::Native(native) => {
                let first = self.arguments(arguments);
                if self.compiler.natives[usize::from(*native)].calls {
                    self.push(Op::CallNative(first, first, count, *native));
                    self.take(first, into);
                } else {
                    self.push(Op::CallNative(into, first, count, *native));
                }
            }
            Callee::Global(global) => {
                let first = self.arguments_from(arguments, into);
                if tail {
                    self.push(Op::TailCall(first, count, *global));
                } else {
                    self.push(Op::Call(first, count, *global));
                }
                // Also behind a tail call: what turns out to be no function of the plan's own
                // comes back.
                self.take(first, into);
            }
            Callee::Value(function) => {
                let function_reg = self.fresh();
                self.value(function, function_reg, false);
                let first = self.arguments(arguments);
                if tail {
                    self.push(Op::TailCallValue(function_reg, count));
                } else {
                    self.push(Op::CallValue(function_reg, count));
                }
                self.take(first, into);
            }
        }
    }

    fn take(&mut self, from: Reg, into: Reg) {
        if from != into {
            self.push(Op::Move(into, from));
        }
    }

    fn block(&mut self, id: BlockId, token: Option<VarId>, body: &Ir, into: Reg) {
        // Jumps out of the block carry their value in a register of its own: `into` may be read
        // by the body.
        let result = self.fresh();
        let dynamic = token.map(|token| {
            let identity = self.fresh();
            self.registers.insert(token, identity);
            self.push(Op::PushBlock(identity, result, 0))
        });
        self.blocks.push(BlockState { id, result, scopes: self.scopes, exits: Vec::new() });
        self.scopes += usize::from(dynamic.is_some());
        self.value(body, result, false);
        if let Some(push) = dynamic {
            self.push(Op::PopScopes(1));
            self.scopes -= 1;
            self.land(push);
        }
        if let Some(block) = self.blocks.pop() {
            for exit in block.exits {
                self.land(exit);
            }
        }
        self.take(result, into);
    }

    fn leave(&mut self, id: BlockId, value: &Ir) {
        let Some(block) = self.blocks.iter().rposition(|block| block.id == id) else { return };
        let (result, scopes) = (self.blocks[block].result, self.blocks[block].scopes);
        self.value(value, result, false);
        let open = self.scopes - scopes;
        let exit = if open == 0 { self.push(Op::Jump(0)) } else { self.push(Op::LeaveScopes(open.min(255) as u8, 0)) };
        self.blocks[block].exits.push(exit);
    }

    fn construct(&mut self, construct: &ConstructIr) -> u32 {
        let argument = match &construct.argument {
            Some(argument) => {
                let reg = self.fresh();
                self.value(argument, reg, false);
                reg
            }
            None => NO_REG,
        };
        let children = construct
            .children
            .iter()
            .map(|child| Child {
                code: self.inner(&child.body),
                tag: child.tag.and_then(|tag| self.registers.get(&tag).copied()).unwrap_or(NO_REG),
                tag_in_cell: child.tag.is_some_and(|tag| self.compiler.variables[tag.0 as usize].in_cell()),
                name: child.name,
            })
            .collect();
        self.constructs.push(Construct {
            rule: construct.rule,
            name: construct.name,
            children,
            order: construct.order.clone(),
            argument,
            with_priority: construct.with_priority,
            active: construct.active,
        });
        self.constructs.len() as u32 - 1
    }

    fn handler(&mut self, body: &Ir, failure: VarId, clauses: &[super::ir::ClauseIr], into: Reg) {
        let failure_reg = self.fresh();
        let clause_reg = self.fresh();
        self.place(failure, failure_reg);
        self.handlers.push(clauses.iter().map(|clause| clause.classes.clone()).collect());
        let index = self.handlers.len() as u16 - 1;
        let push = self.push(Op::PushHandler(failure_reg, index, 0));
        self.scopes += 1;
        self.value(body, into, false);
        self.push(Op::PopScopes(1));
        self.scopes -= 1;
        let done = self.push(Op::Jump(0));
        self.land(push);
        self.put_in_cell(failure, failure_reg);
        let mut exits = vec![done];
        for (number, clause) in clauses.iter().enumerate() {
            let next = self.push(Op::JumpUnlessNumEqInt(clause_reg, number as i16, 0));
            self.value(&clause.body, into, false);
            exits.push(self.push(Op::Jump(0)));
            self.land(next);
        }
        for exit in exits {
            self.land(exit);
        }
    }

    fn cleanup(&mut self, always: bool, body: &Ir, cleanup: &Ir, into: Reg) {
        // The value waits in a register of its own while the clean-up uses the others.
        let result = self.fresh();
        let push = self.push(Op::PushCleanup(0));
        self.scopes += 1;
        self.value(body, result, false);
        let skip = if always {
            self.push(Op::BeginCleanup);
            None
        } else {
            self.push(Op::PopScopes(1));
            Some(self.push(Op::Jump(0)))
        };
        self.land(push);
        self.temporarily(|emitter| {
            let unused = emitter.fresh();
            emitter.value(cleanup, unused, false);
        });
        self.push(Op::EndCleanup);
        self.scopes -= 1;
        if let Some(skip) = skip {
            self.land(skip);
        }
        self.take(result, into);
    }

    fn scope(&mut self, scope: &ScopeIr, body: &Ir, into: Reg) {
        let reg = self.fresh();
        let op = match scope {
            ScopeIr::Valve(value) => {
                self.value(value, reg, false);
                Op::PushValve(reg)
            }
            ScopeIr::Suspended(value) => {
                self.value(value, reg, false);
                Op::PushSuspended(reg)
            }
            ScopeIr::OnInterrupt(hook) | ScopeIr::OnResume(hook) => {
                let code = self.inner(hook);
                self.push(Op::Closure(reg, code));
                if matches!(scope, ScopeIr::OnInterrupt(_)) { Op::PushOnInterrupt(reg) } else { Op::PushOnResume(reg) }
            }
        };
        self.push(op);
        self.scopes += 1;
        self.value(body, into, false);
        self.push(Op::PopScopes(1));
        self.scopes -= 1;
    }
}

/// Whether emitting the form writes its target only with its last instruction.
fn writes_once(ir: &Ir) -> bool {
    matches!(
        ir.kind,
        IrKind::Nil
            | IrKind::True
            | IrKind::Int(_)
            | IrKind::Const(_)
            | IrKind::Local(_)
            | IrKind::Global(_)
            | IrKind::Binary(..)
            | IrKind::Unary(..)
            | IrKind::Lambda(_)
            | IrKind::Call(..)
    )
}

/// Whether the form has nothing to run when nobody wants its value.
fn has_no_code(ir: &Ir) -> bool {
    matches!(ir.kind, IrKind::Nil | IrKind::True | IrKind::Int(_) | IrKind::Const(_) | IrKind::Local(_))
}

/// Whether evaluating the form can change no variable.
fn has_no_effect(ir: &Ir) -> bool {
    deep(|| match &ir.kind {
        IrKind::Nil | IrKind::True | IrKind::Int(_) | IrKind::Const(_) | IrKind::Local(_) | IrKind::Global(_) => true,
        IrKind::Binary(_, left, right) => has_no_effect(left) && has_no_effect(right),
        IrKind::Unary(_, operand) => has_no_effect(operand),
        // A call cannot assign a variable that lives in a register: captured ones live in cells.
        IrKind::Call(Callee::Value(function), arguments) => {
            has_no_effect(function) && arguments.iter().all(has_no_effect)
        }
        IrKind::Call(_, arguments) => arguments.iter().all(has_no_effect),
        _ => false,
    })
}
