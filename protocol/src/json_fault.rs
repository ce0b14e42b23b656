//! What is wrong with a line of JSON, in words for its author.

use rpl_lang::visible::clause;

/// The text around a fault that is looked at, on each side.
const AROUND_BYTES: usize = 12;

/// Why a line is no message, as one clause. JSON has no numbers that are not finite; many programs write them all the
/// same, and then they are named.
pub fn unreadable(line: &str, error: &serde_json::Error) -> String {
    let at = error.column();
    let from = line.floor_char_boundary(at.saturating_sub(AROUND_BYTES));
    let near = &line[from..line.ceil_char_boundary((at + AROUND_BYTES).min(line.len()))];
    let words = || near.split(|c: char| !c.is_ascii_alphabetic());
    let found = words().find(|word| matches!(*word, "NaN" | "Infinity" | "nan" | "inf"));
    match found.filter(|_| error.is_syntax()) {
        Some(word) => clause(&format!(
            "`{word}`, at column {at}, is no number of JSON; a reading without an echo is the range of its sensor"
        )),
        None => clause(&error.to_string().replace(" at line 1 column ", ", at column ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_are_not_finite_are_named() {
        let told = |line: &str| {
            let error = serde_json::from_str::<Vec<f64>>(line).expect_err("it is wrong");
            unreadable(line, &error)
        };
        for (line, word) in [("[1.0, NaN, 2.0]", "`NaN`"), ("[-Infinity]", "`Infinity`"), ("[2.5,nan]", "`nan`")] {
            let told = told(line);
            assert!(told.contains(word) && told.contains("the range of its sensor"), "{told}");
        }
        for line in ["[1.0, x]", "[\"NaN\"]", "[1.0", "["] {
            assert!(!told(line).contains("the range of its sensor"), "{}", told(line));
        }
    }
}
