//! The language beside other interpreters without a compiler to machine code: the same programs, in `rpl` and `anchors`,
//! run in turn.
//!
//! Arguments after `--` choose programs by their names, and `start` how long the command takes to begin; `--page` writes `docs/speed.md`.

use rpl_benches::{Comparison, compared, median_ms};
use rpl_mission::libraries::library_without_robot;
use rpl_runtime::robot::NoRobot;
use rpl_runtime::run::library::Library;
use rpl_runtime::run::system::{Outcome, Progress, System};
use rpl_runtime::state::value::Value;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

/// How often each program is run.
const ROUNDS: usize = 15;

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
    program!("text", "50,000 lines formatted, joined and split", 50_000, 1.2),
    program!("handler", "200,000 failures, each handled", 200_000, 1.0),
    program!("deep", "a hundred times 10,000 calls inside one another", 1_000_000, 1.0),
    program!("memo", "a recursion that remembers its results in a hash table", 40_853_235_313, 1.3),
    program!("tak", "Takeuchi's function of 18, 12 and 6, five times", 7, 1.3),
    program!("counts", "100,000 names made by a pattern, and counted", 500_239, 1.3),
    program!("heap", "heap sort of a vector of 30,000", 1_068_064_761, 1.3),
    program!("matrix", "the product of matrices of 80 × 80, three times", 119_880, 1.3),
    program!("pairs", "200,000 look-ups in an association list of 30", 2_906_600, 1.3),
    program!("numbers", "60,000 numbers read from lines of text", 999_960_000, 1.3),
    program!("agenda", "a priority queue of 20,000 records", 905_991, 1.3),
    program!("grid", "breadth-first search in a grid of 200 × 200", 958, 1.3),
    program!("report", "20 reports, each built by appending 300 lines", 107_800, 1.3),
    program!("handlers", "300,000 calls of closures found in a hash table", 778_753, 1.3),
    program!("labels", "an expression read by three local functions, 10,000 times", 2_730_000, 1.3),
    program!("spawn", "100,000 tasks begun, run and joined", 100_000, 1.0),
    program!("switch", "200,000 times a token handed to and fro by two tasks", 200_000, 1.0),
    program!("timers", "100,000 tasks that wait for a time each", 100_000, 1.0),
    program!("pulse", "a pulse that wakes 100,000 tasks, which end", 100_000, 1.0),
    program!("monitors", "1,000 monitors over a fluent that takes 1,000 values", 1_000, 2.0),
    program!("conditions", "1,000 tasks that wait for conditions of such a fluent", 1_000, 2.0),
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
fn page(rows: &[(&Program, Comparison)], started: Option<&Comparison>) -> String {
    let mut text = String::from(
        "# Speed of the language\n\nThis page compares the same programs here and in other interpreters. None of them compiles to machine code while it runs. The figures are milliseconds of processor time without starting up, each the least of several runs in turn. \"Ratio\" is our time divided by that of the fastest peer, so less is better.\n\n| program | ours | peers | ratio | goal |\n| --- | ---: | --- | ---: | ---: |\n",
    );
    for (program, comparison) in rows {
        let peers: Vec<String> = comparison.peers.iter().map(|(name, ms)| format!("{name} {ms:.1}")).collect();
        let ratio = ratio(comparison).map_or("–".to_string(), |ratio| format!("{ratio:.2}"));
        let (what, ours, goal) = (program.what, comparison.ours_ms, program.goal);
        let written = writeln!(text, "| {what} | {ours:.1} | {} | {ratio} | {goal} |", peers.join(", "));
        assert!(written.is_ok(), "writing into a string cannot fail");
    }
    let (machine, load) = (machine(), load());
    if let Some(started) = started {
        let peers: Vec<String> = started.peers.iter().map(|(name, ms)| format!("{name} {ms:.1}")).collect();
        let (ours, peers) = (started.ours_ms, peers.join(", "));
        let written = writeln!(
            text,
            "\nTo start, evaluate one form, print its value and end, `rpl eval 1` takes {ours:.1} ms of processor time (goal {START_GOAL_MS}). The others take: {peers}."
        );
        assert!(written.is_ok(), "writing into a string cannot fail");
    }
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

/// The name that chooses how long the command takes to start.
const START: &str = "start";

/// The milliseconds that may take.
const START_GOAL_MS: f64 = 4.0;

/// How often a command is started.
const STARTS: u32 = 100;

/// Other interpreters that print a one.
const STARTED: &[(&str, &[&str])] = &[
    ("Lua 5.4", &["lua5.4", "-e", "print(1)"]),
    ("LuaJIT, no JIT", &["luajit", "-joff", "-e", "print(1)"]),
    ("Guile", &["guile", "-c", "(display 1)"]),
    ("Node, no JIT", &["node", "--jitless", "-e", "console.log(1)"]),
];

/// What starting the command takes that was built beside this bench, and other interpreters.
fn started() -> Option<Comparison> {
    let bench = std::env::current_exe().ok()?;
    let command = bench.parent()?.parent()?.join("rpl");
    let ours_ms = started_ms(&[command.to_str()?, "eval", "1"])?;
    let mut peers: Vec<(&str, f64)> =
        STARTED.iter().filter_map(|&(name, command)| Some((name, started_ms(command)?))).collect();
    peers.sort_by(|left, right| left.1.total_cmp(&right.1));
    Some(Comparison { ours_ms, peers })
}

/// Milliseconds of processor time of a command, the mean of many runs; none if it cannot be run.
fn started_ms(command: &[&str]) -> Option<f64> {
    let (program, arguments) = command.split_first()?;
    let before = ticks_of_children()?;
    for _ in 0..STARTS {
        let output = Command::new(program).args(arguments).output().ok()?;
        output.status.success().then_some(())?;
    }
    Some((ticks_of_children()? - before) * MS_PER_TICK / f64::from(STARTS))
}

/// Linux tells times of processes in hundredths of a second.
const MS_PER_TICK: f64 = 10.0;

/// Ticks of processor time of all processes that this one has begun and waited for.
fn ticks_of_children() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    // Behind the name, which may have spaces, in user mode and in the kernel (proc(5)).
    let fields: Vec<&str> = text.rsplit(')').next()?.split_whitespace().collect();
    Some(fields.get(13)?.parse::<f64>().ok()? + fields.get(14)?.parse::<f64>().ok()?)
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let names: Vec<&String> = arguments.iter().filter(|argument| !argument.starts_with('-')).collect();
    let is_wanted = |name: &str| names.is_empty() || names.iter().any(|wanted| *wanted == name);
    let library = library_without_robot(Vec::new()).unwrap_or_else(|error| panic!("{error}"));
    let mut rows = Vec::new();
    for program in PROGRAMS.iter().filter(|program| is_wanted(program.name)) {
        let comparison = compared(program.name, ROUNDS, || once_ms(&library, program));
        show(program, &comparison);
        rows.push((program, comparison));
    }
    let started = is_wanted(START).then(started);
    match &started {
        Some(Some(Comparison { ours_ms, peers })) => {
            println!("{START:<12} {ours_ms:>8.1} ms  {peers:?} (goal {START_GOAL_MS} ms)");
        }
        Some(None) => println!("{START:<12} not measured: build the command first, `cargo build --release -p rpl`"),
        None => {}
    }
    if arguments.iter().any(|argument| argument == "--page") {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/speed.md");
        std::fs::write(&path, page(&rows, started.flatten().as_ref()))
            .unwrap_or_else(|error| panic!("{}: {error}", path.to_string_lossy()));
    }
}
