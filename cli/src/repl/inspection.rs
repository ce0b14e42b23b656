//! The commands that look at a run and change nothing in it.

use super::{Prompt, listings, present};
use crate::commands::project::blocks;
use crate::show::event_line::event_line;
use crate::show::map;
use crate::show::why;
use crate::terminal::layout::terminal_size;
use anyhow::Result;
use rpl_runtime::robot::Grain;

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

/// A projection at the prompt: so many runs, and so far.
const PROJECTED_RUNS: u32 = 60;
const HORIZON_US: u64 = 3_600_000_000;

impl Prompt<'_> {
    pub(super) fn project(&mut self, words: &str) -> Result<()> {
        let (grain, form) = grain_of(words);
        let system = &self.session.branch.system;
        let is_idle = system.is_waiting_for_form();
        let (text, told) = match (form.is_empty(), is_idle) {
            (true, true) => (None, Some("nothing runs; type `:project FORM`")),
            (false, false) => (None, Some("a form is under way; `:project` alone tells how it would go on")),
            (true, false) => (None, None),
            (false, true) => (Some(("projected", form)), None),
        };
        if let Some(told) = told {
            self.console.note(told);
            return Ok(());
        }
        match system.project_form(text, PROJECTED_RUNS, HORIZON_US, grain, system.machine.now_us) {
            Ok(figures) => blocks(&figures).iter().try_for_each(|block| self.console.block(block))?,
            Err(why) => self.console.note(why.trim_end()),
        }
        Ok(())
    }
}

/// The grain that is asked for before a form, and the form.
fn grain_of(words: &str) -> (Grain, &str) {
    let named = Grain::ALL.into_iter().find_map(|grain| {
        let form = words.strip_prefix(':')?.strip_prefix(grain.name())?;
        (form.is_empty() || form.starts_with([' ', '('])).then(|| (grain, form.trim_start()))
    });
    named.unwrap_or((Grain::default(), words))
}

/// The lines, or that there are none.
fn or_else_told(lines: Vec<String>, nothing: &str) -> Vec<String> {
    if lines.is_empty() { vec![nothing.to_string()] } else { lines }
}
