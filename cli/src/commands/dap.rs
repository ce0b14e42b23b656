//! `rpl dap`: the debug adapter, over standard input and output.

use anyhow::Result;
use rpl_shell::status::Status;

/// Serves a debugger: breakpoints, steps in both directions, the tasks of a plan
///
/// Speaks the Debug Adapter Protocol over standard input and output; editors start it. What is debugged is said by
/// `launch`: `program` is the plan, `args` are words of `rpl step` such as `--world dept`, and `stopOnEntry` stops it
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
