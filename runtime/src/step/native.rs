//! Native functions: name, arguments, documentation and code in one place.

use crate::robot::reading::Reading;
use crate::robot::{Outside, RobotGlobals};
use crate::state::failure::Raise;
use crate::state::machine::Machine;
use crate::state::projected::Asked;
use crate::state::value::{TaskRef, Value};
use rpl_lang::code::Program;
use rpl_lang::compile::NativeSignature;
use rpl_lang::kind::Kind;
use std::any::{Any, TypeId};
use std::sync::Arc;

/// Text that is made, or looked through, in the time of one turn of a loop.
const CHARACTERS_A_STEP: usize = 8;

/// Bytes that are kept from a text that was written for the next one, at most.
const MAX_DRAFT: usize = 1 << 16;

/// Pairs that are passed in the time of one turn of a loop.
const PAIRS_A_STEP: usize = 4;

/// The steps of making, or looking through, `bytes` bytes of text.
#[inline]
pub(crate) fn text_steps(bytes: usize) -> usize {
    bytes / CHARACTERS_A_STEP
}

/// The steps of passing `pairs` pairs.
pub(crate) fn walk_steps(pairs: usize) -> usize {
    pairs / PAIRS_A_STEP
}

/// What a native function answers.
pub enum Reply {
    /// A value.
    Value(Value),
    /// The task waits; what wakes it brings the value.
    Wait,
    /// Go on in a function of the plan, with these arguments; its value is the answer.
    Call(Value, Vec<Value>),
    /// Ask the whole run: to compile a datum and go on in it, or to project plans.
    Ask(Asked),
    /// The task itself is leaving.
    Leave,
}

/// A call of a native function.
pub struct Call<'c, 's> {
    /// The machine.
    pub machine: &'c mut Machine,
    /// Program, natives and the robot.
    pub around: &'c mut Surroundings<'s>,
    /// The function that is called.
    pub native: &'c Native,
    /// The arguments.
    pub arguments: &'c [Value],
}

impl Call<'_, '_> {
    /// The task that calls.
    pub fn task(&self) -> TaskRef {
        self.machine.tasks.reference(self.machine.current)
    }

    /// The part of the robot that is of a type.
    ///
    /// # Errors
    /// There is no robot, or none with such a part.
    pub fn part<T: 'static>(&mut self) -> Result<&mut T, Raise> {
        let part = self.around.outside.part(TypeId::of::<T>());
        part.and_then(<dyn Any>::downcast_mut).ok_or_else(Raise::no_robot)
    }

    /// Sets a fluent of the robot as what the plan does changes it, instead of when the robot next tells. A name that
    /// no fluent of the robot has is passed over.
    pub fn tell(&mut self, name: &str, reading: &Reading) {
        let global = self.machine.symbols.find(name).and_then(|name| self.around.program.names.get(&name));
        let Some(number) = self.around.robot.fluents.iter().position(|of| Some(of) == global) else { return };
        if let Some(fluent) = self.machine.robot_fluent(self.around.robot, number) {
            let value = self.machine.value_of_reading(reading);
            self.machine.assign_all(self.around, &[(fluent, value)]);
        }
    }

    /// A reading as a value of plans.
    pub fn value_of(&mut self, reading: &Reading) -> Value {
        self.machine.value_of_reading(reading)
    }

    /// A failure of a class that may not be defined, as what is outside tells it: then it is a `behaviour-failure`.
    pub fn failure(&mut self, class: String, message: String, slots: Vec<(String, Reading)>) -> Raise {
        let (class, message) = self.machine.known_class(self.around, class, message);
        let class = self.machine.symbols.intern(&class);
        let machine = &mut *self.machine;
        let slots = slots.into_iter();
        let slots = slots.map(|(name, reading)| (machine.symbols.intern(&name), machine.value_of_reading(&reading)));
        let slots = slots.collect();
        Raise::Again(machine.new_failure(machine.current, class, message, slots))
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
            _ => Err(self.wrong_type(at)),
        }
    }

    /// The argument at a position as a number.
    ///
    /// # Errors
    /// A `type-error` if it is none.
    pub fn number(&self, at: usize) -> Result<f64, Raise> {
        self.argument(at).as_f64().ok_or_else(|| self.wrong_type(at))
    }

    /// The argument at a position as a string.
    ///
    /// # Errors
    /// A `type-error` if it is none.
    pub fn text(&self, at: usize) -> Result<Arc<str>, Raise> {
        match self.argument(at) {
            Value::Str(index) => Ok(self.machine.heap.strings[index].text.clone()),
            _ => Err(self.wrong_type(at)),
        }
    }

    /// The same, as long as nothing is made.
    ///
    /// # Errors
    /// A `type-error` if it is none.
    pub fn str(&self, at: usize) -> Result<&str, Raise> {
        match self.argument(at) {
            Value::Str(index) => Ok(&self.machine.heap.strings[index]),
            _ => Err(self.wrong_type(at)),
        }
    }

    /// The argument at a position as the elements of a list.
    ///
    /// # Errors
    /// A `type-error` if it is no proper list.
    pub fn list(&mut self, at: usize) -> Result<Vec<Value>, Raise> {
        let elements = self.machine.heap.elements(self.argument(at));
        let elements = elements.map_err(|_| self.wrong_type(at))?;
        self.burn(elements.len());
        Ok(elements)
    }

    /// An empty text to write into, which has room for a short one as a rule: it is given back by [`Call::lay_aside`].
    pub fn draft(&mut self) -> String {
        std::mem::take(&mut self.machine.scratch.draft)
    }

    /// Gives back what [`Call::draft`] gave, once it is copied.
    pub fn lay_aside(&mut self, mut draft: String) {
        if draft.capacity() <= MAX_DRAFT {
            draft.clear();
            self.machine.scratch.draft = draft;
        }
    }

    /// Takes steps from the budget of the task: what walks long data costs as much as a loop over
    /// it.
    pub fn burn(&mut self, steps: usize) {
        let burned = &mut self.machine.scratch.burned;
        *burned = burned.saturating_add(u32::try_from(steps).unwrap_or(u32::MAX));
    }

    /// Takes the steps of making, or looking through, `bytes` bytes of text.
    pub fn burn_text(&mut self, bytes: usize) {
        self.burn(text_steps(bytes));
    }

    /// Takes the steps of passing `pairs` pairs.
    pub fn burn_walk(&mut self, pairs: usize) {
        self.burn(walk_steps(pairs));
    }

    /// The argument at a position as a fluent.
    ///
    /// # Errors
    /// A `type-error` if it is none.
    pub fn fluent(&self, at: usize) -> Result<u32, Raise> {
        match self.argument(at) {
            Value::Fluent(fluent) => Ok(fluent),
            _ => Err(self.wrong_type(at)),
        }
    }

    /// The argument at a position as a task, which may be dead.
    ///
    /// # Errors
    /// A `type-error` if it is none.
    pub fn named_task(&self, at: usize) -> Result<TaskRef, Raise> {
        match self.argument(at) {
            Value::Task(task) => Ok(task),
            _ => Err(self.wrong_type(at)),
        }
    }

    /// The argument at a position as a behaviour, by its number.
    ///
    /// # Errors
    /// A `type-error` if it is none.
    pub fn behaviour(&self, at: usize) -> Result<u16, Raise> {
        match self.argument(at) {
            Value::Behaviour(behaviour) => Ok(behaviour),
            _ => Err(self.wrong_type(at)),
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
            _ => Err(self.wrong_type(at)),
        }
    }

    /// A `type-error`: the argument at a position is not of the kind that the function declares.
    pub fn wrong_type(&self, at: usize) -> Raise {
        self.machine.wrong_type(&self.which(at), self.native.kind(at).noun(), self.argument(at))
    }

    /// The argument at a position, as messages name it.
    pub fn which(&self, at: usize) -> String {
        // What begins so is written by forms of the library: `(setf (nth …) …)`, `(format …)`.
        let name = self.native.name;
        match (name.strip_prefix("%set-"), name.strip_prefix('%')) {
            (Some(accessor), _) => format!("argument {} of `(setf {accessor})`", at + 1),
            (None, Some(form)) => format!("argument {} of `{form}`", at + 1),
            (None, None) => format!("argument {} of `{name}`", at + 1),
        }
    }
}

/// A plain function in Rust that is called by plans.
pub type NativeFunction = fn(&mut Call<'_, '_>) -> Result<Reply, Raise>;

/// The same as a closure that captures.
pub type NativeClosure = dyn Fn(&mut Call<'_, '_>) -> Result<Reply, Raise> + Send + Sync;

/// The code of a native function.
#[derive(Clone)]
pub enum NativeCode {
    /// A function: what all that come with the language have.
    Plain(NativeFunction),
    /// A closure that holds something of the program around, such as the sender of a channel. That is
    /// no part of the run: all forks call the same one, and no saved run has it. If it answers a plan,
    /// it must give the same answer to the same call, or the run is not the same a second time.
    Capturing(Arc<NativeClosure>),
}

impl NativeCode {
    /// Calls it.
    ///
    /// # Errors
    /// The failure of the plan that the code raises.
    #[inline]
    pub fn call(&self, call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
        match self {
            NativeCode::Plain(code) => code(call),
            NativeCode::Capturing(code) => code(call),
        }
    }
}

/// A native function.
#[derive(Clone)]
pub struct Native {
    /// Its name.
    pub name: &'static str,
    /// Its parameters, as documentation shows them: `"list &optional start"`. Their words say what
    /// kind of argument each takes; see [`Kind::of_parameter`].
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
    /// The kind of the argument at a position.
    pub fn kind(&self, at: usize) -> Kind {
        let (kinds, rest) = self.kinds();
        kinds.get(at).copied().or(rest).unwrap_or(Kind::Any)
    }

    /// The kinds of the parameters, and of the arguments behind them.
    fn kinds(&self) -> (Vec<Kind>, Option<Kind>) {
        let mut kinds = Vec::new();
        let mut words = self.parameters.split_whitespace();
        let kind = |word| Kind::of_parameter(word).unwrap_or(Kind::Any);
        while let Some(word) = words.next() {
            match word {
                "&optional" => {}
                "&rest" => return (kinds, words.next().map(kind)),
                "&key" => return (kinds, Some(Kind::Any)),
                word => kinds.push(kind(word)),
            }
        }
        (kinds, None)
    }

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
    pub fn signature(&self) -> NativeSignature {
        let (min, max) = self.arity();
        let (kinds, rest) = self.kinds();
        NativeSignature {
            name: self.name.to_string(),
            parameters: self.parameters.to_string(),
            min,
            max,
            effect: self.effect.acts(),
            waits: self.effect == Effect::Waits,
            calls: self.effect == Effect::Calls,
            kinds,
            rest,
        }
    }
}

/// What a machine runs with and does not own.
pub struct Surroundings<'a> {
    /// All code.
    pub program: &'a Program,
    /// The native functions, by number.
    pub natives: &'a [Native],
    /// How many arguments each of them takes.
    pub signatures: &'a [NativeSignature],
    /// The robot, or [`crate::robot::NoRobot`].
    pub outside: &'a mut dyn Outside,
    /// Where its names stand in the program.
    pub robot: &'a RobotGlobals,
    /// Steps a task takes before control goes back to the caller for a moment.
    pub slice_steps: u32,
}
