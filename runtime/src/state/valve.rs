//! Valves as data: the stack of links, and the lines of those who wait.

use crate::state::priorities::Priorities;
use crate::state::value::TaskRef;
use crate::state::valve_line::{LinePlace, ValveLine};
use rpl_lang::symbol::Symbol;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What a hold is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum HoldPurpose {
    /// `with-valve` or `request-valve`.
    Plan,
    /// A behaviour drives with it.
    Activation(u16),
    /// Hooks run while it changes hands.
    Hooks,
}

/// What an entry of the stack is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LinkKind {
    /// The task has taken the valve.
    Hold {
        /// How often.
        count: u32,
        /// What for.
        purpose: HoldPurpose,
    },
    /// The valve was taken away here, and the task and all below it are suspended.
    Mark,
}

/// An entry of the stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Link {
    /// Names it; those above it have higher numbers.
    pub number: u64,
    /// Whose it is.
    pub task: TaskRef,
    /// The line of those for whom it is the topmost link they are below.
    pub line: u64,
    /// What it is.
    pub kind: LinkKind,
}

impl Link {
    pub(crate) fn is_hold(&self) -> bool {
        matches!(self.kind, LinkKind::Hold { .. })
    }

    pub(crate) fn is_mark(&self) -> bool {
        !self.is_hold()
    }

    pub(crate) fn serves(&self, wanted: HoldPurpose) -> bool {
        matches!(self.kind, LinkKind::Hold { purpose, .. } if purpose == wanted)
    }
}

/// No link, and the first line of those who are below none.
pub const NO_LINK: u64 = 0;

/// Those who are below a link and below none above it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Below {
    /// The link, [`NO_LINK`] for none.
    pub link: u64,
    /// They, in line; never empty.
    pub line: ValveLine,
}

/// A task that waits for a valve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Waiter {
    /// Its place in line.
    pub place: LinePlace,
    /// The line it stands in; none while it is suspended.
    pub line: Option<u64>,
}

/// What hooks run for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Handover {
    /// The subtree of the topmost mark is being interrupted.
    Lend,
    /// It is about to go on.
    GiveBack,
}

/// A subtree whose clean-ups or hooks keep somebody waiting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Claim {
    /// Its root.
    pub root: TaskRef,
    /// The priority of who waits.
    pub priority: u32,
}

/// A valve.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Valve {
    /// Its name.
    pub name: Symbol,
    /// Holds and marks, the topmost last.
    pub links: Vec<Link>,
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
    /// Hooks under way.
    pub handover: Option<Handover>,
    /// What keeps the first in line from pre-empting.
    pub claim: Option<Claim>,
}

impl Valve {
    /// A valve nobody holds.
    pub fn new(name: Symbol) -> Self {
        Self {
            name,
            links: Vec::new(),
            waiters: BTreeMap::new(),
            line: ValveLine::default(),
            lines: BTreeMap::new(),
            open_line: NO_LINK,
            last_link: NO_LINK,
            asked: 0,
            handover: None,
            claim: None,
        }
    }

    /// Tasks that hold it, the present holder last. Hooks do so only for the time of a handover.
    pub fn holders(&self) -> impl DoubleEndedIterator<Item = TaskRef> {
        self.links.iter().filter(|link| link.is_hold() && !link.serves(HoldPurpose::Hooks)).map(|link| link.task)
    }

    /// Roots of the subtrees it was taken away from, and that are suspended for it.
    pub fn interrupted(&self) -> impl Iterator<Item = TaskRef> {
        self.links.iter().filter(|link| link.is_mark()).map(|link| link.task)
    }

    /// Slots of those who wait for it, in the order in which they are served; the suspended ones last.
    pub fn in_line(&self) -> Vec<u32> {
        let mut suspended: Vec<(u64, u32)> = self
            .waiters
            .iter()
            .filter(|(_, waiter)| waiter.line.is_none())
            .map(|(&task, waiter)| (waiter.place.asked, task))
            .collect();
        suspended.sort_unstable();
        let waiting = self.line.iter().map(|(_, task)| task);
        waiting.chain(suspended.into_iter().map(|(_, task)| task)).collect()
    }

    /// Whether a task has taken it and not given it back.
    pub(crate) fn is_taken_by(&self, task: TaskRef) -> bool {
        self.links.iter().any(|link| link.task == task && link.serves(HoldPurpose::Plan))
    }

    /// Whether nobody has anything to do with it.
    pub fn is_at_rest(&self) -> bool {
        self.links.is_empty() && self.waiters.is_empty() && self.handover.is_none() && self.claim.is_none()
    }

    /// Its topmost hold and where that is.
    pub(crate) fn top_hold(&self) -> Option<(usize, Link)> {
        let at = self.links.iter().rposition(Link::is_hold)?;
        Some((at, self.links[at]))
    }

    /// The topmost link, if that is a mark.
    pub(crate) fn top_mark(&self) -> Option<Link> {
        self.links.last().copied().filter(Link::is_mark)
    }

    pub(crate) fn push(&mut self, task: TaskRef, kind: LinkKind) -> u64 {
        self.last_link += 1;
        self.links.push(Link { number: self.last_link, task, line: self.last_link, kind });
        self.last_link
    }

    /// The line of a link, or of those who are below none.
    pub(crate) fn line_of(&self, link: u64) -> u64 {
        match self.links.binary_search_by_key(&link, |known| known.number) {
            Ok(at) => self.links[at].line,
            Err(_) => self.open_line,
        }
    }

    /// One who waits takes its place in the line of a link.
    pub(crate) fn enter(&mut self, priorities: &Priorities, task: u32, link: u64) {
        let number = self.line_of(link);
        let Some(waiter) = self.waiters.get_mut(&task) else { return };
        waiter.line = Some(number);
        self.line.enter(priorities, waiter.place, task);
        let below = self.lines.entry(number).or_insert_with(|| Below { link, line: ValveLine::default() });
        below.line.enter(priorities, waiter.place, task);
    }

    /// One who waits keeps its place and is passed over.
    pub(crate) fn leave(&mut self, priorities: &Priorities, task: u32) {
        let Some(waiter) = self.waiters.get_mut(&task) else { return };
        let Some(number) = waiter.line.take() else { return };
        self.line.leave(priorities, waiter.place);
        if let Some(below) = self.lines.get_mut(&number) {
            below.line.leave(priorities, waiter.place);
            if below.line.is_empty() {
                self.lines.remove(&number);
            }
        }
    }

    /// All in one line stand in that of another link from now on; the shorter line is moved.
    pub(crate) fn join_lines(&mut self, priorities: &Priorities, gone: u64, link: u64) {
        let known = self.line_of(link);
        let Some(mut longer) = self.lines.remove(&gone) else { return };
        let shorter = self.lines.remove(&known).unwrap_or_default();
        let (mut number, mut shorter) = (gone, shorter.line);
        if shorter.len() > longer.line.len() {
            number = known;
            std::mem::swap(&mut shorter, &mut longer.line);
        }
        for (place, task) in shorter.iter() {
            longer.line.enter(priorities, place, task);
            if let Some(waiter) = self.waiters.get_mut(&task) {
                waiter.line = Some(number);
            }
        }
        longer.link = link;
        self.lines.insert(number, longer);
        match self.links.binary_search_by_key(&link, |known| known.number) {
            Ok(at) => self.links[at].line = number,
            Err(_) => self.open_line = number,
        }
    }
}
