//! Bytes that somebody damaged.

use crate::generated::Dice;

/// Numbers nobody means.
pub const NUMBERS: &[&str] = &[
    "0",
    "-0.0",
    "-1",
    "1e308",
    "-1e308",
    "1e-308",
    "nan",
    ".nan",
    "inf",
    "-inf",
    ".inf",
    "1e999",
    "0x10",
    "1_000",
    "9223372036854775807",
    "9223372036854775808",
    "-9223372036854775809",
    "4294967296",
    "65536",
    "1e5",
    "999.999",
    "0.0000001",
    "00012",
    "1.",
    ".5",
    "+3",
    "٣",
    "1e",
    "--1",
];

/// What a text is broken by.
const PIECES: &[&str] = &[
    "\0",
    "\u{feff}",
    "\r\n",
    "\r",
    "\u{1b}[2J",
    "\u{2028}",
    "é",
    "🤖",
    "[[",
    "]]",
    "[",
    "]",
    "{",
    "}",
    "\"",
    "'",
    "\"\"\"",
    "#",
    ":",
    ",",
    "=",
    "&a [*a,*a]",
    "*a",
    "- ",
    "---\n",
    "%YAML 9\n",
    "\\u0000",
    "true",
    "null",
    "\t",
    "\n\n",
    "1979-05-27",
];

/// The text with one in `one_in` of its numbers exchanged.
pub fn numbers(text: &str, one_in: usize, dice: &mut Dice) -> String {
    let mut changed = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find(|character: char| character.is_ascii_digit()) {
        let length = rest[at..].find(|c: char| !(c.is_ascii_digit() || ".e-".contains(c))).unwrap_or(rest.len() - at);
        changed += &rest[..at];
        changed += if dice.once_in(one_in) { dice.pick(NUMBERS) } else { &rest[at..at + length] };
        rest = &rest[at + length..];
    }
    changed + rest
}

/// The text with lines lost, doubled and exchanged.
pub fn lines(text: &str, dice: &mut Dice) -> String {
    let mut lines: Vec<&str> = text.lines().collect();
    for _ in 0..1 + dice.below(4) {
        if lines.is_empty() {
            break;
        }
        let (at, other) = (dice.below(lines.len()), dice.below(lines.len()));
        match dice.below(3) {
            0 => drop(lines.remove(at)),
            1 => lines.insert(at, lines[other]),
            _ => lines.swap(at, other),
        }
    }
    lines.join(dice.pick(&["\n", "\r\n", "\r"]))
}

/// The bytes with some changed, lost, or cut off.
pub fn bytes(bytes: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..1 + dice.below(5) {
        if bytes.is_empty() {
            break;
        }
        let at = dice.below(bytes.len());
        let end = (at + dice.below(20)).min(bytes.len());
        let piece = dice.pick(PIECES).as_bytes().to_vec();
        match dice.below(6) {
            0 => bytes[at] = dice.below(256) as u8,
            1 => drop(bytes.splice(at..at, piece)),
            2 => drop(bytes.splice(at..end, piece)),
            3 => drop(bytes.drain(at..end)),
            4 => bytes.truncate(at),
            _ => {
                let most = if dice.once_in(6) { 30_000 } else { 8 };
                drop(bytes.splice(at..at, piece.repeat(1 + dice.below(most))));
            }
        }
    }
    bytes
}

/// The text, damaged in one way or another.
pub fn text(text: &str, dice: &mut Dice) -> Vec<u8> {
    match dice.below(4) {
        0 => numbers(text, 12, dice).into_bytes(),
        1 => lines(text, dice).into_bytes(),
        2 => bytes(text.as_bytes(), dice),
        _ => bytes(numbers(&lines(text, dice), 12, dice).as_bytes(), dice),
    }
}
