//! How a task that waits can come to have a place of a valve.

use crate::state::machine::Machine;
use crate::state::slab::NONE;
use std::cmp::Ordering;
use std::collections::BTreeSet;

/// How a task that waits can come to have a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Way {
    /// Nothing more is to be suspended.
    Open,
    /// This subtree is to be interrupted.
    Through(u32),
    /// This subtree is to be interrupted, and a clean-up runs in it.
    Blocked(u32),
    /// Its priority is not higher than the holder's.
    Closed,
}

impl Machine {
    pub(super) fn compare_priorities(&self, one: u32, other: u32) -> Ordering {
        match (self.priorities.is_higher(one, other), self.priorities.is_higher(other, one)) {
            (true, _) => Ordering::Greater,
            (_, true) => Ordering::Less,
            (false, false) => Ordering::Equal,
        }
    }

    /// How a task with this priority could come to have a place.
    pub(crate) fn way(&self, task: u32, priority: u32, place: u32) -> Way {
        let entry = &self.places[place as usize];
        if entry.handover.is_some() {
            return Way::Closed;
        }
        let Some((at, hold)) = entry.top_hold() else {
            let interrupted = entry.top_mark().and_then(|mark| self.tasks.find_alive(mark.task));
            let is_first =
                interrupted.is_none_or(|root| self.priorities.is_higher(priority, self.effective_priority(root)));
            return if is_first { Way::Open } else { Way::Closed };
        };
        let Some(holder) = self.tasks.find_alive(hold.task) else { return Way::Closed };
        // Who is kept waiting by a clean-up is so whatever that runs at because of it.
        if !self.priorities.is_higher(priority, self.tasks[holder].priority) {
            return Way::Closed;
        }
        let root = self.subtree_to_interrupt(task, holder, place);
        let mut marks = entry.links[at + 1..].iter().filter_map(|mark| self.tasks.find_alive(mark.task));
        let root = root.filter(|&root| !marks.any(|mark| self.is_within(root, mark)));
        if let Some(cleaning) = root.and_then(|root| self.clean_up_in_the_way(task, root)) {
            return Way::Blocked(cleaning);
        }
        match root {
            _ if !self.priorities.is_higher(priority, self.effective_priority(holder)) => Way::Closed,
            Some(root) => Way::Through(root),
            None => Way::Open,
        }
    }

    /// The subtree whose clean-up a task must wait for before it can interrupt another subtree: that one, or one around
    /// it, if what would be interrupted is a part of its clean-up and the task is none.
    fn clean_up_in_the_way(&self, task: u32, root: u32) -> Option<u32> {
        let mut cleaning = (!self.is_at_rest(root)).then_some(root);
        let mut at = root;
        while at != NONE {
            let record = &self.tasks[at];
            let around = self.tasks.get(record.parent).filter(|around| around.is_within_clean_up(record.parent_scope));
            if around.is_some() && !self.belongs_to_clean_up(task, record.parent) {
                cleaning = Some(record.parent);
            }
            at = record.parent;
        }
        cleaning
    }

    /// Whether a task is one that cleans up, or runs in its clean-up.
    fn belongs_to_clean_up(&self, task: u32, cleaning: u32) -> bool {
        let (mut at, mut scope) = (task, u32::MAX);
        while at != NONE && at != cleaning {
            (at, scope) = (self.tasks[at].parent, self.tasks[at].parent_scope);
        }
        at != NONE && self.tasks[cleaning].is_within_clean_up(scope)
    }

    /// What is suspended when a task pre-empts the holder; none if it is below the holder itself.
    fn subtree_to_interrupt(&self, task: u32, holder: u32, place: u32) -> Option<u32> {
        let mut around = BTreeSet::new();
        let mut at = task;
        while at != NONE {
            around.insert(at);
            at = self.tasks[at].parent;
        }
        let (mut branch, mut owner, mut is_inside) = (None, holder, false);
        let (mut at, mut below) = (holder, NONE);
        while at != NONE {
            if around.contains(&at) && branch.is_none() {
                branch = Some(below);
            }
            if self.tasks[at].held().contains(&place) {
                is_inside |= branch.is_some();
                owner = at;
            }
            (below, at) = (at, self.tasks[at].parent);
        }
        match branch {
            Some(branch) if is_inside => Some(branch).filter(|&branch| branch != NONE),
            _ => Some(owner),
        }
    }
}
