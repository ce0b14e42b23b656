//! Runs with a journal that are killed at any moment, journals that are damaged, and disks that fail:
//! `cargo build --release -p rpl && cargo run --release -p rpl-tests --example kills -- --kills 1000 --seed 1`.
//!
//! Office hours are run undisturbed and then with a journal, killed again and again, and gone on with (`hours`).
//! What they printed, told and traced must be the same, byte for byte. `--damages 10000` cuts every length up to 4 kB
//! off the end of each file in the journal of a short run, and flips 10000 bits: going on with it must give the same
//! or be refused (`damages`). `--faults` lets each write of a short run fail in its turn, by means of `strace`
//! (`faults`). The command is the one beside the examples, or `--command PATH`; `--jobs N` work at once.

mod bench;
mod damages;
mod faults;
mod hours;

use bench::Bench;
use rpl_tests::options::{command, is_given, number};
use std::process::ExitCode;

fn main() -> ExitCode {
    let Some(command) = command() else {
        eprintln!(
            "there is no `rpl` to run; build it with `cargo build --release -p rpl`, or name it with `--command`"
        );
        return ExitCode::FAILURE;
    };
    let folder = std::env::temp_dir().join(format!("rpl-kills-{}", std::process::id()));
    let bench = Bench { command, folder, seed: number("--seed", 1), jobs: number("--jobs", 1) };
    let found = if is_given("--damages") {
        damages::damages(&bench, number("--damages", 1000))
    } else if is_given("--faults") {
        faults::faults(&bench)
    } else {
        hours::kills(&bench, number("--kills", 100))
    };
    match found {
        Ok(0) => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
