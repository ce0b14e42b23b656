//! Numbers of a `quorum` that its forms can never come to.

use super::known::Check;
use super::walk::each_form;
use crate::compile::ir::{ArgumentIr, Ir, IrKind};
use crate::diagnostic::Diagnostic;

pub(super) fn find(check: &Check<'_>, found: &mut Vec<Diagnostic>) {
    for root in check.roots() {
        each_form(root, &mut |ir| {
            let IrKind::Construct(construct) = &ir.kind else { return };
            let Some(ArgumentIr::Quorum { successes, failures }) = &construct.argument else { return };
            let forms = construct.children.len();
            found.extend(out_of_reach(check, successes, forms, "succeed"));
            found.extend(out_of_reach(check, failures, forms, "fail"));
        });
    }
}

fn out_of_reach(check: &Check<'_>, number: &Ir, forms: usize, what: &str) -> Option<Diagnostic> {
    let IrKind::Int(asked) = number.kind else { return None };
    if usize::try_from(asked).is_ok_and(|asked| (1..=forms).contains(&asked)) {
        return None;
    }
    let those = if forms == 1 { "1 form".to_string() } else { format!("{forms} forms") };
    let message = format!("`quorum` of {those} waits for {asked} to {what}, which cannot be");
    let right = match forms {
        0 => "write the forms that are to run behind the two numbers".to_string(),
        1 => "write 1 or `:all`".to_string(),
        _ => format!("write a number from 1 to {forms}, or `:all`"),
    };
    Some(check.warning("never-enough", number.span, message, "cannot be").help(right))
}
