//! What a module in another process costs: a step of the robot in lock step, from what it is told to its
//! `done`, by the clock on the wall. The module is this program once more.

use rpl_benches::{Question, Report};
use rpl_link::process_module::ModuleProcess;
use rpl_link::transcript::{Kept, Transcript};
use rpl_protocol::line::Conversation;
use rpl_protocol::module::manifest::Manifest;
use rpl_protocol::module::message::{Greeting, ModuleAnswer, ModuleWords, Position, ToModule};
use std::env;
use std::io::{self, BufRead, Write};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// Steps that are measured: a mission of ten minutes.
const STEPS: u64 = 12_000;

/// The argument that makes this program the module.
const AS_MODULE: &str = "as-module";

/// A conversation with a module that sets a fluent in each step.
fn conversation(command: &[&str]) -> Conversation<ModuleWords, ModuleAnswer> {
    let manifest = format!(
        "name = \"echo\"\ndoc = \"It answers.\"\ncommand = {command:?}\n[[fluent]]\nname = \"x*\"\ndoc = \"X.\"\ntype = \"number\"\n"
    );
    let manifest = Manifest::parse(&manifest, "echo.toml").unwrap_or_else(|faults| panic!("{faults}"));
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../python");
    let greeting = Greeting { period_us: 50_000, seed: 1 };
    let process = ModuleProcess::start(Arc::new(manifest), &folder, greeting).unwrap_or_else(|error| panic!("{error}"));
    Conversation::new(Arc::new(Transcript::live("echo", Box::new(process), Kept::Last, None)))
}

/// Microseconds of a step.
fn measure(command: &[&str]) -> f64 {
    let mut conversation = conversation(command);
    let began = Instant::now();
    for step in 1..=STEPS {
        let position = Some(Position { x_m: 3.2, y_m: 1.5, heading_rad: 0.1, certainty: 0.99 });
        let tick = ToModule::Tick { time_us: step * 50_000, position, percept: None };
        let answer = conversation.say(&ModuleWords(vec![tick])).unwrap_or_else(|fault| panic!("{fault:?}"));
        assert!(answer.loss.is_none() && answer.messages.len() == 2, "{answer:?}");
    }
    began.elapsed().as_secs_f64() * 1e6 / STEPS as f64
}

/// Plays the module: greets, and answers each tick with a fluent and `done`.
fn play() -> io::Result<()> {
    let mut out = io::stdout().lock();
    for line in io::stdin().lock().lines() {
        let line = line?;
        if line.contains("\"hello\"") {
            writeln!(out, "{{\"type\":\"hello\",\"protocol\":2,\"module\":\"echo\"}}")?;
        } else if let Some((_, rest)) = line.split_once("\"time_us\":") {
            let time_us: String = rest.chars().take_while(char::is_ascii_digit).collect();
            writeln!(
                out,
                "{{\"type\":\"fluents\",\"values\":{{\"x*\":0.5}}}}\n{{\"type\":\"done\",\"time_us\":{time_us}}}"
            )?;
        }
        out.flush()?;
    }
    Ok(())
}

const IN_PYTHON: &str = "from rpl_module import Module; module = Module('echo'); \
    module.each_tick(lambda tick: module.set('x*', tick.position.x_m)); module.run()";

fn main() -> io::Result<()> {
    if env::args().nth(1).as_deref() == Some(AS_MODULE) {
        return play();
    }
    let report = Report::from_arguments();
    let program = env::current_exe()?.to_string_lossy().into_owned();
    let question = |name, what| Question::new(name, what, "µs", 100.0, "–");
    let step = question("step", "a step of a module in another process, in lock step");
    report.row(step, || measure(&[program.as_str(), AS_MODULE]));
    let step = question("python", "the same of a module in Python");
    report.row(step, || measure(&["python3", "-c", IN_PYTHON]));
    Ok(())
}
