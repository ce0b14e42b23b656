//! Where a run stops: at a plan or function, at a line, at a tag, or when a condition over fluents
//! becomes true.

use super::own_text::UNTYPED;
use crate::show::why::shortened;
use rpl_lang::source::{self, Source, SourceId, Span};
use rpl_lang::suggest::suggest;
use rpl_mission::robot::Robot;
use rpl_runtime::run::session::Condition;
use rpl_runtime::run::stepping::Stop;
use rpl_runtime::run::system::System;
use std::fmt;

/// What `:break` takes for all failures, and `:back` for the place of the last one.
pub const FAILURE: &str = "failure";

/// A place or condition.
#[derive(Clone, Debug, PartialEq)]
pub enum Breakpoint {
    /// The entry of a plan or function, or the beginning of a tagged task.
    Name(String),
    /// A line of a text; of the loaded file without a name.
    Line(Option<String>, usize),
    /// A failure that is about to end a form.
    Failure,
    /// A condition.
    Condition {
        /// As it was typed.
        text: String,
        /// What is to become true.
        condition: Condition,
        /// Whether it held last.
        held: bool,
    },
}

impl Breakpoint {
    /// What a user has typed: `deliver`, `12`, `delivery.rpl:12`, `(> x* 3)`; a line alone is one of
    /// `file`.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(text: &str, file: Option<&str>, system: &mut System<Robot>, colour: bool) -> Result<Self, String> {
        if text.starts_with('(') {
            let condition = system
                .condition(text)
                .map_err(|rejected| format!("`{text}` is no condition\n{}", rejected.render(colour)))?;
            let held = system.holds(condition).unwrap_or(false);
            return Ok(Self::Condition { text: text.to_string(), condition, held });
        }
        if text == FAILURE {
            return Ok(Self::Failure);
        }
        if let Ok(line) = text.parse() {
            return at_line(system, None, line, file);
        }
        if let Some((named, line)) = text.rsplit_once(':')
            && let Ok(line) = line.parse()
        {
            return at_line(system, Some(named), line, file);
        }
        let name = text.to_lowercase();
        let known = known_names(system);
        if known.contains(&name) {
            return Ok(Self::Name(name));
        }
        let meant = suggest(&name, known.iter().map(String::as_str));
        Err(match meant {
            Some(meant) => {
                format!("no plan, function or tag is called `{}`; did you mean `{meant}`?", shortened(&name))
            }
            None => format!(
                "no plan, function or tag is called `{}`; a line is a number, a condition stands in ( )",
                shortened(&name)
            ),
        })
    }

    /// Compiles its condition into another program.
    pub fn restore(&mut self, system: &mut System<Robot>) {
        if let Self::Condition { text, condition, held } = self
            && let Ok(compiled) = system.condition(text)
        {
            *condition = compiled;
            *held = system.holds(compiled).unwrap_or(false);
        }
    }

    /// The condition, if it is one.
    pub fn condition(&self) -> Option<Condition> {
        match self {
            Self::Condition { condition, .. } => Some(*condition),
            Self::Name(_) | Self::Line(..) | Self::Failure => None,
        }
    }

    /// Notes whether the condition holds; tells whether it has become true.
    pub(crate) fn becomes(&mut self, holds: bool) -> bool {
        match self {
            Self::Condition { held, .. } => !std::mem::replace(held, holds) && holds,
            Self::Name(_) | Self::Line(..) | Self::Failure => false,
        }
    }

    /// Whether a task that stands before a form stands at this place.
    pub fn is_at(&self, system: &System<Robot>, stop: &Stop, file: Option<&str>) -> bool {
        match self {
            Self::Name(name) => {
                let tag = system.machine.tasks.find_alive(stop.task).map(|task| system.machine.tasks[task].name);
                let is_named = |symbol| system.machine.symbols.name(symbol) == name;
                stop.is_entry && (is_named(stop.name) || stop.depth == 0 && tag.is_some_and(is_named))
            }
            Self::Line(text, line) => {
                let source = system.program.sources.get(stop.span.source);
                let is_text = text.as_deref().or(file).is_none_or(|name| *source.name == *name);
                is_text && system.program.sources.line_column(first(stop.span)).0 == *line
            }
            Self::Condition { .. } | Self::Failure => false,
        }
    }

    /// Whether it is a place in a text, for which the run must be looked at form by form.
    pub(crate) fn is_place(&self) -> bool {
        matches!(self, Self::Name(_) | Self::Line(..))
    }
}

/// A line of a text, if the text is there and has it.
fn at_line(system: &System<Robot>, named: Option<&str>, line: usize, file: Option<&str>) -> Result<Breakpoint, String> {
    let sources = &system.program.sources;
    let own = (system.program.library_sources..sources.len() as u32).map(|number| sources.get(SourceId(number)));
    let texts: Vec<&Source> = own.filter(|source| !UNTYPED.contains(&&*source.name)).collect();
    let wanted = named.or(file);
    let lines = texts.iter().filter(|source| wanted.is_none_or(|name| *source.name == *name));
    let lines = lines.map(|source| source::lines(&source.text).count()).max();
    match (lines, wanted) {
        (Some(lines), _) if (1..=lines).contains(&line) => Ok(Breakpoint::Line(named.map(str::to_string), line)),
        (Some(lines), Some(name)) => Err(format!("`{name}` has no line {line}; its last is {lines}")),
        (None, Some(name)) => {
            let meant = suggest(name, texts.iter().map(|source| &*source.name));
            let advice =
                meant.map_or_else(|| "`:load` loads one".to_string(), |meant| format!("did you mean `{meant}`?"));
            Err(format!("no text is called `{name}`; {advice}"))
        }
        (_, None) => Err(format!("no text has a line {line}")),
    }
}

fn first(span: Span) -> Span {
    Span { end: span.start, ..span }
}

/// Names of functions, plans and tags.
pub fn known_names(system: &System<Robot>) -> Vec<String> {
    let program = &system.program;
    let codes = program.codes.iter().flat_map(|code| {
        let children = code.constructs.iter().flat_map(|construct| &construct.children);
        std::iter::once(code.name).chain(children.filter_map(|child| child.name))
    });
    let mut names: Vec<String> = codes.map(|name| system.machine.symbols.name(name).to_string()).collect();
    names.sort();
    names.dedup();
    names.retain(|name| !name.starts_with(['%', '#']));
    names
}

impl fmt::Display for Breakpoint {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Name(name) => write!(out, "{name}"),
            Self::Failure => write!(out, "{FAILURE}"),
            Self::Line(None, line) => write!(out, "line {line}"),
            Self::Line(Some(file), line) => write!(out, "{file}:{line}"),
            Self::Condition { text, .. } => write!(out, "{text}"),
        }
    }
}
