//! The last line of a terminal, which says what a run is at.

use std::io::{self, Write};
use std::time::{Duration, Instant};

/// How often it is drawn.
const EVERY: Duration = Duration::from_millis(100);

/// The spinner before the text, and a space.
const MARGIN: usize = 2;

/// Columns left free, with the spinner's: what the terminal echoes, such as ^C, must not begin a new
/// line, or the status line stays above it.
const FREE: usize = 6 + MARGIN;

/// To the first column.
const START: &str = "\r";

/// Clears the row from here on. A row that is cleared and written in two pieces flickers.
const CLEAR_REST: &str = "\x1b[K";

const SPINNER: [char; 8] = ['⠁', '⠂', '⠄', '⡀', '⢀', '⠠', '⠐', '⠈'];

/// A status line on standard error. What is written beside it stands above: [`StatusLine::below`].
#[derive(Debug, Default)]
pub struct StatusLine {
    text: String,
    turn: usize,
    drawn: Option<Instant>,
}

impl StatusLine {
    /// Whether it wants a new text; drawing it more often costs more than the run.
    pub fn is_due(&self) -> bool {
        self.drawn.is_none_or(|drawn| drawn.elapsed() >= EVERY)
    }

    /// Columns a text may take.
    pub fn room(&self) -> usize {
        let (_, columns) = console::Term::stderr().size();
        usize::from(columns).saturating_sub(FREE)
    }

    /// Draws another text.
    pub fn set(&mut self, text: &str) {
        self.turn += 1;
        let whole = format!("{} {text}", SPINNER[self.turn % SPINNER.len()]);
        self.text = whole.chars().take(self.room() + MARGIN).collect();
        self.drawn = Some(Instant::now());
        self.show();
    }

    fn show(&self) {
        if !self.text.is_empty() {
            write(&format!("{START}{}{CLEAR_REST}", self.text));
        }
    }

    /// What writes lines in its place, and it below them, in one piece.
    pub fn below(&self, lines: &str) -> String {
        format!("{START}{CLEAR_REST}{lines}\n{}", self.text)
    }

    /// Takes it away.
    pub fn hide(&self) {
        if !self.text.is_empty() {
            write(&format!("{START}{CLEAR_REST}"));
        }
    }
}

/// Nobody is left to be told if standard error is closed.
fn write(text: &str) {
    io::stderr().write_all(text.as_bytes()).ok();
}
