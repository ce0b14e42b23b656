//! The language beside other interpreters without a compiler to machine code: the same programs, in `rpl` and `anchors`,
//! run in turn.
//!
//! Arguments after `--` choose programs by their names; `--page` writes `docs/speed.md`.

use rpl_benches::{Comparison, compared, median_ms};
use rpl_mission::libraries::library_without_robot;
use rpl_runtime::robot::NoRobot;
use rpl_runtime::run::library::Library;
use rpl_runtime::run::system::{Outcome, Progress, System};
use rpl_runtime::state::value::Value;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

/// How often each program is run.
const ROUNDS: usize = 5;

/// A program, and what it must come to.
struct Program {
    /// The stem of its file, and of those of its peers.
    name: &'static str,
    /// What it does.
    what: &'static str,
    text: &'static str,
    value: i64,
    /// How many times the fastest peer's time it may take.
    goal: f64,
}

macro_rules! program {
    ($name:literal, $what:literal, $value:literal, $goal:literal) => {
        Program {
            name: $name,
            what: $what,
            text: include_str!(concat!("../rpl/", $name, ".rpl")),
            value: $value,
            goal: $goal,
        }
    };
}

const PROGRAMS: &[Program] = &[
    program!("fib", "calls: the 30th Fibonacci number", 832_040, 1.0),
    program!("loop", "a loop of ten million turns", 49_999_995_000_000, 1.0),
    program!("mandelbrot", "floats: a grid of 200 × 200", 10_249, 1.0),
    program!("trees", "pairs: ten binary trees of depth 16", 1_310_710, 1.0),
    program!("queens", "lists: eight queens, ten times", 92, 1.2),
    program!("map_filter", "`map` and `filter` over a million", 500_000, 1.2),
    program!("closures", "a million closures that assign", 500_001_500_000, 1.2),
    program!("sort", "`sort` of 100,000 by a function", 1_072_443_146, 1.2),
    program!("sieve", "vectors: primes up to 200,000, five times", 17_984, 2.0),
    program!("bodies", "records: two bodies, 100,000 steps", 1, 2.0),
    program!("table", "a hash table with integers as keys", 44_999_850_000, 1.0),
    program!("words", "a hash table with strings as keys", 300_000, 1.5),
    program!("build", "200,000 strings made and joined", 1_488_889, 1.2),
    program!("handler", "200,000 failures, each handled", 200_000, 1.0),
];

/// Milliseconds from the first wait to the end.
fn once_ms(library: &Arc<Library>, program: &Program) -> f64 {
    let system = match System::without_robot(library, "bench.rpl", program.text, 0) {
        Ok(mut system) => {
            system.settle();
            system
        }
        Err(rejected) => panic!("{}", rejected.render(false)),
    };
    let to_the_end = |mut system: System<NoRobot>| {
        while system.advance() == Progress::Running {}
        assert_eq!(system.outcome(), Some(Outcome::Succeeded(Value::Int(program.value))), "{}", program.name);
        system
    };
    median_ms(1, || system.fork(), to_the_end)
}

/// How many times the time of the fastest peer it takes.
fn ratio(comparison: &Comparison) -> Option<f64> {
    comparison.peers.first().map(|(_, peer_ms)| comparison.ours_ms / peer_ms)
}

fn show(program: &Program, comparison: &Comparison) {
    let ratio = ratio(comparison).map_or("no peer found".to_string(), |ratio| format!("{ratio:.2} × the fastest"));
    println!("{:<12} {:>8.1} ms  {ratio} (goal {})  {}", program.name, comparison.ours_ms, program.goal, program.what);
    for (name, peer_ms) in &comparison.peers {
        println!("{:<12} {peer_ms:>8.1} ms  {name}", "");
    }
}

/// The page of the book.
fn page(rows: &[(&Program, Comparison)]) -> String {
    let mut text = String::from(
        "# Speed of the language\n\nThe same programs here and in other interpreters, none of which compiles to machine code while it runs. Milliseconds of processor time without starting up: medians of runs in turn. \"Ratio\" is our time by that of the fastest peer, so less is better.\n\n| program | ours | peers | ratio | goal |\n| --- | ---: | --- | ---: | ---: |\n",
    );
    for (program, comparison) in rows {
        let peers: Vec<String> = comparison.peers.iter().map(|(name, ms)| format!("{name} {ms:.1}")).collect();
        let ratio = ratio(comparison).map_or("–".to_string(), |ratio| format!("{ratio:.2}"));
        let (what, ours, goal) = (program.what, comparison.ours_ms, program.goal);
        let written = writeln!(text, "| {what} | {ours:.1} | {} | {ratio} | {goal} |", peers.join(", "));
        assert!(written.is_ok(), "writing into a string cannot fail");
    }
    let (machine, load) = (machine(), load());
    text + &format!(
        "\nMeasured on {machine}, with a load of {load}, by `cargo bench -p rpl-benches --bench language -- --page`. The programs are `benches/rpl/*.rpl`, and `benches/anchors` has the peers'.\n"
    )
}

/// The processor of this machine.
fn machine() -> String {
    let cpus = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpus.lines().find_map(|line| line.strip_prefix("model name")).unwrap_or("an unknown processor");
    let count = cpus.lines().filter(|line| line.starts_with("processor")).count();
    format!("{} ({count} cores)", model.trim_start_matches([' ', '\t', ':']))
}

/// How many processes wanted a processor in the last minute.
fn load() -> String {
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    load.split_whitespace().next().unwrap_or("unknown").to_string()
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let is_wanted = |program: &&Program| {
        let mut names = arguments.iter().filter(|argument| !argument.starts_with('-')).peekable();
        names.peek().is_none() || names.any(|name| name == program.name)
    };
    let library = library_without_robot(Vec::new()).unwrap_or_else(|error| panic!("{error}"));
    let mut rows = Vec::new();
    for program in PROGRAMS.iter().filter(is_wanted) {
        let comparison = compared(program.name, ROUNDS, || once_ms(&library, program));
        show(program, &comparison);
        rows.push((program, comparison));
    }
    if arguments.iter().any(|argument| argument == "--page") {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/speed.md");
        std::fs::write(&path, page(&rows)).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
}
