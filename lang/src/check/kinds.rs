//! Arguments that are not of the kind their place takes: a string for a number, a function for a task.

use super::known::Check;
use super::unknown_places::takes_place;
use super::walk::{each_form, each_form_within};
use crate::code::{Atom, CodeKind, Constant, GlobalKind, Part};
use crate::compile::ir::{ArgumentIr, Binary, Callee, Ir, IrKind, ScopeIr, Unary};
use crate::diagnostic::Diagnostic;
use crate::kind::{Kind, time_in_string};
use crate::lexer::Token;
use crate::source::{Span, lies_in};
use crate::suggest::suggest;
use std::collections::BTreeSet;

/// Functions that a macro may hand one argument to.
const MOST_OF_A_MACRO: usize = 8;

/// What a form visibly stands for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Found {
    Nil,
    True,
    Integer,
    Float,
    Text,
    List,
    Vector,
    Symbol,
    Keyword,
    Function,
    Fluent,
    Valve,
    Behaviour,
}

impl Found {
    pub(super) fn noun(self) -> &'static str {
        match self {
            Found::Nil => "nil",
            Found::True => "t",
            Found::Integer => "an integer",
            Found::Float => "a float",
            Found::Text => "a string",
            Found::List => "a list",
            Found::Vector => "a vector",
            Found::Symbol => "a symbol",
            Found::Keyword => "a keyword",
            Found::Function => "a function",
            Found::Fluent => "a fluent",
            Found::Valve => "a valve",
            Found::Behaviour => "a behaviour",
        }
    }

    /// Whether it may be of this kind. Of objects that no text can write, what stands for none of
    /// them is left alone.
    fn may_be(self, kind: Kind) -> bool {
        match kind {
            Kind::Any | Kind::ListOrEnd => true,
            // A fluent as a number is told by a rule of its own.
            Kind::Number | Kind::Seconds | Kind::Angle => matches!(self, Found::Integer | Found::Float | Found::Fluent),
            Kind::Integer => matches!(self, Found::Integer | Found::Fluent),
            Kind::Text => self == Found::Text,
            Kind::List => matches!(self, Found::List | Found::Nil),
            Kind::Vector => self == Found::Vector,
            Kind::Elements => matches!(self, Found::List | Found::Nil | Found::Vector),
            Kind::ListOrText => matches!(self, Found::List | Found::Nil | Found::Text),
            Kind::Sequence => matches!(self, Found::List | Found::Nil | Found::Vector | Found::Text),
            Kind::Symbol => matches!(self, Found::Symbol | Found::Keyword | Found::Nil | Found::True),
            Kind::Name | Kind::Place => {
                matches!(self, Found::Symbol | Found::Keyword | Found::Text | Found::Nil | Found::True)
            }
            Kind::Class => self == Found::Symbol,
            Kind::Function => self == Found::Function,
            Kind::Fluent => matches!(self, Found::Fluent | Found::Nil | Found::True | Found::List),
            Kind::Valve => matches!(self, Found::Valve | Found::Nil | Found::True | Found::List),
            Kind::Behaviour => matches!(self, Found::Behaviour | Found::Nil | Found::True | Found::List),
            Kind::Task | Kind::Failure | Kind::Table => matches!(self, Found::Nil | Found::True | Found::List),
        }
    }
}

pub(super) fn find(check: &Check<'_>, found: &mut Vec<Diagnostic>) {
    let before = found.len();
    // Who handles this very failure may want it: these forms, by their addresses.
    let mut handled = BTreeSet::new();
    for root in check.roots() {
        each_form(root, &mut |ir| {
            if let Some(body) = handles_faults(check, ir) {
                each_form_within(body, &mut |inner| {
                    handled.insert(std::ptr::from_ref(inner));
                });
            }
            if !handled.contains(&std::ptr::from_ref(ir)) {
                look_at(check, ir, found);
            }
        });
    }
    // What stands behind a keyword that is too many is told with it.
    let ends =
        found[before..].iter().filter(|told| told.help.as_ref().is_some_and(|help| help.starts_with("leave out `:")));
    let ends: Vec<Span> = ends.map(|told| told.span).collect();
    found.retain(|told| told.code != "unused-value" || !ends.iter().any(|&end| is_next(check, end, told.span)));
}

/// Whether a form is the next thing behind a place.
fn is_next(check: &Check<'_>, place: Span, form: Span) -> bool {
    let between = Span { start: place.end, end: form.start.max(place.end), ..place };
    place.source == form.source
        && place.end <= form.start
        && check.subject.program.sources.text_of(between).trim().is_empty()
}

/// The part of a form in which a fault of the plan is handled as such.
fn handles_faults<'a>(check: &Check<'_>, ir: &'a Ir) -> Option<&'a Ir> {
    let IrKind::Handler { body, clauses, .. } = &ir.kind else { return None };
    let mut classes = clauses.iter().flat_map(|clause| &clause.classes);
    classes.any(|&class| matches!(check.name(class), "type-error" | "error")).then_some(body)
}

fn look_at(check: &Check<'_>, ir: &Ir, found: &mut Vec<Diagnostic>) {
    let mut look = |form: &str, kind: Kind, argument: &Ir| wrong_kind(check, form, kind, ir.span, argument, found);
    match &ir.kind {
        IrKind::Scope(ScopeIr::Valve { valve, seconds }, _) => {
            look("with-valve", Kind::Valve, valve);
            seconds.iter().for_each(|seconds| look("with-valve", Kind::Seconds, seconds));
        }
        IrKind::Scope(ScopeIr::Suspended(task), _) => look("with-task-suspended", Kind::Task, task),
        IrKind::WaitFor { fluent, timeout, .. } => {
            look("wait-for", Kind::Fluent, fluent);
            timeout.iter().for_each(|timeout| look("wait-for", Kind::Seconds, timeout));
        }
        IrKind::Whenever { fluent, .. } => look("whenever", Kind::Fluent, fluent),
        IrKind::Construct(construct) => match &construct.argument {
            Some(ArgumentIr::Deadline { seconds, .. }) => {
                look("with-timeout", Kind::Seconds, seconds);
                found.extend(seconds_that_act(check, seconds));
            }
            Some(ArgumentIr::Priority(number)) => look("with-priority", Kind::Number, number),
            Some(ArgumentIr::Quorum { successes, failures }) => {
                let numbers = [successes, failures].into_iter().filter(|number| check.keyword(number).is_none());
                numbers.for_each(|number| look("quorum", Kind::Integer, number));
            }
            Some(ArgumentIr::Most(_)) | None => {}
        },
        IrKind::ConstructMap(construct, _) => {
            if let Some(ArgumentIr::Most(count)) = &construct.argument {
                look(check.name(construct.name), Kind::Integer, count);
            }
        }
        IrKind::Binary(operation, left, right) => {
            let name = match operation {
                Binary::Add => "+",
                Binary::Sub => "-",
                Binary::Mul => "*",
                Binary::Div => "/",
                Binary::NumEq => "=",
                Binary::NumDiffer => "/=",
                Binary::Less => "<",
                Binary::LessEq => "<=",
                Binary::Greater => ">",
                Binary::GreaterEq => ">=",
                Binary::Eq | Binary::Cons => return,
            };
            look(name, Kind::Number, left);
            look(name, Kind::Number, right);
        }
        IrKind::Call(Callee::Global(global), arguments) if is_library(check, *global) => {
            let name = check.global_name(*global);
            for (at, argument) in arguments.iter().enumerate() {
                if !matches!(argument.kind, IrKind::Nil) {
                    look(name, kind_of_parameter(check, *global, at), argument);
                }
            }
        }
        IrKind::Unary(Unary::Car, list) => look("car", Kind::List, list),
        IrKind::Unary(Unary::Cdr, list) => look("cdr", Kind::List, list),
        IrKind::Call(Callee::Native(native), arguments) => {
            let signature = &check.subject.natives[usize::from(*native)];
            let form = match (signature.name.strip_prefix("%set-"), signature.name.strip_prefix('%')) {
                (Some(accessor), _) => format!("setf ({accessor} …)"),
                (None, Some(form)) => form.to_string(),
                (None, None) => signature.name.clone(),
            };
            for (at, argument) in arguments.iter().enumerate() {
                // What may be left out may often be nil.
                let is_left_out = at >= usize::from(signature.min) && matches!(argument.kind, IrKind::Nil);
                if !is_left_out {
                    let kind = match signature.kind(at) {
                        // What ends a list may be anything, and a number there is meant; a name rarely is.
                        Kind::ListOrEnd if form == "append" && at > 0 && check.quoted(argument).is_some() => Kind::List,
                        kind => kind,
                    };
                    look(&form, kind, argument);
                }
            }
        }
        _ => {}
    }
}

/// The kind of argument a function of the library takes at a position, as far as its parameter says. Of words such as
/// `pattern` and `names` the library has more than one sense; a number, a function and a fluent are always that.
pub(super) fn kind_of_parameter(check: &Check<'_>, global: u32, at: usize) -> Kind {
    if !is_library(check, global) {
        return Kind::Any;
    }
    if let Some(&kind) = check.parameter_kinds.borrow().get(&(global, at)) {
        return kind;
    }
    let kind = stated_kind(check, global, at).unwrap_or(Kind::Any);
    check.parameter_kinds.borrow_mut().insert((global, at), kind);
    kind
}

fn stated_kind(check: &Check<'_>, global: u32, at: usize) -> Option<Kind> {
    let parameters = &check.known(global)?.function.parameters;
    if at >= usize::from(parameters.required + parameters.optional)
        // A number in place of a place is told of as such.
        || takes_place(check, &Callee::Global(global), at, &mut BTreeSet::new())
    {
        return None;
    }
    let kind = check.parameter_name(global, at).and_then(Kind::of_parameter)?;
    let is_plain = matches!(
        kind,
        Kind::Number
            | Kind::Integer
            | Kind::Seconds
            | Kind::Angle
            | Kind::Function
            | Kind::Fluent
            | Kind::Task
            | Kind::Valve
            | Kind::Behaviour
    );
    is_plain.then_some(kind)
}

fn is_library(check: &Check<'_>, global: u32) -> bool {
    global < check.subject.program.library_globals
}

/// What a form visibly stands for; none if it may be anything.
pub(super) fn found_in(check: &Check<'_>, ir: &Ir) -> Option<Found> {
    match ir.kind {
        IrKind::Nil => Some(Found::Nil),
        IrKind::True => Some(Found::True),
        IrKind::Int(_) => Some(Found::Integer),
        IrKind::Lambda(_) => Some(Found::Function),
        IrKind::Global(global) => match check.kind(global) {
            GlobalKind::Function(_) => Some(Found::Function),
            GlobalKind::Fluent => Some(Found::Fluent),
            GlobalKind::Valve { .. } => Some(Found::Valve),
            GlobalKind::Behaviour(_) => Some(Found::Behaviour),
            GlobalKind::Variable | GlobalKind::Constant => None,
        },
        IrKind::Const(constant) => match check.constant(constant) {
            Constant::Atom(Atom::Symbol(_)) => Some(Found::Symbol),
            Constant::Atom(Atom::Str(_)) => Some(Found::Text),
            Constant::Atom(Atom::Float(_)) => Some(Found::Float),
            Constant::Atom(Atom::Int(_)) => Some(Found::Integer),
            Constant::Atom(Atom::Keyword(_)) => Some(Found::Keyword),
            Constant::Atom(Atom::Native(_)) => Some(Found::Function),
            Constant::Compound(parts) => match parts.last() {
                Some(Part::Vector { .. }) => Some(Found::Vector),
                Some(Part::List { .. } | Part::Atom(_)) | None => Some(Found::List),
            },
            Constant::Atom(Atom::Nil) => Some(Found::Nil),
            Constant::Atom(Atom::True) => Some(Found::True),
            Constant::Atom(Atom::Object(_)) => None,
        },
        _ => None,
    }
}

/// What stands where `with-timeout` wants its seconds, and is something to be done.
fn seconds_that_act(check: &Check<'_>, seconds: &Ir) -> Option<Diagnostic> {
    let is_plan = match &seconds.kind {
        IrKind::Call(Callee::Global(global), _) => {
            check.known(*global).is_some_and(|known| known.function.kind == CodeKind::Plan)
        }
        IrKind::Construct(_) | IrKind::Whenever { .. } | IrKind::WaitFor { .. } | IrKind::Loop(_) => true,
        _ => false,
    };
    let warning = || check.warning("wrong-kind", seconds.span, "the seconds of `with-timeout` come first", "no number");
    is_plan.then(|| warning().help("write `(with-timeout SECONDS FORM...)`"))
}

fn wrong_kind(check: &Check<'_>, form: &str, kind: Kind, around: Span, ir: &Ir, warnings: &mut Vec<Diagnostic>) {
    let ir = bound_within(check, ir, around);
    let Some(found) = found_in(check, ir).filter(|found| !found.may_be(kind)) else { return };
    let place = check.narrowed(around, ir);
    // A macro hands an argument to several functions.
    let is_told = |told: &Diagnostic| told.code == "wrong-kind" && told.span == place;
    if warnings.iter().rev().take(MOST_OF_A_MACRO).any(is_told) {
        return;
    }
    let form = &written_head(check, form, around);
    let text = match ir.kind {
        IrKind::Const(constant) => match check.constant(constant) {
            Constant::Atom(Atom::Str(text)) => Some(format!("{text:?}")),
            _ => None,
        },
        _ => None,
    };
    let shown = match check.quoted(ir) {
        _ if text.is_some() => text.unwrap_or_default(),
        Some(symbol) => format!("'{}", check.name(symbol)),
        None => check.shown(ir),
    };
    let form = if form.contains(' ') { form.clone() } else { format!("`{form}`") };
    let message = format!("{form} wants {}, and `{shown}` is {}", kind.noun(), found.noun());
    let warning = check.warning("wrong-kind", place, message, format!("not {}", kind.noun()));
    warnings.push(match advice(check, &form, kind, found, ir) {
        Some(advice) => warning.help(advice),
        None => warning,
    });
}

/// What a macro has bound to a variable within a form; other values stand for themselves.
fn bound_within<'i>(check: &'i Check<'_>, ir: &'i Ir, form: Span) -> &'i Ir {
    let IrKind::Local(variable) = ir.kind else { return ir };
    check.bindings().constant(variable).filter(|value| lies_in(value.span, form)).unwrap_or(ir)
}

/// The function that a form of the text begins with, or the macro that stands for it there.
fn written_head(check: &Check<'_>, function: &str, form: Span) -> String {
    let text = check.subject.program.sources.text_of(form);
    let head = text.strip_prefix('(').and_then(|text| text.split(|c: char| c.is_whitespace() || c == ')').next());
    let is_macro = |head: &&str| {
        let name = check.subject.symbols.find(head);
        name.is_some_and(|name| check.subject.program.macros.contains_key(&name))
    };
    head.filter(is_macro).unwrap_or(function).to_string()
}

/// Advice on what stands where a task is taken: a task of the text that has the name for a tag, or nearly.
fn tag_advice(check: &Check<'_>, ir: &Ir, name: &str) -> String {
    let places = check.tags(ir.span.source);
    let tags: Vec<&str> = places.iter().map(|&span| check.subject.program.sources.text_of(span)).collect();
    match suggest(name, tags.iter().copied()) {
        _ if tags.contains(&name) => format!("the task with this tag is `{name}`, without the quote"),
        Some(near) => format!("did you mean the task with the tag `{near}`? It stands without the quote"),
        None => format!("`(:tag {name} FORM...)` gives a task this name; it stands without the quote"),
    }
}

/// Whether one more value stands directly behind a form.
fn is_followed(check: &Check<'_>, form: Span) -> bool {
    let tokens = check.tokens(form.source);
    let behind = tokens.get(tokens.partition_point(|(_, span)| span.start < form.end));
    behind.is_some_and(|(token, _)| !matches!(token, Token::Close | Token::Keyword))
}

fn advice(check: &Check<'_>, form: &str, kind: Kind, found: Found, ir: &Ir) -> Option<String> {
    match (kind, found) {
        (Kind::Seconds | Kind::Number | Kind::Angle | Kind::Integer, Found::Text) => {
            let IrKind::Const(constant) = ir.kind else { return None };
            let Constant::Atom(Atom::Str(text)) = check.constant(constant) else { return None };
            time_in_string(text).map(|number| format!("write `{number}`, without quotes"))
        }
        (Kind::Task, Found::Symbol) => Some(tag_advice(check, ir, check.name(check.quoted(ir)?))),
        (Kind::List, Found::Symbol) if form == "`append`" => {
            Some(format!("`append` joins lists: one more element is `(list {})`", check.shown(ir)))
        }
        (_, Found::Symbol) => {
            let name = check.name(check.quoted(ir)?);
            let is_defined = check.subject.symbols.find(name).is_some_and(|symbol| {
                check.subject.program.names.contains_key(&symbol) || check.natives.contains_key(name)
            });
            let is_thing = matches!(kind, Kind::Valve | Kind::Fluent | Kind::Behaviour | Kind::Function);
            if is_defined {
                return Some(format!("without the quote `{name}` is the thing itself"));
            }
            if is_thing {
                return Some(format!("without the quote it is {} `{name}`, if there is one", kind.noun()));
            }
            matches!(form, "`=`" | "`/=`").then(|| "`eq` compares symbols".to_string())
        }
        (Kind::Behaviour, Found::Function) => {
            Some(format!("a plan is called, and starts its behaviours itself: `({} …)`", check.shown(ir)))
        }
        (_, Found::Function) => {
            let name = check.shown(ir);
            let takes_nothing = check
                .natives
                .get(name.as_str())
                .is_some_and(|&native| check.subject.natives[usize::from(native)].min == 0);
            takes_nothing.then(|| format!("its value is `({name})`"))
        }
        (Kind::Number, Found::True) => Some("`eq` compares anything; a condition needs no comparison with `t`".into()),
        (Kind::Text, Found::True) if form == "`format`" => {
            Some("leave out the `t`; to write the text, `(print (format …))`".into())
        }
        (Kind::Behaviour | Kind::Valve | Kind::Fluent | Kind::Task, Found::Text) => {
            Some("a name stands there without quotation marks".into())
        }
        (Kind::Valve, Found::Behaviour) => {
            let IrKind::Global(global) = ir.kind else { return None };
            let GlobalKind::Behaviour(number) = *check.kind(global) else { return None };
            let valve = check.subject.behaviours.get(usize::from(number))?.valve.as_ref()?;
            Some(format!("the behaviour `{}` is moved by whoever has the valve `{valve}`", check.shown(ir)))
        }
        (_, Found::Keyword) if is_followed(check, ir.span) => Some(format!("leave out `{}`", check.shown(ir))),
        (Kind::Valve, _) => Some("a valve is defined by `(def-valve NAME)`".into()),
        (_, Found::Fluent) => Some(format!("its value is `(value {})`", check.shown(ir))),
        _ => None,
    }
}
