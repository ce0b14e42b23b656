//! Sessions: a run that lives from form to form, each added to the program that is already there.
//!
//! The main task waits for the next form, runs it, keeps its outcome and waits again; what a form
//! spawns lives on. A definition replaces an older one for every call that is yet to come.

use crate::robot::Outside;
use crate::run::library::{Library, Rejected, has_error};
use crate::run::system::System;
use crate::state::limits::Spent;
use crate::state::task::{Leaving, ScopeKind, State, Waiting};
use crate::state::value::Value;
use rpl_lang::code::Program;
use rpl_lang::code::{Code, CodeKind, GlobalKind};
use rpl_lang::compile::{Loader, NoFiles};
use rpl_lang::diagnostic::Diagnostic;
use rpl_lang::source::Span;
use rpl_lang::symbol::Symbol;
use std::sync::Arc;

/// What the main task of a session runs, and a task beside it. `_` is the value of the last form
/// that succeeded; `%keep` takes it too, if it is to be kept under a name of its own.
const SESSION: &str = "
(def-fluent %form? nil)
(defvar %form nil)
(defvar %outcome nil)
(defvar _ nil \"the value of the last form\")
(defvar %typed 0)
(defvar %answers nil)
(defvar %keep nil)
(defun %beside (%number %form %arguments %kept)
  (let ((%outcome (with-failure-handling ((failure (f) f))
                    (if (eq %arguments t) (list (%form)) (apply %form %arguments)))))
    (unless (failurep %outcome)
      (setq _ (first %outcome))
      (when %kept (%kept _)))
    (push (list %number %outcome) %answers)))
(loop
  (wait-for %form?)
  (setf (value %form?) nil)
  (setq %outcome
    (block form
      (let ((%leave (lambda (why) (return-from form why))) (%kept %keep))
        (with-failure-handling ((failure (f) f))
          (setq _ (%form))
          (when %kept (%kept _))
          'succeeded)))))
";

/// What the text above leaves in `%outcome` when a form has come to its end.
const SUCCEEDED: &str = "succeeded";

/// How a form of a session ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answer {
    /// With a value.
    Succeeded(Value),
    /// With a failure.
    Failed(Value),
    /// It was given up before its end; its clean-ups have run.
    GivenUp,
}

/// What became of a text that was added to a session.
#[derive(Clone, Debug, Default)]
pub struct Submitted {
    /// Warnings.
    pub warnings: Vec<Diagnostic>,
    /// Functions and plans that had a definition already.
    pub redefined: Vec<Redefined>,
}

/// A condition over fluents, compiled into one session's program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Condition(u32);

/// A function or plan with a new definition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Redefined {
    /// Its name.
    pub name: Symbol,
    /// Paths of the living tasks that go on in the old text until it returns.
    pub still_running: Vec<String>,
}

impl<O: Outside> System<O> {
    /// A run without forms, traced, that waits for the first one.
    ///
    /// # Errors
    /// The session's own text does not fit the library, which is a fault of the library.
    pub fn session(library: &Arc<Library>, outside: O, seed: u64) -> Result<Self, Rejected> {
        let loaded = library.load("session", SESSION, &mut NoFiles)?;
        let mut system = Self::traced(library.clone(), loaded, outside, seed);
        system.settle();
        Ok(system)
    }

    /// Compiles a text into the running program and hands its forms to the main task, which must
    /// wait for them. If the text is wrong nothing changes.
    ///
    /// # Errors
    /// The findings in the text.
    pub fn submit(&mut self, name: &str, text: &str, loader: &mut dyn Loader) -> Result<Submitted, Rejected> {
        assert!(self.is_waiting_for_form(), "a form is handed in only when the one before has ended");
        let (form, submitted) = self.extend(name, text, loader)?;
        // Time stands still while somebody types: each form has all steps of an instant.
        self.machine.spent = Spent::default();
        self.set_session_variable("%outcome", Value::Nil);
        self.set_session_variable("%form", Value::Function(form));
        if let Some(Value::Fluent(has_form)) = self.session_variable("%form?") {
            self.with_machine(|machine, around| machine.assign_all(around, &[(has_form, Value::True)]));
        }
        Ok(submitted)
    }

    /// The value of what is handed in next is kept in a variable of this name, if it has one. It is
    /// the run that keeps it, so that it is there again when the run is repeated.
    pub fn keep_value_as(&mut self, name: Option<&str>) {
        let keep = name.map_or(Value::Nil, |name| {
            let text = format!(
                "(defvar {name} nil \"a value that the prompt has shown\")\n(lambda (%value) (setq {name} %value))"
            );
            match self.extend("session", &text, &mut NoFiles) {
                Ok(_) => {
                    let takes_one = |code: &Arc<Code>| code.kind == CodeKind::Function && code.parameters.required == 1;
                    let keeper = self.program.codes.iter().rposition(takes_one);
                    keeper.map_or(Value::Nil, |code| Value::Function(code as u32))
                }
                // A name that something else has keeps nothing.
                Err(_) => Value::Nil,
            }
        });
        self.set_session_variable("%keep", keep);
    }

    /// Compiles a text into the running program and evaluates it beside the form that runs: it may
    /// define functions and plans and look at everything, `variables` included, but neither assign
    /// nor wait. The value, or the failure.
    ///
    /// # Errors
    /// The findings in the text; then nothing changes.
    pub fn inspect(
        &mut self,
        name: &str,
        text: &str,
        variables: &[(Symbol, Value)],
        loader: &mut dyn Loader,
    ) -> Result<(Submitted, Result<Value, Value>), Rejected> {
        let evaluate = |system: &mut Self, code, arguments: &[Value]| {
            system.with_machine(|machine, around| machine.evaluate_code(around, code, arguments))
        };
        // Definitions stand at the top level, so only an expression can be put into a function.
        let names: Vec<&str> = variables.iter().map(|&(name, _)| self.machine.symbols.name(name)).collect();
        let function = format!("(lambda ({}) {text})", names.join(" "));
        if !variables.is_empty()
            && let Ok((form, submitted)) = self.extend(name, &function, loader)
            && let Ok(Value::Function(code)) = evaluate(self, form, &[])
        {
            let values: Vec<Value> = variables.iter().map(|&(_, value)| value).collect();
            return Ok((submitted, evaluate(self, code, &values)));
        }
        let (form, submitted) = self.extend(name, text, loader)?;
        Ok((submitted, evaluate(self, form, &[])))
    }

    /// Compiles a condition over fluents, written as in fluent position, for
    /// [`System::holds`].
    ///
    /// # Errors
    /// The findings in the text.
    pub fn condition(&mut self, text: &str) -> Result<Condition, Rejected> {
        let before = self.program.codes.len();
        self.extend("condition", &format!("(fluent {text})"), &mut NoFiles)?;
        let network = self.program.codes.iter().rposition(|code| code.kind == CodeKind::Network);
        match network.filter(|&code| code >= before) {
            Some(code) => Ok(Condition(code as u32)),
            None => unreachable!("`fluent` compiles to a network"),
        }
    }

    /// Whether a condition holds now.
    ///
    /// # Errors
    /// The failure of its evaluation.
    pub fn holds(&mut self, condition: Condition) -> Result<bool, Value> {
        let value = self.with_machine(|machine, around| machine.evaluate_code(around, condition.0, &[]));
        value.map(|value| value != Value::Nil)
    }

    /// Adds a text to the program: the code of its forms, and what it redefined.
    pub(crate) fn extend(
        &mut self,
        name: &str,
        text: &str,
        loader: &mut dyn Loader,
    ) -> Result<(u32, Submitted), Rejected> {
        let mut program = (*self.program).clone();
        let mut symbols = self.machine.symbols.clone();
        let compiled = self.library.extend(&mut program, &mut symbols, name, text, loader);
        let program = Arc::new(program);
        if has_error(&compiled.diagnostics) {
            return Err(Rejected { diagnostics: compiled.diagnostics, program });
        }
        let redefined = self.redefined(&program);
        self.program = program;
        self.machine.symbols = symbols;
        self.machine.bring_up_to(&self.program, &[]);
        Ok((compiled.main, Submitted { warnings: compiled.diagnostics, redefined }))
    }

    /// Whether the main task has nothing to run.
    pub fn is_waiting_for_form(&self) -> bool {
        let main = &self.machine.tasks[self.machine.main];
        match (main.waiting(), self.session_variable("%form?")) {
            (Some(Waiting::Fluent { fluent, .. }), Some(Value::Fluent(has_form))) => {
                main.state() == State::Blocked && fluent == has_form
            }
            _ => false,
        }
    }

    /// How the last form ended; none while it runs, or before the first.
    pub fn answer(&self) -> Option<Answer> {
        if !self.is_waiting_for_form() {
            return None;
        }
        match self.session_variable("%outcome")? {
            failure @ Value::Failure(_) => Some(Answer::Failed(failure)),
            Value::Symbol(how) if self.machine.symbols.name(how) == SUCCEEDED => {
                Some(Answer::Succeeded(self.session_variable("_")?))
            }
            Value::Symbol(_) => Some(Answer::GivenUp),
            _ => None,
        }
    }

    /// Leaves the form that runs: its clean-ups still run, and the main task waits for the next one.
    pub fn give_up_form(&mut self) {
        let value = Value::Symbol(self.machine.symbols.intern("given-up"));
        self.leave_form(value);
    }

    /// The same, with what it leaves in `%outcome`.
    pub(crate) fn leave_form(&mut self, value: Value) {
        let main = self.machine.main;
        let is_form = |kind: &ScopeKind| matches!(kind, ScopeKind::Block { .. });
        let form = self.machine.tasks[main].scopes.iter().find(|scope| is_form(&scope.kind));
        let Some(ScopeKind::Block { identity, .. }) = form.map(|scope| scope.kind.clone()) else { return };
        if self.machine.tasks[main].is_leaving() {
            return;
        }
        self.with_machine(|machine, around| machine.depart(around, main, Leaving::Block { identity, value }));
    }

    /// Whether it is a session.
    pub(crate) fn is_session(&self) -> bool {
        self.session_global("%form?").is_some()
    }

    pub(crate) fn session_global(&self, name: &str) -> Option<usize> {
        let symbol = self.machine.symbols.find(name)?;
        self.program.names.get(&symbol).map(|&global| global as usize)
    }

    pub(crate) fn session_variable(&self, name: &str) -> Option<Value> {
        self.machine.globals.get(self.session_global(name)?).copied()
    }

    pub(crate) fn set_session_variable(&mut self, name: &str, value: Value) {
        if let Some(global) = self.session_global(name) {
            self.machine.globals[global] = value;
        }
    }

    /// Functions and plans whose definition is another one in `program`.
    fn redefined(&self, program: &Program) -> Vec<Redefined> {
        let pairs = self.program.globals.iter().zip(&program.globals);
        pairs
            .filter(|(old, new)| old.kind != new.kind)
            .filter_map(|(old, _)| match old.kind {
                GlobalKind::Function(code) => Some((old.name, self.program.codes.get(code as usize)?.span)),
                _ => None,
            })
            .map(|(name, old_text)| Redefined { name, still_running: self.running_within(old_text) })
            .collect()
    }

    /// Paths of the living tasks that have a frame in a stretch of text.
    fn running_within(&self, text: Span) -> Vec<String> {
        let is_within = |code: u32| {
            self.program.codes.get(code as usize).is_some_and(|code| {
                code.span.source == text.source && code.span.start >= text.start && code.span.end <= text.end
            })
        };
        let alive = self.machine.tasks.iter().filter(|(_, task)| !task.state().is_dead());
        alive
            .filter(|(_, task)| std::iter::once(&task.frame).chain(&*task.frames).any(|frame| is_within(frame.code)))
            .map(|(index, _)| self.machine.path(index))
            .collect()
    }
}
