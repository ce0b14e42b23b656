//! The places of a valve that has several: which are free, and whom they were taken away from.

use crate::state::machine::Machine;
use crate::state::valve_place::{Handover, Link};

/// An owner that was interrupted and can have any place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interrupted {
    /// The place that was taken away from it.
    pub(super) place: u32,
    /// Where its mark is.
    pub(super) mark: usize,
    /// What it had the place at.
    pub(super) priority: u32,
    number: u64,
}

impl Machine {
    /// The free place that is given next: rather one that was taken away from nobody.
    pub(super) fn free_place(&self, valve: u32) -> Option<u32> {
        let free = self.valves[valve as usize].places().filter(|&place| self.is_free(place));
        free.min_by_key(|&place| (!self.places[place as usize].links.is_empty(), place))
    }

    /// Whether a place has no owner that could use it.
    pub(super) fn is_free(&self, place: u32) -> bool {
        let stack = &self.places[place as usize];
        let Some((at, hold)) = stack.top_hold() else { return stack.handover.is_none() };
        let marks = &stack.links[at + 1..];
        if stack.handover.is_some() || marks.is_empty() {
            return false;
        }
        let owner = self.tasks.find_alive(hold.task).and_then(|holder| self.owner_above(holder, place));
        let mut roots = marks.iter().filter_map(|mark| self.tasks.find_alive(mark.task));
        owner.is_some_and(|owner| roots.any(|root| self.is_within(owner, root)))
    }

    /// Whether a task above this one holds a place, and lends it.
    pub(crate) fn is_lent_to(&self, task: u32, place: u32) -> bool {
        let parent = self.tasks[task].parent;
        self.tasks.get(parent).is_some() && self.owner_above(parent, place).is_some()
    }

    /// How many places go to others as soon as hooks have ended.
    pub(super) fn places_about_to_be_lent(&self, valve: u32) -> usize {
        let is_about_to_be = |&place: &u32| {
            let stack = &self.places[place as usize];
            let mark = stack.links.iter().rev().find(|link| link.is_mark());
            let root = mark.and_then(|mark| self.tasks.find_alive(mark.task));
            stack.handover == Some(Handover::Lend) && root.is_some_and(|root| !self.is_lent_to(root, place))
        };
        self.valves[valve as usize].places().filter(is_about_to_be).count()
    }

    /// The owners that were interrupted and can have any place: from each place the one it was taken from last.
    pub(super) fn interrupted(&self, valve: u32) -> impl Iterator<Item = Interrupted> {
        self.valves[valve as usize].places().filter_map(|place| self.interrupted_at(place))
    }

    fn interrupted_at(&self, place: u32) -> Option<Interrupted> {
        let links = &self.places[place as usize].links;
        let is_free = self.is_free(place);
        let holder = self.holder_of(place);
        let is_interrupted_owner = |link: &Link| {
            let root = self.tasks.find_alive(link.task).filter(|_| link.is_mark());
            root.is_some_and(|root| {
                let uses_it = !is_free && holder.is_some_and(|holder| self.is_within(holder, root));
                !uses_it && !self.is_lent_to(root, place)
            })
        };
        let mark = links.iter().rposition(is_interrupted_owner)?;
        let root = self.tasks.find_alive(links[mark].task)?;
        let held = links[..mark].iter().rev().find(|link| link.is_hold());
        let held = held.and_then(|hold| self.tasks.find_alive(hold.task)).filter(|&task| self.is_within(task, root));
        let priority = self.effective_priority(held.unwrap_or(root));
        Some(Interrupted { place, mark, priority, number: links[mark].number })
    }

    /// Who of them goes on first: the most important, among equals the one that was interrupted last.
    pub(crate) fn first_interrupted(&self, valve: u32) -> Option<Interrupted> {
        self.interrupted(valve).max_by(|one, other| {
            self.compare_priorities(one.priority, other.priority).then(one.number.cmp(&other.number))
        })
    }

    /// Whether a task of this priority that could have a place comes before all who were interrupted at others.
    pub(super) fn comes_before_interrupted_elsewhere(&self, priority: u32, place: u32) -> bool {
        if !self.has_more_places(place) || !self.is_free(place) {
            return true;
        }
        let mut elsewhere = self.interrupted(self.valve_of_place(place)).filter(|known| known.place != place);
        elsewhere.all(|known| self.priorities.is_higher(priority, known.priority))
    }
}
