//! The commands that look at a run and change nothing in it.

use super::command::Verb;
use super::{Prompt, listings, present};
use crate::show::event_line::event_line;
use crate::show::map;
use crate::show::why;
use crate::terminal::layout::terminal_size;

/// Events that `:trace` shows.
const LAST_EVENTS: usize = 20;

impl Prompt<'_> {
    pub(super) fn look(&self, verb: Verb, rest: &str) -> Vec<String> {
        let system = &self.session.branch.system;
        let or = |lines: Vec<String>, nothing: &str| if lines.is_empty() { vec![nothing.to_string()] } else { lines };
        match verb {
            Verb::Why => why::why(&present::situation(&self.session), rest).unwrap_or_else(|reason| vec![reason]),
            Verb::Task => match listings::living(system, rest) {
                Some(task) => listings::task(system, task),
                None => vec![why::missing(&present::situation(&self.session), rest)],
            },
            Verb::Tasks => listings::tasks(system),
            Verb::Fluents => or(listings::fluents(system, rest), "no fluent has such a name"),
            Verb::Valves => or(listings::valves(system), "there are no valves"),
            Verb::Map => {
                let (width, height) = terminal_size();
                let drawn = self.map.as_ref().and_then(|map| {
                    map::map(map, &system.outside, width, height.saturating_sub(3), self.console.colour)
                });
                drawn.unwrap_or_else(|| vec!["there is no world; start `rpl --world dept`".to_string()])
            }
            _ => or(self.last_events(rest), "no such event"),
        }
    }

    fn last_events(&self, words: &str) -> Vec<String> {
        let words: Vec<&str> = words.split_whitespace().collect();
        let texts = self.session.branch.log.iter().rev().map(|event| event_line(event, self.console.out_colour()));
        let mut last: Vec<String> =
            texts.filter(|text| words.iter().all(|word| text.contains(word))).take(LAST_EVENTS).collect();
        last.reverse();
        last
    }
}
