//! `rpl dap`: the debug adapter, over standard input and output.

use anyhow::Result;
use rpl_shell::status::Status;

/// Run the debug adapter for editors: breakpoints, steps in both directions, the tasks of a plan
///
/// It uses the Debug Adapter Protocol over standard input and output; editors start it. `launch` takes three arguments:
/// `program` is the plan, `args` are options of `rpl step` such as `--world dept`, and `stopOnEntry` stops the plan
/// before its first form.
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {}

/// Serves until the debugger disconnects or is gone.
///
/// # Errors
/// Standard output is closed.
pub fn run(_: &Arguments) -> Result<Status> {
    Ok(rpl_prompt::debug()?)
}
