//! Which events of a trace are shown.

use rpl_drive::events::detail;
use rpl_runtime::state::trace::{Event, EventKind};
use rpl_shell::arguments::duration::parse_duration_us;

/// What an event must fulfil; all of it.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Filter {
    /// Show only a task and those below it, by its path or a part of the path
    #[arg(long, value_name = "PATH")]
    pub task: Option<String>,
    /// Show only changes of a fluent, and tasks that wait for it
    #[arg(long, value_name = "NAME")]
    pub fluent: Option<String>,
    /// Show only events from this time on, such as 12.5s
    #[arg(long, value_name = "TIME", value_parser = parse_duration_us)]
    pub from: Option<u64>,
    /// Show only events up to this time
    #[arg(long, value_name = "TIME", value_parser = parse_duration_us)]
    pub to: Option<u64>,
}

impl Filter {
    /// Whether an event is shown.
    pub fn admits(&self, event: &Event) -> bool {
        self.from.is_none_or(|from_us| event.time_us >= from_us)
            && !self.is_over(event)
            && self.task.as_deref().is_none_or(|path| lies_in(&event.path, path))
            && self.fluent.as_deref().is_none_or(|name| concerns(event, name))
    }

    /// Whether an event lies behind the last one that could be shown.
    pub fn is_over(&self, event: &Event) -> bool {
        self.to.is_some_and(|to_us| event.time_us > to_us)
    }
}

/// Whether the names of a part of a path stand in it one after the other.
pub fn lies_in(path: &str, part: &str) -> bool {
    let is_border = |c: Option<char>| c.is_none_or(|c| c == '/');
    path.match_indices(part.trim_matches('/')).any(|(at, found)| {
        is_border(path[..at].chars().next_back()) && is_border(path[at + found.len()..].chars().next())
    })
}

/// Whether an event changes a fluent, or is about a task that waits for it.
pub fn concerns(event: &Event, fluent: &str) -> bool {
    let is_border = |c: char| c.is_whitespace() || matches!(c, '(' | ')');
    match event.kind {
        EventKind::Fluent | EventKind::Pulse => detail(event, "fluent") == fluent,
        EventKind::Blocked => detail(event, "reads").split(is_border).any(|name| name == fluent),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_of_a_path_is_made_of_whole_names() {
        let path = "main/with-policy[1]/fetch/go-to";
        for part in ["main", "fetch", "fetch/go-to", "with-policy[1]/fetch", path, "/fetch/"] {
            assert!(lies_in(path, part), "{part}");
        }
        for part in ["fet", "etch", "main/fetch", "go-to/more", "with-policy"] {
            assert!(!lies_in(path, part), "{part}");
        }
    }
}
