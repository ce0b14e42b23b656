//! The commands that look at a run and change nothing in it.

use super::{Prompt, listings, present};
use rpl_drive::show::event_line::event_line;
use rpl_drive::show::{map, why};
use rpl_shell::terminal::layout::terminal_size;

/// Events that `:trace` shows.
const LAST_EVENTS: usize = 20;

impl Prompt<'_> {
    pub(super) fn why(&self, path: &str) -> Vec<String> {
        why::why(&present::situation(&self.session), path).unwrap_or_else(|reason| vec![reason])
    }

    pub(super) fn tasks(&self) -> Vec<String> {
        listings::tasks(&self.session.branch.system)
    }

    pub(super) fn task(&self, path: &str) -> Vec<String> {
        let system = &self.session.branch.system;
        match listings::living(system, path) {
            Some(task) => listings::task(system, task),
            None => vec![why::missing(&present::situation(&self.session), path)],
        }
    }

    pub(super) fn fluents(&self, word: &str) -> Vec<String> {
        or_else_told(listings::fluents(&self.session.branch.system, word), "no fluent has such a name")
    }

    pub(super) fn valves(&self) -> Vec<String> {
        or_else_told(listings::valves(&self.session.branch.system), "there are no valves")
    }

    pub(super) fn drawn_map(&self) -> Vec<String> {
        let (width, height) = terminal_size();
        let drawn = self.map.as_ref().and_then(|map| {
            let outside = &self.session.branch.system.outside;
            map::map(map, outside, width, height.saturating_sub(3), self.console.colour)
        });
        drawn.unwrap_or_else(|| vec!["there is no world; start `rpl --world dept`".to_string()])
    }

    pub(super) fn last_events(&self, words: &str) -> Vec<String> {
        let words: Vec<&str> = words.split_whitespace().collect();
        let texts = self.session.branch.log.iter().rev().map(|event| event_line(event, self.console.out_colour()));
        let mut last: Vec<String> =
            texts.filter(|text| words.iter().all(|word| text.contains(word))).take(LAST_EVENTS).collect();
        last.reverse();
        or_else_told(last, "no such event")
    }
}

/// The lines, or that there are none.
fn or_else_told(lines: Vec<String>, nothing: &str) -> Vec<String> {
    if lines.is_empty() { vec![nothing.to_string()] } else { lines }
}
