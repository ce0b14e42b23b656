//! Disks that fail: each call that writes to the journal of a short run, in its turn.
//!
//! The calls are those of the command as it is; `strace` lets them fail, and counts them for each thread.

use crate::bench::{BEGIN, Bench, Files, Left, Place, SHORT};
use std::fs;
use std::io;
use std::process::Command;

/// The calls by which something is changed on a disk, and how each fails.
const CALLS: [(&str, &str); 7] = [
    ("write", "ENOSPC"),
    ("ftruncate", "EIO"),
    ("fsync", "EIO"),
    ("fdatasync", "EIO"),
    ("rename", "ENOSPC"),
    ("unlink", "EROFS"),
    ("openat", "EACCES"),
];

/// How many fail in a row, the first included.
const COUNTS: [usize; 2] = [1, 20];

/// Files whose calls fail, and those beside them.
const NAMES: [&str; 9] = [
    "t.jsonl",
    "j",
    "j/run.new",
    "j/output.txt",
    "j/log.txt",
    "j/checkpoint-000000.new",
    "j/checkpoint-000001.new",
    "j/goes-on.new",
    "j/end.new",
];

/// Files that are looked at in the folder before and after, and at most removed or renamed.
const PLACED: [&str; 6] = ["j/run", "j/checkpoint-000000", "j/checkpoint-000001", "j/goes-on", "j/end", "j/lock"];

/// A part of the run: from its files to where it stands then.
struct Life {
    arguments: Vec<&'static str>,
    before: Files,
    printed: Vec<u8>,
    status: Option<i32>,
    /// How often each of [`CALLS`] is made, by all threads.
    calls: Vec<usize>,
}

/// A short run, undisturbed.
struct Run {
    lives: Vec<Life>,
    left: Left,
}

/// Which call fails, from which on and how often.
#[derive(Clone, Copy)]
struct Fault {
    call: usize,
    from: usize,
    count: usize,
}

/// How many runs did not come to what they should.
///
/// # Errors
/// There is no `strace`, or the command cannot be started.
pub fn faults(bench: &Bench) -> io::Result<u64> {
    let run = undisturbed(&mut bench.place("one")?)?;
    let mut cases = Vec::new();
    for (life, Life { calls, .. }) in run.lives.iter().enumerate() {
        let faults = calls.iter().enumerate().flat_map(|(call, &times)| {
            (1..=times).flat_map(move |from| COUNTS.map(|count| Fault { call, from, count }))
        });
        cases.extend(faults.map(|fault| (life, fault)));
    }
    let findings = bench.each(cases.len(), undisturbed, |place, run, number| {
        let (life, fault) = cases[number];
        let Fault { call, from, count } = fault;
        let (name, error) = CALLS[call];
        let found = disturbed(place, run, &run.lives[life], fault)?;
        let what = || format!("rpl {:?}, {name} {from} to {}: {error}", run.lives[life].arguments, from + count - 1);
        Ok(found.map(|found| format!("{}: {found}", what())))
    })?;
    println!("{} faults, {findings} findings", cases.len());
    Ok(findings)
}

/// The run, part by part, and once more as one that must not go on without its journal.
fn undisturbed(place: &mut Place) -> io::Result<Run> {
    fs::write(place.folder.join("plan.rpl"), SHORT)?;
    let parts: [&[&str]; 4] = [
        &[&BEGIN[..], &["--until", "2s"]].concat(),
        &["resume", "j", "--until", "5s"],
        &["resume", "j"],
        &[&BEGIN[..], &["--journal-must"]].concat(),
    ];
    let (mut lives, mut left) = (Vec::new(), None);
    for arguments in parts {
        if arguments[0] == "run" {
            Files(Vec::new()).put_back(place)?;
        }
        let before = place.files()?;
        let output = traced(place, arguments, None)?.output()?;
        let calls = fs::read_to_string(place.folder.join("calls"))?;
        let times = |(name, _): &(&str, &str)| calls.lines().filter(|line| line.contains(&format!(" {name}("))).count();
        lives.push(Life {
            arguments: arguments.to_vec(),
            before,
            printed: output.stdout,
            status: output.status.code(),
            calls: CALLS.iter().map(times).collect(),
        });
        if output.status.code() == Some(0) && left.is_none() {
            left = Some(Left::by(place)?);
        }
    }
    let left = left.ok_or_else(|| io::Error::other("the short run does not come to its end"))?;
    Ok(Run { lives, left })
}

/// The command under `strace`, which writes calls to the journal and the trace into a file, and lets some fail.
fn traced(place: &Place, arguments: &[&str], fault: Option<Fault>) -> io::Result<Command> {
    let folder = place.folder.canonicalize()?;
    let names: Vec<&str> = CALLS.iter().map(|(name, _)| *name).collect();
    let mut command = Command::new("strace");
    command.args(["-f", "-qqq", "-o", "calls", "-e"]).arg(format!("trace={}", names.join(",")));
    if let Some(Fault { call, from, count }) = fault {
        let (name, error) = CALLS[call];
        command.arg("-e").arg(format!("inject={name}:error={error}:when={from}..{}", from + count - 1));
    }
    for name in NAMES.iter().chain(&PLACED) {
        command.arg("-P").arg(folder.join(name));
    }
    command.arg(&place.command).args(arguments).current_dir(&place.folder).env("NO_COLOR", "1");
    Ok(command)
}

/// What was wrong with a run whose disk failed so, and that was gone on with when it did no more.
fn disturbed(place: &Place, run: &Run, life: &Life, fault: Fault) -> io::Result<Option<String>> {
    life.before.put_back(place)?;
    let output = traced(place, &life.arguments, Some(fault))?.output()?;
    let told = String::from_utf8_lossy(&output.stderr);
    let is_told = told.contains("error: ");
    let is_stopped = life.arguments.contains(&"--journal-must") && told.contains("the run is stopped");
    match output.status.code() {
        status if status == life.status => {
            if output.stdout != life.printed {
                return Ok(Some(format!("it printed {} bytes, not {}", output.stdout.len(), life.printed.len())));
            }
        }
        // It could not be begun, the trace could not be written to its end, or it must not go on.
        Some(2) if is_told && (output.stdout.is_empty() || output.stdout == life.printed || is_stopped) => {}
        status => return Ok(Some(format!("exit status {status:?}: {told}"))),
    }
    gone_on(place).map(|found| found.or_else(|| run.left.difference(place)))
}

/// Goes on until the run is over: where it was to stand still and could not say so, it stands still once more.
fn gone_on(place: &Place) -> io::Result<Option<String>> {
    for _ in 0..3 {
        let again: &[&str] = if place.journal().join("run").exists() { &["resume", "j"] } else { &BEGIN };
        let output = place.rpl(again).output()?;
        match output.status.code() {
            Some(0) => return Ok(None),
            Some(3) => {}
            status => {
                let told = String::from_utf8_lossy(&output.stderr).into_owned();
                return Ok(Some(format!("then rpl {again:?} has exit status {status:?}: {told}")));
            }
        }
    }
    Ok(Some("it does not come to its end".to_string()))
}
