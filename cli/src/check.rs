//! `rpl check FILE...`: all findings in plan texts, without running them.

use crate::console::Console;
use crate::files::{self, PlanText};
use crate::mission::{self, Site};
use crate::status::Status;
use anyhow::Result;
use rpl_lang::check::KnownPlaces;
use rpl_lang::code::Program;
use rpl_lang::diagnostic::{Diagnostic, Severity, render};
use std::sync::Arc;

/// Checks every file; the places they name are looked up in the world, if one is given.
///
/// # Errors
/// There is no such world, or standard output is closed.
pub fn run(names: &[String], are_scenarios: bool, world: Option<&str>, console: &mut Console) -> Result<Status> {
    let places = world.map(places_of).transpose()?;
    let sites = match are_scenarios {
        true => vec![Site::for_checking_scenarios()?],
        false => vec![Site::without_robot()?, Site::for_checking()?],
    };
    let mut status = Status::Succeeded;
    for name in names {
        match if are_scenarios { files::scenario(name) } else { files::plan(name) } {
            Ok(plan) => {
                let (findings, program) = findings(&sites, &plan, places.as_ref());
                if tell(&plan.name, &findings, &program, console)? {
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

fn places_of(world: &str) -> Result<KnownPlaces> {
    let world = mission::world(world)?;
    Ok(KnownPlaces { names: world.places.iter().map(|place| place.name.clone()).collect(), world: world.name })
}

/// What is found in a plan at the first site that has all it needs, or at the last one: a plan that
/// names nothing of the robot's may give the robot's names meanings of its own.
fn findings(sites: &[Site], plan: &PlanText, places: Option<&KnownPlaces>) -> (Vec<Diagnostic>, Arc<Program>) {
    let mut found = (Vec::new(), Arc::default());
    for site in sites {
        found = site.library.check(&plan.name, &plan.text, places, &mut plan.folder.clone());
        if found.0.iter().all(|finding| finding.code != "needs-a-world") {
            break;
        }
    }
    found
}

/// Tells the findings in a text, and whether there are errors among them.
fn tell(name: &str, findings: &[Diagnostic], program: &Program, console: &mut Console) -> Result<bool> {
    if findings.is_empty() {
        console.print(&format!("{name}: no findings"))?;
        return Ok(false);
    }
    console.note(render(findings, &program.sources, console.colour).trim_end());
    console.note(&format!("{name}: {}", count(findings)));
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
