//! Holds and marks, put on and taken out.

use crate::state::machine::Machine;
use crate::state::memory;
use crate::state::slab::NONE;
use crate::state::task::Wake;
use crate::state::value::{TaskRef, Value};
use crate::state::valve::{HoldPurpose, Link, LinkKind, NO_LINK};
use crate::step::native::Surroundings;
use std::collections::BTreeSet;

impl Machine {
    /// Gives the valve to a task that waits for it.
    pub(crate) fn grant(&mut self, around: &mut Surroundings<'_>, task: u32, valve: u32) {
        self.interrupt_activations(around, task, valve);
        self.leave_valve_line(task, valve);
        self.take(task, valve, HoldPurpose::Plan);
        if task == self.current {
            self.tasks[task].end_wait();
        } else {
            self.wake(task, Wake::Value(Value::Nil));
        }
    }

    /// The task's hold goes on top, or counts once more.
    pub(crate) fn take(&mut self, task: u32, valve: u32, purpose: HoldPurpose) {
        let me = self.tasks.reference(task);
        let top = self.valves[valve as usize].links.last_mut().filter(|top| top.task == me && top.serves(purpose));
        if let Some(LinkKind::Hold { count, .. }) = top.map(|top| &mut top.kind) {
            *count += 1;
            return;
        }
        let number = self.valves[valve as usize].push(me, LinkKind::Hold { count: 1, purpose });
        self.tasks[task].rare().held.push(valve);
        self.heap.allocated += memory::LINK;
        if purpose != HoldPurpose::Hooks {
            self.trace_valve(task, valve, "granted");
        }
        self.gather_line(task, valve, number);
    }

    /// Those who wait below a task that has taken the valve just now stand in its line.
    fn gather_line(&mut self, task: u32, valve: u32, number: u64) {
        if self.tasks[task].first_child == NONE {
            return;
        }
        let line = &self.valves[valve as usize].line;
        self.scratch.valve_looks += line.len() as u64;
        let below: Vec<u32> =
            line.iter().map(|(_, other)| other).filter(|&other| self.is_within(other, task)).collect();
        below.into_iter().for_each(|other| self.move_to_line(other, valve, number));
    }

    /// One who waits stands in the line of another link from now on.
    fn move_to_line(&mut self, task: u32, valve: u32, link: u64) {
        let entry = &mut self.valves[valve as usize];
        entry.leave(&self.priorities, task);
        entry.enter(&self.priorities, task, link);
    }

    /// Takes a link out of the stack; its line goes to the links below.
    pub(crate) fn remove_link(&mut self, valve: u32, at: usize) {
        self.scratch.valve_looks += (self.valves[valve as usize].links.len() - at) as u64;
        let link = self.valves[valve as usize].links.remove(at);
        if let Some(task) = self.tasks.find(link.task) {
            let rare = self.tasks[task].rare();
            let list = if link.is_hold() { &mut rare.held } else { &mut rare.marked };
            if let Some(at) = list.iter().rposition(|&known| known == valve) {
                list.swap_remove(at);
            }
            if let LinkKind::Hold { purpose: HoldPurpose::Plan | HoldPurpose::Activation(_), .. } = link.kind {
                self.trace_valve(task, valve, "released");
            }
        }
        if self.valves[valve as usize].lines.contains_key(&link.line) {
            self.pass_line_down(valve, at, link);
        }
    }

    /// Those below a link that is gone stand in the line of the next one they are below.
    fn pass_line_down(&mut self, valve: u32, at: usize, gone: Link) {
        let next = self.valves[valve as usize].links[..at].last().copied();
        let contains = |link: Link| match (self.tasks.find(link.task), self.tasks.find(gone.task)) {
            (Some(above), Some(gone)) => self.is_within(gone, above),
            _ => false,
        };
        if next.is_none_or(contains) {
            let link = next.map_or(NO_LINK, |next| next.number);
            self.valves[valve as usize].join_lines(&self.priorities, gone.line, link);
            return;
        }
        let Some(below) = self.valves[valve as usize].lines.get(&gone.line) else { return };
        let waiters: Vec<u32> = below.line.iter().map(|(_, task)| task).collect();
        for task in waiters {
            let link = self.link_above(task, valve);
            self.move_to_line(task, valve, link);
        }
    }

    /// Gives one hold of a task back.
    pub(crate) fn release_valve(&mut self, around: &mut Surroundings<'_>, task: u32, valve: u32) {
        let me = self.tasks.reference(task);
        let links = &mut self.valves[valve as usize].links;
        let Some(at) = links.iter().rposition(|link| link.task == me && link.serves(HoldPurpose::Plan)) else { return };
        if let LinkKind::Hold { count: count @ 2.., .. } = &mut links[at].kind {
            *count -= 1;
            return;
        }
        self.remove_link(valve, at);
        self.stir(around, valve);
    }

    /// A dead task holds nothing, and nothing is suspended below it.
    pub(crate) fn drop_links_of(&mut self, around: &mut Surroundings<'_>, task: u32) {
        let me = self.tasks.reference(task);
        let Some(rare) = &mut self.tasks[task].rare else { return };
        let claimed = std::mem::take(&mut rare.claimed);
        let valves: BTreeSet<u32> = rare.held.iter().chain(&rare.marked).copied().collect();
        for valve in claimed {
            self.valves[valve as usize].claim = None;
            self.claims -= 1;
            self.scratch.restless.insert(valve);
        }
        for valve in valves {
            while let Some(at) = self.valves[valve as usize].links.iter().rposition(|link| link.task == me) {
                self.remove_link(valve, at);
            }
            self.scratch.restless.insert(valve);
        }
        self.serve_valves(around);
    }

    /// A borrowed hold for a behaviour.
    pub(crate) fn hold_for_activation(&mut self, task: u32, valve: u32, behaviour: u16) {
        self.take(task, valve, HoldPurpose::Activation(behaviour));
    }

    /// The behaviour has ended: its hold is given back.
    pub(crate) fn release_activation(&mut self, around: &mut Surroundings<'_>, behaviour: u16, owner: Option<TaskRef>) {
        let purpose = HoldPurpose::Activation(behaviour);
        let held = owner.and_then(|owner| self.tasks.find(owner)).map_or(&[][..], |owner| self.tasks[owner].held());
        let drives = |&&valve: &&u32| self.valves[valve as usize].links.iter().any(|link| link.serves(purpose));
        let Some(&valve) = held.iter().find(drives) else { return };
        if let Some(at) = self.valves[valve as usize].links.iter().rposition(|link| link.serves(purpose)) {
            self.remove_link(valve, at);
            self.stir(around, valve);
        }
    }

    /// Behaviours that drive with a valve lose it to a task they do not belong to.
    fn interrupt_activations(&mut self, around: &mut Surroundings<'_>, task: u32, valve: u32) {
        let mut driving = Vec::new();
        for (at, link) in self.valves[valve as usize].links.iter().enumerate().rev() {
            let owner = self.tasks.find(link.task);
            if let LinkKind::Hold { purpose: HoldPurpose::Activation(behaviour), .. } = link.kind
                && !owner.is_some_and(|owner| self.is_within(task, owner))
            {
                driving.push((at, behaviour));
            }
        }
        driving.iter().for_each(|&(at, _)| self.remove_link(valve, at));
        driving.iter().rev().for_each(|&(_, behaviour)| self.interrupt_behaviour(around, behaviour));
    }
}
