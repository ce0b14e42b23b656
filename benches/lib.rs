//! What the benches share: a median timer, other interpreters that do the same work in the same
//! command, and one table row a question.
//!
//! Arguments after `--` choose rows; with `--alone` no other interpreter is run:
//! `cargo bench -p rpl-benches -- fib timers --alone`.

use rustix::time::ClockId;
use std::path::PathBuf;
use std::process::Command;
use std::time::{Duration, Instant};

/// An interpreter that does the same work from a script `anchors/STEM.EXTENSION`, which checks its
/// result and prints the milliseconds it took.
struct Interpreter {
    name: &'static str,
    command: &'static [&'static str],
    extension: &'static str,
}

/// None of them compiles to machine code here.
const INTERPRETERS: &[Interpreter] = &[
    Interpreter { name: "Lua 5.4", command: &["lua5.4"], extension: "lua" },
    Interpreter { name: "LuaJIT, no JIT", command: &["luajit", "-joff"], extension: "lua" },
    Interpreter {
        name: "Guile",
        command: &["env", "GUILE_JIT_THRESHOLD=-1", "GUILE_WARN_DEPRECATED=no", "guile"],
        extension: "scm",
    },
    Interpreter { name: "Node, no JIT", command: &["node", "--jitless", "--stack-size=60000"], extension: "js" },
];

/// How often an anchor is run; its median counts.
const ANCHOR_RUNS: usize = 3;

/// One question: what was measured, in which unit, and what it is compared with.
#[derive(Clone, Copy, Debug)]
pub struct Question {
    /// Chooses the row on the command line.
    pub name: &'static str,
    /// What is measured.
    pub what: &'static str,
    /// The unit of the figure.
    pub unit: &'static str,
    /// The figure to reach.
    pub target: f64,
    /// The best figures measured elsewhere, as text.
    pub peers: &'static str,
    /// Scripts `anchors/STEM.*` do the same work, and print their figure in the unit of the row.
    pub anchors: Option<&'static str>,
}

impl Question {
    /// A question without scripts beside it.
    #[must_use]
    pub const fn new(
        name: &'static str,
        what: &'static str,
        unit: &'static str,
        target: f64,
        peers: &'static str,
    ) -> Self {
        Self { name, what, unit, target, peers, anchors: None }
    }
}

/// Runs the questions that the command line asks for and prints a row for each.
#[derive(Debug)]
pub struct Report {
    wanted: Vec<String>,
    alone: bool,
}

impl Report {
    /// The rows named on the command line; all if none is.
    pub fn from_arguments() -> Self {
        let wanted = std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
        Self { wanted, alone: std::env::args().any(|argument| argument == "--alone") }
    }

    /// Measures and prints one row, if it is asked for.
    pub fn row(&self, question: Question, measure: impl FnOnce() -> f64) {
        if !self.wanted.is_empty() && !self.wanted.iter().any(|name| name == question.name) {
            return;
        }
        let figure = measure();
        let verdict = if figure <= question.target { "reached" } else { "missed" };
        let Question { name, what, unit, target, peers, .. } = question;
        println!("{name:<12} {:>9} {unit:<8} target {:>7} {verdict:<8} {what}", digits(figure), digits(target));
        println!("{:<12} measured elsewhere: {peers}", "");
        let Some(stem) = question.anchors.filter(|_| !self.alone) else { return };
        for interpreter in INTERPRETERS {
            if let Some(here) = anchor(interpreter, stem) {
                println!("{:<12} {:<13} {here:>9.1} {unit}: {:.2} times ours", "", interpreter.name, here / figure);
            }
        }
    }
}

/// Three digits that count, or one decimal place.
fn digits(figure: f64) -> String {
    let size = figure.abs();
    let places = if size >= 9.995 { 1 } else { 2 };
    if size == 0.0 || size >= 0.9995 {
        format!("{figure:.places$}")
    } else if size >= 0.000_999_5 {
        format!("{figure:.*}", (2.0 - size.log10().floor()) as usize)
    } else {
        format!("{figure:.1e}")
    }
}

/// Milliseconds of some runs of a script, the median; none if it cannot be run.
fn anchor(interpreter: &Interpreter, stem: &str) -> Option<f64> {
    let times: Option<Vec<f64>> = (0..ANCHOR_RUNS).map(|_| anchor_once(interpreter, stem)).collect();
    times.map(median)
}

/// Milliseconds of one run of a script; none if it is not there, or cannot be run here.
fn anchor_once(interpreter: &Interpreter, stem: &str) -> Option<f64> {
    let script: PathBuf =
        [env!("CARGO_MANIFEST_DIR"), "anchors", &format!("{stem}.{}", interpreter.extension)].iter().collect();
    if !script.exists() {
        return None;
    }
    let (program, arguments) = interpreter.command.split_first()?;
    let output = Command::new(program).args(arguments).arg(&script).output().ok()?;
    if !output.status.success() {
        let error = String::from_utf8_lossy(&output.stderr);
        println!("{:<12} {} cannot run {}: {}", "", interpreter.name, script.to_string_lossy(), error.trim());
        return None;
    }
    String::from_utf8_lossy(&output.stdout).trim().parse().ok()
}

/// What a program takes here, and its equals in other interpreters.
#[derive(Debug)]
pub struct Comparison {
    /// Least milliseconds here.
    pub ours_ms: f64,
    /// Least milliseconds of each interpreter that was found, the fastest first.
    pub peers: Vec<(&'static str, f64)>,
}

/// Runs a program and the scripts `anchors/STEM.*` in turn, so that what else the machine does is the same for all. The
/// least time counts: a processor that others use too has slow seconds, and no fast ones.
pub fn compared(stem: &str, rounds: usize, mut ours_ms: impl FnMut() -> f64) -> Comparison {
    let mut ours = Vec::new();
    let mut theirs: Vec<(&'static str, Vec<f64>)> = INTERPRETERS.iter().map(|one| (one.name, Vec::new())).collect();
    for _ in 0..rounds {
        ours.push(ours_ms());
        for (interpreter, (_, times)) in INTERPRETERS.iter().zip(&mut theirs) {
            times.extend(anchor_once(interpreter, stem));
        }
    }
    let ran = theirs.into_iter().filter(|(_, times)| times.len() == rounds);
    let mut peers: Vec<(&'static str, f64)> = ran.map(|(name, times)| (name, least(times))).collect();
    peers.sort_by(|left, right| left.1.total_cmp(&right.1));
    Comparison { ours_ms: least(ours), peers }
}

/// The smallest one.
fn least(values: Vec<f64>) -> f64 {
    values.into_iter().fold(f64::INFINITY, f64::min)
}

/// The middle one; of an even number, the higher of the two in the middle.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Processor time of this thread so far: other work on the machine does not count.
pub fn computed() -> Duration {
    let time = rustix::time::clock_gettime(ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec.unsigned_abs(), time.tv_nsec.unsigned_abs() as u32)
}

/// A time in milliseconds.
fn ms(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// Median milliseconds of `act` over `runs` fresh values of `prepare`, which is not timed, nor is
/// dropping what `act` gives.
pub fn median_ms<T, R>(runs: usize, mut prepare: impl FnMut() -> T, mut act: impl FnMut(T) -> R) -> f64 {
    let times = (0..runs)
        .map(|_| {
            let input = prepare();
            let began = computed();
            let result = act(input);
            let elapsed_ms = ms(computed() - began);
            drop(result);
            elapsed_ms
        })
        .collect();
    median(times)
}

/// Least milliseconds of `act` over `runs`: processor time if it stays on this thread, else wall
/// time. `prepare` is not timed.
pub fn least_ms(runs: usize, on_this_thread: bool, mut prepare: impl FnMut(), mut act: impl FnMut()) -> f64 {
    let times = (0..runs).map(|_| {
        prepare();
        let (computed_before, began) = (computed(), Instant::now());
        act();
        ms(if on_this_thread { computed() - computed_before } else { began.elapsed() })
    });
    times.fold(f64::INFINITY, f64::min)
}

/// Set in a process that measures one row for another.
const IS_FRESH: &str = "RPL_BENCH_FRESH";

/// The figure of a row as a new process measures it, whose memory nobody has used before; what
/// `measure` gives in that process itself.
pub fn in_fresh_process(row: &str, measure: impl FnOnce() -> f64) -> f64 {
    if std::env::var_os(IS_FRESH).is_some() {
        return measure();
    }
    let output = std::env::current_exe()
        .and_then(|program| Command::new(program).args([row, "--alone"]).env(IS_FRESH, "1").output());
    let text = output.map(|output| String::from_utf8_lossy(&output.stdout).into_owned()).unwrap_or_default();
    text.split_whitespace().nth(1).and_then(|figure| figure.parse().ok()).unwrap_or(f64::NAN)
}

/// Bytes of memory this process has in use, as the kernel counts them; none where that is unknown.
pub fn resident_bytes() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/statm").ok()?;
    let pages: f64 = text.split_whitespace().nth(1)?.parse().ok()?;
    Some(pages * 4096.0)
}
