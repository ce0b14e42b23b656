//! Command lines, put together from what the command knows and what it does not.

use super::case::{Case, Expected, plan, text};
use super::mangle;
use crate::generated::Dice;

const COMMANDS: &[&str] = &[
    "run",
    "check",
    "test",
    "fmt",
    "eval",
    "worlds",
    "examples",
    "doc",
    "trace",
    "localize",
    "experiment",
    "completions",
    "",
];

const ARGUMENTS: &[&str] = &[
    "plan.rpl",
    "-",
    "--",
    "no\nfile.rpl",
    "../..",
    "",
    "test-room",
    "dept",
    "(+ 1 2)",
    "rotated",
    "diff",
    "🤖",
    "--world",
    "--seed",
    "--until",
    "--scenario",
    "--set",
    "--trace",
    "--json",
    "--figures",
    "--max-steps",
    "-q",
    "--check",
    "--png",
    "--map",
    "--grid",
    "--memory",
    "--log",
    "--beams",
    "--windows",
    "--window-length",
    "--phase",
    "--mount",
    "--field-of-view",
    "--runs",
    "--jobs",
    "--row",
    "--results",
    "--why",
    "--last",
    "--from",
    "--task",
    "--filter",
    "--help",
    "none",
    "coarse",
    "x=1",
    "x",
    "90s",
    "out",
    "bash",
    "go-to",
    "behaviours",
    "=",
];

/// Some words in some order. Nothing is asked that takes long, and nothing that waits for input.
pub fn typed(dice: &mut Dice) -> Case {
    let command = dice.pick(COMMANDS);
    let mut arguments: Vec<String> =
        [command].iter().filter(|word| !word.is_empty()).map(|word| word.to_string()).collect();
    if *command == *"experiment" {
        arguments.extend(["barn", "--runs", "1"].map(str::to_string));
    }
    for _ in 0..dice.below(6) {
        let word = if dice.once_in(3) { dice.pick(mangle::NUMBERS) } else { dice.pick(ARGUMENTS) };
        arguments.push(word.to_string());
    }
    Case { kind: "command line", files: vec![plan(), text("x", "\u{feff}")], arguments, expected: Expected::Anything }
}
