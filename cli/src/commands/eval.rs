//! `rpl eval EXPR`: the value of a text's last form.

use anyhow::Result;
use rpl_drive::observed::RunEnd;
use rpl_drive::run_driver::{Pace, drive};
use rpl_drive::run_record::Records;
use rpl_drive::show::failure_report::{PLAN_FAILED, Reporter};
use rpl_drive::show::summary::{status, summarize, tell_failed_scenario};
use rpl_lang::formatter;
use rpl_lang::source::SourceId;
use rpl_runtime::run::system::Outcome;
use rpl_shell::arguments::site::SiteArguments;
use rpl_shell::files::inputs;
use rpl_shell::files::module_files::{GoingBack, ModuleVoices};
use rpl_shell::files::plans::Folder;
use rpl_shell::interrupt;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use std::time::Instant;

/// A value that takes more columns is laid out over several lines.
const WIDE: usize = 100;

/// Evaluate an expression, or standard input, and print its value
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Expression; `-` for standard input
    #[arg(value_name = "EXPR", allow_hyphen_values = true)]
    expression: String,
    /// Where it is evaluated
    #[command(flatten)]
    site: SiteArguments,
    /// Print one JSON object to standard output instead of the value, after the output of the expression
    #[arg(long)]
    json: bool,
}

/// Evaluates a text, `-` for standard input, and prints the value as it could be read.
///
/// # Errors
/// The world cannot be read, standard input cannot be read, or standard output is closed.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let began = Instant::now();
    let (name, text) = match arguments.expression.as_str() {
        "-" => ("<stdin>", inputs::standard_input()?),
        text => ("<eval>", text.to_string()),
    };
    let (site, _, modules) = arguments.site.build(ModuleVoices::Processes(GoingBack::Never))?;
    let seed = arguments.site.seed();
    let mut folder = Folder::Disk(".".into());
    let loaded = match site.library.load(name, &text, &mut folder) {
        Ok(loaded) => loaded,
        Err(rejected) => {
            console.note(rejected.render(console.colour).trim_end());
            return Ok(Status::Wrong);
        }
    };
    modules.start(&site, seed, None)?;
    let mut system = site.start(loaded, seed);
    let mut records = Records::default();
    let ending = {
        let _stops = interrupt::stops_runs();
        drive(&mut system, Pace::default(), console, &mut records)?
    };
    if arguments.json {
        console.print(&summarize(&system, ending, &records.observed, seed, began).as_json()?)?;
        console.flush()?;
    }
    match ending {
        RunEnd::Outcome(Outcome::Succeeded(_)) if arguments.json => {}
        RunEnd::Outcome(Outcome::Succeeded(value)) => {
            console.print(&laid_out(system.machine.write(&system.program, value)))?;
        }
        RunEnd::Outcome(Outcome::Failed(failure)) => {
            let reporter = Reporter { machine: &system.machine, program: &system.program, colour: console.colour };
            console.note(reporter.text(PLAN_FAILED, failure).trim_end());
        }
        RunEnd::Outcome(Outcome::Evaporated) | RunEnd::TimeUp | RunEnd::Interrupted | RunEnd::GivenUp => {}
    }
    tell_failed_scenario(&system, console);
    console.flush()?;
    Ok(status(&system, ending))
}

/// A long value as the formatter lays out a text.
fn laid_out(value: String) -> String {
    let is_wide = value.chars().count() > WIDE;
    let lines = is_wide.then(|| formatter::format(&value, SourceId(0)).ok()).flatten();
    lines.map_or(value, |lines| lines.trim_end().to_string())
}
