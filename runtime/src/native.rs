//! Native functions: name, arguments, documentation and code in one place.

use crate::failure::Raise;
use crate::machine::{Machine, Surroundings};
use crate::value::{TaskRef, Value};

/// So much text is made, or looked through, in the time of one turn of a loop.
const CHARACTERS_A_STEP: usize = 8;

/// So many pairs are passed in the time of one turn of a loop.
const PAIRS_A_STEP: usize = 4;

/// What a native function answers.
pub enum Reply {
    /// A value.
    Value(Value),
    /// The task waits; what wakes it brings the value.
    Wait,
    /// Go on in a function of the plan, with these arguments; its value is the answer.
    Call(Value, Vec<Value>),
    /// Compile a datum and go on in it.
    Execute(Value),
    /// The task itself is leaving.
    Leave,
}

/// A call of a native function.
pub struct Call<'c, 's> {
    /// The machine.
    pub machine: &'c mut Machine,
    /// Program, natives and the robot.
    pub around: &'c mut Surroundings<'s>,
    /// The arguments.
    pub arguments: &'c [Value],
}

impl Call<'_, '_> {
    /// The task that calls.
    pub fn task(&self) -> TaskRef {
        self.machine.tasks.reference(self.machine.current)
    }

    /// The argument at a position; `nil` if it was left out.
    pub fn argument(&self, at: usize) -> Value {
        self.arguments.get(at).copied().unwrap_or(Value::Nil)
    }

    /// The argument at a position as an integer.
    ///
    /// # Errors
    /// A `type-error` if it is none.
    pub fn integer(&self, at: usize) -> Result<i64, Raise> {
        match self.argument(at) {
            Value::Int(value) => Ok(value),
            other => Err(self.wrong_type(at, "an integer", other)),
        }
    }

    /// The argument at a position as a number.
    ///
    /// # Errors
    /// A `type-error` if it is none.
    pub fn number(&self, at: usize) -> Result<f64, Raise> {
        self.argument(at).as_f64().ok_or_else(|| self.wrong_type(at, "a number", self.argument(at)))
    }

    /// The argument at a position as a string.
    ///
    /// # Errors
    /// A `type-error` if it is none.
    pub fn text(&self, at: usize) -> Result<std::sync::Arc<str>, Raise> {
        match self.argument(at) {
            Value::Str(index) => Ok(self.machine.heap.strings[index].clone()),
            other => Err(self.wrong_type(at, "a string", other)),
        }
    }

    /// The argument at a position as the elements of a list.
    ///
    /// # Errors
    /// A `type-error` if it is no proper list.
    pub fn list(&mut self, at: usize) -> Result<Vec<Value>, Raise> {
        let elements = self.machine.heap.elements(self.argument(at));
        let elements = elements.map_err(|found| self.wrong_type(at, "a list", found))?;
        self.burn(elements.len());
        Ok(elements)
    }

    /// Takes steps from the budget of the task: what walks long data costs as much as a loop over
    /// it.
    pub fn burn(&mut self, steps: usize) {
        let burned = &mut self.machine.scratch.burned;
        *burned = burned.saturating_add(u32::try_from(steps).unwrap_or(u32::MAX));
    }

    /// Takes the steps of making, or looking through, so much text.
    pub fn burn_text(&mut self, bytes: usize) {
        self.burn(bytes / CHARACTERS_A_STEP);
    }

    /// Takes the steps of passing so many pairs.
    pub fn burn_walk(&mut self, pairs: usize) {
        self.burn(pairs / PAIRS_A_STEP);
    }

    /// The argument at a position as a fluent.
    ///
    /// # Errors
    /// A `type-error` if it is none.
    pub fn fluent(&self, at: usize) -> Result<u32, Raise> {
        match self.argument(at) {
            Value::Fluent(fluent) => Ok(fluent),
            other => Err(self.wrong_type(at, "a fluent", other)),
        }
    }

    /// The name a symbol or string argument spells.
    ///
    /// # Errors
    /// A `type-error` if it is neither.
    pub fn name(&self, at: usize) -> Result<String, Raise> {
        match self.argument(at) {
            Value::Symbol(symbol) | Value::Keyword(symbol) => Ok(self.machine.symbols.name(symbol).to_string()),
            Value::Str(index) => Ok(self.machine.heap.strings[index].to_string()),
            other => Err(self.wrong_type(at, "a name", other)),
        }
    }

    /// A `type-error` about the argument at a position.
    pub fn wrong_type(&self, at: usize, expected: &str, found: Value) -> Raise {
        self.machine.wrong_type(&format!("argument {}", at + 1), expected, found)
    }
}

/// The code of a native function.
pub type NativeCode = fn(&mut Call<'_, '_>) -> Result<Reply, Raise>;

/// A native function.
#[derive(Clone, Copy)]
pub struct Native {
    /// Its name.
    pub name: &'static str,
    /// Its parameters, as documentation shows them: `"list &optional start"`.
    pub parameters: &'static str,
    /// What it does, in one sentence.
    pub doc: &'static str,
    /// Whether it waits, assigns or acts on tasks.
    pub effect: Effect,
    /// Its code.
    pub code: NativeCode,
}

/// What a native does beside giving a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Nothing.
    None,
    /// It assigns or acts on tasks: a network may not call it.
    Acts,
    /// It may block the task: a network may not call it either.
    Waits,
    /// It goes on in code of the plan.
    Calls,
}

impl Effect {
    /// Whether a network may not have it.
    #[inline]
    pub fn acts(self) -> bool {
        matches!(self, Effect::Acts | Effect::Waits)
    }
}

impl Native {
    /// Fewest and most arguments, read off the parameters.
    pub fn arity(&self) -> (u8, Option<u8>) {
        let (mut min, mut max, mut optional, mut rest) = (0, 0, false, false);
        for word in self.parameters.split_whitespace() {
            match word {
                "&optional" => optional = true,
                "&rest" | "&key" => rest = true,
                _ if rest => {}
                _ if optional => max += 1,
                _ => {
                    min += 1;
                    max += 1;
                }
            }
        }
        (min, (!rest).then_some(max))
    }

    /// What the compiler needs to know.
    pub fn signature(&self) -> rpl_lang::compile::NativeSignature {
        let (min, max) = self.arity();
        rpl_lang::compile::NativeSignature {
            name: self.name.to_string(),
            min,
            max,
            effect: self.effect.acts(),
            waits: self.effect == Effect::Waits,
            calls: self.effect == Effect::Calls,
        }
    }
}
