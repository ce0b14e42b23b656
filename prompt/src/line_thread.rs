//! Lines are edited in a thread of their own, so that a run can go on meanwhile and write above the
//! line that is being typed.

use super::line_editor::{LineEditor, Typed};
use super::live_prompt::LivePrompt;
use super::vocabulary::Vocabulary;
use anyhow::{Context, Result, anyhow};
use rustyline::ExternalPrinter;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

/// Goes up a row and down again: the editor draws its line anew after whatever is printed above it,
/// and a line feed is the least.
const NOTHING_ABOVE: &str = "\x1b[A\n";

/// A line is wanted.
struct Wanted {
    prompt: String,
    vocabulary: Vocabulary,
}

/// The terminal, with the thread in which lines are edited.
pub struct LineThread {
    asked: Sender<Wanted>,
    lines: Receiver<Result<Typed>>,
    /// What writes above the line that is being typed; none where output goes elsewhere.
    printer: Option<Box<dyn ExternalPrinter + Send>>,
    live: LivePrompt,
}

impl LineThread {
    /// The terminal of this process.
    ///
    /// # Errors
    /// It cannot be used.
    pub fn open(colour: bool) -> Result<Self> {
        rpl_shell::interrupt::keep_terminal();
        let (asked, wanted) = channel::<Wanted>();
        let (sender, lines) = channel();
        let (opened, printer) = channel();
        let live = LivePrompt::default();
        let shown = live.clone();
        std::thread::spawn(move || {
            let mut editor = match LineEditor::new(colour, shown) {
                Ok(editor) => editor,
                Err(error) => return drop(opened.send(Err(error))),
            };
            // Whoever opens the terminal waits for it.
            opened.send(Ok(editor.printer())).ok();
            for Wanted { prompt, vocabulary } in wanted {
                editor.learn(vocabulary);
                if sender.send(editor.line(&prompt)).is_err() {
                    return;
                }
            }
        });
        let printer = printer.recv().context("the line editor does not start")??;
        Ok(Self { asked, lines, printer, live })
    }

    /// Lets a line be typed after a prompt, with words that can be completed.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn ask(&self, prompt: String, vocabulary: Vocabulary) -> Result<()> {
        self.live.set(&prompt);
        self.asked.send(Wanted { prompt, vocabulary }).map_err(|_| gone())
    }

    /// The line that was asked for.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn line(&self) -> Result<Typed> {
        self.lines.recv().map_err(|_| gone())?
    }

    /// The line that was asked for, if it is typed within a time.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn line_within(&self, wait: Duration) -> Result<Option<Typed>> {
        match self.lines.recv_timeout(wait) {
            Ok(line) => line.map(Some),
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(RecvTimeoutError::Disconnected) => Err(gone()),
        }
    }

    /// Writes lines above the one that is being typed.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn print_above(&mut self, lines: &[String]) -> Result<()> {
        match &mut self.printer {
            Some(printer) if !lines.is_empty() => Ok(printer.print(lines.join("\n") + "\n")?),
            _ => Ok(()),
        }
    }

    /// Shows another prompt, as wide as the one that was asked with.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn show_prompt(&mut self, prompt: &str) -> Result<()> {
        match &mut self.printer {
            Some(printer) if self.live.set(prompt) => Ok(printer.print(NOTHING_ABOVE.to_string())?),
            _ => Ok(()),
        }
    }
}

fn gone() -> anyhow::Error {
    anyhow!("the terminal is gone")
}
