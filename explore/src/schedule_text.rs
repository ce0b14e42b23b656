//! A schedule as a text: a first line that says what it is, and a line for each deviation.

use rpl_runtime::state::schedule::Deviation;
use std::fmt::Write;

/// The first line.
const HEADER: &str = "rpl-schedule 1";

/// Writes deviations down.
pub fn write(deviations: &[Deviation]) -> String {
    let mut text = format!("{HEADER}\n");
    for deviation in deviations {
        // Writing into a string cannot fail.
        writeln!(text, "turn {} takes {}", deviation.turn, deviation.taken).ok();
    }
    text
}

/// Reads them.
///
/// # Errors
/// The line that is wrong, and what it looks like.
pub fn read(text: &str) -> Result<Vec<Deviation>, String> {
    let mut lines = text.lines().enumerate();
    match lines.next() {
        Some((_, HEADER)) => {}
        _ => {
            return Err(format!("it is no schedule: the first line of one is `{HEADER}`, and `rpl explore` writes it"));
        }
    }
    let mut deviations: Vec<Deviation> = Vec::new();
    for (number, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
        let found = deviation(line).filter(|found| deviations.last().is_none_or(|last| last.turn < found.turn));
        let Some(found) = found else {
            let place = number + 1;
            return Err(format!("line {place} is not of the form `turn 7 takes 1`, with a later turn in each line"));
        };
        deviations.push(found);
    }
    Ok(deviations)
}

fn deviation(line: &str) -> Option<Deviation> {
    let mut words = line.split_whitespace();
    let ("turn", turn, "takes", taken, None) =
        (words.next()?, words.next()?, words.next()?, words.next()?, words.next())
    else {
        return None;
    };
    Some(Deviation { turn: turn.parse().ok()?, taken: taken.parse().ok().filter(|&taken| taken > 0)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let deviations = [Deviation { turn: 0, taken: 1 }, Deviation { turn: 7, taken: 3 }];
        assert_eq!(read(&write(&deviations)), Ok(deviations.to_vec()));
        assert_eq!(read(&write(&[])), Ok(Vec::new()));
    }

    #[test]
    fn a_line_that_is_wrong_is_named() {
        assert!(read("turn 1 takes 1").is_err_and(|why| why.contains("rpl-schedule 1")));
        for line in ["turn 1 takes 0", "turn one takes 1", "turn 3 takes 1 2", "turn 2 takes 1\nturn 2 takes 1"] {
            assert!(read(&format!("{HEADER}\n{line}\n")).is_err_and(|why| why.starts_with("line ")), "{line}");
        }
    }
}
