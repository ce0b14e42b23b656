//! Register code: what a plan is compiled to. The list of [`Op`]s is its specification.
//!
//! A frame has up to 256 registers. A call's arguments are its callee's first registers, so the
//! callee's window starts at the caller's first argument and the result is found there. A closure's
//! captured values follow the parameters. Variables that are both captured and assigned live in
//! heap cells; their register holds the cell.

use crate::source::{Sources, Span};
use crate::symbol::Symbol;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

// Every instruction fits eight bytes.
const _: () = assert!(size_of::<Op>() == 8);

/// A register of the current frame.
pub type Reg = u8;

/// No register, where one is optional.
pub const NO_REG: Reg = 255;

/// The count of no call: what is called has its arguments arranged.
pub const ARRANGES: u16 = u16::MAX;

/// One instruction. Jumps are relative to the next instruction; a jump backwards and every call
/// burn one unit of the task's step budget.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Op {
    /// `r0 := nil`
    Nil(Reg),
    /// `r0 := t`
    True(Reg),
    /// `r0 := integer`
    Int(Reg, i32),
    /// `r0 := constants[i]`
    Const(Reg, u32),
    /// `r0 := globals[i]`; `unbound-variable` if it has no value yet
    Global(Reg, u32),
    /// `globals[i] := r0`
    SetGlobal(Reg, u32),
    /// `globals[i] := a fluent with the initial value r0`
    DefFluent(Reg, u32),
    /// `r0 := r1`
    Move(Reg, Reg),
    /// `r0 := a new cell holding r1`
    CellNew(Reg, Reg),
    /// `r0 := contents of cell r1`
    CellGet(Reg, Reg),
    /// contents of cell r0 `:= r1`
    CellSet(Reg, Reg),
    /// `r0 := r1 + r2`
    Add(Reg, Reg, Reg),
    /// `r0 := r1 − r2`
    Sub(Reg, Reg, Reg),
    /// `r0 := r1 · r2`
    Mul(Reg, Reg, Reg),
    /// `r0 := r1 + integer`
    AddInt(Reg, Reg, i16),
    /// `r0 := r1 < r2`
    Less(Reg, Reg, Reg),
    /// `r0 := r1 ≤ r2`
    LessEq(Reg, Reg, Reg),
    /// `r0 := r1 = r2`, numbers only
    NumEq(Reg, Reg, Reg),
    /// `r0 := r1 eq r2`
    Eq(Reg, Reg, Reg),
    /// `r0 := not r1`
    Not(Reg, Reg),
    /// `r0 := (r1 . r2)`
    Cons(Reg, Reg, Reg),
    /// `r0 := car r1`
    Car(Reg, Reg),
    /// `r0 := cdr r1`
    Cdr(Reg, Reg),
    /// go on elsewhere
    Jump(i32),
    /// if r0 is nil
    JumpIfNil(Reg, i32),
    /// if r0 is not nil
    JumpIfTrue(Reg, i32),
    /// if the optional parameter r0 was given
    JumpIfGiven(Reg, i32),
    /// unless `r0 < r1`
    JumpUnlessLess(Reg, Reg, i32),
    /// unless `r0 ≤ r1`
    JumpUnlessLessEq(Reg, Reg, i32),
    /// unless `r0 = r1`
    JumpUnlessNumEq(Reg, Reg, i32),
    /// unless `r0 < integer`
    JumpUnlessLessInt(Reg, i16, i32),
    /// unless `r0 ≤ integer`
    JumpUnlessLessEqInt(Reg, i16, i32),
    /// unless `r0 > integer`
    JumpUnlessGreaterInt(Reg, i16, i32),
    /// unless `r0 ≥ integer`
    JumpUnlessGreaterEqInt(Reg, i16, i32),
    /// unless `r0 = integer`
    JumpUnlessNumEqInt(Reg, i16, i32),
    /// call the function in a global; arguments from r0, count, global; result in r0
    Call(Reg, u8, u32),
    /// the same in tail position
    TailCall(Reg, u8, u32),
    /// call the value in r0; arguments from r0 + 1; result in r0 + 1
    CallValue(Reg, u8),
    /// the same in tail position
    TailCallValue(Reg, u8),
    /// run code i, which takes no arguments; result in r0
    CallCode(Reg, u32),
    /// `r0 := native(arguments from r1, count)`
    CallNative(Reg, Reg, u8, u16),
    /// `r0 := closure over code i`, capturing the registers that code names
    Closure(Reg, u32),
    /// end the frame with the value r0
    Return(Reg),
    /// the body of a plan begins: a node of the task tree
    EnterPlan,
    /// the body of a plan has the value r0: children it spawned are evaporated first
    LeavePlan(Reg),
    /// `r0 := a task not yet reached`, for the tag with this name (a constant)
    TagNew(Reg, u32),
    /// run a construct of concurrent children, `constructs[i]`; its value goes to r0
    Parallel(Reg, u32),
    /// the same, one child for each element of the list in r1
    ParallelMap(Reg, Reg, u32),
    /// `r0 := spawn` of `constructs[i]`
    Spawn(Reg, u32),
    /// a block that is left from inside a closure: its identity goes to r0; when it is left, its
    /// value goes to r1 and execution goes on at the target
    PushBlock(Reg, Reg, i32),
    /// leave the block whose identity is in r0 with the value r1
    ReturnFrom(Reg, Reg),
    /// failures of `handlers[i]` are caught: failure in r0, number of the clause in r0 + 1
    PushHandler(Reg, u16, i32),
    /// clean-up at the target whenever the following is left early
    PushCleanup(i32),
    /// the protected part ended by itself: pop, and run the clean-up that follows
    BeginCleanup,
    /// the clean-up has run: go on with whatever was under way
    EndCleanup,
    /// wait for the valve in r0, hold it until the scope ends
    PushValve(Reg),
    /// the closure in r0 runs when the subtree is interrupted
    PushOnInterrupt(Reg),
    /// the closure in r0 runs when the subtree gets its valve back
    PushOnResume(Reg),
    /// the task in r0 is suspended until the scope ends
    PushSuspended(Reg),
    /// count from now on how often the fluent in r0 becomes true; a network made for this alone
    /// dies with it
    PushWatch(Reg, Missed, bool),
    /// wait until the watched fluent has become true
    WatchWait,
    /// the body of the watch has run
    WatchDone,
    /// leave the innermost scopes: count
    PopScopes(u8),
    /// leave a number of scopes early, running their clean-ups, then jump
    LeaveScopes(u8, i32),
    /// `r0 := network` evaluated by code i
    Network(Reg, u32),
    /// `r0 := wait for the fluent r1`, at most r2 seconds; a network made for this wait alone dies
    /// with it
    WaitFor(Reg, Reg, Reg, bool),
    /// `r0 := value of r1` if that is a fluent, else r1
    Deref(Reg, Reg),
    /// assign r2 to the fluent r1; `r0 := r2`
    Assign(Reg, Reg, Reg),
    /// raise the failure in r0 again
    Refail(Reg),
}

impl Op {
    /// Whether a stepper stops before it: it calls, waits, assigns, or opens a construct.
    pub fn is_step(&self) -> bool {
        matches!(
            self,
            Op::Call(..)
                | Op::TailCall(..)
                | Op::CallValue(..)
                | Op::TailCallValue(..)
                | Op::CallNative(..)
                | Op::SetGlobal(..)
                | Op::DefFluent(..)
                | Op::CellSet(..)
                | Op::Assign(..)
                | Op::Parallel(..)
                | Op::ParallelMap(..)
                | Op::Spawn(..)
                | Op::PushValve(..)
                | Op::PushSuspended(..)
                | Op::PushWatch(..)
                | Op::WaitFor(..)
                | Op::ReturnFrom(..)
                | Op::Refail(..)
        )
    }

    /// The register that has the value of the form when the instruction is done, if it has one.
    pub fn value_register(&self) -> Option<Reg> {
        match *self {
            Op::Call(reg, ..)
            | Op::CallNative(reg, ..)
            | Op::SetGlobal(reg, _)
            | Op::DefFluent(reg, _)
            | Op::Parallel(reg, _)
            | Op::ParallelMap(reg, ..)
            | Op::Spawn(reg, _)
            | Op::WaitFor(reg, ..) => Some(reg),
            Op::CallValue(reg, _) => Some(reg + 1),
            _ => None,
        }
    }
}

/// What a `whenever` does with events that come while its body runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Missed {
    /// One more round, however many there were.
    Once,
    /// One round for each.
    Always,
    /// None.
    Never,
}

/// How the children of a construct decide its outcome.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Rule {
    /// All must succeed.
    Par,
    /// The first to end decides.
    Pursue,
    /// The first success wins.
    TryAll,
    /// All must succeed, in a partial order.
    Plan,
    /// Child 0 is the policy, child 1 the primary activity.
    Policy,
    /// One child; its outcome is the construct's.
    Single,
    /// One child with a deadline.
    Timeout,
}

impl Rule {
    /// The name in the text and in paths.
    pub fn name(self) -> &'static str {
        match self {
            Rule::Par => "par",
            Rule::Pursue => "pursue",
            Rule::TryAll => "try-all",
            Rule::Plan => "plan",
            Rule::Policy => "with-policy",
            Rule::Single => "task",
            Rule::Timeout => "with-timeout",
        }
    }
}

/// One child of a construct.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Child {
    /// Its code.
    pub code: u32,
    /// The register whose value (or cell) is the tag's task; [`NO_REG`] if it has no tag.
    pub tag: Reg,
    /// Whether the tag's register holds a cell.
    pub tag_in_cell: bool,
    /// A tag's or process' name, a symbol; else the child is named after the construct.
    pub name: Option<Symbol>,
}

/// A construct of concurrent children.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Construct {
    /// How the outcome is decided.
    pub rule: Rule,
    /// The construct's name in paths.
    pub name: Symbol,
    /// In the order of position.
    pub children: Vec<Child>,
    /// For [`Rule::Plan`]: the second starts when the first is dead.
    pub order: Vec<(u16, u16)>,
    /// Seconds of a timeout, number of a priority; [`NO_REG`] if none.
    pub argument: Reg,
    /// Whether the argument is a priority to append.
    pub with_priority: bool,
    /// Whether a timeout counts only the time in which the body is not suspended.
    pub active: bool,
}

/// The parameters of a function.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// Must be given.
    pub required: u8,
    /// May be given, in order.
    pub optional: u8,
    /// Whether further arguments are collected in a list.
    pub rest: bool,
    /// May be given by name.
    pub keys: Vec<Symbol>,
}

impl Parameters {
    /// Whether a call passes exactly the required parameters and nothing needs to be arranged.
    pub fn is_simple(&self) -> bool {
        self.optional == 0 && !self.rest && self.keys.is_empty()
    }

    /// The number of arguments of a call that needs nothing arranged; [`ARRANGES`] if there is none.
    pub fn exact_count(&self) -> u16 {
        if self.is_simple() { u16::from(self.required) } else { ARRANGES }
    }

    /// How many registers the parameters take.
    pub fn registers(&self) -> usize {
        usize::from(self.required) + usize::from(self.optional) + usize::from(self.rest) + self.keys.len()
    }

    /// Whether a call with this many arguments can be right.
    pub fn accepts(&self, count: usize) -> bool {
        let positional = usize::from(self.required) + usize::from(self.optional);
        count >= usize::from(self.required) && (count <= positional || self.rest || !self.keys.is_empty())
    }

    /// "2 arguments", "at least 1 argument", as errors say it.
    pub fn describe(&self) -> String {
        let required = usize::from(self.required);
        let plural = |count: usize| if count == 1 { "1 argument".to_string() } else { format!("{count} arguments") };
        if self.rest || !self.keys.is_empty() {
            format!("at least {}", plural(required))
        } else if self.optional > 0 {
            format!("{required} to {}", plural(required + usize::from(self.optional)))
        } else {
            plural(required)
        }
    }
}

/// What kind of body a code is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum CodeKind {
    /// A function or closure.
    Function,
    /// A plan: its calls are nodes of the task tree.
    Plan,
    /// The body of a task.
    Task,
    /// The expression of a network.
    Network,
}

/// A variable of the text and where it is found while code runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Local {
    /// Its name in the text.
    pub name: Symbol,
    /// Its register, or that of the cell that holds it.
    pub register: Reg,
    /// The first instruction at which it has its value.
    pub from: u32,
    /// One past the last instruction of its scope.
    pub to: u32,
}

/// A compiled body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Code {
    /// The name it has in the text, or what it is.
    pub name: Symbol,
    /// What kind of body it is.
    pub kind: CodeKind,
    /// Its parameters.
    pub parameters: Parameters,
    /// The frame's size, parameters and captured values included.
    pub registers: u8,
    /// A call with so many arguments needs nothing checked or arranged; [`ARRANGES`] if none does.
    pub exact_count: u16,
    /// Registers of the frame that makes the closure, in the order of the captured values.
    pub captures: Vec<Reg>,
    /// The instructions.
    pub ops: Vec<Op>,
    /// The place of each instruction.
    pub spans: Vec<Span>,
    /// Constructs that [`Op::Parallel`], [`Op::ParallelMap`] and [`Op::Spawn`] name.
    pub constructs: Vec<Construct>,
    /// Classes of failure that [`Op::PushHandler`] names, one list of classes a clause.
    pub handlers: Vec<Vec<Vec<Symbol>>>,
    /// Variables, in the order of their binding.
    pub locals: Vec<Local>,
    /// Documentation string.
    pub doc: Option<Arc<str>>,
    /// The whole definition.
    pub span: Span,
}

/// A constant that has no parts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Atom {
    /// An integer that does not fit [`Op::Int`].
    Int(i64),
    /// A float.
    Float(f64),
    /// A string.
    Str(Arc<str>),
    /// A symbol; `nil` and `t` are not symbols at run time.
    Symbol(Symbol),
    /// A keyword.
    Keyword(Symbol),
    /// `nil`
    Nil,
    /// `t`
    True,
    /// A native function.
    Native(u16),
    /// An object of the running system, by the index its compiler call gave.
    Object(u32),
}

/// A part of a quoted list. The parts stand in the order in which a stack builds the list, so that
/// copying, comparing, writing or dropping it costs no Rust stack, however deep it nests.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Part {
    /// An element.
    Atom(Atom),
    /// The list of so many elements before it.
    List {
        /// How many, the tail not included.
        length: u32,
        /// Whether one more, the last, is the tail after the dot.
        dotted: bool,
    },
}

/// A constant of the text.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Constant {
    /// What has no parts.
    Atom(Atom),
    /// A list; the last part makes it of those before.
    List(Vec<Part>),
}

impl From<Atom> for Constant {
    fn from(atom: Atom) -> Self {
        Constant::Atom(atom)
    }
}

/// What a global name stands for, as far as the text knows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum GlobalKind {
    /// A function or plan: its code.
    Function(u32),
    /// A variable.
    Variable,
    /// A constant: never assigned.
    Constant,
    /// A fluent.
    Fluent,
    /// A valve.
    Valve,
    /// A behaviour, by its number in the robot's table.
    Behaviour(u16),
}

/// A global name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Global {
    /// Its name.
    pub name: Symbol,
    /// What it stands for.
    pub kind: GlobalKind,
    /// Documentation string.
    pub doc: Option<Arc<str>>,
    /// Where it is defined; none for what the library or the robot brings.
    pub span: Option<Span>,
}

/// A class of failure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FailureClass {
    /// The class above it; none for `failure`.
    pub parent: Option<Symbol>,
    /// Its own slots.
    pub slots: Vec<Symbol>,
}

/// All code of a system. What was there at its start, and what is defined later, stays; code that runs
/// once can be given back.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Program {
    /// All bodies.
    pub codes: Vec<Arc<Code>>,
    /// All constants.
    pub constants: Vec<Constant>,
    /// All global names; a name defined again in a file has a second entry.
    pub globals: Vec<Global>,
    /// Which global a name means now.
    pub names: BTreeMap<Symbol, u32>,
    /// Macros: their code.
    pub macros: BTreeMap<Symbol, u32>,
    /// The tree of failure classes.
    pub failure_classes: BTreeMap<Symbol, FailureClass>,
    /// The texts.
    pub sources: Sources,
    /// Places of codes that were given back, and are used again.
    pub free_codes: Vec<u32>,
    /// Places of constants that were given back.
    pub free_constants: Vec<u32>,
    /// How many globals belong to the library and the robot; those may be defined again.
    pub library_globals: u32,
    /// How many texts are the library's and the robot's; a failure in them is shown where the plan
    /// calls them.
    pub library_sources: u32,
}

/// What an allocator adds to the tables of a code.
const BLOCKS_OF_CODE: usize = 160;

impl Code {
    /// Bytes it takes.
    pub fn bytes(&self) -> usize {
        let children = self.constructs.iter().map(|construct| size_of_val(construct.children.as_slice()));
        size_of::<Self>()
            + BLOCKS_OF_CODE
            + size_of_val(self.captures.as_slice())
            + size_of_val(self.ops.as_slice())
            + size_of_val(self.spans.as_slice())
            + size_of_val(self.locals.as_slice())
            + self.constructs.len() * size_of::<Construct>()
            + children.sum::<usize>()
            + self.handlers.len() * size_of::<Vec<Vec<Symbol>>>()
    }

    /// What stands in a place that was given back.
    fn none(code: &Code) -> Self {
        let (name, span) = (code.name, code.span);
        Self {
            name,
            kind: CodeKind::Function,
            parameters: Parameters::default(),
            registers: 1,
            exact_count: 0,
            captures: Vec::new(),
            ops: vec![Op::Return(0)],
            spans: vec![span],
            constructs: Vec::new(),
            handlers: Vec::new(),
            locals: Vec::new(),
            doc: None,
            span,
        }
    }
}

impl Program {
    /// Adds a code and gives its number.
    pub fn add_code(&mut self, code: Code) -> u32 {
        let code = Arc::new(code);
        match self.free_codes.pop() {
            Some(place) => {
                self.codes[place as usize] = code;
                place
            }
            None => {
                self.codes.push(code);
                self.codes.len() as u32 - 1
            }
        }
    }

    /// Adds a constant and gives its number.
    pub fn add_constant(&mut self, constant: Constant) -> u32 {
        match self.free_constants.pop() {
            Some(place) => {
                self.constants[place as usize] = constant;
                place
            }
            None => {
                self.constants.push(constant);
                self.constants.len() as u32 - 1
            }
        }
    }

    /// Gives the place of a code back that nothing refers to.
    pub fn free_code(&mut self, code: u32) {
        let none = Code::none(&self.codes[code as usize]);
        self.codes[code as usize] = Arc::new(none);
        self.free_codes.push(code);
    }

    /// Gives the place of a constant back that nothing refers to.
    pub fn free_constant(&mut self, constant: u32) {
        self.constants[constant as usize] = Constant::Atom(Atom::Nil);
        self.free_constants.push(constant);
    }

    /// Whether `class` is `ancestor` or below it.
    pub fn is_failure_subclass(&self, class: Symbol, ancestor: Symbol) -> bool {
        let mut at = Some(class);
        while let Some(class) = at {
            if class == ancestor {
                return true;
            }
            at = self.failure_classes.get(&class).and_then(|known| known.parent);
        }
        false
    }

    /// The slots of a class, inherited ones first.
    pub fn failure_slots(&self, class: Symbol) -> Vec<Symbol> {
        let mut lines = Vec::new();
        let mut at = self.failure_classes.get(&class);
        while let Some(known) = at {
            lines.push(known.slots.as_slice());
            at = known.parent.and_then(|parent| self.failure_classes.get(&parent));
        }
        lines.into_iter().rev().flatten().copied().collect()
    }
}
