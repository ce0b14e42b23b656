//! Forged inputs for the command, many of them:
//! `cargo build -p rpl && cargo run -p rpl-tests --example forged -- --runs 500 --seed 1`.
//!
//! Each is run as a child process with little memory and time. `--only SEED` runs one and shows what
//! the command says. The command is the one beside the examples, or `--command PATH`.

use rpl_tests::forger::{Case, judge::judge};
use rpl_tests::options::{command, number, option};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let Some(command) = command() else {
        eprintln!("there is no `rpl` to run; build it with `cargo build -p rpl`, or name it with `--command PATH`");
        return ExitCode::FAILURE;
    };
    let folder = std::env::temp_dir().join(format!("rpl-forged-{}", std::process::id()));
    if let Some(seed) = option("--only").and_then(|text| text.parse().ok()) {
        return one(seed, &command, &folder);
    }
    let (runs, seed): (u64, u64) = (number("--runs", 500), number("--seed", 1));
    let (mut findings, mut statuses) = (0, BTreeMap::new());
    for at in 0..runs {
        let seed = seed.wrapping_mul(0x100_0000) + at;
        let case = Case::new(seed);
        match judge(&case, &command, &folder) {
            Ok(output) => *statuses.entry((case.kind, output.status.code())).or_insert(0) += 1,
            Err(finding) => {
                println!("seed {seed}, {}: rpl {:?}\n  {finding}", case.kind, case.arguments);
                findings += 1;
            }
        }
    }
    for ((kind, status), count) in statuses {
        println!("{kind:14} exit status {}: {count}", status.unwrap_or(-1));
    }
    println!("{runs} cases, {findings} findings");
    if findings == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn one(seed: u64, command: &Path, folder: &Path) -> ExitCode {
    let case = Case::new(seed);
    println!("{}: rpl {:?}", case.kind, case.arguments);
    match judge(&case, command, folder) {
        Ok(output) => {
            println!(
                "{}\n{}{}",
                output.status,
                String::from_utf8_lossy(&output.stdout),
                String::from_utf8_lossy(&output.stderr)
            );
            ExitCode::SUCCESS
        }
        Err(finding) => {
            println!("{finding}");
            ExitCode::FAILURE
        }
    }
}
