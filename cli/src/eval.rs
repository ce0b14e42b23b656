//! `rpl eval EXPR`: the value of a text's last form.

use crate::console::Console;
use crate::drive::{Ending, Pace, Records, drive};
use crate::failure_report::{PLAN_FAILED, Reporter};
use crate::files::{self, Folder};
use crate::interrupt;
use crate::mission::Site;
use crate::run::status;
use crate::status::Status;
use anyhow::Result;
use rpl_runtime::system::{Outcome, System};

/// Evaluates a text, `-` for standard input, and prints the value as it could be read.
///
/// # Errors
/// Standard input cannot be read, or standard output is closed.
pub fn run(expression: &str, console: &mut Console) -> Result<Status> {
    interrupt::catch();
    let (name, text) = match expression {
        "-" => ("<stdin>", files::standard_input()?),
        text => ("<eval>", text.to_string()),
    };
    let site = Site::without_robot()?;
    let mut folder = Folder::Disk(".".into());
    let loaded = match site.library.load(name, &text, &mut folder) {
        Ok(loaded) => loaded,
        Err(rejected) => {
            console.note(rejected.render(console.colour).trim_end());
            return Ok(Status::Wrong);
        }
    };
    let mut system = System::new(site.library.clone(), loaded, site.robot(0));
    let ending = drive(&mut system, Pace::default(), console, &mut Records::default())?;
    match ending {
        Ending::Outcome(Outcome::Succeeded(value)) => {
            console.print(&system.machine.write(&system.program, value))?;
        }
        Ending::Outcome(Outcome::Failed(failure)) => {
            let reporter = Reporter { machine: &system.machine, program: &system.program, colour: console.colour };
            console.note(reporter.text(PLAN_FAILED, failure).trim_end());
        }
        Ending::Outcome(Outcome::Evaporated) | Ending::TimeUp | Ending::Interrupted => {}
    }
    console.flush()?;
    Ok(status(ending))
}
