//! What the rules look at: the text, what it was resolved to, and all that is known around it.

use super::bindings::Bindings;
use super::places;
use super::rules::RULES;
use crate::code::{Atom, Constant, GlobalKind, Program};
use crate::compile::ir::{Callee, Function, Ir, IrKind, VarId};
use crate::compile::resolved::Defined;
use crate::compile::{NativeSignature, Resolved};
use crate::diagnostic::{Diagnostic, Severity};
use crate::kind::Kind;
use crate::lexer::{Token, lex};
use crate::name_places::find_name;
use crate::source::{SourceId, Span, lies_in};
use crate::symbol::{Symbol, Symbols};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

/// Tags that a name is compared with.
const MOST_TAGS: usize = 1_000;

/// A behaviour, as a text can use it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BehaviourSignature {
    /// Its keyword parameters, without the colon.
    pub parameters: Vec<String>,
    /// The valve it drives with.
    pub valve: Option<String>,
}

/// The places a plan can go to, as far as they are known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KnownPlaces {
    /// The name of the world.
    pub world: String,
    /// All its places.
    pub names: Vec<String>,
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

/// A function of which the body is known.
#[derive(Clone, Copy)]
pub(super) struct KnownFunction<'a> {
    pub(super) function: &'a Function,
    pub(super) bindings: &'a Bindings<'a>,
}

/// What a form does by itself, and what it calls.
#[derive(Clone, Debug, Default)]
pub(super) struct Effects {
    /// Functions called, or given to what is called.
    pub(super) calls: Vec<u32>,
    /// What a network may not do: the place, and what is done there.
    pub(super) acts: Option<(Span, &'static str)>,
    /// Whether it may wait, or end in a way that is not seen.
    pub(super) waits: bool,
    pub(super) fails: bool,
}

/// The words of a text with their places.
pub(super) type Tokens = Rc<Vec<(Token, Span)>>;

/// Everything the rules ask for.
pub(super) struct Check<'a> {
    pub(super) subject: Subject<'a>,
    /// By global.
    pub(super) functions: BTreeMap<u32, (&'a Function, usize)>,
    /// Of the library's texts, then of the text.
    pub(super) bindings: Vec<Bindings<'a>>,
    /// Names the text may redefine, with care.
    pub(super) natives: BTreeMap<&'a str, u16>,
    /// By global, found out when they are asked for.
    pub(super) effects: RefCell<BTreeMap<u32, Rc<Effects>>>,
    /// Whether calls come to an end; none while that is being found out.
    pub(super) ends: RefCell<BTreeMap<u32, Option<bool>>>,
    /// The words of texts, without comments, found out when they are asked for.
    tokens: RefCell<BTreeMap<SourceId, Tokens>>,
    /// The first tags of texts, found out when they are asked for.
    tags: RefCell<BTreeMap<SourceId, Rc<Vec<Span>>>>,
    /// The kinds of the library's parameters, by global and position, found out when they are asked for.
    pub(super) parameter_kinds: RefCell<BTreeMap<(u32, usize), Kind>>,
}

impl<'a> Check<'a> {
    pub(super) fn new(subject: Subject<'a>) -> Self {
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
        Self {
            subject,
            functions,
            bindings,
            natives,
            effects: RefCell::default(),
            ends: RefCell::default(),
            tokens: RefCell::default(),
            tags: RefCell::default(),
            parameter_kinds: RefCell::default(),
        }
    }

    pub(super) fn known(&self, global: u32) -> Option<KnownFunction<'_>> {
        let &(function, text) = self.functions.get(&global)?;
        Some(KnownFunction { function, bindings: &self.bindings[text] })
    }

    /// Of the text that is checked.
    pub(super) fn bindings(&self) -> &Bindings<'a> {
        &self.bindings[self.bindings.len() - 1]
    }

    /// The functions that the text defines, by global.
    pub(super) fn own_functions(&self) -> impl Iterator<Item = (u32, &'a Function)> {
        let own = self.subject.library.len();
        let functions = self.functions.iter().filter(move |&(_, &(_, text))| text == own);
        functions.map(|(&global, &(function, _))| (global, function))
    }

    /// The name of a parameter of a function, by its position.
    pub(super) fn parameter_name(&self, global: u32, at: usize) -> Option<&'a str> {
        let &(function, text) = self.functions.get(&global)?;
        let text = self.subject.library.get(text).unwrap_or(self.subject.text);
        let variable = function.bindings.get(at)?.variable;
        Some(self.name(text.variables[variable.0 as usize].name))
    }

    /// Every function of the text that stands at the top: definitions, forms, tests.
    pub(super) fn roots(&self) -> impl Iterator<Item = &'a Function> + use<'a> {
        let definitions = self.subject.text.definitions.iter().filter_map(|definition| match &definition.defined {
            Defined::Function(_, function) | Defined::Macro(function) => Some(function),
            Defined::Value | Defined::Failure => None,
        });
        definitions.chain(&self.subject.text.forms).chain(&self.subject.text.tests)
    }

    /// The places of definitions and forms that have an error, in order; none lies in another.
    pub(super) fn faulty(&self, errors: &[Diagnostic]) -> Vec<Span> {
        let definitions = self.subject.text.definitions.iter().map(|definition| definition.span);
        let forms = self.subject.text.forms.iter().chain(&self.subject.text.tests).map(|form| form.span);
        let spans = definitions.chain(forms);
        let errors = errors.iter().filter(|error| error.severity == Severity::Error);
        let mut places: Vec<Span> = errors.map(|error| error.span).collect();
        places.sort();
        let has_error = |span: &Span| {
            let first = places.partition_point(|place| (place.source, place.start) < (span.source, span.start));
            let from = places[first..].iter();
            let mut within = from.take_while(|place| place.source == span.source && place.start <= span.end);
            within.any(|&place| lies_in(place, *span))
        };
        let mut faulty: Vec<Span> = spans.filter(has_error).collect();
        // Of those that begin at one place the longest first; forms lie in one another or apart.
        faulty.sort_by_key(|span| (span.source, span.start, std::cmp::Reverse(span.end)));
        let mut outer: Vec<Span> = Vec::new();
        for span in faulty {
            if outer.last().is_none_or(|&last| !lies_in(span, last)) {
                outer.push(span);
            }
        }
        outer
    }

    pub(super) fn name(&self, name: Symbol) -> &'a str {
        self.subject.symbols.name(name)
    }

    pub(super) fn global_name(&self, global: u32) -> &'a str {
        self.name(self.subject.program.globals[global as usize].name)
    }

    pub(super) fn kind(&self, global: u32) -> &'a GlobalKind {
        &self.subject.program.globals[global as usize].kind
    }

    /// Whether a name stands for a valve that only one task can have at a time.
    pub(super) fn is_exclusive(&self, global: u32) -> bool {
        *self.kind(global) == GlobalKind::Valve { places: 1 }
    }

    pub(super) fn constant(&self, constant: u32) -> &'a Constant {
        &self.subject.program.constants[constant as usize]
    }

    pub(super) fn variable_name(&self, variable: VarId) -> &'a str {
        self.name(self.subject.text.variables[variable.0 as usize].name)
    }

    /// The name of the native a form calls, and the arguments.
    pub(super) fn native_call<'i>(&self, ir: &'i Ir) -> Option<(&'a str, &'i [Ir])> {
        match &ir.kind {
            IrKind::Call(Callee::Native(native), arguments) => {
                Some((self.subject.natives[usize::from(*native)].name.as_str(), arguments))
            }
            _ => None,
        }
    }

    /// The symbol a quoted form stands for.
    pub(super) fn quoted(&self, ir: &Ir) -> Option<Symbol> {
        match ir.kind {
            IrKind::Const(constant) => match self.constant(constant) {
                Constant::Atom(Atom::Symbol(symbol)) => Some(*symbol),
                _ => None,
            },
            _ => None,
        }
    }

    /// The keyword a form is.
    pub(super) fn keyword(&self, ir: &Ir) -> Option<Symbol> {
        match ir.kind {
            IrKind::Const(constant) => match self.constant(constant) {
                Constant::Atom(Atom::Keyword(symbol)) => Some(*symbol),
                _ => None,
            },
            _ => None,
        }
    }

    /// The number a form is.
    pub(super) fn number(&self, ir: &Ir) -> Option<f64> {
        match ir.kind {
            IrKind::Int(number) => Some(number as f64),
            IrKind::Const(constant) => match self.constant(constant) {
                Constant::Atom(Atom::Float(number)) => Some(*number),
                _ => None,
            },
            _ => None,
        }
    }

    /// Whether a place is in the text that is checked, not in the library.
    pub(super) fn is_own(&self, span: Span) -> bool {
        let library = self.subject.library.iter().flat_map(|text| &text.definitions);
        library.map(|definition| definition.span.source).max().is_none_or(|last| span.source > last)
    }

    /// The words of a text, without comments.
    pub(super) fn tokens(&self, source: SourceId) -> Tokens {
        let mut known = self.tokens.borrow_mut();
        let tokens = known.entry(source).or_insert_with(|| {
            let (mut tokens, _) = lex(&self.subject.program.sources.get(source).text, source);
            tokens.retain(|(token, _)| !token.is_comment());
            Rc::new(tokens)
        });
        tokens.clone()
    }

    /// Where the first tags of a text stand, as many as a name is compared with.
    pub(super) fn tags(&self, source: SourceId) -> Rc<Vec<Span>> {
        let tokens = self.tokens(source);
        let text_of = |span: Span| self.subject.program.sources.text_of(span);
        let mut known = self.tags.borrow_mut();
        let tags = known.entry(source).or_insert_with(|| {
            let is_tagged = |pair: &&[(Token, Span)]| {
                pair[0].0 == Token::Keyword && text_of(pair[0].1) == ":tag" && pair[1].0 == Token::Symbol
            };
            Rc::new(tokens.windows(2).filter(is_tagged).map(|pair| pair[1].1).take(MOST_TAGS).collect())
        });
        tags.clone()
    }

    /// A warning at a form: the whole of it if it stands in one line, else its head.
    pub(super) fn warning(
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
    pub(super) fn shown(&self, ir: &Ir) -> String {
        match ir.kind {
            IrKind::Global(global) => self.global_name(global).to_string(),
            IrKind::Local(variable) => self.variable_name(variable).to_string(),
            _ => places::one_line(&self.subject.program.sources, ir.span),
        }
    }

    /// Where a form stands, or, if it is a name a macro has copied, where the name first stands in the
    /// form around it.
    pub(super) fn narrowed(&self, around: Span, ir: &Ir) -> Span {
        let name = match ir.kind {
            IrKind::Global(global) => self.global_name(global),
            IrKind::Local(variable) => self.variable_name(variable),
            _ => return ir.span,
        };
        let within = if lies_in(ir.span, around) { ir.span } else { around };
        find_name(&self.subject.program.sources, within, name).unwrap_or(ir.span)
    }
}
