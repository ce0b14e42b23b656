//! Holds and marks, put on and taken out.

use crate::state::machine::Machine;
use crate::state::memory;
use crate::state::slab::NONE;
use crate::state::task::Wake;
use crate::state::value::{TaskRef, Value};
use crate::state::valve::LinkName;
use crate::state::valve_place::{HoldPurpose, Link, LinkKind};
use crate::step::native::Surroundings;
use std::collections::BTreeSet;

impl Machine {
    /// Gives a place to a task that waits for it.
    pub(crate) fn grant(&mut self, around: &mut Surroundings<'_>, task: u32, place: u32) {
        self.interrupt_activations(around, task, place);
        self.leave_valve_line(task, self.valve_of_place(place));
        self.take(task, place, HoldPurpose::Plan);
        if task == self.current {
            self.tasks[task].end_wait();
        } else {
            self.wake(task, Wake::Value(Value::Nil));
        }
    }

    /// The task's hold goes on top, or counts once more.
    pub(crate) fn take(&mut self, task: u32, place: u32, purpose: HoldPurpose) {
        let me = self.tasks.reference(task);
        let top = self.places[place as usize].links.last_mut().filter(|top| top.task == me && top.serves(purpose));
        if let Some(LinkKind::Hold { count, .. }) = top.map(|top| &mut top.kind) {
            *count += 1;
            return;
        }
        if self.has_more_places(place) && self.owner_above(task, place).is_none() {
            self.note_owner(place);
        }
        let number = self.push_link(task, place, LinkKind::Hold { count: 1, purpose });
        self.tasks[task].rare().held.push(place);
        if purpose != HoldPurpose::Hooks {
            self.trace_valve(task, self.valve_of_place(place), "granted");
        }
        self.gather_line(task, LinkName { place, number });
    }

    pub(crate) fn push_link(&mut self, task: u32, place: u32, kind: LinkKind) -> u64 {
        let task = self.tasks.reference(task);
        let number = self.next_link(place);
        self.places[place as usize].links.push(Link { number, task, line: number, kind });
        self.heap.allocated += memory::LINK;
        number
    }

    /// The number of the next link of a place's valve.
    pub(crate) fn next_link(&mut self, place: u32) -> u64 {
        let valve = self.valve_of_place(place);
        let entry = &mut self.valves[valve as usize];
        entry.last_link += 1;
        entry.last_link
    }

    /// Whether the valve of a place has others.
    pub(crate) fn has_more_places(&self, place: u32) -> bool {
        self.valve_at(place).places > 1
    }

    /// A place has another owner from now on.
    pub(crate) fn note_owner(&mut self, place: u32) {
        self.places[place as usize].since = self.next_link(place);
    }

    /// Those who wait below a task that has taken a place just now stand in its line.
    fn gather_line(&mut self, task: u32, link: LinkName) {
        if self.tasks[task].first_child == NONE {
            return;
        }
        let valve = self.valve_of_place(link.place);
        let line = &self.valves[valve as usize].line;
        self.scratch.valve_looks += line.len() as u64;
        let is_below = |other: u32| {
            self.is_within(other, task)
                && self.link_above(other, valve).is_some_and(|(place, at)| {
                    place == link.place && self.places[place as usize].links[at].number == link.number
                })
        };
        let below: Vec<u32> = line.iter().map(|(_, other)| other).filter(|&other| is_below(other)).collect();
        below.into_iter().for_each(|other| self.move_to_line(other, valve));
    }

    /// One who waits stands in the line of the topmost link it is below from now on.
    fn move_to_line(&mut self, task: u32, valve: u32) {
        let (line, link) = self.line_above(task, valve);
        let entry = &mut self.valves[valve as usize];
        entry.leave(&self.priorities, task);
        entry.enter(&self.priorities, task, line, link);
    }

    /// Takes a link out of the stack; its line goes to the links below.
    pub(crate) fn remove_link(&mut self, place: u32, at: usize) {
        let entry = &mut self.places[place as usize];
        self.scratch.valve_looks += (entry.links.len() - at) as u64;
        let valve = entry.valve;
        let link = entry.links.remove(at);
        if let Some(task) = self.tasks.find(link.task) {
            self.forget_link(task, place, &link);
            if let LinkKind::Hold { purpose: HoldPurpose::Plan | HoldPurpose::Activation(_), .. } = link.kind {
                self.trace_valve(task, valve, "released");
            }
        }
        if self.valves[valve as usize].lines.contains_key(&link.line) {
            self.pass_line_down(place, at, link);
        }
    }

    /// A task knows of a link no more.
    fn forget_link(&mut self, task: u32, place: u32, link: &Link) {
        let rare = self.tasks[task].rare();
        let list = if link.is_hold() { &mut rare.held } else { &mut rare.marked };
        if let Some(at) = list.iter().rposition(|&known| known == place) {
            list.swap_remove(at);
        }
    }

    /// Those below a link that is gone stand in the line of the next one they are below.
    fn pass_line_down(&mut self, place: u32, at: usize, gone: Link) {
        let valve = self.valve_of_place(place);
        if let Some(next) = self.next_for_all(place, at, gone) {
            let (known, link) = self.line_of(valve, next);
            let number = self.valves[valve as usize].join_lines(&self.priorities, gone.line, known, link);
            match next {
                Some((place, at)) => self.places[place as usize].links[at].line = number,
                None => self.valves[valve as usize].open_line = number,
            }
            return;
        }
        let Some(below) = self.valves[valve as usize].lines.get(&gone.line) else { return };
        let waiters: Vec<u32> = below.line.iter().map(|(_, task)| task).collect();
        waiters.into_iter().for_each(|task| self.move_to_line(task, valve));
    }

    /// The next link of all who were below one that is gone, if it is the same for all: they are below its task.
    fn next_for_all(&self, place: u32, at: usize, gone: Link) -> Option<Option<(u32, usize)>> {
        let (valve, has_more) = (self.valve_of_place(place), self.has_more_places(place));
        let Some(next) = at.checked_sub(1) else {
            let elsewhere = || self.tasks.find(gone.task).map(|task| self.link_above(task, valve));
            return if has_more { elsewhere() } else { Some(None) };
        };
        let above = self.tasks.find(self.places[place as usize].links[next].task)?;
        let task = self.tasks.find(gone.task)?;
        let is_next = self.is_within(task, above) && (!has_more || self.place_above(task, valve) == Some(place));
        is_next.then_some(Some((place, next)))
    }

    /// The owner that was interrupted at a mark goes from its place to a free one, with all links below it.
    pub(crate) fn move_owner(&mut self, from: u32, mark: usize, to: u32) {
        let root = self.places[from as usize].links[mark].task;
        let Some(root) = self.tasks.find_alive(root) else { return };
        let valve = self.valve_of_place(from);
        let links = std::mem::take(&mut self.places[from as usize].links);
        self.scratch.valve_looks += links.len() as u64;
        for mut link in links {
            let task = self.tasks.find_alive(link.task).filter(|&task| self.is_within(task, root));
            let Some(task) = task else {
                self.places[from as usize].links.push(link);
                continue;
            };
            self.forget_link(task, from, &link);
            let rare = self.tasks[task].rare();
            if link.is_hold() { &mut rare.held } else { &mut rare.marked }.push(to);
            link.number = self.next_link(to);
            if let Some(below) = self.valves[valve as usize].lines.get_mut(&link.line) {
                below.link = Some(LinkName { place: to, number: link.number });
            }
            self.places[to as usize].links.push(link);
        }
    }

    /// The place of a valve that a task has taken for a plan.
    pub(crate) fn place_taken_by(&self, task: u32, valve: u32) -> Option<u32> {
        let (me, places) = (self.tasks.reference(task), self.valves[valve as usize].places());
        let mut held = self.tasks[task].held().iter().copied().filter(|place| places.contains(place));
        held.find(|&place| self.places[place as usize].is_taken_by(me))
    }

    /// Gives one hold of a task back.
    pub(crate) fn release_valve(&mut self, around: &mut Surroundings<'_>, task: u32, valve: u32) {
        let Some(place) = self.place_taken_by(task, valve) else { return };
        let me = self.tasks.reference(task);
        let links = &mut self.places[place as usize].links;
        let Some(at) = links.iter().rposition(|link| link.task == me && link.serves(HoldPurpose::Plan)) else { return };
        if let LinkKind::Hold { count: count @ 2.., .. } = &mut links[at].kind {
            *count -= 1;
            return;
        }
        self.remove_link(place, at);
        self.stir(around, valve);
    }

    /// A dead task holds nothing, and nothing is suspended below it.
    pub(crate) fn drop_links_of(&mut self, around: &mut Surroundings<'_>, task: u32) {
        let me = self.tasks.reference(task);
        let Some(rare) = &mut self.tasks[task].rare else { return };
        let claimed = std::mem::take(&mut rare.claimed);
        let places: BTreeSet<u32> = rare.held.iter().chain(&rare.marked).copied().collect();
        for place in claimed {
            self.places[place as usize].claim = None;
            self.claims -= 1;
            self.scratch.restless.insert(self.valve_of_place(place));
        }
        for place in places {
            while let Some(at) = self.places[place as usize].links.iter().rposition(|link| link.task == me) {
                self.remove_link(place, at);
            }
            self.scratch.restless.insert(self.valve_of_place(place));
        }
        self.serve_valves(around);
    }

    /// A borrowed hold for a behaviour.
    pub(crate) fn hold_for_activation(&mut self, task: u32, place: u32, behaviour: u16) {
        self.take(task, place, HoldPurpose::Activation(behaviour));
    }

    /// The behaviour has ended: its hold is given back.
    pub(crate) fn release_activation(&mut self, around: &mut Surroundings<'_>, behaviour: u16, owner: Option<TaskRef>) {
        let purpose = HoldPurpose::Activation(behaviour);
        let held = owner.and_then(|owner| self.tasks.find(owner)).map_or(&[][..], |owner| self.tasks[owner].held());
        let drives = |&&place: &&u32| self.places[place as usize].links.iter().any(|link| link.serves(purpose));
        let Some(&place) = held.iter().find(drives) else { return };
        if let Some(at) = self.places[place as usize].links.iter().rposition(|link| link.serves(purpose)) {
            self.remove_link(place, at);
            self.stir(around, self.valve_of_place(place));
        }
    }

    /// Behaviours that drive with a place lose it to a task they do not belong to.
    fn interrupt_activations(&mut self, around: &mut Surroundings<'_>, task: u32, place: u32) {
        let mut driving = Vec::new();
        for (at, link) in self.places[place as usize].links.iter().enumerate().rev() {
            let owner = self.tasks.find(link.task);
            if let LinkKind::Hold { purpose: HoldPurpose::Activation(behaviour), .. } = link.kind
                && !owner.is_some_and(|owner| self.is_within(task, owner))
            {
                driving.push((at, behaviour));
            }
        }
        driving.iter().for_each(|&(at, _)| self.remove_link(place, at));
        let valve = self.valve_of_place(place);
        driving.iter().rev().for_each(|&(_, behaviour)| self.interrupt_behaviour(around, behaviour, valve, task));
    }
}
