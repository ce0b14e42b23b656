//! Who gets a valve next, and what is suspended for it.

use crate::state::machine::Machine;
use crate::state::memory;
use crate::state::priorities::Priorities;
use crate::state::slab::NONE;
use crate::state::valve::{Below, Handover, Link, LinkKind};
use crate::state::valve_line::LinePlace;
use crate::step::native::Surroundings;
use std::collections::BTreeSet;

/// How a task that waits can come to have the valve.
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

/// Who is served next, and what keeps a more important one from it.
#[derive(Clone, Copy, Debug, Default)]
struct NextServed {
    served: Option<(LinePlace, u32, Option<u32>)>,
    blocked: Option<(LinePlace, u32)>,
    /// How many were looked at.
    looks: u64,
}

impl NextServed {
    /// Notes the way of one who waits; tells whether it leads on.
    fn note(&mut self, priorities: &Priorities, place: LinePlace, task: u32, way: Way) -> bool {
        self.looks += 1;
        let is_first = |known: Option<LinePlace>| known.is_none_or(|known| place.is_before(known, priorities));
        match way {
            Way::Open | Way::Through(_) => {
                if is_first(self.served.map(|(place, ..)| place)) {
                    let root = if let Way::Through(root) = way { Some(root) } else { None };
                    self.served = Some((place, task, root));
                }
                true
            }
            Way::Blocked(root) => {
                if is_first(self.blocked.map(|(place, _)| place)) {
                    self.blocked = Some((place, root));
                }
                false
            }
            Way::Closed => false,
        }
    }
}

impl Machine {
    /// How many links and waiters were looked at for valves, in this value's own life: what a test of
    /// growth counts.
    pub fn valve_work(&self) -> u64 {
        self.scratch.valve_looks
    }

    /// Something has changed about a valve.
    pub(crate) fn stir(&mut self, around: &mut Surroundings<'_>, valve: u32) {
        self.scratch.restless.insert(valve);
        self.serve_valves(around);
    }

    /// Lets valves about which something has changed go on to whom they are due, unless something
    /// is just being decided.
    pub(crate) fn serve_valves(&mut self, around: &mut Surroundings<'_>) {
        if self.scratch.is_serving || self.scratch.is_departing {
            return;
        }
        self.scratch.is_serving = true;
        while let Some(valve) = self.scratch.restless.pop_first() {
            self.serve_valve(around, valve);
        }
        self.scratch.boost_changes.clear();
        self.scratch.is_serving = false;
    }

    /// Lets a valve go on until nobody can have it any more.
    fn serve_valve(&mut self, around: &mut Surroundings<'_>, valve: u32) {
        loop {
            let next = self.next_served(valve);
            self.scratch.valve_looks += 1 + next.looks;
            if let Some((_, task, root)) = next.served {
                self.let_in(around, task, valve, root);
            } else if self.valves[valve as usize].top_mark().is_some() && self.valves[valve as usize].handover.is_none()
            {
                self.give_back(around, valve);
            } else {
                self.set_claim(valve, next.blocked);
                return;
            }
        }
    }

    /// Who is served next, and who would be if no clean-up kept it waiting.
    fn next_served(&self, valve: u32) -> NextServed {
        let entry = &self.valves[valve as usize];
        let mut next = NextServed::default();
        let Some((first, task)) = entry.line.first() else { return next };
        let Some((_, hold)) = entry.top_hold() else {
            let way = self.way(task, first.priority, valve);
            next.note(&self.priorities, first, task, way);
            return next;
        };
        let Some(holder) = self.tasks.find_alive(hold.task) else { return next };
        let lent = entry.lines.get(&hold.line).filter(|_| entry.top_mark().is_none());
        if let Some((place, task)) = lent.and_then(|below| below.line.first()) {
            next.note(&self.priorities, place, task, Way::Open);
        }
        let floor = self.tasks[holder].priority;
        if entry.handover.is_none() && self.priorities.is_higher(first.priority, floor) {
            for below in entry.lines.values() {
                self.look_along(&mut next, valve, below, holder, floor);
            }
        }
        next
    }

    /// Looks for who can pre-empt the holder in one line. Those who are below no task that is above
    /// the holder too all want the same subtree suspended: the first speaks for all. If a clean-up keeps it waiting to
    /// which others belong, the holder runs at its priority, and they have to wait as well.
    fn look_along(&self, next: &mut NextServed, valve: u32, below: &Below, holder: u32, floor: u32) {
        let entry = &self.valves[valve as usize];
        let link = entry.links.binary_search_by_key(&below.link, |link| link.number).ok().map(|at| entry.links[at]);
        let lender = link.filter(Link::is_hold).and_then(|link| self.tasks.find(link.task));
        let is_inside = lender.is_some_and(|lender| self.is_within(holder, lender));
        let most = if is_inside { usize::MAX } else { 1 };
        for (place, task) in below.line.iter().take(most) {
            let is_higher = self.priorities.is_higher(place.priority, floor);
            if !is_higher || next.note(&self.priorities, place, task, self.way(task, place.priority, valve)) {
                return;
            }
        }
    }

    /// How a task with this priority could come to have the valve.
    pub(crate) fn way(&self, task: u32, priority: u32, valve: u32) -> Way {
        let entry = &self.valves[valve as usize];
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
        let root = self.subtree_to_interrupt(task, holder, valve);
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
    fn subtree_to_interrupt(&self, task: u32, holder: u32, valve: u32) -> Option<u32> {
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
            if self.tasks[at].held().contains(&valve) {
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

    /// A task gets the valve, or hooks run first.
    fn let_in(&mut self, around: &mut Surroundings<'_>, task: u32, valve: u32, root: Option<u32>) {
        let Some(root) = root else { return self.grant(around, task, valve) };
        self.trace_valve(root, valve, "pre-empted");
        let hooks = self.hooks_of(root, valve, true);
        self.hold(around, root);
        let reference = self.tasks.reference(root);
        self.valves[valve as usize].push(reference, LinkKind::Mark);
        self.tasks[root].rare().marked.push(valve);
        self.heap.allocated += memory::LINK;
        if !self.start_hooks(around, root, valve, &hooks, Handover::Lend) {
            self.grant(around, task, valve);
        }
    }

    /// The valve comes back to whom it was taken away from last.
    fn give_back(&mut self, around: &mut Surroundings<'_>, valve: u32) {
        let mark = self.valves[valve as usize].top_mark();
        let Some(root) = mark.and_then(|mark| self.tasks.find_alive(mark.task)) else { return };
        let hooks = if self.tasks[root].is_protected() { Vec::new() } else { self.hooks_of(root, valve, false) };
        if !self.start_hooks(around, root, valve, &hooks, Handover::GiveBack) {
            self.lift_mark(around, valve);
        }
    }

    /// The topmost mark goes away, and its root goes on.
    pub(crate) fn lift_mark(&mut self, around: &mut Surroundings<'_>, valve: u32) {
        let Some(mark) = self.valves[valve as usize].top_mark() else { return };
        let Some(root) = self.tasks.find_alive(mark.task) else { return };
        let first = self.valves[valve as usize].lines.get(&mark.line).and_then(|below| below.line.first());
        let at = self.valves[valve as usize].links.len() - 1;
        self.remove_link(valve, at);
        self.trace_valve(root, valve, "returned");
        self.unhold(around, root);
        let holder = self.holder_of(valve);
        let Some((place, task)) = first.filter(|_| !holder.is_some_and(|holder| self.is_within(holder, root))) else {
            return;
        };
        // A clean-up of the interrupted stands for it.
        let mut next = NextServed::default();
        let way = if self.holds_valve(task, valve) { Way::Open } else { self.way(task, place.priority, valve) };
        if next.note(&self.priorities, place, task, way)
            && let Some((_, task, root)) = next.served
        {
            self.let_in(around, task, valve, root);
        }
    }
}
