//! The `rpl` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    rpl_command::main()
}
