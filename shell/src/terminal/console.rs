//! Standard output and standard error: colour and a status line on a terminal only.
//!
//! Characters that act on a terminal do not pass. Colours of our own do, and so does the output of a plan.

use crate::terminal::page::Block;
use crate::terminal::status_line::StatusLine;
use crate::terminal::{colour, layout};
use ::console::Term;
use rpl_lang::visible::{visible, visible_coloured};
use std::io::{self, IsTerminal, Write};

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
    status: Option<StatusLine>,
    sink: Sink,
    // Locking and buffering once, because a plan may print a million lines.
    out: io::BufWriter<io::Stdout>,
}

impl Console {
    /// The console of this process.
    pub fn new(quiet: bool) -> Self {
        Self {
            colour: colour::is_taken_by(&io::stderr()),
            quiet,
            status: None,
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

    /// Keeps what is written from now on, or writes it again.
    pub fn keep(&mut self, keeps: bool) {
        self.sink = if keeps { Sink::Kept(Vec::new()) } else { Sink::Streams };
    }

    /// Takes the lines kept so far.
    pub fn take_kept(&mut self) -> Vec<String> {
        match &mut self.sink {
            Sink::Kept(lines) => std::mem::take(lines),
            Sink::Streams | Sink::Nowhere => Vec::new(),
        }
    }

    /// Shows a status line from now on, if standard error is a terminal.
    pub fn begin_status(&mut self) {
        if self.quiet || !io::stderr().is_terminal() {
            return;
        }
        self.status = Some(StatusLine::default());
    }

    /// The columns a new text for the status line may take, if it wants one.
    pub fn status_room(&self) -> Option<usize> {
        self.status.as_ref().filter(|status| status.is_due()).map(StatusLine::room)
    }

    /// Draws the status line.
    pub fn status(&mut self, text: &str) {
        if let Some(status) = &mut self.status {
            status.set(&visible(text));
        }
    }

    /// Takes the status line away.
    pub fn end_status(&mut self) {
        if let Some(status) = self.status.take() {
            status.hide();
        }
    }

    /// Whether standard output takes colours.
    pub fn out_colour(&self) -> bool {
        colour::is_taken_by(&io::stdout())
    }

    /// A line on standard output.
    ///
    /// # Errors
    /// The pipe is closed, or the disk is full.
    pub fn print(&mut self, text: &str) -> io::Result<()> {
        match (&mut self.sink, &self.status) {
            (Sink::Nowhere, _) => Ok(()),
            (Sink::Kept(lines), _) => {
                lines.push(text.to_string());
                Ok(())
            }
            (Sink::Streams, Some(status)) if io::stdout().is_terminal() => {
                self.out.write_all(status.below(text).as_bytes())?;
                self.out.flush()
            }
            (Sink::Streams, _) => writeln!(self.out, "{text}"),
        }
    }

    /// A line on standard output that is handed over at once: one of many with a long time between them.
    ///
    /// # Errors
    /// The pipe is closed, or the disk is full.
    pub fn say(&mut self, text: &str) -> io::Result<()> {
        self.print(text)?;
        self.flush()
    }

    /// Lines that explain, on standard output; a terminal gets them laid out for its width.
    ///
    /// # Errors
    /// The pipe is closed, or the disk is full.
    pub fn explain(&mut self, text: &str) -> io::Result<()> {
        self.explain_hanging(text, layout::HANGING)
    }

    /// The same, with what does not fit `hanging` columns further in.
    ///
    /// # Errors
    /// The pipe is closed, or the disk is full.
    pub fn explain_hanging(&mut self, text: &str, hanging: usize) -> io::Result<()> {
        let text = &*visible_coloured(text);
        match columns(&Term::stdout()) {
            Some(width) => self.print(&layout::within(text, width, hanging)),
            None => self.print(text),
        }
    }

    /// A stretch of a page, on standard output; a terminal gets it laid out for its width.
    ///
    /// # Errors
    /// The pipe is closed, or the disk is full.
    pub fn block(&mut self, block: &Block) -> io::Result<()> {
        match block {
            Block::Lines(text) => self.explain(text),
            Block::Table(table) => self.print(&table.text(columns(&Term::stdout()))),
        }
    }

    /// Hands over what has been printed.
    ///
    /// # Errors
    /// The pipe is closed, or the disk is full.
    pub fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }

    /// Lines on standard error; a terminal gets them laid out for its width. Nobody is left to be
    pub fn note(&mut self, text: &str) {
        let text = &*visible_coloured(text);
        let laid_out = columns(&Term::stderr()).map(|width| layout::within(text, width, layout::HANGING));
        let text = laid_out.as_deref().unwrap_or(text);
        match (&mut self.sink, &self.status) {
            (Sink::Nowhere, _) => {}
            (Sink::Kept(lines), _) => lines.push(text.to_string()),
            (Sink::Streams, status) => {
                // What was printed before stands before it; whether it can be written is told there.
                self.out.flush().ok();
                let text = status.as_ref().map_or_else(|| format!("{text}\n"), |status| status.below(text));
                io::stderr().write_all(text.as_bytes()).ok();
            }
        }
    }
}

/// Columns of a terminal; none where there is none.
fn columns(terminal: &Term) -> Option<usize> {
    terminal.size_checked().map(|(_, columns)| usize::from(columns))
}

/// What clap has to say, before there is a console: on standard error what is wrong with the command
/// line, on standard output what was asked for. Clap lays out neither usage nor errors.
///
/// # Errors
/// The pipe is closed, or the disk is full.
pub fn answer(text: &str, is_error: bool) -> io::Result<()> {
    let terminal = if is_error { Term::stderr() } else { Term::stdout() };
    let text = &*visible_coloured(text);
    let laid_out = columns(&terminal).map(|width| layout::within(text, width, layout::HANGING));
    let text = laid_out.as_deref().unwrap_or(text);
    // Both take the colours away where none are wanted.
    match is_error {
        true => write!(anstream::stderr(), "{text}"),
        false => write!(anstream::stdout(), "{text}").and_then(|()| io::stdout().flush()),
    }
}

/// A line on standard error, before there is a console.
pub fn note(text: &str) {
    writeln!(io::stderr(), "{}", visible_coloured(text)).ok();
}
