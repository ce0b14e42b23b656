//! `rpl check FILE...`: all findings in plan texts, without running them.

use anyhow::{Context, Result};
use clap::ValueHint;
use clap_complete::engine::ArgValueCompleter;
use rpl_lang::check::KnownPlaces;
use rpl_lang::code::Program;
use rpl_lang::diagnostic::{Diagnostic, Severity, render};
use rpl_lang::source::{Sources, Span};
use rpl_lang::visible::visible;
use rpl_mission::site::Site;
use rpl_protocol::module::process_modules::ModuleSource;
use rpl_shell::arguments::{completion, plan_files};
use rpl_shell::files::module_files::{self, GoingBack, ModuleVoices};
use rpl_shell::files::plans::PlanText;
use rpl_shell::files::project_file::{Project, ProjectFile};
use rpl_shell::files::roles::{Role, Roles};
use rpl_shell::files::{plans, robot_files, world_files};
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use serde::Serialize;
use std::sync::Arc;

/// Check plans without running them: report all errors, and warn of what is probably wrong
///
/// An error keeps a plan from running, and the exit status is 2. A warning does not, and the exit status
/// is 0. Each warning has the name of its rule. To allow it, write a comment `; check: allow RULE` in its
/// line or in the line above; begin names that are unused on purpose with an underscore.
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Plan files, folders with plans, or the `rpl.toml` of a project; `-` for standard input (default: the plans and
    /// the world of the nearest `rpl.toml`, in this folder or above)
    #[arg(value_name = "FILE", add = ArgValueCompleter::new(completion::plans))]
    files: Vec<String>,
    /// Check the files as scenarios: second plans that disturb the world
    #[arg(long)]
    scenario: bool,
    /// World of the plans: places that they name must exist in it
    #[arg(long, value_name = "WORLD", conflicts_with = "scenario", add = ArgValueCompleter::new(completion::worlds))]
    world: Option<String>,
    /// Robot: a built-in name or a .toml file (default: b21)
    #[arg(long, value_name = "R", conflicts_with = "scenario", add = ArgValueCompleter::new(completion::robots))]
    robot: Option<String>,
    /// Manifest of a module in another process that the plans use; can be repeated
    #[arg(long, value_name = "FILE", conflicts_with = "scenario", value_hint = ValueHint::FilePath)]
    module: Vec<String>,
    /// Print one JSON object to standard output instead
    #[arg(long)]
    json: bool,
}

/// What `--json` writes.
#[derive(Clone, Debug, Default, Serialize)]
struct CheckReport {
    files: Vec<FileRecord>,
    errors: usize,
    warnings: usize,
}

/// What was found in a file.
#[derive(Clone, Debug, Serialize)]
struct FileRecord {
    /// None where a folder could not be read.
    file: Option<String>,
    /// Why it could not be checked.
    error: Option<String>,
    findings: Vec<FindingRecord>,
}

#[derive(Clone, Debug, Serialize)]
struct FindingRecord {
    severity: &'static str,
    rule: &'static str,
    message: String,
    #[serde(flatten)]
    place: PlaceRecord,
    label: String,
    help: Option<String>,
    related: Vec<RelatedRecord>,
}

/// A stretch of a text; lines and columns count from 1, and the end is not part of it.
#[derive(Clone, Debug, Serialize)]
struct PlaceRecord {
    file: String,
    line: usize,
    column: usize,
    end_line: usize,
    end_column: usize,
}

#[derive(Clone, Debug, Serialize)]
struct RelatedRecord {
    message: String,
    #[serde(flatten)]
    place: PlaceRecord,
}

/// The arguments, with what the project of the files says. What they say themselves holds.
fn in_project(arguments: &Arguments, console: &mut Console) -> Result<(Arguments, Option<ProjectFile>)> {
    let mut arguments = arguments.clone();
    let Some(project) = Project::of(&arguments.files, ("check", "plan"), console)? else {
        return Ok((arguments, None));
    };
    if project.is_meant {
        arguments.files = vec![project.folder()];
    }
    let says = project.says;
    if !arguments.scenario {
        arguments.world = arguments.world.or_else(|| says.world.clone());
        arguments.robot = arguments.robot.or_else(|| says.robot.clone());
        if arguments.module.is_empty() {
            arguments.module.clone_from(&says.modules);
        }
    }
    Ok((arguments, Some(says)))
}

/// Checks every file; the places they name are looked up in the world, if one is given.
///
/// # Errors
/// There is no such world or module, nothing is named and there is no project, or standard output is closed.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let (arguments, project) = &in_project(arguments, console)?;
    let robot = arguments.robot.as_deref();
    let places = arguments.world.as_deref().map(|world| places_of(world, robot)).transpose()?;
    let files = plan_files::named(&arguments.files);
    let read = |name: &Result<String, String>| -> Result<PlanText, String> {
        let name = name.as_ref().map_err(Clone::clone)?;
        let plan = if arguments.scenario { plans::scenario(name) } else { plans::plan(name) };
        plan.map_err(|error| format!("{error:#}"))
    };
    let texts: Vec<Result<PlanText, String>> = files.iter().map(read).collect();
    let roles = Roles::of(project.as_ref(), texts.iter().flatten());
    let sites = CheckSites::of(arguments)?;
    let mut report = CheckReport::default();
    for (name, text) in files.into_iter().zip(texts) {
        match text {
            Ok(plan) => {
                let said = arguments.scenario.then_some(Role::Scenario);
                let role = said.clone().unwrap_or_else(|| roles.role(&plan.name));
                let (findings, program) = findings(sites.of_role(&role), &plan, places.as_ref());
                if !arguments.json {
                    let found_out = if said.is_none() { &role } else { &Role::Plan };
                    tell(&plan.name, found_out, &findings, &program, console)?;
                }
                report.add(FileRecord::found(&plan.name, &findings, &program.sources));
            }
            // The other files can still be checked.
            Err(error) => {
                if !arguments.json {
                    console.note(&format!("error: {error}"));
                }
                report.add(FileRecord { file: name.ok(), error: Some(error), findings: Vec::new() });
            }
        }
    }
    if arguments.json {
        console.print(&serde_json::to_string(&report).context("the report cannot be written as JSON")?)?;
    }
    Ok(if report.errors == 0 { Status::Succeeded } else { Status::Wrong })
}

/// Where texts are checked, by what they are for.
struct CheckSites {
    plans: Vec<Site>,
    /// Without the modules: the plans of one define what it brings along.
    of_modules: Vec<Site>,
    scenarios: [Site; 1],
}

impl CheckSites {
    fn of(arguments: &Arguments) -> Result<Self> {
        let (_, sources) = module_files::named(&arguments.module, ModuleVoices::Processes(GoingBack::Never))?;
        let bare: Vec<ModuleSource> =
            sources.iter().map(|source| ModuleSource { plans: None, ..source.clone() }).collect();
        Ok(Self {
            plans: Site::without_world(sources)?,
            of_modules: Site::without_world(bare)?,
            scenarios: [Site::for_checking_scenarios()?],
        })
    }

    fn of_role(&self, role: &Role) -> &[Site] {
        match role {
            Role::Plan => &self.plans,
            Role::Scenario => &self.scenarios,
            Role::OfModule(_) => &self.of_modules,
        }
    }
}

impl CheckReport {
    fn add(&mut self, file: FileRecord) {
        let errors = file.findings.iter().filter(|finding| finding.severity == ERROR).count();
        self.warnings += file.findings.len() - errors;
        self.errors += errors + usize::from(file.error.is_some());
        self.files.push(file);
    }
}

/// What is found in a plan without a world and modules, as data.
///
/// # Errors
/// The library of plans does not compile.
pub fn found_in(plan: &PlanText) -> Result<serde_json::Value> {
    let sites = [Site::without_robot()?, Site::for_checking(Vec::new())?];
    let (findings, program) = findings(&sites, plan, None);
    Ok(serde_json::json!(FileRecord::found(&plan.name, &findings, &program.sources).findings))
}

const ERROR: &str = "error";

impl FileRecord {
    fn found(name: &str, findings: &[Diagnostic], sources: &Sources) -> Self {
        let mut findings: Vec<&Diagnostic> = findings.iter().collect();
        findings.sort_by_key(|finding| finding.span);
        let findings = findings.into_iter().map(|finding| FindingRecord::of(finding, sources)).collect();
        Self { file: Some(name.to_string()), error: None, findings }
    }
}

impl FindingRecord {
    fn of(finding: &Diagnostic, sources: &Sources) -> Self {
        let related = finding
            .related
            .iter()
            .map(|(span, message)| RelatedRecord { message: message.clone(), place: PlaceRecord::of(*span, sources) });
        Self {
            severity: match finding.severity {
                Severity::Error => ERROR,
                Severity::Warning => "warning",
            },
            rule: finding.code,
            message: finding.message.clone(),
            place: PlaceRecord::of(finding.span, sources),
            label: finding.label.clone(),
            help: finding.help.clone(),
            related: related.collect(),
        }
    }
}

impl PlaceRecord {
    fn of(span: Span, sources: &Sources) -> Self {
        let (line, column) = sources.line_column(span);
        let (end_line, end_column) = sources.line_column(Span { start: span.end, ..span });
        Self { file: sources.get(span.source).name.to_string(), line, column, end_line, end_column }
    }
}

fn places_of(world: &str, robot: Option<&str>) -> Result<KnownPlaces> {
    let robot = robot_files::named(robot)?;
    // No arena has places, whatever its seed.
    let world = world_files::named(world, &robot, 0)?;
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

/// Tells the findings in a text.
fn tell(name: &str, role: &Role, findings: &[Diagnostic], program: &Program, console: &mut Console) -> Result<()> {
    if findings.is_empty() {
        let role = match role {
            Role::Plan => String::new(),
            Role::Scenario => ", as a scenario".to_string(),
            Role::OfModule(manifest) => format!(", as plans of `{}`", visible(manifest)),
        };
        return Ok(console.print(&format!("{}: no findings{role}", visible(name)))?);
    }
    console.note(render(findings, &program.sources, console.colour).trim_end());
    console.note(&format!("{}: {}", visible(name), count(findings)));
    Ok(())
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
