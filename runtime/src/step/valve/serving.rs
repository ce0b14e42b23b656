//! Who gets a place of a valve next, and what is suspended for it.

use crate::state::machine::Machine;
use crate::state::priorities::Priorities;
use crate::state::valve::Below;
use crate::state::valve_line::Turn;
use crate::state::valve_place::{Handover, Link, LinkKind};
use crate::step::native::Surroundings;
use crate::step::valve::way::Way;
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// A task that gets a place, and what is to be interrupted for it.
#[derive(Clone, Copy, Debug)]
struct Served {
    turn: Turn,
    task: u32,
    place: u32,
    root: Option<u32>,
}

/// Who is served next, and what keeps a more important one from it.
#[derive(Clone, Debug, Default)]
struct NextServed {
    served: Option<Served>,
    /// By place, the first whom a clean-up keeps from it, and the root of that.
    blocked: BTreeMap<u32, (Turn, u32)>,
    /// How many were looked at.
    looks: u64,
}

impl NextServed {
    /// Notes the way of one who waits; tells whether it leads on.
    fn note(&mut self, priorities: &Priorities, turn: Turn, task: u32, place: u32, way: Way) -> bool {
        self.looks += 1;
        let is_first = |known: Option<Turn>| known.is_none_or(|known| turn.is_before(known, priorities));
        match way {
            Way::Open | Way::Through(_) => {
                if is_first(self.served.map(|served| served.turn)) {
                    let root = if let Way::Through(root) = way { Some(root) } else { None };
                    self.served = Some(Served { turn, task, place, root });
                }
                true
            }
            Way::Blocked(root) => {
                if is_first(self.blocked.get(&place).map(|&(turn, _)| turn)) {
                    self.blocked.insert(place, (turn, root));
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

    /// Whether a task that asks for a valve would get it now, whoever else waits.
    pub(crate) fn can_have(&self, task: u32, valve: u32) -> bool {
        let entry = &self.valves[valve as usize];
        let priority = self.effective_priority(task);
        let place = if entry.places == 1 { Some(entry.first_place) } else { self.place_above(task, valve) };
        if let Some(place) = place {
            return matches!(self.way(task, priority, place), Way::Open | Way::Through(_));
        }
        let mut next = NextServed::default();
        self.look_for_place(&mut next, valve, Turn { priority, asked: entry.asked }, task);
        next.served.is_some()
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
            if let Some(Served { task, place, root, .. }) = next.served {
                self.let_in(around, task, place, root);
            } else if let Some(place) = self.next_given_back(valve) {
                self.give_back(around, place);
            } else {
                for place in self.valves[valve as usize].places() {
                    self.set_claim(place, next.blocked.get(&place).copied());
                }
                return;
            }
        }
    }

    /// Who is served next, and who would be if no clean-up kept it waiting.
    fn next_served(&self, valve: u32) -> NextServed {
        let entry = &self.valves[valve as usize];
        let mut next = NextServed::default();
        let Some((first, _)) = entry.line.first() else { return next };
        next.looks += u64::from(entry.places - 1);
        let mut is_within_reach = false;
        for place in entry.places() {
            let stack = &self.places[place as usize];
            let Some((_, hold)) = stack.top_hold() else {
                is_within_reach = true;
                continue;
            };
            let Some(holder) = self.tasks.find_alive(hold.task) else { continue };
            let lent = entry.lines.get(&hold.line).filter(|_| stack.top_mark().is_none());
            if let Some((turn, task)) = lent.and_then(|below| below.line.first()) {
                next.note(&self.priorities, turn, task, place, Way::Open);
            }
            let is_higher = self.priorities.is_higher(first.priority, self.tasks[holder].priority);
            is_within_reach |= stack.handover.is_none() && is_higher;
        }
        if is_within_reach {
            entry.lines.values().for_each(|below| self.look_along(&mut next, valve, below));
        }
        next
    }

    /// Looks for who can pre-empt the holder in one line. Those who are below no task that is above
    /// the holder too all want the same subtree suspended: the first speaks for all. If a clean-up keeps it waiting to
    /// which others belong, the holder runs at its priority, and they have to wait as well.
    fn look_along(&self, next: &mut NextServed, valve: u32, below: &Below) {
        let entry = &self.valves[valve as usize];
        let place = match below.link {
            Some(link) => link.place,
            None if entry.places > 1 => return self.look_along_open_line(next, valve, below),
            None => entry.first_place,
        };
        let stack = &self.places[place as usize];
        let holder = self.holder_of(place);
        let link = below.link.and_then(|link| stack.position(link.number)).map(|at| stack.links[at]);
        let lender = link.filter(Link::is_hold).and_then(|link| self.tasks.find(link.task));
        let is_inside = holder.zip(lender).is_some_and(|(holder, lender)| self.is_within(holder, lender));
        let most = if is_inside { usize::MAX } else { 1 };
        for (turn, task) in below.line.iter().take(most) {
            let way = self.way(task, turn.priority, place);
            let is_closed = holder
                .is_some_and(|holder| !self.priorities.is_higher(turn.priority, self.tasks[holder].priority))
                || way == Way::Open && !self.comes_before_interrupted_elsewhere(turn.priority, place);
            if is_closed || next.note(&self.priorities, turn, task, place, way) {
                return;
            }
        }
    }

    /// Looks at those who belong to no place and can have any. A place about to be lent is for the first of them,
    /// who take no other beside it.
    fn look_along_open_line(&self, next: &mut NextServed, valve: u32, below: &Below) {
        let has_free = self.free_place(valve).is_some();
        let lent = if has_free { 0 } else { self.places_about_to_be_lent(valve) };
        if let Some((turn, task)) = below.line.iter().nth(lent) {
            self.look_for_place(next, valve, turn, task);
        }
    }

    /// Looks for the place that a task could have which belongs to none: a free one, unless an interrupted task comes
    /// before it, or else that of the least important holder that can be interrupted.
    fn look_for_place(&self, next: &mut NextServed, valve: u32, turn: Turn, task: u32) {
        if let Some(free) = self.free_place(valve) {
            let is_first =
                self.interrupted(valve).all(|known| self.priorities.is_higher(turn.priority, known.priority));
            next.note(&self.priorities, turn, task, free, if is_first { Way::Open } else { Way::Closed });
            return;
        }
        let places = self.places_held_below(turn.priority, valve);
        places
            .into_iter()
            .find(|&place| next.note(&self.priorities, turn, task, place, self.way(task, turn.priority, place)));
    }

    /// Places whose holders have lower priorities than this: the lowest first, among equals that which has had its
    /// owner for the shortest time.
    fn places_held_below(&self, priority: u32, valve: u32) -> Vec<u32> {
        let mut held: Vec<(u32, u32)> = self.valves[valve as usize]
            .places()
            .filter(|&place| self.places[place as usize].handover.is_none())
            .filter_map(|place| Some((self.tasks[self.holder_of(place)?].priority, place)))
            .filter(|&(held, _)| self.priorities.is_higher(priority, held))
            .collect();
        held.sort_by(|&(one, place), &(other, other_place)| {
            let since = |place: u32| Reverse(self.places[place as usize].since);
            self.compare_priorities(one, other).then_with(|| since(place).cmp(&since(other_place)))
        });
        held.into_iter().map(|(_, place)| place).collect()
    }

    /// The place that is given back next, its topmost mark that of who was interrupted.
    fn next_given_back(&mut self, valve: u32) -> Option<u32> {
        let entry = &self.valves[valve as usize];
        let is_marked = |place: u32| {
            let stack = &self.places[place as usize];
            stack.handover.is_none() && stack.top_mark().is_some()
        };
        if entry.places == 1 {
            return Some(entry.first_place).filter(|&place| is_marked(place));
        }
        if let Some(lent) = entry.places().find(|&place| is_marked(place) && !self.is_free(place)) {
            return Some(lent);
        }
        let free = self.free_place(valve)?;
        let next = self.first_interrupted(valve)?;
        if self.is_free(next.place) {
            return Some(next.place);
        }
        self.move_owner(next.place, next.mark, free);
        Some(free)
    }

    /// A task gets a place, or hooks run first.
    fn let_in(&mut self, around: &mut Surroundings<'_>, task: u32, place: u32, root: Option<u32>) {
        let Some(root) = root else { return self.grant(around, task, place) };
        self.trace_valve(root, self.valve_of_place(place), "pre-empted");
        let hooks = self.hooks_of(root, place, true);
        self.hold(around, root);
        self.push_link(root, place, LinkKind::Mark);
        self.tasks[root].rare().marked.push(place);
        if !self.start_hooks(around, root, place, &hooks, Handover::Lend) {
            self.grant(around, task, place);
        }
    }

    /// A place comes back to whom it was taken away from last.
    fn give_back(&mut self, around: &mut Surroundings<'_>, place: u32) {
        let mark = self.places[place as usize].top_mark();
        let Some(root) = mark.and_then(|mark| self.tasks.find_alive(mark.task)) else { return };
        let hooks = if self.tasks[root].is_protected() { Vec::new() } else { self.hooks_of(root, place, false) };
        if !self.start_hooks(around, root, place, &hooks, Handover::GiveBack) {
            self.lift_mark(around, place);
        }
    }

    /// The topmost mark goes away, and its root goes on.
    pub(crate) fn lift_mark(&mut self, around: &mut Surroundings<'_>, place: u32) {
        let Some(mark) = self.places[place as usize].top_mark() else { return };
        let Some(root) = self.tasks.find_alive(mark.task) else { return };
        let valve = self.valve_of_place(place);
        let first = self.valves[valve as usize].lines.get(&mark.line).and_then(|below| below.line.first());
        let at = self.places[place as usize].links.len() - 1;
        self.remove_link(place, at);
        if self.has_more_places(place) && !self.is_lent_to(root, place) {
            self.note_owner(place);
        }
        self.trace_valve(root, valve, "returned");
        self.unhold(around, root);
        let holder = self.holder_of(place);
        let Some((turn, task)) = first.filter(|_| !holder.is_some_and(|holder| self.is_within(holder, root))) else {
            return;
        };
        // A clean-up of the interrupted stands for it.
        let mut next = NextServed::default();
        let has_it = self.place_had(task, valve) == Some(place);
        let way = if has_it { Way::Open } else { self.way(task, turn.priority, place) };
        if next.note(&self.priorities, turn, task, place, way)
            && let Some(Served { task, place, root, .. }) = next.served
        {
            self.let_in(around, task, place, root);
        }
    }
}
