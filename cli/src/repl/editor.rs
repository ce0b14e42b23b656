//! The line editor: several lines by our own lexer, history, completion, hints, colours.

use super::command::COMMANDS;
use super::session::Session;
use super::terminal::LivePrompt;
use crate::reference::Reference;
use anyhow::Result;
use rpl_lang::lexer::{Token, lex};
use rpl_lang::reader::{Completeness, completeness};
use rpl_lang::source::SourceId;
use rustyline::completion::Completer;
use rustyline::error::ReadlineError;
use rustyline::highlight::{CmdKind, Highlighter};
use rustyline::hint::Hinter;
use rustyline::history::FileHistory;
use rustyline::validate::{ValidationContext, ValidationResult, Validator};
use rustyline::{Config, Context, ExternalPrinter, Helper};
use std::borrow::Cow;
use std::cell::Cell;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Lines of history that are kept.
const HISTORY: usize = 2000;

/// What was typed.
pub enum Line {
    /// A command, or complete forms.
    Text(String),
    /// Ctrl-C: the line is given up.
    Cancelled {
        /// There was nothing to give up.
        was_empty: bool,
    },
    /// Ctrl-D on an empty line.
    End,
}

/// The editor.
pub struct Editor {
    inner: rustyline::Editor<Assistant, FileHistory>,
    history: Option<PathBuf>,
}

impl Editor {
    /// An editor with the history of earlier sessions.
    ///
    /// # Errors
    /// The terminal cannot be used.
    pub fn new(colour: bool, live: LivePrompt) -> Result<Self> {
        let config = Config::builder().max_history_size(HISTORY)?.auto_add_history(true).build();
        let mut inner = rustyline::Editor::with_config(config)?;
        let library: BTreeMap<String, String> =
            Reference::new()?.signatures().map(|(name, signature)| (name.to_string(), signature.to_string())).collect();
        inner.set_helper(Some(Assistant { names: library.clone(), library, colour, live, is_empty: Cell::new(true) }));
        let history = history_file();
        if let Some(file) = &history {
            // The first session has none.
            inner.load_history(file).ok();
        }
        Ok(Self { inner, history })
    }

    /// What writes above the line that is being typed.
    ///
    /// # Errors
    /// The terminal cannot be used.
    pub fn printer(&mut self) -> Result<Box<dyn ExternalPrinter + Send>> {
        Ok(Box::new(self.inner.create_external_printer()?))
    }

    /// Takes over the names that can be typed now beside those of the library.
    pub fn learn(&mut self, names: BTreeMap<String, String>) {
        if let Some(assistant) = self.inner.helper_mut() {
            assistant.names = assistant.library.clone();
            assistant.names.extend(names);
        }
    }

    /// The next text.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn line(&mut self, prompt: &str) -> Result<Line> {
        match self.inner.readline(prompt) {
            Ok(text) => {
                if let Some(file) = &self.history {
                    // A history that cannot be kept is no reason to stop.
                    self.inner.save_history(file).ok();
                }
                Ok(Line::Text(text))
            }
            Err(ReadlineError::Interrupted) => {
                Ok(Line::Cancelled { was_empty: self.inner.helper().is_none_or(|helper| helper.is_empty.get()) })
            }
            Err(ReadlineError::Eof) => Ok(Line::End),
            Err(error) => Err(error.into()),
        }
    }
}

fn history_file() -> Option<PathBuf> {
    let state = std::env::var_os("XDG_STATE_HOME").map(PathBuf::from);
    let folder = state.or_else(|| Some(PathBuf::from(std::env::var_os("HOME")?).join(".local/state")))?.join("rpl");
    std::fs::create_dir_all(&folder).ok()?;
    Some(folder.join("history"))
}

/// Columns and rows of the terminal; what fits everywhere if there is none.
pub fn terminal_size() -> (usize, usize) {
    let (rows, columns) = ::console::Term::stdout().size_checked().unwrap_or((24, 80));
    (usize::from(columns), usize::from(rows))
}

/// Names that the session's own texts define, with how functions are called.
pub fn defined_names(session: &Session) -> BTreeMap<String, String> {
    let system = &session.branch.system;
    let own = system.program.globals.iter().skip(system.program.library_globals as usize);
    let names = own.map(|global| (system.machine.symbols.name(global.name).to_string(), String::new()));
    names.filter(|(name, _)| !name.starts_with(['%', '#'])).collect()
}

struct Assistant {
    library: BTreeMap<String, String>,
    names: BTreeMap<String, String>,
    colour: bool,
    live: LivePrompt,
    /// Nothing is typed: the editor does not tell what it gives up.
    is_empty: Cell<bool>,
}

/// Where the word that ends at a place begins.
fn word_start(line: &str, end: usize) -> usize {
    let is_border = |c: char| c.is_whitespace() || matches!(c, '(' | ')' | '\'' | '`' | ',' | '"');
    line[..end].rfind(is_border).map_or(0, |at| at + line[at..].chars().next().map_or(1, char::len_utf8))
}

impl Completer for Assistant {
    type Candidate = String;

    fn complete(&self, line: &str, end: usize, _: &Context<'_>) -> rustyline::Result<(usize, Vec<String>)> {
        let start = word_start(line, end);
        let word = line[start..end].to_lowercase();
        let commands = COMMANDS.iter().map(|entry| entry.name).filter(|_| line[..start].trim().is_empty());
        let known = commands.map(str::to_string).chain(self.names.keys().cloned());
        Ok((start, known.filter(|name| name.starts_with(&word)).collect()))
    }
}

impl Hinter for Assistant {
    type Hint = String;

    fn hint(&self, line: &str, end: usize, _: &Context<'_>) -> Option<String> {
        self.is_empty.set(line.is_empty());
        if end < line.len() {
            return None;
        }
        // How the function is called whose name has just been typed.
        let called = line.strip_suffix(' ')?;
        let start = word_start(called, called.len());
        let is_call = called[..start].ends_with('(');
        let signature = self.names.get(&called[start..].to_lowercase()).filter(|text| is_call && !text.is_empty())?;
        Some(format!("   {signature}"))
    }
}

impl Highlighter for Assistant {
    fn highlight<'l>(&self, line: &'l str, _: usize) -> Cow<'l, str> {
        if !self.colour {
            return Cow::Borrowed(line);
        }
        let (tokens, _) = lex(line, SourceId(0));
        let mut shown = String::with_capacity(line.len() + 32);
        let mut end = 0;
        for (token, span) in tokens {
            let (from, to) = (span.start as usize, span.end as usize);
            let (Some(before), Some(text)) = (line.get(end..from), line.get(from..to)) else { continue };
            shown.push_str(before);
            match colour_of(token, text, self) {
                Some(code) => shown.push_str(&format!("\x1b[{code}m{text}\x1b[0m")),
                None => shown.push_str(text),
            }
            end = to;
        }
        shown.push_str(line.get(end..).unwrap_or(""));
        Cow::Owned(shown)
    }

    fn highlight_prompt<'b, 's: 'b, 'p: 'b>(&'s self, prompt: &'p str, _: bool) -> Cow<'b, str> {
        Cow::Owned(self.live.text(prompt))
    }

    fn highlight_hint<'h>(&self, hint: &'h str) -> Cow<'h, str> {
        if self.colour { Cow::Owned(format!("\x1b[2m{hint}\x1b[0m")) } else { Cow::Borrowed(hint) }
    }

    fn highlight_char(&self, _: &str, _: usize, _: CmdKind) -> bool {
        self.colour
    }
}

fn colour_of(token: Token, text: &str, assistant: &Assistant) -> Option<&'static str> {
    match token {
        Token::Str => Some("32"),
        Token::Int(_) | Token::Float(_) => Some("33"),
        Token::Keyword => Some("35"),
        Token::LineComment | Token::BlockComment | Token::DatumComment => Some("2"),
        Token::Error | Token::Unterminated => Some("31"),
        Token::Symbol if assistant.names.contains_key(&text.to_lowercase()) => Some("36"),
        Token::Symbol | Token::Open | Token::Close | Token::Dot | Token::Prefix(_) => None,
    }
}

impl Validator for Assistant {
    fn validate(&self, context: &mut ValidationContext<'_>) -> rustyline::Result<ValidationResult> {
        let text = context.input();
        let is_command = text.trim_start().starts_with(':');
        Ok(match is_command || completeness(text) == Completeness::Complete {
            true => ValidationResult::Valid(None),
            false => ValidationResult::Incomplete,
        })
    }
}

impl Helper for Assistant {}
