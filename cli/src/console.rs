//! Standard output and standard error: colour and a status line on a terminal only.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal, Write};
use std::time::{Duration, Instant};

/// How often the status line is drawn.
const STATUS_EVERY: Duration = Duration::from_millis(100);

/// Where a command writes.
pub struct Console {
    /// Whether standard error takes colours.
    pub colour: bool,
    /// Whether only results and errors are written.
    pub quiet: bool,
    status: Option<ProgressBar>,
    drawn: Option<Instant>,
    silent: bool,
    // Locking and buffering once, because a plan may print a million lines.
    out: io::BufWriter<io::Stdout>,
}

impl Console {
    /// The console of this process.
    pub fn new(quiet: bool) -> Self {
        Self {
            colour: takes_colour(),
            quiet,
            status: None,
            drawn: None,
            silent: false,
            out: io::BufWriter::new(io::stdout()),
        }
    }

    /// A console that shows nothing, for one run among many.
    pub fn silent() -> Self {
        Self { silent: true, ..Self::new(true) }
    }

    /// Shows a status line from now on, if standard error is a terminal.
    pub fn begin_status(&mut self) {
        if self.quiet || !io::stderr().is_terminal() {
            return;
        }
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
        if let Ok(style) = ProgressStyle::with_template("{spinner} {wide_msg}") {
            bar.set_style(style);
        }
        self.status = Some(bar);
    }

    /// Whether the status line wants a new text; drawing it more often costs more than the run.
    pub fn wants_status(&mut self) -> bool {
        self.status.is_some() && self.drawn.is_none_or(|drawn| drawn.elapsed() >= STATUS_EVERY)
    }

    /// Draws the status line.
    pub fn status(&mut self, text: String) {
        if let Some(bar) = &self.status {
            bar.set_message(text);
            bar.tick();
            self.drawn = Some(Instant::now());
        }
    }

    /// Takes the status line away.
    pub fn end_status(&mut self) {
        if let Some(bar) = self.status.take() {
            bar.finish_and_clear();
        }
    }

    /// A line on standard output.
    ///
    /// # Errors
    /// The pipe is closed, or the disk is full.
    pub fn print(&mut self, text: &str) -> io::Result<()> {
        if self.silent {
            return Ok(());
        }
        let out = &mut self.out;
        match &self.status {
            Some(bar) => bar.suspend(|| writeln!(out, "{text}").and_then(|()| out.flush())),
            None => writeln!(out, "{text}"),
        }
    }

    /// Hands over what has been printed.
    ///
    /// # Errors
    /// The pipe is closed, or the disk is full.
    pub fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }

    /// A line on standard error. Nobody is left to be told if that is closed.
    pub fn note(&mut self, text: &str) {
        match &self.status {
            _ if self.silent => {}
            Some(bar) => bar.suspend(|| note(text)),
            None => note(text),
        }
    }
}

/// A line on standard error, before there is a console.
pub fn note(text: &str) {
    writeln!(io::stderr(), "{text}").ok();
}

/// Whether standard error is a terminal and nobody asked for no colours.
pub fn takes_colour() -> bool {
    let asked_for_none = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    !asked_for_none && io::stderr().is_terminal()
}
