//! A place of a valve as data: a stack of links.

use crate::state::value::TaskRef;
use serde::{Deserialize, Serialize};

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
    /// The task has taken the place.
    Hold {
        /// How often.
        count: u32,
        /// What for.
        purpose: HoldPurpose,
    },
    /// The place was taken away here, and the task and all below it are suspended.
    Mark,
}

/// An entry of the stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Link {
    /// Names it in its valve; those above it have higher numbers.
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

/// A place of a valve: what one task has at a time.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Place {
    /// The valve.
    pub valve: u32,
    /// Holds and marks, the topmost last.
    pub links: Vec<Link>,
    /// When its owner got it, as a number of the valve's links; counted where there are more places.
    pub since: u64,
    /// Hooks under way.
    pub handover: Option<Handover>,
    /// What keeps the first in line from pre-empting.
    pub claim: Option<Claim>,
}

impl Place {
    /// A place that nobody holds.
    pub fn new(valve: u32) -> Self {
        Self { valve, links: Vec::new(), since: 0, handover: None, claim: None }
    }

    /// Tasks that hold it, the present holder last. Hooks do so only for the time of a handover.
    pub fn holders(&self) -> impl DoubleEndedIterator<Item = TaskRef> {
        self.links.iter().filter(|link| link.is_hold() && !link.serves(HoldPurpose::Hooks)).map(|link| link.task)
    }

    /// Roots of the subtrees it was taken away from, and that are suspended for it.
    pub fn interrupted(&self) -> impl Iterator<Item = TaskRef> {
        self.links.iter().filter(|link| link.is_mark()).map(|link| link.task)
    }

    /// Whether a task has taken it and not given it back.
    pub(crate) fn is_taken_by(&self, task: TaskRef) -> bool {
        self.links.iter().any(|link| link.task == task && link.serves(HoldPurpose::Plan))
    }

    /// Whether nobody has anything to do with it.
    pub fn is_at_rest(&self) -> bool {
        self.links.is_empty() && self.handover.is_none() && self.claim.is_none()
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

    /// Where the link with a number is.
    pub(crate) fn position(&self, number: u64) -> Option<usize> {
        self.links.binary_search_by_key(&number, |known| known.number).ok()
    }
}
