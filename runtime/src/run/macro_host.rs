//! Runs macros at compile time, in a machine of their own without tasks.

use crate::robot::{NoRobot, RobotGlobals};
use crate::run::datum;
use crate::run::datum::{Origins, Unfit};
use crate::state::failure::Raise;
use crate::state::limits::Limits;
use crate::state::machine::Machine;
use crate::state::value::Value;
use crate::step::exec::budget::EVALUATION_SHARE;
use crate::step::native::{Native, Surroundings};
use rpl_lang::code::Program;
use rpl_lang::compile::{MacroHost, NativeSignature, Unexpanded};
use rpl_lang::diagnostic::{Diagnostic, NOT_OF_THE_FORM};
use rpl_lang::symbol::Symbols;
use rpl_lang::syntax::{NodeId, Tree};
use rpl_random::Stream;
use std::sync::Arc;

/// Steps one expansion may take.
const MAX_STEPS: u32 = 20_000_000;

/// Steps all expansions of a text may take: a text full of endless macros is refused in seconds.
const MAX_STEPS_OF_A_TEXT: u64 = 100_000_000;

/// What macros make may take this share of the memory of a run.
const SHARE_OF_MEMORY: usize = 8;

/// What a machine that is kept may have made and not given back.
const MAX_KEPT_BYTES: usize = 1 << 20;

/// The machine macros run in.
pub struct MacroMachine {
    machine: Machine,
    /// Steps of all expansions so far.
    steps: u64,
    /// Globals that were defined since the last expansion.
    defined: Vec<u32>,
    /// Whether an expansion has come to the limit of memory.
    ran_out: bool,
    natives: Arc<[Native]>,
    signatures: Arc<[NativeSignature]>,
}

/// The machine that expands macros in data, kept from one datum to the next: it has taken in the
/// constants of the program so far. No part of the state.
#[derive(Default)]
pub(crate) struct Macros(pub(crate) Option<Box<MacroMachine>>);

impl Clone for Macros {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl MacroMachine {
    /// A machine for the macros of a program.
    pub fn new(program: &Program, natives: Arc<[Native]>, signatures: Arc<[NativeSignature]>) -> Self {
        let machine = Machine::new(program, Symbols::default(), Stream::new(0, "macros"), Stream::new(0, "foresight"));
        let mut host = Self { machine, steps: 0, defined: Vec::new(), ran_out: false, natives, signatures };
        host.begin(program, Limits::default().bytes);
        host
    }

    /// Begins another text of a run with `memory_bytes` of memory: it has a budget of its own.
    pub(crate) fn begin(&mut self, program: &Program, memory_bytes: usize) {
        self.steps = 0;
        self.machine.bring_up_to(program, &[]);
        self.defined.clear();
        self.machine.limits.steps = MAX_STEPS * EVALUATION_SHARE;
        self.machine.limits.bytes = memory_bytes / SHARE_OF_MEMORY;
        self.ran_out = false;
    }

    /// Steps of all expansions of the text so far.
    pub(crate) fn steps(&self) -> u64 {
        self.steps
    }

    /// Whether an expansion of the text has come to the limit of memory. Another machine may have more
    /// left of it, if this one has expanded other texts before.
    pub(crate) fn has_run_out(&self) -> bool {
        self.ran_out
    }

    /// Whether what it has made takes so little that it may wait for the next text.
    pub(crate) fn is_small(&self) -> bool {
        self.machine.heap.allocated < MAX_KEPT_BYTES
    }

    fn run(
        &mut self,
        program: &Program,
        tree: &Tree,
        code: u32,
        form: NodeId,
        origins: &mut Origins,
    ) -> Result<Value, Value> {
        self.machine.bring_up_constants(program, &[]);
        self.machine.bring_up_globals(program, self.defined.drain(..));
        let arguments: Vec<Value> = tree.items(form)[1..]
            .iter()
            .map(|&item| datum::to_value(&mut self.machine.heap, &self.machine.symbols, tree, item, origins))
            .collect();
        let mut around = Surroundings {
            program,
            natives: &self.natives,
            signatures: &self.signatures,
            outside: &mut NoRobot,
            robot: RobotGlobals::NONE,
            // What is evaluated without a task is not cut.
            slice_steps: u32::MAX,
        };
        self.machine.scratch.burned = 0;
        let result = self.machine.evaluate_function(&mut around, code, &arguments);
        self.steps += u64::from(self.machine.scratch.burned);
        result
    }

    fn diagnostic(&self, program: &Program, failure: Value, tree: &Tree, form: NodeId) -> Diagnostic {
        let span = tree.span(form);
        // A macro of the language says of what form its call is to be, as a special form does.
        if let Value::Failure(index) = failure
            && let Some(expected) = self.machine.heap.failures[index].message.strip_prefix(NOT_OF_THE_FORM)
        {
            let message = format!("{NOT_OF_THE_FORM}{expected}");
            return Diagnostic::error("malformed", span, message, format!("expected {expected}"));
        }
        let text = self.machine.show(program, failure);
        let mut diagnostic =
            Diagnostic::error("macro", span, format!("this macro call cannot be expanded: {text}"), "in this call");
        if let Value::Failure(index) = failure
            && let Some(place) = self.machine.heap.failures[index].span
        {
            diagnostic = diagnostic.related(place, "raised here");
        }
        diagnostic
    }
}

impl MacroHost for MacroMachine {
    fn expand(
        &mut self,
        program: &Program,
        symbols: &mut Symbols,
        tree: &mut Tree,
        code: u32,
        form: NodeId,
        most: usize,
    ) -> Result<NodeId, Unexpanded> {
        if self.steps > MAX_STEPS_OF_A_TEXT {
            return Err(Unexpanded::TooLong { steps: MAX_STEPS_OF_A_TEXT });
        }
        // The machine interns into the compiler's own table while it runs.
        std::mem::swap(&mut self.machine.symbols, symbols);
        let mut origins = Origins::default();
        let result = self.run(program, tree, code, form, &mut origins);
        std::mem::swap(&mut self.machine.symbols, symbols);
        let span = tree.span(form);
        let expansion = match result {
            Ok(value) => {
                let mut objects = Vec::new();
                let heap = &self.machine.heap;
                let node = datum::to_node(heap, symbols, tree, value, span, Some(&mut origins), &mut objects, most);
                match (node, objects.first()) {
                    (Ok(node), None) => {
                        origins.place_loose(tree, form);
                        Ok(node)
                    }
                    (Err(Unfit::Circle), _) => {
                        Err(Diagnostic::error("macro", span, "the expansion is a circular list", "in this call"))
                    }
                    (Err(Unfit::TooLarge), _) => return Err(Unexpanded::TooLarge),
                    (Ok(_), Some(object)) => {
                        let message = format!("the expansion contains {}, which has no text", object.type_name());
                        Err(Diagnostic::error("macro", span, message, "in this call"))
                    }
                }
            }
            Err(failure) => {
                self.ran_out |= matches!(failure, Value::Failure(index)
                    if symbols.name(self.machine.heap.failures[index].class) == "out-of-memory");
                std::mem::swap(&mut self.machine.symbols, symbols);
                let diagnostic = self.diagnostic(program, failure, tree, form);
                std::mem::swap(&mut self.machine.symbols, symbols);
                Err(diagnostic)
            }
        };
        if self.machine.heap.is_full() {
            self.machine.collect();
        }
        expansion.map_err(|diagnostic| Unexpanded::Failed(Box::new(diagnostic)))
    }

    fn defined(&mut self, global: u32) {
        self.defined.push(global);
    }
}

impl Machine {
    /// Calls a function by its code, without a task.
    fn evaluate_function(
        &mut self,
        around: &mut Surroundings<'_>,
        code: u32,
        arguments: &[Value],
    ) -> Result<Value, Value> {
        let callee = &around.program.codes[code as usize];
        if self.scratch.stack.len() < arguments.len() + 512 {
            self.scratch.stack.resize(arguments.len() + 1024, Value::Nil);
        }
        let top = self.scratch.top;
        self.scratch.stack[top..top + arguments.len()].copy_from_slice(arguments);
        let arranged = self.arrange(callee, top, arguments.len());
        let count = callee.parameters.registers();
        if let Err(raise) = arranged {
            let raise = match raise {
                Raise::New { message, .. } => Raise::new("arity-error", message),
                again => again,
            };
            return Err(self.failure_from(raise));
        }
        let arranged = self.scratch.stack[top..top + count].to_vec();
        self.evaluate_code(around, code, &arranged)
    }
}
