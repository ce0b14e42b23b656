//! What is probably wrong with a text that can run: warnings, each under the name of its rule.
//!
//! Works on resolved forms, so that what macros make of a text is seen; told are only places in
//! the text itself. A rule that cannot see enough says nothing: a value whose kind is not visible
//! may be any, a function that is not visible may do anything.
//!
//! A comment `; check: allow RULE`, in the line of a warning or in the line above, takes the
//! warning away.

mod behaviours;
mod bindings;
mod calls;
mod conditions;
mod effects;
mod flow;
mod fluents;
mod kinds;
mod names;
mod places;
mod suspension;
mod unknown_places;
mod unused;
mod valve_order;
mod valves;
mod walk;

use crate::code::{Atom, Constant, GlobalKind, Program};
use crate::compile::ir::{Callee, Defined, Function, Ir, IrKind, VarId};
use crate::compile::{NativeSignature, Resolved};
use crate::diagnostic::{Diagnostic, Severity};
use crate::source::Span;
use crate::symbol::{Symbol, Symbols};
use bindings::Bindings;
use effects::Effects;
pub use unknown_places::KnownPlaces;

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

/// The rules, in the order of their documentation.
pub const RULES: &[&str] = &[
    "unused-binding",
    "duplicate-definition",
    "redefines-library",
    "unreachable-code",
    "unreachable-clause",
    "unused-value",
    "endless-loop",
    "policy-never-waits",
    "network-effect",
    "condition-never-changes",
    "fluent-as-value",
    "wrong-kind",
    "unknown-parameter",
    "unknown-place",
    "unknown-slot",
    "unknown-state",
    "wrong-call",
    "wrong-format",
    "valve-order",
    "needs-valve",
    "suspends-itself",
];

/// A behaviour, as a text can use it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BehaviourSignature {
    /// Its keyword parameters, without the colon.
    pub parameters: Vec<String>,
    /// The valve it drives with.
    pub valve: Option<String>,
}

/// A compiled text and all that is known around it.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// All code, this text's included.
    pub program: &'a Program,
    /// The names.
    pub symbols: &'a Symbols,
    /// The native functions, by number.
    pub natives: &'a [NativeSignature],
    /// The behaviours, by number.
    pub behaviours: &'a [BehaviourSignature],
    /// The places of the world, if it is known.
    pub places: Option<&'a KnownPlaces>,
    /// What the library was resolved to.
    pub library: &'a [Resolved],
    /// What the text was resolved to.
    pub text: &'a Resolved,
}

/// The warnings about a text, in order of place. `errors` are what its compilation found: nothing is
/// said about a definition or form that has one. Cost: linear in the text and in what it calls, but
/// for the valves, of which every two requests of concurrent parts are compared.
pub fn check(subject: Subject<'_>, errors: &[Diagnostic]) -> Vec<Diagnostic> {
    let check = Check::new(subject);
    let mut warnings = Vec::new();
    let found = &mut warnings;
    unused::find(&check, found);
    names::find(&check, found);
    flow::find(&check, found);
    effects::find(&check, found);
    conditions::find(&check, found);
    fluents::find(&check, found);
    calls::find(&check, found);
    kinds::find(&check, found);
    behaviours::find(&check, found);
    unknown_places::find(&check, found);
    valve_order::find(&check, found);
    suspension::find(&check, found);
    let faulty = check.faulty(errors);
    warnings.retain(|warning| !faulty.iter().any(|&span| lies_in(warning.span, span)));
    warnings.retain(|warning| !places::is_allowed(&subject.program.sources, warning));
    warnings.sort_by(|a, b| (a.span, a.code, &a.message).cmp(&(b.span, b.code, &b.message)));
    warnings.dedup();
    warnings
}

fn lies_in(inner: Span, outer: Span) -> bool {
    inner.source == outer.source && outer.start <= inner.start && inner.end <= outer.end
}

/// A function of which the body is known.
#[derive(Clone, Copy)]
struct Known<'a> {
    function: &'a Function,
    bindings: &'a Bindings<'a>,
}

/// Everything the rules ask for.
struct Check<'a> {
    subject: Subject<'a>,
    /// By global.
    functions: BTreeMap<u32, (&'a Function, usize)>,
    /// Of the library's texts, then of the text.
    bindings: Vec<Bindings<'a>>,
    /// Names the text may redefine, with care.
    natives: BTreeMap<&'a str, u16>,
    /// By global, found out when they are asked for.
    effects: RefCell<BTreeMap<u32, Rc<Effects>>>,
    /// Whether calls come to an end; none while that is being found out.
    ends: RefCell<BTreeMap<u32, Option<bool>>>,
}

impl<'a> Check<'a> {
    fn new(subject: Subject<'a>) -> Self {
        let mut functions = BTreeMap::new();
        let texts = subject.library.iter().chain([subject.text]);
        for (number, text) in texts.clone().enumerate() {
            for definition in &text.definitions {
                if let Defined::Function(global, function) = &definition.defined {
                    functions.insert(*global, (function, number));
                }
            }
        }
        let natives =
            subject.natives.iter().enumerate().map(|(number, native)| (native.name.as_str(), number as u16)).collect();
        let bindings = texts.map(Bindings::of).collect();
        Self { subject, functions, bindings, natives, effects: RefCell::default(), ends: RefCell::default() }
    }

    fn known(&self, global: u32) -> Option<Known<'_>> {
        let &(function, text) = self.functions.get(&global)?;
        Some(Known { function, bindings: &self.bindings[text] })
    }

    /// Of the text that is checked.
    fn bindings(&self) -> &Bindings<'a> {
        &self.bindings[self.bindings.len() - 1]
    }

    /// Every function of the text that stands at the top: definitions, forms, tests.
    fn roots(&self) -> impl Iterator<Item = &'a Function> + use<'a> {
        let definitions = self.subject.text.definitions.iter().filter_map(|definition| match &definition.defined {
            Defined::Function(_, function) | Defined::Macro(function) => Some(function),
            Defined::Value | Defined::Failure => None,
        });
        definitions.chain(&self.subject.text.forms).chain(&self.subject.text.tests)
    }

    /// The places of definitions and forms that have an error.
    fn faulty(&self, errors: &[Diagnostic]) -> Vec<Span> {
        let definitions = self.subject.text.definitions.iter().map(|definition| definition.span);
        let forms = self.subject.text.forms.iter().chain(&self.subject.text.tests).map(|form| form.span);
        let spans = definitions.chain(forms);
        let is_error = |error: &&Diagnostic| error.severity == Severity::Error;
        spans.filter(|&span| errors.iter().filter(is_error).any(|error| lies_in(error.span, span))).collect()
    }

    fn name(&self, name: Symbol) -> &'a str {
        self.subject.symbols.name(name)
    }

    fn global_name(&self, global: u32) -> &'a str {
        self.name(self.subject.program.globals[global as usize].name)
    }

    fn kind(&self, global: u32) -> &'a GlobalKind {
        &self.subject.program.globals[global as usize].kind
    }

    fn constant(&self, constant: u32) -> &'a Constant {
        &self.subject.program.constants[constant as usize]
    }

    fn variable_name(&self, variable: VarId) -> &'a str {
        self.name(self.subject.text.variables[variable.0 as usize].name)
    }

    /// The name of the native a form calls, and the arguments.
    fn native_call<'i>(&self, ir: &'i Ir) -> Option<(&'a str, &'i [Ir])> {
        match &ir.kind {
            IrKind::Call(Callee::Native(native), arguments) => {
                Some((self.subject.natives[usize::from(*native)].name.as_str(), arguments))
            }
            _ => None,
        }
    }

    /// The symbol a quoted form stands for.
    fn quoted(&self, ir: &Ir) -> Option<Symbol> {
        match ir.kind {
            IrKind::Const(constant) => match self.constant(constant) {
                Constant::Atom(Atom::Symbol(symbol)) => Some(*symbol),
                _ => None,
            },
            _ => None,
        }
    }

    /// The keyword a form is.
    fn keyword(&self, ir: &Ir) -> Option<Symbol> {
        match ir.kind {
            IrKind::Const(constant) => match self.constant(constant) {
                Constant::Atom(Atom::Keyword(symbol)) => Some(*symbol),
                _ => None,
            },
            _ => None,
        }
    }

    /// Whether a place is in the text that is checked, not in the library.
    fn is_own(&self, span: Span) -> bool {
        let library = self.subject.library.iter().flat_map(|text| &text.definitions);
        library.map(|definition| definition.span.source).max().is_none_or(|last| span.source > last)
    }

    /// A warning at a form: the whole of it if it stands in one line, else its head.
    fn warning(
        &self,
        rule: &'static str,
        span: Span,
        message: impl Into<String>,
        label: impl Into<String>,
    ) -> Diagnostic {
        debug_assert!(RULES.contains(&rule), "{rule} is not in the list");
        Diagnostic::warning(rule, places::brief(&self.subject.program.sources, span), message, label)
    }

    /// The name of a form's value as the text writes it, where it can be shown in advice.
    fn shown(&self, ir: &Ir) -> String {
        match ir.kind {
            IrKind::Global(global) => self.global_name(global).to_string(),
            IrKind::Local(variable) => self.variable_name(variable).to_string(),
            _ => places::one_line(&self.subject.program.sources, ir.span),
        }
    }
}
