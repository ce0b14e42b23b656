//! Calls: arguments arranged, frames begun, natives called.

use crate::state::failure::Raise;
use crate::state::limits::Limits;
use crate::state::machine::{Machine, SCRATCH_TASK};
use crate::state::scratch::Cursor;
use crate::state::task::Frame;
use crate::state::value::Value;
use crate::step::exec::evaluation::MAX_EVALUATIONS_DEEP;
use crate::step::exec::{Proceed, REACH, WINDOW};
use crate::step::native::{Call as NativeCall, Reply, Surroundings};
use rpl_lang::code::{Code, CodeKind, Parameters, Reg};
use rpl_lang::compile::NativeSignature;
use rpl_lang::kind::Kind;
use rpl_lang::suggest::suggest;
use std::borrow::Cow;

impl Limits {
    /// The fewest frames that are allowed, wherever they start: each takes the next one's registers along, and so does
    /// each evaluation of a network.
    #[inline]
    pub(crate) fn frames_anywhere(&self) -> usize {
        const _: () = assert!(size_of::<Frame>() + WINDOW * size_of::<Value>() <= 2 * 4096);
        let by_bytes = (self.bytes / 4 / 8192).saturating_sub(MAX_EVALUATIONS_DEEP as usize + 1);
        by_bytes.min(self.frames as usize)
    }

    /// Whether one more frame may start at this register above `frames` others.
    ///
    /// The calls of the running task take a quarter of the memory at most, beside the data.
    #[inline]
    pub(crate) fn allow(&self, frames: usize, base: usize) -> bool {
        frames < self.frames as usize && frames * size_of::<Frame>() + base * size_of::<Value>() < self.bytes / 4
    }
}

/// Clears the registers of a frame from one on: four at a time, and so perhaps some behind the frame, where nothing lives.
#[inline(always)]
pub(super) fn clear_registers(r: &mut [Value; REACH], at: usize, end: usize) {
    if let Some(four) = r[at..].first_chunk_mut::<4>() {
        *four = [Value::Nil; 4];
    }
    if at + 4 < end {
        clear_more(r, at + 4, end);
    }
}

#[inline(never)]
fn clear_more(r: &mut [Value; REACH], at: usize, end: usize) {
    r[at..end].fill(Value::Nil);
}

/// Copies what a closure has captured into the registers from one on.
#[inline(always)]
pub(super) fn place_captured(r: &mut [Value; REACH], at: usize, captured: &[Value]) {
    match captured {
        [] => {}
        [only] => r[at].set(only),
        captured => place_many(r, at, captured),
    }
}

#[inline(never)]
fn place_many(r: &mut [Value; REACH], at: usize, captured: &[Value]) {
    r[at..at + captured.len()].copy_from_slice(captured);
}

impl Machine {
    /// Arranges arguments for a function with optional, rest or key parameters.
    pub(crate) fn arrange(&mut self, code: &Code, first: usize, count: usize) -> Result<(), Raise> {
        let parameters: &Parameters = &code.parameters;
        if !parameters.accepts(count) {
            let name = self.symbols.name(code.name).to_string();
            let given = if count == 1 { "1 was given".into() } else { format!("{count} were given") };
            return Err(Raise::new("arity-error", format!("`{name}` takes {}, and {given}", parameters.describe())));
        }
        if parameters.is_simple() {
            return Ok(());
        }
        let required = usize::from(parameters.required);
        let optional = usize::from(parameters.optional);
        let given: Vec<Value> = self.scratch.stack[first..first + count].to_vec();
        let positional = given.len().min(required + optional);
        let mut arranged = given[..positional].to_vec();
        arranged.resize(required + optional, Value::Unbound);
        let rest = &given[positional..];
        if parameters.rest {
            arranged.push(self.heap.list(rest));
        }
        if !parameters.keys.is_empty() {
            let keys = arranged.len();
            arranged.resize(keys + parameters.keys.len(), Value::Unbound);
            for pair in rest.chunks(2) {
                let known = match pair[0] {
                    Value::Keyword(key) => parameters.keys.iter().position(|&known| known == key),
                    _ => None,
                };
                match (known, pair.get(1)) {
                    (Some(at), Some(&value)) => arranged[keys + at] = value,
                    _ if parameters.rest => {}
                    (None, _) => {
                        return Err(self.no_such_keyword(code, pair[0]));
                    }
                    (Some(at), None) => {
                        let key = self.symbols.name(parameters.keys[at]);
                        return Err(Raise::new("arity-error", format!("`:{key}` has no value")));
                    }
                }
            }
        }
        self.scratch.stack[first..first + arranged.len()].copy_from_slice(&arranged);
        Ok(())
    }

    #[cold]
    fn no_such_keyword(&self, code: &Code, given: Value) -> Raise {
        let known: Vec<&str> = code.parameters.keys.iter().map(|&key| self.symbols.name(key)).collect();
        let listed = known.iter().map(|key| format!("`:{key}`")).collect::<Vec<_>>().join(", ");
        let name = self.symbols.name(code.name);
        Raise::new(
            "arity-error",
            match given {
                Value::Keyword(key) => {
                    let key = self.symbols.name(key);
                    let help = match suggest(key, known.iter().copied()) {
                        Some(near) => format!("did you mean `:{near}`?"),
                        None => format!("it has {listed}"),
                    };
                    format!("`{name}` has no parameter `:{key}`; {help}")
                }
                other => {
                    let positional = code.parameters.required + code.parameters.optional;
                    let others = if positional == 0 { "" } else { "after its other arguments " };
                    let found = self.described(other);
                    format!("`{name}` takes only keywords with values {others}({listed}), and here stands {found}")
                }
            },
        )
    }

    fn not_a_function(&self, value: Value) -> Raise {
        self.wrong_type("what is called", Kind::Function.noun(), value)
    }

    #[cold]
    #[inline(never)]
    pub(crate) fn describe_global(&self, around: &Surroundings<'_>, global: u32) -> Raise {
        let name = self.symbols.name(around.program.globals[global as usize].name);
        Raise::new("unbound-variable", format!("`{name}` has no value yet: its definition has not run"))
    }

    #[cold]
    #[inline(never)]
    pub(crate) fn too_deep(&self) -> Raise {
        Raise::new("stack-overflow", format!("{} calls inside one another", self.limits.frames))
    }

    #[cold]
    #[inline(never)]
    pub(crate) fn grow_stack(&mut self, base: usize) {
        // By a little only: what is grown is filled, and so taken from the system.
        self.scratch.stack.resize((base + REACH) / 8 * 9, Value::Nil);
    }

    pub(crate) fn clear_frame(&mut self, code: &Code, base: usize) {
        let (from, to) = (code.parameters.registers(), usize::from(code.registers));
        if self.scratch.stack.len() < base + REACH {
            self.grow_stack(base);
        }
        self.scratch.stack[base + from..base + to].fill(Value::Nil);
    }

    /// Calls a native with a number of arguments in the registers from one on.
    #[inline]
    pub(super) fn call_native_at(
        &mut self,
        around: &mut Surroundings<'_>,
        native: u16,
        from: usize,
        count: u8,
    ) -> Result<Reply, Raise> {
        let arguments = &self.scratch.stack[from..from + usize::from(count)];
        match *arguments {
            [] => self.call_native(around, native, &[]),
            [first] => self.call_native(around, native, &[first]),
            [first, second] => self.call_native(around, native, &[first, second]),
            [first, second, third] => self.call_native(around, native, &[first, second, third]),
            _ => {
                let arguments = arguments.to_vec();
                self.call_native(around, native, &arguments)
            }
        }
    }

    pub(crate) fn call_native(
        &mut self,
        around: &mut Surroundings<'_>,
        native: u16,
        arguments: &[Value],
    ) -> Result<Reply, Raise> {
        let natives = around.natives;
        let entry = &natives[usize::from(native)];
        if entry.effect.acts() && self.current == SCRATCH_TASK {
            // What the library calls for it has the same name behind a `%`.
            self.refuse_in_network(&format!("`{}` cannot be called", entry.name.trim_start_matches('%')))?;
        }
        entry.code.call(&mut NativeCall { machine: self, around, native: entry, arguments })
    }

    /// Calls a native that has found no room once more, when what nobody needs is gone.
    #[cold]
    #[inline(never)]
    fn call_with_room(
        &mut self,
        around: &mut Surroundings<'_>,
        native: u16,
        arguments: &[Value],
        raise: Raise,
    ) -> Result<Reply, Raise> {
        let Raise::NoRoom(bytes) = raise else { return Err(raise) };
        // Not all arguments need to stand in registers.
        let (top, above) = (self.scratch.top, self.scratch.top + arguments.len());
        if self.scratch.stack.len() < above {
            self.scratch.stack.resize(above, Value::Nil);
        }
        self.scratch.stack[top..above].copy_from_slice(arguments);
        let room = self.make_room(above, bytes);
        self.scratch.top = top;
        room?;
        self.call_native(around, native, arguments)
    }

    /// Calls the function in a global: one whose arguments need arranging, whose frame needs a closer look at the limits,
    /// or that is no code.
    #[inline(never)]
    pub(super) fn call_global(
        &mut self,
        around: &mut Surroundings<'_>,
        place: &mut Cursor,
        global: u32,
        first: Reg,
        count: u8,
        tail: bool,
    ) -> Result<Proceed, Raise> {
        let (number, callee) = match self.globals[global as usize] {
            Value::Function(number) => (number, &around.program.codes[number as usize]),
            Value::Unbound => return Err(self.describe_global(around, global)),
            function => return self.call_any(around, place, function, first, count, tail),
        };
        let from = place.frame.base as usize + usize::from(first);
        let count = usize::from(count);
        let tail = tail && callee.kind != CodeKind::Plan;
        let base = if tail { place.frame.base as usize } else { from };
        if tail {
            self.scratch.stack.copy_within(from..from + count, base);
        } else if !self.limits.allow(self.scratch.frames.len(), base) {
            return Err(self.too_deep());
        }
        self.arrange(callee, base, count)?;
        if !tail {
            self.scratch.frames.push(place.frame);
        }
        self.clear_frame(callee, base);
        place.frame = Frame { code: number, pc: 0, base: base as u32 };
        Ok(Proceed::Entered)
    }

    /// Calls a function of any kind with the arguments in the registers from `first` on, where its value
    /// goes.
    #[inline(never)]
    pub(super) fn call_any(
        &mut self,
        around: &mut Surroundings<'_>,
        place: &mut Cursor,
        function: Value,
        first: Reg,
        count: u8,
        tail: bool,
    ) -> Result<Proceed, Raise> {
        let from = place.frame.base as usize + usize::from(first);
        let arguments = self.scratch.stack[from..from + usize::from(count)].to_vec();
        self.call_value(around, place, function, &arguments, usize::from(first), tail, first)
    }

    /// Goes on with what a native has answered, unless that is a value at once.
    #[inline(never)]
    #[allow(clippy::too_many_arguments, reason = "the instruction in full")]
    pub(super) fn take_reply(
        &mut self,
        around: &mut Surroundings<'_>,
        place: &mut Cursor,
        to: Reg,
        first: Reg,
        count: u8,
        native: u16,
        reply: Result<Reply, Raise>,
    ) -> Result<Proceed, Raise> {
        let base = place.frame.base as usize;
        let reply = match reply {
            Ok(reply) => reply,
            Err(raise) => {
                let from = base + usize::from(first);
                let arguments = self.scratch.stack[from..from + usize::from(count)].to_vec();
                self.call_with_room(around, native, &arguments, raise)?
            }
        };
        match reply {
            Reply::Value(value) => {
                self.scratch.stack[base + usize::from(to)] = value;
                self.collect_if_full()?;
                let acts = around.natives[usize::from(native)].effect.acts();
                Ok(if self.scratch.switch || acts { Proceed::Leave } else { Proceed::On })
            }
            Reply::Wait => {
                let task = self.current;
                self.tasks[task].wake_register = to;
                Ok(Proceed::Blocked)
            }
            Reply::Leave => {
                self.scratch.stack[base + usize::from(to)] = Value::Nil;
                Ok(Proceed::Leave)
            }
            Reply::Ask(asked) => Ok(Proceed::Ask(asked, to)),
            Reply::Call(function, arguments) => {
                self.call_value(around, place, function, &arguments, usize::from(to), false, to)
            }
        }
    }

    /// Calls any function value. On return `place` tells where to go on; an exit if the task stops.
    #[allow(clippy::too_many_arguments, reason = "the calling convention in full")]
    fn call_value(
        &mut self,
        around: &mut Surroundings<'_>,
        place: &mut Cursor,
        mut function: Value,
        arguments: &[Value],
        mut first: usize,
        mut tail: bool,
        result: Reg,
    ) -> Result<Proceed, Raise> {
        let mut arguments = Cow::Borrowed(arguments);
        // A native may go on in a function, and that be a native again: as far as data reach.
        while let Value::Native(native) = function {
            match self.call_native_value(around, native, &arguments)? {
                Reply::Value(value) => {
                    self.scratch.stack[place.frame.base as usize + usize::from(result)] = value;
                    return Ok(Proceed::Entered);
                }
                Reply::Wait => {
                    let task = self.current;
                    self.tasks[task].wake_register = result;
                    return Ok(Proceed::Blocked);
                }
                Reply::Leave => return Ok(Proceed::Entered),
                Reply::Ask(asked) => return Ok(Proceed::Ask(asked, result)),
                Reply::Call(next, further) => {
                    (function, arguments) = (next, Cow::Owned(further));
                    (first, tail) = (usize::from(result), false);
                    self.scratch.burned = self.scratch.burned.saturating_add(1);
                    if self.scratch.burned >= place.steps() {
                        self.scratch.burned = 0;
                        *place = self.budget_anew(around, place.frame);
                        return Err(self.runaway());
                    }
                }
            }
        }
        self.enter_function(around, place, function, &arguments, first, tail)
    }

    /// Begins a function that is no native.
    fn enter_function(
        &mut self,
        around: &Surroundings<'_>,
        place: &mut Cursor,
        function: Value,
        arguments: &[Value],
        first: usize,
        tail: bool,
    ) -> Result<Proceed, Raise> {
        let (number, captured) = match function {
            Value::Function(number) => (number, None),
            Value::Closure(index) => (self.heap.closures[index].code, Some(self.heap.closures[index].captured.clone())),
            other => return Err(self.not_a_function(other)),
        };
        let callee = &around.program.codes[number as usize];
        let tail = tail && callee.kind != CodeKind::Plan;
        let base = place.frame.base as usize + if tail { 0 } else { first };
        let needed = base + WINDOW.max(arguments.len());
        if self.scratch.stack.len() < needed {
            self.grow_stack(needed);
        }
        self.scratch.stack[base..base + arguments.len()].copy_from_slice(arguments);
        self.arrange(callee, base, arguments.len())?;
        if !tail {
            if !self.limits.allow(self.scratch.frames.len(), base) {
                return Err(self.too_deep());
            }
            self.scratch.frames.push(place.frame);
        }
        self.clear_frame(callee, base);
        if let Some(captured) = captured {
            let at = base + callee.parameters.registers();
            self.scratch.stack[at..at + captured.len()].copy_from_slice(&captured);
        }
        place.frame = Frame { code: number, pc: 0, base: base as u32 };
        Ok(Proceed::Entered)
    }

    /// Calls a native that is known only by its value.
    fn call_native_value(
        &mut self,
        around: &mut Surroundings<'_>,
        native: u16,
        arguments: &[Value],
    ) -> Result<Reply, Raise> {
        let NativeSignature { min, max, .. } = around.signatures[usize::from(native)];
        let count = arguments.len();
        if count < usize::from(min) || max.is_some_and(|max| count > usize::from(max)) {
            let name = around.natives[usize::from(native)].name;
            return Err(Raise::new("arity-error", format!("`{name}` cannot take {count} arguments")));
        }
        match self.call_native(around, native, arguments) {
            Ok(reply) => Ok(reply),
            Err(raise) => self.call_with_room(around, native, arguments, raise),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_that_are_allowed_anywhere_are_allowed_at_the_highest_register() {
        for bytes in [0, 1 << 16, 1 << 22, 3_000_000, 1 << 30] {
            let limits = Limits { bytes, ..Limits::default() };
            for frames in (0..limits.frames_anywhere()).step_by(7) {
                let highest = (frames + 1 + MAX_EVALUATIONS_DEEP as usize) * (WINDOW - 1);
                assert!(limits.allow(frames, highest), "{frames} frames within {bytes} bytes");
            }
        }
        assert!(Limits::default().frames_anywhere() > 10_000, "calls are not looked at one by one");
    }
}
