//! Runs generated programs, many of them:
//! `cargo run --release -p rpl-tests --example generated -- --runs 1000000 --seed 1`.
//!
//! `--skip N` begins behind N programs. `--findings N` goes on until N findings. `--texts N`
//! mangles texts for the reader and the compiler instead, `--forgeries N` forges saved runs.

use rpl_tests::generated::drive::{Case, Tally};
use rpl_tests::generated::shrink::shrink;
use rpl_tests::generated::{forged, texts};
use rpl_tests::options::number;
use std::process::ExitCode;
use std::time::Instant;

/// Runs of one program.
const RUNS_EACH: u64 = 10;

/// Texts that are tried to make a finding small.
const TRIES: usize = 3_000;

/// No text of some thousand characters takes longer to be read and compiled, or refused.
const MAX_SECONDS: f64 = 10.0;

fn main() -> ExitCode {
    std::panic::set_hook(Box::new(|panic| {
        if std::env::var_os("RUST_BACKTRACE").is_some() {
            eprintln!("{panic}\n{}", std::backtrace::Backtrace::force_capture());
        }
    }));
    let (runs, seed, most) = (number("--runs", 100_000), number("--seed", 1), number("--findings", 1));
    let (texts, forgeries) = (number("--texts", 0), number("--forgeries", 0));
    if texts + forgeries > 0 {
        return other_inputs(seed, texts, forgeries, most);
    }
    let (start, mut tally, mut findings) = (Instant::now(), Tally::default(), 0);
    let mut programs = number("--skip", 0);
    while tally.runs < runs {
        let case = Case::generated(seed.wrapping_mul(0x1000_0000) + programs);
        if let Err(finding) = case.judge(RUNS_EACH, &mut tally) {
            report(&case, &finding);
            findings += 1;
            if findings == most {
                return ExitCode::FAILURE;
            }
        }
        programs += 1;
        if programs.is_multiple_of((runs / RUNS_EACH / 20).max(1)) {
            println!("{programs} programs in {:.0} s: {tally:?}", start.elapsed().as_secs_f64());
        }
    }
    if findings == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Mangled texts and forged runs.
fn other_inputs(seed: u64, texts: u64, forgeries: u64, most: u64) -> ExitCode {
    let (start, mut findings, mut compiled, mut slowest) = (Instant::now(), 0, 0, 0.0_f64);
    let mut tally = forged::Tally::default();
    for at in 0..texts.max(forgeries) {
        let seed = seed.wrapping_mul(0x1000_0000) + at;
        let began = Instant::now();
        let text = if at < texts { texts::judge(seed) } else { Ok(false) };
        let seconds = began.elapsed().as_secs_f64();
        slowest = slowest.max(seconds);
        let text = if seconds > MAX_SECONDS { Err(format!("it took {seconds:.1} s")) } else { text };
        compiled += u64::from(text == Ok(true));
        let state = if at < forgeries { forged::judge(seed, 20, &mut tally) } else { Ok(()) };
        for finding in text.err().into_iter().chain(state.err()) {
            println!("seed {seed}: {finding}");
            findings += 1;
            if findings >= most {
                return ExitCode::FAILURE;
            }
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "{texts} texts ({compiled} compiled, the slowest took {slowest:.1} s), forged runs: {tally:?}; {seconds:.0} s"
    );
    if findings == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The words of a finding without its numbers and names, so that shrinking keeps to one fault.
fn kind(finding: &str) -> String {
    finding.split(|letter: char| !letter.is_alphabetic()).filter(|word| word.len() > 3).take(4).collect()
}

fn report(case: &Case, finding: &str) {
    let wanted = kind(finding);
    let mut tries = 0;
    let judge = |text: &str| Case { seed: case.seed, text: text.to_string() }.judge(RUNS_EACH, &mut Tally::default());
    let small = shrink(&case.text, |text| {
        tries += 1;
        tries < TRIES && judge(text).is_err_and(|found| kind(&found) == wanted)
    });
    let last = judge(&small).err().unwrap_or_default();
    println!("seed {}: {finding}\nshrunk to\n{small}{last}\n", case.seed);
}
