//! Places that the world has not, where a text names one: `(go-to 'nowhere)`.

use super::known::{Check, KnownPlaces};
use super::walk::each_form;
use crate::compile::ir::{Callee, Ir, IrKind, VarId};
use crate::diagnostic::Diagnostic;
use crate::kind::Kind;
use crate::source::Span;
use crate::suggest::suggest;
use std::collections::BTreeSet;

pub(super) fn find(check: &Check<'_>, found: &mut Vec<Diagnostic>) {
    let Some(known) = check.subject.places else { return };
    for root in check.roots() {
        each_form(root, &mut |ir| {
            let IrKind::Call(callee, arguments) = &ir.kind else { return };
            for (at, argument) in arguments.iter().enumerate() {
                let Some(name) = check.quoted(argument).map(|symbol| check.name(symbol)) else { continue };
                if !known.names.iter().any(|place| place == name)
                    && takes_place(check, callee, at, &mut BTreeSet::new())
                {
                    let place = check.narrowed(ir.span, argument);
                    let warning = unknown_place(check, known, name, place);
                    found.push(match other_order(check, known, callee, arguments) {
                        Some(order) => warning.help(format!("the order is `{order}`")),
                        None => warning,
                    });
                }
            }
        });
    }
}

fn unknown_place(check: &Check<'_>, known: &KnownPlaces, name: &str, span: Span) -> Diagnostic {
    let message = format!("there is no place `{name}` in the world `{}`", known.world);
    let warning = check.warning("unknown-place", span, message, "unknown place");
    warning.help(match suggest(name, known.names.iter().map(String::as_str)) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("it has {}", known.names.join(", ")),
    })
}

/// How a plan of the library takes its arguments, if a place is given where it takes none.
fn other_order(check: &Check<'_>, known: &KnownPlaces, callee: &Callee, arguments: &[Ir]) -> Option<String> {
    let Callee::Global(global) = *callee else { return None };
    let is_place = |argument: &Ir| {
        let name = check.quoted(argument).map(|symbol| check.name(symbol));
        name.is_some_and(|name| known.names.iter().any(|place| place == name))
    };
    let mut positions = (0..arguments.len()).filter(|&at| is_place(&arguments[at]));
    positions.find(|&at| !takes_place(check, callee, at, &mut BTreeSet::new()))?;
    let names = (0..).map_while(|at| check.parameter_name(global, at));
    let required = usize::from(check.known(global)?.function.parameters.required);
    let words =
        std::iter::once(check.global_name(global).to_string()).chain(names.take(required).map(str::to_uppercase));
    Some(format!("({})", words.collect::<Vec<_>>().join(" ")))
}

/// Whether what is called takes a place at a position: a native function that says so, or a function
/// of the library that hands it on to one.
pub(super) fn takes_place(check: &Check<'_>, callee: &Callee, at: usize, seen: &mut BTreeSet<(u32, usize)>) -> bool {
    match callee {
        Callee::Native(native) => check.subject.natives[usize::from(*native)].kind(at) == Kind::Place,
        Callee::Global(global) => {
            let is_library = *global < check.subject.program.library_globals;
            let known = check.known(*global).filter(|_| is_library && seen.insert((*global, at)));
            known.and_then(|known| Some((known, known.function.bindings.get(at)?.variable))).is_some_and(
                |(known, parameter)| {
                    let mut is_place = false;
                    each_form(known.function, &mut |ir| is_place |= hands_on(check, ir, parameter, seen));
                    is_place
                },
            )
        }
        Callee::Value(_) => false,
    }
}

fn hands_on(check: &Check<'_>, ir: &Ir, parameter: VarId, seen: &mut BTreeSet<(u32, usize)>) -> bool {
    let IrKind::Call(callee, arguments) = &ir.kind else { return false };
    let is_parameter = |argument: &Ir| matches!(argument.kind, IrKind::Local(variable) if variable == parameter);
    let mut positions = arguments.iter().enumerate().filter(|(_, argument)| is_parameter(argument));
    positions.any(|(at, _)| takes_place(check, callee, at, seen))
}
