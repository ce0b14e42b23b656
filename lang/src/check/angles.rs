//! Angles beyond a full turn, written without a unit: `(cos 60)`, where `60deg` is meant.

use super::known::Check;
use super::walk::each_form;
use crate::code::GlobalKind;
use crate::compile::ir::{Callee, Ir, IrKind};
use crate::diagnostic::Diagnostic;
use crate::kind::Kind;
use crate::lexer::Token;
use crate::source::{Span, lies_in};
use std::f64::consts::TAU;

pub(super) fn find(check: &Check<'_>, found: &mut Vec<Diagnostic>) {
    for root in check.roots() {
        each_form(root, &mut |ir| look_at(check, ir, found));
    }
}

fn look_at(check: &Check<'_>, ir: &Ir, found: &mut Vec<Diagnostic>) {
    let IrKind::Call(callee, arguments) = &ir.kind else { return };
    let (name, angles) = match callee {
        Callee::Native(native) => {
            let signature = &check.subject.natives[usize::from(*native)];
            match (signature.name.as_str(), arguments.as_slice()) {
                ("activate", [behaviour, pairs @ ..]) => (behaviour_name(check, behaviour), angles_among(check, pairs)),
                (name, _) => {
                    let is_angle = |at| signature.kind(at) == Kind::Angle;
                    (name, arguments.iter().enumerate().filter(|&(at, _)| is_angle(at)).map(|(_, ir)| ir).collect())
                }
            }
        }
        // The words for parameters say their kind in the library; in a plan they may mean anything.
        Callee::Global(global) if *global < check.subject.program.library_globals => {
            (check.global_name(*global), angles_of(check, *global, arguments))
        }
        Callee::Global(_) | Callee::Value(_) => return,
    };
    found.extend(angles.into_iter().filter_map(|angle| without_unit(check, name, angle, ir.span)));
}

fn behaviour_name<'a>(check: &Check<'a>, behaviour: &Ir) -> &'a str {
    match behaviour.kind {
        IrKind::Global(global) if matches!(check.kind(global), GlobalKind::Behaviour(_)) => check.global_name(global),
        _ => "activate",
    }
}

/// The values of keywords that name an angle.
fn angles_among<'i>(check: &Check<'_>, pairs: &'i [Ir]) -> Vec<&'i Ir> {
    let names_angle = |key: &Ir| check.keyword(key).is_some_and(|key| is_angle(check.name(key)));
    pairs.chunks_exact(2).filter(|pair| names_angle(&pair[0])).map(|pair| &pair[1]).collect()
}

fn angles_of<'i>(check: &Check<'_>, global: u32, arguments: &'i [Ir]) -> Vec<&'i Ir> {
    let Some(known) = check.known(global) else { return Vec::new() };
    let function = known.function;
    let positional = function.bindings.len() - function.parameters.keys.len();
    let variables = &check.subject.library[check.functions[&global].1].variables;
    let word = |at: usize| check.name(variables[function.bindings[at].variable.0 as usize].name);
    let (by_position, pairs) = arguments.split_at(positional.min(arguments.len()));
    let mut angles: Vec<&Ir> =
        by_position.iter().enumerate().filter(|&(at, _)| is_angle(word(at))).map(|(_, ir)| ir).collect();
    angles.extend(angles_among(check, pairs));
    angles
}

fn is_angle(word: &str) -> bool {
    Kind::of_parameter(word) == Some(Kind::Angle)
}

fn without_unit(check: &Check<'_>, name: &str, angle: &Ir, call: Span) -> Option<Diagnostic> {
    let number = check.number(angle).filter(|number| number.abs() > TAU)?;
    let within = if lies_in(angle.span, call) { angle.span } else { call };
    let (span, written) = bare_number(check, within, number)?;
    let message = format!("`{name}` takes an angle in radians, and {written} is more than a full turn");
    let warning = check.warning("angle-without-unit", span, message, "a number without a unit");
    Some(warning.help(format!("write `{written}deg`; if radians are meant, `{written}rad`")))
}

/// Where the number stands in a form without a unit.
fn bare_number<'a>(check: &Check<'a>, form: Span, number: f64) -> Option<(Span, &'a str)> {
    let tokens = check.tokens(form.source);
    let first = tokens.partition_point(|(_, span)| span.start < form.start);
    let mut within = tokens[first..].iter().take_while(|(_, span)| lies_in(*span, form));
    within.find_map(|&(token, span)| {
        let value = match token {
            Token::Int(value) => value as f64,
            Token::Float(value) => value,
            _ => return None,
        };
        let text = check.subject.program.sources.text_of(span);
        let is_bare = text.ends_with(|c: char| c.is_ascii_digit());
        (value == number && is_bare).then_some((span, text))
    })
}
