//! Valves as data: their places, and the lines of those who wait.

use crate::state::priorities::Priorities;
use crate::state::valve_line::{Turn, ValveLine};
use rpl_lang::symbol::Symbol;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::Range;

/// The first line of those who are below no link.
pub const OPEN_LINE: u64 = 0;

/// A link, named by its place and its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LinkName {
    /// The place.
    pub place: u32,
    /// The number.
    pub number: u64,
}

/// Those who are below a link and below none above it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Below {
    /// The link; none for those who are below none, and can have any place.
    pub link: Option<LinkName>,
    /// They, in line; never empty.
    pub line: ValveLine,
}

/// A task that waits for a valve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Waiter {
    /// Its turn.
    pub turn: Turn,
    /// The line it stands in; none while it is suspended.
    pub line: Option<u64>,
}

/// A valve.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Valve {
    /// Its name.
    pub name: Symbol,
    /// The first of its places, which follow each other.
    pub first_place: u32,
    /// How many places it has.
    pub places: u32,
    /// Who waits for it, by slot, the suspended ones as well.
    pub waiters: BTreeMap<u32, Waiter>,
    /// Those who wait and are not suspended.
    pub line: ValveLine,
    /// The same, by the link they are below.
    pub lines: BTreeMap<u64, Below>,
    /// The line of those who are below no link.
    pub open_line: u64,
    /// Links there have been.
    pub last_link: u64,
    /// Requests that had to wait.
    pub asked: u64,
}

impl Valve {
    /// A valve nobody waits for.
    pub fn new(name: Symbol, first_place: u32, places: u32) -> Self {
        Self {
            name,
            first_place,
            places,
            waiters: BTreeMap::new(),
            line: ValveLine::default(),
            lines: BTreeMap::new(),
            open_line: OPEN_LINE,
            last_link: OPEN_LINE,
            asked: 0,
        }
    }

    /// Its places.
    pub fn places(&self) -> Range<u32> {
        self.first_place..self.first_place + self.places
    }

    /// Slots of those who wait for it, in the order in which they are served; the suspended ones last.
    pub fn in_line(&self) -> Vec<u32> {
        let mut suspended: Vec<(u64, u32)> = self
            .waiters
            .iter()
            .filter(|(_, waiter)| waiter.line.is_none())
            .map(|(&task, waiter)| (waiter.turn.asked, task))
            .collect();
        suspended.sort_unstable();
        let waiting = self.line.iter().map(|(_, task)| task);
        waiting.chain(suspended.into_iter().map(|(_, task)| task)).collect()
    }

    /// The line of those who are below no link.
    pub(crate) fn open(&self) -> Option<&Below> {
        self.lines.get(&self.open_line)
    }

    /// One who waits takes its turn in the line of a link.
    pub(crate) fn enter(&mut self, priorities: &Priorities, task: u32, line: u64, link: Option<LinkName>) {
        let Some(waiter) = self.waiters.get_mut(&task) else { return };
        waiter.line = Some(line);
        self.line.enter(priorities, waiter.turn, task);
        let below = self.lines.entry(line).or_insert_with(|| Below { link, line: ValveLine::default() });
        below.line.enter(priorities, waiter.turn, task);
    }

    /// One who waits keeps its turn and is passed over.
    pub(crate) fn leave(&mut self, priorities: &Priorities, task: u32) {
        let Some(waiter) = self.waiters.get_mut(&task) else { return };
        let Some(number) = waiter.line.take() else { return };
        self.line.leave(priorities, waiter.turn);
        if let Some(below) = self.lines.get_mut(&number) {
            below.line.leave(priorities, waiter.turn);
            if below.line.is_empty() {
                self.lines.remove(&number);
            }
        }
    }

    /// All in one line stand in that of another link from now on; the shorter line is moved. Gives the line
    /// that is left.
    pub(crate) fn join_lines(&mut self, priorities: &Priorities, gone: u64, known: u64, link: Option<LinkName>) -> u64 {
        let Some(mut longer) = self.lines.remove(&gone) else { return known };
        let shorter = self.lines.remove(&known).unwrap_or_default();
        let (mut number, mut shorter) = (gone, shorter.line);
        if shorter.len() > longer.line.len() {
            number = known;
            std::mem::swap(&mut shorter, &mut longer.line);
        }
        for (turn, task) in shorter.iter() {
            longer.line.enter(priorities, turn, task);
            if let Some(waiter) = self.waiters.get_mut(&task) {
                waiter.line = Some(number);
            }
        }
        longer.link = link;
        self.lines.insert(number, longer);
        number
    }
}
