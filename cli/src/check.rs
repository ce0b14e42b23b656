//! `rpl check FILE...`: all findings in plan texts, without running them.

use crate::console::Console;
use crate::files::{self, PlanText};
use crate::mission::Site;
use crate::status::Status;
use anyhow::Result;
use rpl_lang::diagnostic::{Diagnostic, Severity, render};
use rpl_runtime::library::Library;

/// Checks every file.
///
/// # Errors
/// Standard output is closed.
pub fn run(names: &[String], console: &mut Console) -> Result<Status> {
    let library = Site::for_checking()?.library;
    let mut status = Status::Succeeded;
    for name in names {
        match files::plan(name) {
            Ok(plan) => {
                if check(&library, plan, console)? {
                    status = Status::Wrong;
                }
            }
            // The other files can still be checked.
            Err(error) => {
                console.note(&format!("error: {error}"));
                status = Status::Wrong;
            }
        }
    }
    Ok(status)
}

/// Checks one text; tells whether it has errors.
fn check(library: &Library, plan: PlanText, console: &mut Console) -> Result<bool> {
    let PlanText { name, text, mut folder } = plan;
    let (findings, program) = match library.load(&name, &text, &mut folder) {
        Ok(loaded) => (loaded.warnings, loaded.program),
        Err(rejected) => (rejected.diagnostics, rejected.program),
    };
    if findings.is_empty() {
        console.print(&format!("{name}: no findings"))?;
        return Ok(false);
    }
    console.note(render(&findings, &program.sources, console.colour).trim_end());
    console.note(&format!("{name}: {}", count(&findings)));
    Ok(findings.iter().any(|finding| finding.severity == Severity::Error))
}

fn count(findings: &[Diagnostic]) -> String {
    let errors = findings.iter().filter(|finding| finding.severity == Severity::Error).count();
    let warnings = findings.len() - errors;
    let plural = |count: usize, noun: &str| match count {
        0 => None,
        1 => Some(format!("1 {noun}")),
        _ => Some(format!("{count} {noun}s")),
    };
    let parts: Vec<String> = [plural(errors, "error"), plural(warnings, "warning")].into_iter().flatten().collect();
    parts.join(", ")
}
