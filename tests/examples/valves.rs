//! Compares all small programs that share valves with a model of the rules:
//! `cargo run --release -p rpl-tests --example valves`.
//!
//! Two children each before a valve of one place, with everything that can happen to each task at each step, and three
//! children each; and one child more than there are places before valves of two and three, one program of a thousand of
//! the last. `--every N` takes one program of N, `--from N` begins with that one, `--blows3` lets things happen
//! to those of three children and more too.

use rpl_tests::options::{is_given, number};
use rpl_tests::valves::program::programs;
use rpl_tests::valves::{Tally, judge};
use std::process::ExitCode;

/// Tasks below main.
const MOST_TASKS: usize = 6;

fn main() -> ExitCode {
    let every: usize = number("--every", 1);
    let most_findings: usize = number("--findings", 1);
    let from: usize = number("--from", 0);
    let with_blows3 = is_given("--blows3");
    let mut findings = 0;
    for (width, places, rarer, with_blows) in
        [(2, 1, 1, true), (3, 1, 1, with_blows3), (3, 2, 1, with_blows3), (4, 3, 1_000, with_blows3)]
    {
        let mut tally = Tally::default();
        for program in programs(width, places, MOST_TASKS, every * rarer).skip(from) {
            if let Err(finding) = judge(&program, with_blows, &mut tally) {
                println!("{finding}\n");
                findings += 1;
                if findings == most_findings {
                    return ExitCode::FAILURE;
                }
            }
        }
        println!("{width} children, {places} places: {} programs, {} runs agree", tally.programs, tally.runs);
    }
    if findings == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
