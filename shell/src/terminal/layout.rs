//! Lines laid out for the width of a terminal.

use ::console::{measure_text_width, strip_ansi_codes, truncate_str};

/// How much further in a line goes on that does not fit, where nothing else is said.
pub(crate) const HANGING: usize = 4;

/// Help is never wider, however wide the terminal.
pub const HELP_COLUMNS: usize = 100;

/// A text whose lines fit a width. A longer line goes on below, some columns further in than it begins, and is broken
/// between words, or at a `/` where one word alone is too long. A drawing is cut off. Laid out once more, nothing
/// changes.
pub(crate) fn within(text: &str, width: usize, hanging: usize) -> String {
    let lines: Vec<String> = text.split('\n').map(|line| line_within(line, width, hanging)).collect();
    lines.join("\n")
}

fn line_within(line: &str, width: usize, hanging: usize) -> String {
    if measure_text_width(line) <= width {
        return line.to_string();
    }
    if is_drawing(line) {
        return truncate_str(line, width, "…").into_owned();
    }
    let indent = line.chars().take_while(|&c| c == ' ').count();
    // No further in than the longest word leaves room for.
    let words = line.split_whitespace().map(measure_text_width).filter(|&columns| columns <= width);
    let room = width - words.max().unwrap_or(0);
    let margin = " ".repeat((indent + hanging).min(width / 2).min(room));
    let mut rows = Rows { done: String::new(), row: String::new(), margin, width };
    rows.row.push_str(&line[..indent]);
    line[indent..].split_inclusive(' ').for_each(|word| rows.add(word));
    rows.done + rows.row.trim_end()
}

/// Walls, belief, and the lines that mark a place in a text; not the advice that stands below them.
fn is_drawing(line: &str) -> bool {
    let is_advice = || ["│Help", "│Note"].iter().any(|word| strip_ansi_codes(line).contains(word));
    line.chars().any(|c| ('\u{2500}'..='\u{259f}').contains(&c)) && !is_advice()
}

struct Rows {
    done: String,
    row: String,
    margin: String,
    width: usize,
}

impl Rows {
    fn fits(&self, before: &str, word: &str) -> bool {
        measure_text_width(before) + measure_text_width(word.trim_end()) <= self.width
    }

    fn add(&mut self, word: &str) {
        if self.fits(&self.row, word) {
            self.row.push_str(word);
        } else if self.fits(&self.margin, word) {
            self.begin_row();
            self.row.push_str(word);
        } else {
            word.split_inclusive('/').for_each(|part| self.add_part(part));
        }
    }

    /// A part of a word that is longer than a row.
    fn add_part(&mut self, part: &str) {
        if !self.fits(&self.row, part) && self.fits(&self.margin, part) {
            self.begin_row();
        }
        for c in part.chars() {
            if !self.fits(&self.row, c.encode_utf8(&mut [0; 4])) && self.row != self.margin {
                self.begin_row();
            }
            self.row.push(c);
        }
    }

    fn begin_row(&mut self) {
        self.done.push_str(self.row.trim_end());
        self.done.push('\n');
        self.row.clone_from(&self.margin);
    }
}

/// Columns and rows of the terminal; what fits everywhere if there is none.
pub fn terminal_size() -> (usize, usize) {
    let (rows, columns) = ::console::Term::stdout().size_checked().unwrap_or((24, 80));
    (usize::from(columns), usize::from(rows))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_line_goes_on_further_in_and_never_within_a_word() {
        let line = "  main/greet  waits for (eq region* 'hallway), and the value is held by somebody";
        assert_eq!(
            within(line, 40, HANGING),
            "  main/greet  waits for (eq region*\n      'hallway), and the value is held\n      by somebody"
        );
        assert_eq!(within(line, 80, HANGING), line);
    }

    #[test]
    fn a_word_is_broken_only_if_it_fits_nowhere() {
        let line = "retry         In a clause of `with-failure-handling`: again";
        assert_eq!(within(line, 30, 14), "retry         In a clause of\n      `with-failure-handling`:\n      again");
    }

    #[test]
    fn a_path_that_is_too_long_is_broken_between_its_tasks() {
        let path = "main/with-policy[1]/bring/go-to/navigation  waits";
        assert_eq!(within(path, 24, HANGING), "main/with-policy[1]/\n    bring/go-to/\n    navigation  waits");
        assert_eq!(within(&"x".repeat(30), 12, HANGING), "xxxxxxxxxxxx\n    xxxxxxxx\n    xxxxxxxx\n    xx");
    }

    #[test]
    fn nothing_is_lost_and_nothing_is_wider_at_any_width() {
        let text =
            "error: a word, \u{1b}[31mred\u{1b}[0m and a/very/long/path/through/many/tasks\n  in two lines of it";
        let bare = |text: &str| text.split_whitespace().collect::<String>();
        for width in 6..90 {
            let laid_out = within(text, width, HANGING);
            assert_eq!(bare(&laid_out), bare(text), "at {width}");
            assert!(laid_out.lines().all(|line| measure_text_width(line) <= width), "at {width}:\n{laid_out}");
            assert_eq!(within(&laid_out, width, HANGING), laid_out, "at {width}");
        }
    }

    #[test]
    fn a_drawing_is_cut_and_the_advice_below_it_is_not() {
        assert_eq!(within("   │      ╰──────── unknown name", 20, HANGING), "   │      ╰────────…");
        let advice = "   │Help: did you mean `wait-for`?";
        assert_eq!(within(advice, 24, HANGING), "   │Help: did you mean\n       `wait-for`?");
    }
}
