//! Attacks on the command, many of them:
//! `cargo build --release -p rpl && cargo run --release -p rpl-tests --example attacks -- --runs 5000 --seed 1`.
//!
//! The page of a run, a simulator, the servers of editors, hosts, modules, projects, journals and forged files, in turns
//! drawn from the seed. `--surface NAME` attacks one of them; `--case SEED` runs one forged file or command line, and shows
//! what the command says. The command is the one beside the examples, or `--command PATH`.

use rpl_tests::attacker::{SURFACES, Surface};
use rpl_tests::forger::{Case, judge::judge};
use rpl_tests::generated::Dice;
use rpl_tests::options::{command, number, option};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    let Some(command) = command() else {
        eprintln!(
            "there is no `rpl` to run; build it with `cargo build --release -p rpl`, or name it with `--command PATH`"
        );
        return ExitCode::FAILURE;
    };
    let folder = std::env::temp_dir().join(format!("rpl-attacks-{}", std::process::id()));
    if let Some(seed) = option("--case").and_then(|text| text.parse().ok()) {
        return one(seed, &command, &folder);
    }
    let (runs, seed): (usize, u64) = (number("--runs", 500), number("--seed", 1));
    let only = option("--surface");
    let (mut findings, mut attacks) = (0, 0);
    for (at, (name, share, start)) in SURFACES.into_iter().enumerate() {
        if only.as_deref().is_some_and(|only| only != name) {
            continue;
        }
        let runs = if only.is_some() { runs } else { (runs * share).div_ceil(100) };
        let mut dice = Dice::new(seed.wrapping_mul(0x100) + at as u64);
        let begun = Instant::now();
        let (mut surface, mut kinds) = (None::<Box<dyn Surface>>, BTreeMap::new());
        for run in 0..runs {
            let judged = match &mut surface {
                Some(surface) => surface.attack(&mut dice),
                None => {
                    fs::remove_dir_all(&folder).ok();
                    let made = fs::create_dir_all(&folder).map_err(|error| error.to_string());
                    made.and_then(|()| start(&command, &folder))
                        .and_then(|started| surface.insert(started).attack(&mut dice))
                }
            };
            attacks += 1;
            match judged {
                Ok(kind) => *kinds.entry(kind).or_insert(0) += 1,
                Err(finding) => {
                    println!("{name}, attack {run}: {finding}");
                    findings += 1;
                    // What was found may have left it as nobody wants it.
                    surface = None;
                }
            }
        }
        if let Some(Err(finding)) = surface.map(|mut surface| surface.end()) {
            println!("{name}, at the end: {finding}");
            findings += 1;
        }
        println!("{name}: {} s", begun.elapsed().as_secs());
        for (kind, count) in kinds {
            println!("  {count:5} {kind}");
        }
    }
    fs::remove_dir_all(&folder).ok();
    println!("{attacks} attacks, {findings} findings");
    if findings == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn one(seed: u64, command: &Path, folder: &Path) -> ExitCode {
    let case = Case::new(seed);
    println!("{}: rpl {:?}", case.kind, case.arguments);
    match judge(&case, command, folder) {
        Ok(output) => {
            let said = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned());
            println!("{}\n{}", output.status, said.concat());
            ExitCode::SUCCESS
        }
        Err(finding) => {
            println!("{finding}");
            ExitCode::FAILURE
        }
    }
}
