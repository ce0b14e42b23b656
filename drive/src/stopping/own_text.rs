//! Whose text a place lies in: the user's own, the library's, or the prompt's.

use rpl_lang::source::Span;
use rpl_mission::robot::Robot;
use rpl_runtime::run::stepping::Stop;
use rpl_runtime::run::system::System;

/// Texts that nobody has typed.
pub const UNTYPED: &[&str] = &["session", "condition", "watch"];

/// The prompt's own text.
const HIDDEN: &str = "session";

/// Whether a stop counts as a step back.
pub fn is_shown(system: &System<Robot>, stop: &Stop) -> bool {
    is_own(system, stop.span)
}

/// Whether a place lies in a text that nobody steps through.
pub fn is_hidden(system: &System<Robot>, span: Span) -> bool {
    *system.program.sources.get(span.source).name == *HIDDEN
}

/// Whether a place lies in what was typed and loaded; the rest is the library.
pub fn is_own(system: &System<Robot>, span: Span) -> bool {
    span.source.0 >= system.program.library_sources && !is_hidden(system, span)
}
