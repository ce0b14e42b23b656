//! Calls that must fail: of what is no function, with arguments it does not take, with a format
//! that does not fit.

use super::infix;
use super::kinds::{Found, found_in};
use super::known::Check;
use super::unknown_places::takes_place;
use super::walk::each_form;
use crate::code::{Atom, CodeKind, Constant, GlobalKind, Parameters};
use crate::compile::ir::{Callee, Ir, IrKind};
use crate::diagnostic::Diagnostic;
use crate::number::unit_names;
use crate::source::Span;
use crate::suggest::suggest;
use std::collections::BTreeSet;

pub(super) fn find(check: &Check<'_>, found: &mut Vec<Diagnostic>) {
    for root in check.roots() {
        each_form(root, &mut |ir| {
            let IrKind::Call(callee, arguments) = &ir.kind else { return };
            if infix::called_operand(check, ir).is_some() {
                return;
            }
            match callee {
                Callee::Global(global) => global_call(check, *global, arguments, ir.span, found),
                Callee::Value(value) => value_call(check, value, arguments, ir.span, found),
                Callee::Native(_) => format_call(check, ir, found),
            }
        });
    }
}

fn global_call(check: &Check<'_>, global: u32, arguments: &[Ir], span: Span, found: &mut Vec<Diagnostic>) {
    let name = check.global_name(global);
    let what = match check.kind(global) {
        GlobalKind::Function(_) => {
            if let Some(at) = number_for_place(check, global, arguments) {
                let message = format!("`{name}` takes the name of a place here, and this is a number");
                let warning = check.warning("wrong-kind", arguments[at].span, message, "not a place");
                found.push(warning.help("to drive to coordinates write `(go-to-point X Y)`"));
            } else if let Some(known) = check.known(global) {
                keywords(check, name, &known.function.parameters, arguments, span, found);
            }
            return;
        }
        GlobalKind::Fluent => "a fluent",
        GlobalKind::Valve { .. } => "a valve",
        GlobalKind::Behaviour(_) => "a behaviour",
        GlobalKind::Variable | GlobalKind::Constant => return,
    };
    let warning = check.warning("wrong-call", span, format!("`{name}` is {what}, not a function"), "cannot be called");
    found.push(match check.kind(global) {
        GlobalKind::Fluent => warning.help(format!("its value is `(value {name})`")),
        GlobalKind::Behaviour(_) => warning.help(format!("write `(run-behaviour {name} …)`")),
        _ => warning,
    });
}

fn value_call(check: &Check<'_>, value: &Ir, arguments: &[Ir], span: Span, found: &mut Vec<Diagnostic>) {
    let (name, value) = match value.kind {
        IrKind::Local(variable) => match check.bindings().constant(variable) {
            Some(value) => (Some(check.variable_name(variable)), value),
            None => return,
        },
        _ => (None, value),
    };
    let is_data = match value.kind {
        IrKind::Int(_) | IrKind::True | IrKind::Binary(..) => true,
        IrKind::Const(constant) => {
            !matches!(check.constant(constant), Constant::Atom(Atom::Native(_) | Atom::Object(_)))
        }
        _ => false,
    };
    if is_data {
        let message = match name {
            Some(name) => format!("`{name}` is a local variable here, and no function"),
            None => format!("this calls `{}`, which is no function", check.shown(value)),
        };
        let warning = check.warning("wrong-call", span, message, "cannot be called");
        found.push(match name {
            Some(_) => warning,
            None => {
                warning.help(format!("as an argument it stands without these parentheses: `{}`", check.shown(value)))
            }
        });
    }
    if name.is_none() && is_done(check, value) {
        let message = format!("this calls the value of `{}`", check.shown(value));
        let warning = check.warning("wrong-call", span, message, "cannot be called");
        found.push(warning.help("forms that are done one after the other are one form by `(seq FORM...)`"));
    }
    let name = name.unwrap_or("this function");
    let IrKind::Lambda(function) = &value.kind else { return };
    if !function.parameters.accepts(arguments.len()) {
        let count = arguments.len();
        let given = if count == 1 { "1 is given".to_string() } else { format!("{count} are given") };
        let expected = function.parameters.describe();
        let message = format!("`{name}` takes {expected}, and {given}");
        let defined = super::places::brief(&check.subject.program.sources, function.span);
        let warning = check.warning("wrong-call", span, message, format!("takes {expected}"));
        found.push(warning.related(defined, "defined here"));
    }
    keywords(check, name, &function.parameters, arguments, span, found);
}

/// Whether a form is something to be done, and gives no function.
fn is_done(check: &Check<'_>, ir: &Ir) -> bool {
    match &ir.kind {
        IrKind::Call(Callee::Global(global), _) => {
            check.known(*global).is_some_and(|known| known.function.kind == CodeKind::Plan)
        }
        IrKind::Call(Callee::Native(native), _) => check.subject.natives[usize::from(*native)].effect,
        IrKind::Construct(_) | IrKind::Spawn(_) | IrKind::WaitFor { .. } | IrKind::SetGlobal(..) => true,
        _ => false,
    }
}

/// The first number that stands where a place is taken.
fn number_for_place(check: &Check<'_>, global: u32, arguments: &[Ir]) -> Option<usize> {
    let takes_place = |at: usize| takes_place(check, &Callee::Global(global), at, &mut BTreeSet::new());
    (0..arguments.len()).find(|&at| is_number(check, &arguments[at]) && takes_place(at))
}

fn is_number(check: &Check<'_>, ir: &Ir) -> bool {
    matches!(found_in(check, ir), Some(Found::Integer | Found::Float))
}

/// Keywords a function does not know, or that have no value.
fn keywords(
    check: &Check<'_>,
    name: &str,
    parameters: &Parameters,
    arguments: &[Ir],
    span: Span,
    found: &mut Vec<Diagnostic>,
) {
    let positional = usize::from(parameters.required) + usize::from(parameters.optional);
    if parameters.keys.is_empty() || parameters.rest || arguments.len() <= positional {
        return;
    }
    let known: Vec<&str> = parameters.keys.iter().map(|&key| check.name(key)).collect();
    let last = positional.checked_sub(1).map(|last| &arguments[last]);
    if let Some(last) = last
        && let Some(key) = check.keyword(last)
        && check.keyword(&arguments[positional]).is_none()
    {
        let key = check.name(key);
        let place = super::places::keyword(&check.subject.program.sources, span, last.span, key);
        let message = format!("`{name}` takes this argument by its place, and has no parameter `:{key}`");
        let warning = check.warning("unknown-parameter", place, message, "unknown parameter");
        found.push(warning.help(format!("leave out `:{key}`")));
        return;
    }
    unknown_keywords(check, name, &known, &arguments[positional..], span, found);
}

/// Tells the keywords among `:key value` pairs that are not known.
pub(super) fn unknown_keywords(
    check: &Check<'_>,
    name: &str,
    known: &[&str],
    pairs: &[Ir],
    span: Span,
    found: &mut Vec<Diagnostic>,
) {
    for (number, pair) in pairs.chunks(2).enumerate() {
        let Some(key) = check.keyword(&pair[0]).map(|key| check.name(key)) else {
            let before = number.checked_sub(1).map(|before| &pairs[2 * before + 1]);
            found.extend(no_keyword(check, name, known, pair, before, span));
            return;
        };
        let place = super::places::keyword(&check.subject.program.sources, span, pair[0].span, key);
        if !known.contains(&key) {
            let message = format!("`{name}` has no parameter `:{key}`");
            let near = suggest(key, known.iter().copied());
            let listed: Vec<String> = known.iter().map(|known| format!("`:{known}`")).collect();
            let warning = check.warning("unknown-parameter", place, message, "unknown parameter");
            found.push(match (near, listed.is_empty()) {
                (Some(near), _) => warning.help(format!("did you mean `:{near}`?")),
                (None, false) => warning.help(format!("it has {}", listed.join(", "))),
                (None, true) => warning.help("it has none"),
            });
        } else if pair.len() == 1 {
            let message = format!("`:{key}` has no value in this call of `{name}`");
            found.push(check.warning("unknown-parameter", place, message, "a value is missing"));
        }
    }
}

/// What stands where only pairs of keyword and value are taken, and visibly begins none.
fn no_keyword(
    check: &Check<'_>,
    name: &str,
    known: &[&str],
    pair: &[Ir],
    before: Option<&Ir>,
    call: Span,
) -> Option<Diagnostic> {
    let [first, rest @ ..] = pair else { return None };
    let what = match (found_in(check, first), rest) {
        (Some(found), _) => format!("is {}", found.noun()),
        (None, []) => "has no keyword".to_string(),
        (None, _) => return None,
    };
    // What a macro has copied has the place of the whole call.
    let shown = (first.span != call).then(|| match check.quoted(first) {
        Some(symbol) => format!("'{}", check.name(symbol)),
        None => check.shown(first),
    });
    let subject = shown.as_ref().map_or("one argument".to_string(), |shown| format!("`{shown}`"));
    let message = format!("`{name}` takes only keywords with values here, and {subject} {what}");
    let warning = check.warning("unknown-parameter", check.narrowed(call, first), message, "a keyword is missing");
    let unit = shown.as_deref().filter(|shown| unit_names().any(|unit| unit == *shown));
    if let (Some(number), Some(unit)) = (before.filter(|number| is_number(check, number)), unit) {
        return Some(
            warning.help(format!("a number and its unit are one word: write `{}{unit}`", check.shown(number))),
        );
    }
    Some(warning.help(match known {
        [] => "it has no parameters".to_string(),
        [only] => format!("write `:{only} {}`", shown.as_deref().unwrap_or("VALUE")),
        many => format!("it has {}", many.iter().map(|known| format!("`:{known}`")).collect::<Vec<_>>().join(", ")),
    }))
}

/// Directives of a format that have no argument, and arguments that have no directive.
fn format_call(check: &Check<'_>, ir: &Ir, found: &mut Vec<Diagnostic>) {
    let Some(("format" | "%format", [control, values @ ..])) = check.native_call(ir) else { return };
    for value in values.iter().filter(|value| found_in(check, value) == Some(Found::Fluent)) {
        let name = check.shown(value);
        let message = format!("`{name}` is a fluent, and what is shown is not its value");
        let warning = check.warning("fluent-as-value", check.narrowed(ir.span, value), message, "the fluent itself");
        found.push(warning.help(format!("its value is `(value {name})`")));
    }
    let IrKind::Const(constant) = control.kind else { return };
    let Constant::Atom(Atom::Str(text)) = check.constant(constant) else { return };
    let Some(directives) = count_directives(text) else { return };
    if directives == values.len() {
        return;
    }
    let plural = |count: usize, noun: &str| format!("{count} {noun}{}", if count == 1 { "" } else { "s" });
    let message = format!(
        "this format shows {}, and {} given",
        plural(directives, "value"),
        match values.len() {
            1 => "1 is".to_string(),
            count => format!("{count} are"),
        }
    );
    let warning = check.warning("wrong-format", ir.span, message, format!("shows {}", plural(directives, "value")));
    let is_percent = |pair: &[u8]| pair[0] == b'%' && matches!(pair[1], b'd' | b's' | b'f' | b'i' | b'v');
    found.push(match directives == 0 && text.as_bytes().windows(2).any(is_percent) {
        true => warning.help("a value is shown by `~a`"),
        false => warning,
    });
}

/// How many values a format shows; none if it has a directive that is not known.
fn count_directives(text: &str) -> Option<usize> {
    let mut count = 0;
    let mut characters = text.chars();
    while let Some(character) = characters.next() {
        if character != '~' {
            continue;
        }
        match characters.find(|c| !c.is_ascii_digit() && *c != ',')?.to_ascii_lowercase() {
            'a' | 's' | 'd' | 'f' => count += 1,
            '%' | '~' => {}
            _ => return None,
        }
    }
    Some(count)
}
