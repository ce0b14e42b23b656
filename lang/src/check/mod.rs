//! What is probably wrong with a text that can run: warnings, each under the name of its rule.
//!
//! Works on resolved forms, so that what macros make of a text is seen; told are only places in
//! the text itself. A rule that cannot see enough says nothing: a value whose kind is not visible
//! may be any, a function that is not visible may do anything.
//!
//! A comment `; check: allow RULE`, in the line of a warning or in the line above, takes the
//! warning away.
//!
//! The check runs nothing, and compilation does not depend on it. It sees through calls. The resolved forms of a text
//! lie beside its code until it is compiled. Those of a library are kept for good; a library that was read back makes
//! them when they are first asked for.

mod angles;
mod behaviours;
mod bindings;
mod calls;
mod claims;
mod conditions;
mod effects;
mod flow;
mod fluents;
mod infix;
mod joined;
mod kinds;
mod known;
mod names;
mod no_value;
mod places;
mod policies;
mod quorums;
mod quotes;
mod rules;
mod suspension;
mod unknown_places;
mod unused;
mod valve_order;
mod valves;
pub(crate) mod walk;

use crate::diagnostic::Diagnostic;
use crate::source::lies_in;
use known::Check;
pub use known::{BehaviourSignature, KnownPlaces, Subject};
pub use rules::RULES;

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
    angles::find(&check, found);
    infix::find(&check, found);
    quotes::find(&check, found);
    joined::find(&check, found);
    no_value::find(&check, found);
    policies::find(&check, found);
    claims::find(&check, found);
    valve_order::find(&check, found);
    suspension::find(&check, found);
    quorums::find(&check, found);
    let faulty = check.faulty(errors);
    warnings.retain(|Diagnostic { span, .. }| {
        let behind = faulty.partition_point(|faulty| (faulty.source, faulty.start) <= (span.source, span.start));
        !behind.checked_sub(1).is_some_and(|before| lies_in(*span, faulty[before]))
    });
    let mut allowances = places::Allowances::new(&subject.program.sources);
    warnings.retain(|warning| !allowances.allow(warning));
    warnings.sort_by(|a, b| (a.span, a.code, &a.message).cmp(&(b.span, b.code, &b.message)));
    warnings.dedup();
    warnings
}
