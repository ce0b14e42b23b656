//! Requests of valves, and the lines of those who wait.

use crate::state::failure::Raise;
use crate::state::machine::Machine;
use crate::state::memory;
use crate::state::task::Waiting;
use crate::state::valve::{HoldPurpose, NO_LINK, Waiter};
use crate::state::valve_line::LinePlace;
use crate::step::native::Surroundings;
use crate::step::valve::serving::Way;

impl Machine {
    pub(crate) fn valve_name(&self, valve: u32) -> &str {
        self.symbols.name(self.valves[valve as usize].name)
    }

    /// The task that has the valve now or had it last.
    pub(crate) fn holder_of(&self, valve: u32) -> Option<u32> {
        self.valves[valve as usize].top_hold().and_then(|(_, hold)| self.tasks.find_alive(hold.task))
    }

    /// Whether a task, or one above it, holds the valve now.
    pub fn holds_valve(&self, task: u32, valve: u32) -> bool {
        let top = self.valves[valve as usize].links.last().filter(|link| link.is_hold());
        top.and_then(|hold| self.tasks.find(hold.task)).is_some_and(|holder| self.is_within(task, holder))
    }

    /// Asks for a valve; tells whether the task has it now. If not, it waits in line.
    pub(crate) fn request_valve(
        &mut self,
        around: &mut Surroundings<'_>,
        task: u32,
        valve: u32,
    ) -> Result<bool, Raise> {
        if self.valves[valve as usize].links.is_empty() || self.holds_valve(task, valve) {
            self.take(task, valve, HoldPurpose::Plan);
            return Ok(true);
        }
        let is_open = matches!(self.way(task, self.effective_priority(task), valve), Way::Open | Way::Through(_));
        if let Some(holder) = self.holder_of(valve).filter(|_| !is_open) {
            self.check_circle(around.program, task, holder, Waiting::Valve(valve))?;
        }
        self.trace_valve(task, valve, "requested");
        self.tasks[task].wait(Waiting::Valve(valve));
        self.join_valve_line(task, valve);
        self.stir(around, valve);
        Ok(self.tasks[task].waiting() != Some(Waiting::Valve(valve)))
    }

    /// A request takes its place.
    fn join_valve_line(&mut self, task: u32, valve: u32) {
        let priority = self.effective_priority(task);
        let entry = &mut self.valves[valve as usize];
        entry.asked += 1;
        let place = LinePlace { priority, asked: entry.asked };
        entry.waiters.insert(task, Waiter { place, line: None });
        self.heap.allocated += memory::WAITER;
        self.enter_line(task, valve);
    }

    /// A task that waits stands in line, unless it is suspended.
    fn enter_line(&mut self, task: u32, valve: u32) {
        if self.tasks[task].is_held() {
            return;
        }
        let priority = self.effective_priority(task);
        let link = self.link_above(task, valve);
        let entry = &mut self.valves[valve as usize];
        self.scratch.valve_looks += entry.links.len() as u64;
        if let Some(waiter) = entry.waiters.get_mut(&task) {
            waiter.place.priority = priority;
        }
        entry.enter(&self.priorities, task, link);
    }

    /// A task waits no longer.
    pub(crate) fn leave_valve_line(&mut self, task: u32, valve: u32) {
        let entry = &mut self.valves[valve as usize];
        entry.leave(&self.priorities, task);
        entry.waiters.remove(&task);
        // Whoever kept it waiting is to know.
        if entry.claim.is_some() {
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

    /// The topmost link whose task is this one or above it.
    pub(crate) fn link_above(&self, task: u32, valve: u32) -> u64 {
        let links = self.valves[valve as usize].links.iter().rev();
        let mut above =
            links.filter(|link| self.tasks.find(link.task).is_some_and(|other| self.is_within(task, other)));
        above.next().map_or(NO_LINK, |link| link.number)
    }
}
