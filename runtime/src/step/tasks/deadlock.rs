//! Deadlocks: who waits for whom, waits that would close a circle, and runs in which nothing can
//! happen any more.
//!
//! The search for a circle goes from both ends by turns, from the one that has cost less: who is waited
//! for, and who waits. It is over when either has nobody left, so that a crowd on one side costs nothing.
//! Who waits for a valve of several places can do with any of them: a circle that is found is one only if every way
//! out of it leads back.

use crate::state::failure::Raise;
use crate::state::machine::Machine;
use crate::state::slab::NONE;
use crate::state::task::{Leaving, ScopeKind, State, Waiting};
use crate::state::value::Value;
use crate::step::native::Surroundings;
use crate::step::tasks::needs::Needs;
use rpl_lang::code::Program;
use std::collections::{BTreeMap, BTreeSet};

/// One end of the search.
struct End {
    seen: BTreeSet<u32>,
    waiting: Vec<u32>,
    cost: usize,
}

impl End {
    fn at(tasks: Vec<u32>) -> Self {
        Self { seen: tasks.iter().copied().collect(), waiting: tasks, cost: 0 }
    }

    /// Notes tasks next to one; tells whether the other end has seen one of them.
    fn go_to(&mut self, tasks: Vec<u32>, other: &End) -> bool {
        self.cost += 1 + tasks.len();
        let new: Vec<u32> = tasks.into_iter().filter(|&task| self.seen.insert(task)).collect();
        let meets = new.iter().any(|task| other.seen.contains(task));
        self.waiting.extend(new);
        meets
    }
}

impl Machine {
    /// A wait that would close a circle of waiting is a `deadlock`.
    pub(crate) fn check_circle(&self, program: &Program, task: u32, what: Waiting) -> Result<(), Raise> {
        let first = self.awaited(task, what);
        let (mut ahead, mut behind) = (End::at(first.tasks()), End::at(vec![task]));
        let mut is_closed = ahead.seen.contains(&task);
        while !is_closed {
            let (Some(&next), Some(&before)) = (ahead.waiting.last(), behind.waiting.last()) else { return Ok(()) };
            is_closed = if ahead.cost + self.crowd_ahead(next) <= behind.cost + self.crowd_behind(before) {
                ahead.waiting.pop();
                ahead.go_to(self.must_happen_first(next).tasks(), &behind)
            } else {
                behind.waiting.pop();
                behind.go_to(self.who_waits_for(before), &ahead)
            };
        }
        let tasks = first.tasks();
        if self.can_go_on(task, first) {
            return Ok(());
        }
        Err(Raise::new("deadlock", self.describe_circle(program, task, tasks, what)))
    }

    fn describe_circle(&self, program: &Program, task: u32, first: Vec<u32>, what: Waiting) -> String {
        let mut came_from: BTreeMap<u32, u32> = first.iter().map(|&first| (first, NONE)).collect();
        let mut waiting: Vec<u32> = first.into_iter().rev().collect();
        while let Some(at) = waiting.pop().filter(|&at| at != task) {
            for next in self.must_happen_first(at).tasks().into_iter().rev() {
                came_from.entry(next).or_insert_with(|| {
                    waiting.push(next);
                    at
                });
            }
        }
        let mut parts = Vec::new();
        let (mut at, mut next) = (came_from.get(&task).copied().unwrap_or(NONE), task);
        while at != NONE {
            let record = &self.tasks[at];
            parts.push(if record.is_held() && self.suspending(at).tasks().contains(&next) {
                format!("{} is suspended by {}", self.path(at), self.path(next))
            } else {
                format!("{} waits for {}", self.path(at), self.describe(program, record.waiting()))
            });
            (at, next) = (came_from[&at], at);
        }
        parts.push(format!("{} waits for {}", self.path(task), self.describe(program, Some(what))));
        parts.reverse();
        format!("this would close a circle of waiting: {}", parts.join("; "))
    }

    /// The tasks without whose going on this one cannot go on.
    pub(super) fn must_happen_first(&self, task: u32) -> Needs {
        let record = &self.tasks[task];
        let mut first = if record.is_held() { self.suspending(task) } else { Needs::default() };
        if let Some(waiting) = record.waiting() {
            first.add(self.awaited(task, waiting));
        }
        first
    }

    /// The tasks that only by going on let one that is suspended go on: those that have a valve which was taken away
    /// from it or from around it, and those whose forms suspend it. An owner can have any place of its valve.
    fn suspending(&self, task: u32) -> Needs {
        let mut found = Needs::default();
        let mut reaches = Some(task);
        while let Some(at) = reaches.filter(|&at| self.tasks[at].stop() > 0) {
            let record = &self.tasks[at];
            let me = self.tasks.reference(at);
            for &place in record.rare.iter().flat_map(|rare| &rare.marked) {
                if self.has_more_places(place) && !self.is_lent_to(at, place) {
                    found.any.push(self.holders_of(self.valve_of_place(place)));
                    continue;
                }
                let links = self.places[place as usize].links.iter();
                let above = links.skip_while(|link| !(link.is_mark() && link.task == me));
                let holds = above.filter(|link| link.is_hold());
                found.all.extend(holds.filter_map(|hold| self.tasks.find_alive(hold.task)));
            }
            found.all.extend(
                record.rare.iter().flat_map(|rare| &rare.suspended_by).filter_map(|&by| self.tasks.find_alive(by)),
            );
            reaches = self.suspends_with_it(at);
        }
        found
    }

    /// The tasks that have a valve's places now or had them last.
    fn holders_of(&self, valve: u32) -> Vec<u32> {
        self.valves[valve as usize].places().filter_map(|place| self.holder_of(place)).collect()
    }

    /// The tasks without whose going on a wait does not end.
    fn awaited(&self, task: u32, waiting: Waiting) -> Needs {
        let record = &self.tasks[task];
        let all = match waiting {
            Waiting::Valve(valve) => {
                let entry = &self.valves[valve as usize];
                let place = if entry.places == 1 { Some(entry.first_place) } else { self.place_above(task, valve) };
                let Some(place) = place else { return Needs { all: Vec::new(), any: vec![self.holders_of(valve)] } };
                self.holder_of(place).into_iter().collect()
            }
            Waiting::Death(other) | Waiting::Rest(other) | Waiting::Swap(other) | Waiting::Hooks(other) => {
                self.tasks.get_alive(other).map(|_| other).into_iter().collect()
            }
            Waiting::Spawned => self.children(task),
            Waiting::Children if self.needs_children(task) => {
                self.children_of_scope(task, record.scopes.len() as u32 - 1)
            }
            Waiting::Children
            | Waiting::Fluent { .. }
            | Waiting::Watch(_)
            | Waiting::Time
            | Waiting::Signal(_)
            | Waiting::Answer => Vec::new(),
        };
        Needs { all, any: Vec::new() }
    }

    /// Whether a task that waits for children can do without none of them.
    fn needs_children(&self, task: u32) -> bool {
        let record = &self.tasks[task];
        match record.scopes.last().map(|scope| &scope.kind) {
            Some(ScopeKind::Children(children)) => children.needs_all() || record.is_leaving(),
            _ => false,
        }
    }

    /// The tasks that cannot go on without this one's going on.
    fn who_waits_for(&self, task: u32) -> Vec<u32> {
        let record = &self.tasks[task];
        let mut found = Vec::new();
        if let Some(parent) = self.tasks.get_alive(record.parent).filter(|parent| parent.state() == State::Blocked)
            && let Some(waiting) = parent.waiting()
        {
            let is_awaited = match waiting {
                Waiting::Spawned => true,
                Waiting::Children => {
                    self.needs_children(record.parent) && record.parent_scope as usize + 1 == parent.scopes.len()
                }
                Waiting::Fluent { .. }
                | Waiting::Watch(_)
                | Waiting::Time
                | Waiting::Valve(_)
                | Waiting::Death(_)
                | Waiting::Rest(_)
                | Waiting::Swap(_)
                | Waiting::Signal(_)
                | Waiting::Hooks(_)
                | Waiting::Answer => false,
            };
            found.extend(is_awaited.then_some(record.parent));
        }
        if let Some(rare) = &record.rare {
            found.extend([rare.mourners, rare.resters].iter().flat_map(|line| line.tasks(&self.tasks)));
            let held = rare.held.iter().filter(|&&place| self.holder_of(place) == Some(task));
            found.extend(held.flat_map(|&place| self.valve_at(place).waiters.keys().copied()));
        }
        found
    }

    /// At most how many tasks must go on before this one.
    fn crowd_ahead(&self, task: u32) -> usize {
        let record = &self.tasks[task];
        match (record.waiting(), record.scopes.last().map(|scope| &scope.kind)) {
            (Some(Waiting::Children), Some(ScopeKind::Children(children))) => children.alive as usize,
            (Some(Waiting::Spawned), Some(ScopeKind::Call(call))) => call.spawned as usize,
            (Some(Waiting::Valve(valve)), _) => self.valves[valve as usize].places as usize,
            _ => 1,
        }
    }

    /// At most how many tasks wait for this one. Those that it suspends are not counted, and not looked for: the
    /// search goes on from the other end.
    fn crowd_behind(&self, task: u32) -> usize {
        let Some(rare) = &self.tasks[task].rare else { return 1 };
        let has_interrupted = |place: u32| self.places[place as usize].interrupted().next().is_some();
        if rare.suspends > 0 || rare.held.iter().any(|&place| self.valve_at(place).places().any(has_interrupted)) {
            return usize::MAX / 4;
        }
        let in_lines = rare.held.iter().map(|&place| self.valve_at(place).waiters.len());
        1 + rare.in_lines as usize + in_lines.sum::<usize>()
    }

    /// Nothing can happen any more: the main task fails with what every task waits for. If it is
    /// leaving already, the clean-up it waits for does.
    pub(crate) fn fail_deadlocked(&mut self, around: &mut Surroundings<'_>) {
        let waits = self.what_tasks_wait_for(around.program);
        let message = format!("every task is blocked and no timer runs: {waits}");
        let failing = self.deadlocked_task();
        let failure = self.failure_of(failing, Raise::new("deadlock", message));
        if let Value::Failure(index) = failure {
            self.heap.failures[index].is_runaway = true;
        }
        self.spent.times = self.spent.times.saturating_add(1);
        self.depart(around, failing, Leaving::Fail(failure));
    }

    /// The task that fails when nothing can happen any more: main, or if that is on its way out,
    /// the innermost clean-up that keeps it.
    fn deadlocked_task(&self) -> u32 {
        if !self.tasks[self.main].is_protected() {
            return self.main;
        }
        let mut cleaning = self.living_tasks();
        cleaning.retain(|&task| !self.tasks[task].is_leaving() && self.tasks[task].is_cleaning_up());
        let is_innermost = |&task: &u32| !cleaning.iter().any(|&other| other != task && self.is_within(other, task));
        cleaning.iter().copied().find(is_innermost).unwrap_or(self.main)
    }
}
