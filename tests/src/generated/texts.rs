//! Mangled texts for the reader and the compiler: whatever they are, they are refused or compiled.

use super::drive::said;
use super::{Dice, grammar};
use crate::library;
use rpl_lang::compile::NoFiles;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What texts are made of, beside what generated programs have.
const EXAMPLES: &[&str] = &[
    include_str!("../../../examples/first-steps.rpl"),
    include_str!("../../../examples/failure-handling.rpl"),
    include_str!("../../../examples/plan-as-data.rpl"),
    include_str!("../../../examples/paper.rpl"),
    rpl_stdlib::PRELUDE,
];

/// Pieces that are hard to read, or mean something at an unexpected place.
const PIECES: &[&str] = &[
    "(",
    ")",
    "((((((((",
    "))))",
    "'",
    "`",
    ",",
    ",@",
    "#'",
    "#|",
    "|#",
    "#;",
    "\"",
    "\\",
    ";",
    "\n",
    "\n(",
    ".",
    " . ",
    "\0",
    "\u{feff}",
    "≤",
    "é",
    "🤖",
    "15cm",
    "1e999",
    "-9223372036854775808",
    "9223372036854775808",
    "3d",
    "-0.0",
    "1+",
    ":",
    ":key",
    "&rest",
    "&key",
    "&optional",
    "nil",
    "t",
    "quote",
    "lambda",
    "let",
    "defmacro",
    "(defmacro m (&rest x) `(m ,@x)) (m 1)",
    "(defmacro w () (loop nil)) (w)",
    "(defmacro g (x) `(progn (g2 ,x) (g2 ,x)))",
    "defun",
    "def-plan",
    "block",
    "return-from",
    "loop",
    "until",
    "while",
    "par",
    "plan",
    ":order",
    ":tag",
    "whenever",
    ":missed",
    "setf",
    "value",
    "wait-for",
    ":timeout",
    "fluent",
    "def-fluent",
    "with-failure-handling",
    "retry",
    "unwind-protect",
];

/// A text that somebody mangled.
pub fn mangled(seed: u64) -> String {
    let mut dice = Dice::new(seed);
    let whole = match dice.below(3) {
        0 => grammar::program(seed),
        _ => (*dice.pick(EXAMPLES)).to_string(),
    };
    let start = dice.below(whole.len());
    let length = 1 + dice.below(1500);
    let from = if dice.once_in(2) { 0 } else { start };
    let mut text: Vec<u8> = whole.bytes().skip(from).take(length).collect();
    for _ in 0..1 + dice.below(8) {
        let at = dice.below(text.len() + 1);
        let piece = dice.pick(PIECES).as_bytes().to_vec();
        let end = (at + dice.below(12)).min(text.len());
        match dice.below(6) {
            0 => drop(text.splice(at..at, piece)),
            1 => drop(text.splice(at..end, piece)),
            2 => drop(text.drain(at..end)),
            3 => {
                let copied = text[at..end].to_vec();
                drop(text.splice(at..at, copied));
            }
            4 if at < text.len() => text[at] = (dice.below(256)) as u8,
            _ => {
                let most = if dice.once_in(40) { 20_000 } else { 6 };
                let many = piece.repeat(1 + dice.below(most));
                drop(text.splice(at..at, many));
            }
        }
    }
    String::from_utf8_lossy(&text).into_owned()
}

/// Reads and compiles a mangled text, and draws what was found in it; tells whether it compiled.
///
/// # Errors
/// What a panic said.
pub fn judge(seed: u64) -> Result<bool, String> {
    let text = mangled(seed);
    let judged = catch_unwind(AssertUnwindSafe(|| match library().load("mangled.rpl", &text, &mut NoFiles) {
        Ok(_) => true,
        Err(rejected) => {
            assert!(!rejected.render(false).is_empty(), "a refusal says why");
            false
        }
    }));
    judged.map_err(|panic| format!("panic: {}", said(&*panic)))
}
