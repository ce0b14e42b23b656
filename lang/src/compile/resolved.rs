//! What a text is resolved to, and what its compilation gives.

use super::ir::{Function, Variable};
use crate::code::CodeKind;
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::symbol::Symbol;
use std::sync::Arc;

/// What a text was resolved to, before registers: what [`crate::check`] looks at.
#[derive(Clone, Debug, Default)]
pub struct Resolved {
    /// In the order of the text, loaded files in their place.
    pub(crate) definitions: Vec<Definition>,
    /// What runs, in order: forms, and the values of definitions.
    pub(crate) forms: Vec<Function>,
    /// Bodies of tests.
    pub(crate) tests: Vec<Function>,
    /// By number.
    pub(crate) variables: Vec<Variable>,
}

impl Resolved {
    /// What the text defines, in its order, each with the whole form; a form can define several names.
    pub fn defined(&self) -> impl Iterator<Item = (Symbol, Span, DefinedKind)> {
        self.definitions.iter().map(|definition| {
            let kind = match &definition.defined {
                Defined::Function(_, function) => DefinedKind::Function(function.kind),
                Defined::Macro(_) => DefinedKind::Macro,
                Defined::Value => DefinedKind::Value,
                Defined::Failure => DefinedKind::Failure,
            };
            (definition.name, definition.span, kind)
        })
    }

    /// The name of a variable of the text by its number, and where it is bound.
    pub fn variable(&self, number: u32) -> Option<(Symbol, Span)> {
        self.variables.get(number as usize).map(|variable| (variable.name, variable.span))
    }
}

/// What a form of a text defines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DefinedKind {
    /// A function or plan.
    Function(CodeKind),
    /// A macro.
    Macro,
    /// A variable, constant, fluent or valve.
    Value,
    /// A class of failure.
    Failure,
}

/// A definition of the text.
#[derive(Clone, Debug)]
pub(crate) struct Definition {
    pub(crate) name: Symbol,
    /// The whole form.
    pub(crate) span: Span,
    pub(crate) defined: Defined,
}

/// What a definition defines.
#[derive(Clone, Debug)]
pub(crate) enum Defined {
    /// A function or plan, and its global.
    Function(u32, Function),
    Macro(Function),
    /// A variable, constant, fluent or valve.
    Value,
    /// A class of failure, with a namespace of its own.
    Failure,
}

/// A top-level form with something to run.
pub(crate) enum TopLevel {
    /// The value of a definition.
    Definition(Function),
    /// A form of the main task.
    Form(Function),
    /// A test and its body.
    Test(TestForm, Function),
}

/// A test that can be run.
#[derive(Clone, Debug, PartialEq)]
pub struct Test {
    /// Its name, alone among the tests of its text.
    pub name: Arc<str>,
    /// What it is about.
    pub doc: Option<Arc<str>>,
    /// What it runs with.
    pub options: TestOptions,
    /// Code without parameters that runs the definitions of the text and then the test; the other
    /// forms of the text do not run.
    pub code: u32,
    /// Its place.
    pub span: Span,
}

/// What a test asks for; whatever it leaves out is up to the command that runs it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TestOptions {
    /// `:world`: the world the robot is in.
    pub world: Option<Arc<str>>,
    /// `:scenario`: a plan with hands in the world.
    pub scenario: Option<Arc<str>>,
    /// `:seed` of every random stream.
    pub seed: Option<u64>,
    /// `:until`: the time of the plan by which it must have ended.
    pub until_s: Option<f64>,
}

/// A test without its code.
pub(crate) struct TestForm {
    pub(super) name: Arc<str>,
    pub(super) doc: Option<Arc<str>>,
    pub(super) options: TestOptions,
    pub(super) span: Span,
}

impl TestForm {
    pub(super) fn with_code(self, code: u32) -> Test {
        let TestForm { name, doc, options, span } = self;
        Test { name, doc, options, code, span }
    }
}

/// The result of a compilation: the code of its forms, and the findings.
#[derive(Clone, Debug)]
pub struct Compiled {
    /// Code without parameters that runs the forms in order; its value is the last form's.
    pub main: u32,
    /// The tests of the text, in order; those of loaded files are not among them.
    pub tests: Vec<Test>,
    /// Errors and warnings.
    pub diagnostics: Vec<Diagnostic>,
    /// What the text was resolved to.
    pub resolved: Resolved,
    /// The codes that were added to the program.
    pub codes: Vec<u32>,
    /// The constants that were added.
    pub constants: Vec<u32>,
    /// Parts that macros have made.
    pub expanded: usize,
    /// Whether they would have made more than they might.
    pub lacks_room: bool,
}

impl Compiled {
    /// Whether the text defines something that stays.
    pub fn defines(&self) -> bool {
        !self.resolved.definitions.is_empty()
    }
}
