//! The line editor: several lines by our own lexer, history, completion, hints, colours.

use super::live_prompt::LivePrompt;
use super::margins;
use super::vocabulary::{LibraryWords, Vocabulary, called};
use anyhow::Result;
use rpl_lang::lexer::{Token, lex};
use rpl_lang::reader::{Completeness, completeness};
use rpl_lang::source::SourceId;
use rpl_shell::terminal::layout::terminal_size;
use rustyline::completion::Completer;
use rustyline::error::ReadlineError;
use rustyline::highlight::{CmdKind, Highlighter};
use rustyline::hint::{Hint, Hinter};
use rustyline::history::FileHistory;
use rustyline::validate::{ValidationContext, ValidationResult, Validator};
use rustyline::{
    CharSearch, Cmd, ColorMode, CompletionType, ConditionalEventHandler, Config, Context, Event, EventContext,
    EventHandler, ExternalPrinter, Helper, KeyCode, KeyEvent, Modifiers, Movement, RepeatCount,
};
use std::borrow::Cow;
use std::cell::Cell;
use std::path::PathBuf;

/// Lines of history that are kept.
const HISTORY: usize = 2000;

/// Columns that the prompt may take.
const PROMPT_WIDTH: usize = 24;

/// What stands between a line and its hint.
const MARGIN: &str = "   ";

/// A hint shorter than this says nothing.
const LEAST_HINT: usize = 12;

/// What was typed.
pub enum Typed {
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
pub struct LineEditor {
    inner: rustyline::Editor<Assistant, FileHistory>,
    history: Option<PathBuf>,
}

impl LineEditor {
    /// An editor with the history of earlier sessions.
    ///
    /// # Errors
    /// The terminal cannot be used.
    pub fn new(colour: bool, live: LivePrompt) -> Result<Self> {
        let config = Config::builder()
            .max_history_size(HISTORY)?
            .auto_add_history(true)
            .completion_type(CompletionType::List)
            .completion_show_all_if_ambiguous(true)
            // Marks are shown without colours too.
            .color_mode(ColorMode::Forced)
            .build();
        let mut inner = rustyline::Editor::with_config(config)?;
        inner.bind_sequence(KeyEvent(KeyCode::Enter, Modifiers::NONE), EventHandler::Conditional(Box::new(NextLine)));
        inner.bind_sequence(
            KeyEvent(KeyCode::Backspace, Modifiers::NONE),
            EventHandler::Conditional(Box::new(JoinLines)),
        );
        inner.set_helper(Some(Assistant {
            library: LibraryWords::new()?,
            vocabulary: Vocabulary::default(),
            colour,
            live,
            is_empty: Cell::new(true),
        }));
        let history = history_file();
        if let Some(file) = &history {
            // The first session has none.
            inner.load_history(file).ok();
        }
        Ok(Self { inner, history })
    }

    /// What writes above the line that is being typed; none where output goes elsewhere.
    pub fn printer(&mut self) -> Option<Box<dyn ExternalPrinter + Send>> {
        let printer = self.inner.create_external_printer().ok()?;
        Some(Box::new(printer))
    }

    /// Takes over what can be typed now.
    pub fn learn(&mut self, vocabulary: Vocabulary) {
        if let Some(assistant) = self.inner.helper_mut() {
            assistant.vocabulary = vocabulary;
        }
    }

    /// The next text.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn line(&mut self, prompt: &str) -> Result<Typed> {
        match self.inner.readline(prompt) {
            Ok(text) => {
                if let Some(file) = &self.history {
                    // A history that cannot be kept is no reason to stop.
                    self.inner.save_history(file).ok();
                }
                Ok(Typed::Text(margins::without_margins(&text).into_owned()))
            }
            Err(ReadlineError::Interrupted) => {
                Ok(Typed::Cancelled { was_empty: self.inner.helper().is_none_or(|helper| helper.is_empty.get()) })
            }
            Err(ReadlineError::Eof) => Ok(Typed::End),
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

/// Enter on a text that is not complete begins the next line where it belongs.
struct NextLine;

impl ConditionalEventHandler for NextLine {
    fn handle(&self, _: &Event, _: RepeatCount, _: bool, context: &EventContext<'_>) -> Option<Cmd> {
        margins::continuation(context.line(), context.pos()).map(|text| Cmd::Insert(1, text))
    }
}

/// Backspace before the first word of a line takes the whole indentation away, and the line end.
struct JoinLines;

impl ConditionalEventHandler for JoinLines {
    fn handle(&self, _: &Event, _: RepeatCount, _: bool, context: &EventContext<'_>) -> Option<Cmd> {
        let is_before_word = margins::is_in_indentation(context.line(), context.pos());
        is_before_word.then_some(Cmd::Kill(Movement::ViCharSearch(1, CharSearch::Backward('\n'))))
    }
}

struct Assistant {
    library: LibraryWords,
    vocabulary: Vocabulary,
    colour: bool,
    live: LivePrompt,
    /// Nothing is typed: the editor does not tell what it gives up.
    is_empty: Cell<bool>,
}

impl Completer for Assistant {
    type Candidate = String;

    fn complete(&self, line: &str, end: usize, _: &Context<'_>) -> rustyline::Result<(usize, Vec<String>)> {
        Ok(self.vocabulary.complete(&self.library, &line[..end]))
    }
}

/// What is shown behind a line: nothing of it is to be typed.
struct Signature(String);

impl Hint for Signature {
    fn display(&self) -> &str {
        &self.0
    }

    fn completion(&self) -> Option<&str> {
        None
    }
}

impl Hinter for Assistant {
    type Hint = Signature;

    fn hint(&self, line: &str, end: usize, _: &Context<'_>) -> Option<Signature> {
        self.is_empty.set(line.is_empty());
        if end < line.len() {
            return None;
        }
        let hint = self.vocabulary.hint(&self.library, called(line)?)?;
        // What does not fit beside the line would move it.
        let column = PROMPT_WIDTH + line.lines().last().unwrap_or_default().chars().count() + MARGIN.len();
        let room = terminal_size().0.saturating_sub(column + 1);
        (room >= LEAST_HINT).then(|| Signature(format!("{MARGIN}{}", ::console::truncate_str(hint, room, "…"))))
    }
}

impl Highlighter for Assistant {
    fn highlight<'l>(&self, line: &'l str, _: usize) -> Cow<'l, str> {
        let (tokens, _) = lex(line, SourceId(0));
        let mut shown = String::with_capacity(line.len() + 32);
        let mut end = 0;
        for (token, span) in tokens {
            let (from, to) = (span.start as usize, span.end as usize);
            let (Some(before), Some(text)) = (line.get(end..from), line.get(from..to)) else { continue };
            shown.push_str(&margins::marked(before, self.colour));
            match colour_of(token, text, self).filter(|_| self.colour) {
                Some(code) => shown.push_str(&format!("\x1b[{code}m{text}\x1b[0m")),
                None => shown.push_str(text),
            }
            end = to;
        }
        shown.push_str(&margins::marked(line.get(end..).unwrap_or(""), self.colour));
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
        Token::Symbol if assistant.vocabulary.knows(&assistant.library, text) => Some("36"),
        Token::Symbol | Token::Open | Token::Close | Token::Dot | Token::Prefix(_) => None,
    }
}

impl Validator for Assistant {
    fn validate(&self, context: &mut ValidationContext<'_>) -> rustyline::Result<ValidationResult> {
        let text = context.input();
        Ok(match margins::is_command(text) || completeness(text) == Completeness::Complete {
            true => ValidationResult::Valid(None),
            false => ValidationResult::Incomplete,
        })
    }
}

impl Helper for Assistant {}
