//! Requests of valves, and the lines of those who wait.

use crate::state::failure::Raise;
use crate::state::machine::Machine;
use crate::state::memory;
use crate::state::slab::NONE;
use crate::state::task::Waiting;
use crate::state::valve::{LinkName, Valve, Waiter};
use crate::state::valve_line::Turn;
use crate::state::valve_place::{HoldPurpose, Link};
use crate::step::native::Surroundings;

impl Machine {
    pub(crate) fn valve_name(&self, valve: u32) -> &str {
        self.symbols.name(self.valves[valve as usize].name)
    }

    pub(crate) fn valve_of_place(&self, place: u32) -> u32 {
        self.places[place as usize].valve
    }

    pub(crate) fn valve_at(&self, place: u32) -> &Valve {
        &self.valves[self.valve_of_place(place) as usize]
    }

    /// The task that has a place now or had it last.
    pub(crate) fn holder_of(&self, place: u32) -> Option<u32> {
        self.places[place as usize].top_hold().and_then(|(_, hold)| self.tasks.find_alive(hold.task))
    }

    /// The outermost of a task and those above it that holds a place.
    pub(crate) fn owner_above(&self, task: u32, place: u32) -> Option<u32> {
        let (mut owner, mut at) = (None, task);
        while at != NONE {
            if self.tasks[at].held().contains(&place) {
                owner = Some(at);
            }
            at = self.tasks[at].parent;
        }
        owner
    }

    /// The place of a valve to which a task belongs: where it, or else the nearest task above it that has any,
    /// has a link.
    pub(crate) fn place_above(&self, task: u32, valve: u32) -> Option<u32> {
        let places = self.valves[valve as usize].places();
        let mut at = task;
        while at != NONE {
            let linked = self.tasks[at].rare.iter().flat_map(|rare| rare.held.iter().chain(&rare.marked));
            if let Some(place) = linked.copied().filter(|place| places.contains(place)).min() {
                return Some(place);
            }
            at = self.tasks[at].parent;
        }
        None
    }

    /// The place of a valve that a task, or one above it, has now.
    pub(crate) fn place_had(&self, task: u32, valve: u32) -> Option<u32> {
        let entry = &self.valves[valve as usize];
        let place = if entry.places == 1 { entry.first_place } else { self.place_above(task, valve)? };
        let top = self.places[place as usize].links.last().filter(|link| link.is_hold());
        let has_it = top.and_then(|hold| self.tasks.find(hold.task)).is_some_and(|holder| self.is_within(task, holder));
        has_it.then_some(place)
    }

    /// Whether a task, or one above it, holds the valve now.
    pub fn holds_valve(&self, task: u32, valve: u32) -> bool {
        self.place_had(task, valve).is_some()
    }

    /// Asks for a valve; tells whether the task has it now. If not, it waits in line.
    pub(crate) fn request_valve(
        &mut self,
        around: &mut Surroundings<'_>,
        task: u32,
        valve: u32,
    ) -> Result<bool, Raise> {
        if let Some(place) = self.place_had(task, valve).or_else(|| self.empty_place(task, valve)) {
            self.take(task, place, HoldPurpose::Plan);
            return Ok(true);
        }
        if !self.can_have(task, valve) {
            self.check_circle(around.program, task, Waiting::Valve(valve))?;
        }
        self.trace_valve(task, valve, "requested");
        self.tasks[task].wait(Waiting::Valve(valve));
        self.join_valve_line(task, valve);
        self.stir(around, valve);
        Ok(self.tasks[task].waiting() != Some(Waiting::Valve(valve)))
    }

    /// A place that nobody has anything to do with, for a task that belongs to none.
    fn empty_place(&self, task: u32, valve: u32) -> Option<u32> {
        let mut places = self.valves[valve as usize].places();
        let empty = places.find(|&place| self.places[place as usize].links.is_empty())?;
        (!self.has_more_places(empty) || self.place_above(task, valve).is_none()).then_some(empty)
    }

    /// A request takes its turn.
    fn join_valve_line(&mut self, task: u32, valve: u32) {
        let priority = self.effective_priority(task);
        let entry = &mut self.valves[valve as usize];
        entry.asked += 1;
        let turn = Turn { priority, asked: entry.asked };
        entry.waiters.insert(task, Waiter { turn, line: None });
        self.heap.allocated += memory::WAITER;
        self.enter_line(task, valve);
    }

    /// A task that waits stands in line, unless it is suspended.
    fn enter_line(&mut self, task: u32, valve: u32) {
        if self.tasks[task].is_held() {
            return;
        }
        let priority = self.effective_priority(task);
        let (line, link) = self.line_above(task, valve);
        let looked = link.map_or(self.valves[valve as usize].first_place, |link| link.place);
        self.scratch.valve_looks += self.places[looked as usize].links.len() as u64;
        let entry = &mut self.valves[valve as usize];
        if let Some(waiter) = entry.waiters.get_mut(&task) {
            waiter.turn.priority = priority;
        }
        entry.enter(&self.priorities, task, line, link);
    }

    /// A task waits no longer.
    pub(crate) fn leave_valve_line(&mut self, task: u32, valve: u32) {
        let entry = &mut self.valves[valve as usize];
        entry.leave(&self.priorities, task);
        entry.waiters.remove(&task);
        // Whoever kept it waiting is to know.
        if entry.places().any(|place| self.places[place as usize].claim.is_some()) {
            self.scratch.restless.insert(valve);
        }
    }

    /// A task that waits for a valve was suspended, resumed, or has another priority now.
    pub(crate) fn change_line(&mut self, task: u32, change: impl FnOnce(&mut Self)) {
        let Some(Waiting::Valve(valve)) = self.tasks[task].waiting() else { return change(self) };
        self.valves[valve as usize].leave(&self.priorities, task);
        change(self);
        self.enter_line(task, valve);
        self.scratch.restless.insert(valve);
    }

    /// The topmost link whose task is this one or above it, in the place to which the task belongs: the place, and
    /// where in its stack.
    pub(crate) fn link_above(&self, task: u32, valve: u32) -> Option<(u32, usize)> {
        let entry = &self.valves[valve as usize];
        let place = if entry.places == 1 { entry.first_place } else { self.place_above(task, valve)? };
        let is_above = |link: &Link| self.tasks.find(link.task).is_some_and(|other| self.is_within(task, other));
        let at = self.places[place as usize].links.iter().rposition(is_above)?;
        Some((place, at))
    }

    /// The line of a link, or of those who are below none.
    pub(crate) fn line_of(&self, valve: u32, link: Option<(u32, usize)>) -> (u64, Option<LinkName>) {
        let Some((place, at)) = link else { return (self.valves[valve as usize].open_line, None) };
        let Link { number, line, .. } = self.places[place as usize].links[at];
        (line, Some(LinkName { place, number }))
    }

    /// The line in which a task stands that waits.
    pub(crate) fn line_above(&self, task: u32, valve: u32) -> (u64, Option<LinkName>) {
        self.line_of(valve, self.link_above(task, valve))
    }
}
