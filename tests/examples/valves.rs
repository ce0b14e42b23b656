//! Compares all small programs that share valves with a model of the rules:
//! `cargo run --release -p rpl-tests --example valves`.
//!
//! Two children each, with everything that can happen to each task at each step, and three children each.
//! `--every N` takes one program of so many, `--blows3` lets things happen to those of three children too.

use rpl_tests::options::{is_given, number};
use rpl_tests::valves::program::programs;
use rpl_tests::valves::{Tally, judge};
use std::process::ExitCode;

/// Tasks below main.
const MOST_TASKS: usize = 6;

fn main() -> ExitCode {
    let every: usize = number("--every", 1);
    let most_findings: usize = number("--findings", 1);
    let with_blows3 = is_given("--blows3");
    let mut findings = 0;
    for (width, with_blows) in [(2, true), (3, with_blows3)] {
        let mut tally = Tally::default();
        for program in programs(width, MOST_TASKS).step_by(every) {
            if let Err(finding) = judge(&program, with_blows, &mut tally) {
                println!("{finding}\n");
                findings += 1;
                if findings == most_findings {
                    return ExitCode::FAILURE;
                }
            }
        }
        println!("{width} children: {} programs, {} runs agree", tally.programs, tally.runs);
    }
    if findings == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
