//! Standard output and standard error: colour and a status line on a terminal only.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal, Write};
use std::time::{Duration, Instant};

/// How often the status line is drawn.
const STATUS_EVERY: Duration = Duration::from_millis(100);

/// Where lines go.
enum Sink {
    /// To standard output and standard error.
    Streams,
    /// Nobody sees them.
    Nowhere,
    /// They are kept.
    Kept(Vec<String>),
}

/// Where a command writes.
pub struct Console {
    /// Whether standard error takes colours.
    pub colour: bool,
    /// Whether only results and errors are written.
    pub quiet: bool,
    status: Option<ProgressBar>,
    drawn: Option<Instant>,
    sink: Sink,
    // Locking and buffering once, because a plan may print a million lines.
    out: io::BufWriter<io::Stdout>,
}

impl Console {
    /// The console of this process.
    pub fn new(quiet: bool) -> Self {
        Self {
            colour: takes_colour(&io::stderr()),
            quiet,
            status: None,
            drawn: None,
            sink: Sink::Streams,
            out: io::BufWriter::new(io::stdout()),
        }
    }

    /// A console that shows nothing, for one run among many.
    pub fn silent() -> Self {
        Self { sink: Sink::Nowhere, ..Self::new(true) }
    }

    /// A console that keeps what a run writes, in order.
    pub fn keeping() -> Self {
        Self { sink: Sink::Kept(Vec::new()), ..Self::new(true) }
    }

    /// The lines kept so far.
    pub fn kept(self) -> Vec<String> {
        match self.sink {
            Sink::Kept(lines) => lines,
            Sink::Streams | Sink::Nowhere => Vec::new(),
        }
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

    /// Whether standard output takes colours.
    pub fn out_colour(&self) -> bool {
        takes_colour(&io::stdout())
    }

    /// A line on standard output.
    ///
    /// # Errors
    /// The pipe is closed, or the disk is full.
    pub fn print(&mut self, text: &str) -> io::Result<()> {
        match &mut self.sink {
            Sink::Streams => {}
            Sink::Nowhere => return Ok(()),
            Sink::Kept(lines) => {
                lines.push(text.to_string());
                return Ok(());
            }
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
        match (&mut self.sink, &self.status) {
            (Sink::Nowhere, _) => {}
            (Sink::Kept(lines), _) => lines.push(text.to_string()),
            (Sink::Streams, Some(bar)) => bar.suspend(|| note(text)),
            (Sink::Streams, None) => note(text),
        }
    }
}

/// A line on standard error, before there is a console.
pub fn note(text: &str) {
    writeln!(io::stderr(), "{text}").ok();
}

/// Whether a stream is a terminal and nobody asked for no colours.
pub fn takes_colour(stream: &impl IsTerminal) -> bool {
    let asked_for_none = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    !asked_for_none && stream.is_terminal()
}
