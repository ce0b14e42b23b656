//! `rpl project FILE`: how a mission would probably go on from a moment, as tables.

use crate::commands::run::load;
use anyhow::{Result, anyhow, bail};
use clap_complete::engine::ArgValueCompleter;
use rpl_drive::show::projection::blocks;
use rpl_mission::run::{Reached, run_to};
use rpl_runtime::state::projected::Grain;
use rpl_shell::arguments::completion;
use rpl_shell::arguments::duration::parse_duration_us;
use rpl_shell::arguments::site::SiteArguments;
use rpl_shell::files::module_files::{GoingBack, ModuleVoices};
use rpl_shell::files::plans;
use rpl_shell::files::project_file::Project;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use std::ops::ControlFlow::Continue;

/// Predict how a plan will go, from what the robot knows
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Plan file or built-in example; `-` for standard input (default: the plan of the nearest `rpl.toml`)
    #[arg(value_name = "FILE", add = ArgValueCompleter::new(completion::plans))]
    file: Option<String>,
    #[command(flatten)]
    site: SiteArguments,
    /// Set the initial value of a variable of the plan; can be repeated
    #[arg(long, value_name = "NAME=EXPR", add = ArgValueCompleter::new(completion::variables))]
    set: Vec<String>,
    /// Number of projected runs
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    runs: u32,
    /// Run the plan up to this time, such as 3min, and project from there
    #[arg(long, value_name = "TIME", default_value = "0s", value_parser = parse_duration_us)]
    from: u64,
    /// How far to project
    #[arg(long, value_name = "TIME", default_value = "1h", value_parser = parse_duration_us)]
    horizon: u64,
    /// Detail of the projection: events (`abstract`), or each step of the robot's own controller (`simulated`)
    #[arg(long, value_name = "GRAIN", default_value = Grain::default().name(), value_parser = parse_grain)]
    grain: Grain,
    /// Print one JSON object to standard output
    #[arg(long)]
    json: bool,
}

/// The arguments, with what the project of the plan says. What they say themselves holds.
fn in_project(arguments: &Arguments, console: &mut Console) -> Result<Arguments> {
    let mut arguments = arguments.clone();
    let named = arguments.file.as_slice();
    let Some(project) = Project::of(named, ("project", "plan"), console)? else { return Ok(arguments) };
    let plan = project.plan_or(arguments.file.take())?;
    arguments.set = project.first_values(&plan, &arguments.set);
    arguments.file = Some(plan);
    arguments.site.in_project(&project.says);
    Ok(arguments)
}

/// Runs the plan up to the moment and projects the rest.
///
/// # Errors
/// The text or the command line is wrong, the run ends before, or it cannot be projected.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    if arguments.horizon == 0 {
        bail!("nothing can be projected for no time; write a time such as `--horizon 20min`");
    }
    let arguments = &in_project(arguments, console)?;
    let plan = plans::plan(arguments.file.as_deref().unwrap_or_default())?;
    let (site, _, _modules) = arguments.site.build(ModuleVoices::Processes(GoingBack::Never))?;
    let Some(loaded) = load(&site.library, plan, &arguments.set, console)? else { return Ok(Status::Wrong) };
    let mut system = site.start(loaded, arguments.site.seed());
    let reached = run_to(&mut system, arguments.from, |system| {
        system.machine.output.clear();
        Continue(())
    });
    if let Reached::End(_) = reached {
        bail!("the run ends after {:.1} s, before `--from`: there is nothing to project", system.machine.now_s());
    }
    let figures = system.project_rest(arguments.runs, arguments.horizon, arguments.grain, arguments.site.seed());
    let figures = figures.map_err(|why| anyhow!("the plan cannot be projected: {why}"))?;
    if arguments.json {
        console.print(&serde_json::to_string(&figures)?)?;
    } else {
        blocks(&figures).iter().try_for_each(|block| console.block(block))?;
    }
    Ok(Status::Succeeded)
}

fn parse_grain(text: &str) -> Result<Grain, String> {
    let found = Grain::ALL.into_iter().find(|grain| grain.name() == text);
    found.ok_or_else(|| "there are `abstract`, in events, and `simulated`, step by step".to_string())
}
