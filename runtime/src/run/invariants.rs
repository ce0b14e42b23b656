//! What is true of a machine between two steps, whatever runs in it.

use crate::state::line::Line;
use crate::state::machine::{Machine, SCRATCH_TASK};
use crate::state::slab::{Marks, NONE};
use crate::state::task::{ScopeKind, State, Task, Waiting};
use crate::state::valve::{Below, OPEN_LINE, Valve};
use crate::state::valve_line::ValveLine;
use crate::state::valve_place::{Link, LinkKind, Place};
use std::collections::BTreeMap;

fn ensure(holds: bool, what: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(what()) }
}

impl Machine {
    /// Checks the links between tasks, fluents, valves and the run queue.
    ///
    /// # Errors
    /// One sentence about the first thing that is wrong. Cost: linear, but for valves' lines.
    pub fn check_invariants(&self) -> Result<(), String> {
        let mut queued = Marks::new(self.tasks.slots());
        for task in self.priorities.queued(&self.tasks) {
            ensure(queued.set(task), || format!("task {task} stands in the run queue twice"))?;
        }
        for (index, task) in self.tasks.iter().filter(|&(index, _)| index != SCRATCH_TASK) {
            self.check_task(index, task, queued.is_set(index))
                .map_err(|what| format!("{} (task {index}): {what}", self.path(index)))?;
        }
        let resting = self.tasks.iter().filter(|(_, task)| matches!(task.waiting(), Some(Waiting::Rest(_)))).count();
        ensure(resting == self.waits_for_rest as usize, || {
            format!("{resting} tasks wait for others to be at rest, and {} are counted", self.waits_for_rest)
        })?;
        let has_swap = |task: &Task| task.rare.as_ref().is_some_and(|rare| rare.swap_pending.is_some());
        let swaps = self.tasks.iter().filter(|(_, task)| has_swap(task)).count();
        ensure(swaps == self.swaps_pending as usize, || {
            format!("{swaps} tasks are to be given other plans, and {} are counted", self.swaps_pending)
        })?;
        self.check_fluents()?;
        self.check_watches()?;
        self.check_valves()
    }

    fn check_task(&self, index: u32, task: &Task, is_queued: bool) -> Result<(), String> {
        ensure(is_queued == (task.state() == State::Ready && !task.is_held()), || {
            format!("{} with {} suspensions, and in the run queue: {is_queued}", task.state().name(), task.stop())
        })?;
        ensure(task.state() != State::Running, || "runs between two steps".into())?;
        ensure((task.state() == State::Blocked) == task.waiting().is_some(), || {
            format!("is {} and waits for {:?}", task.state().name(), task.waiting())
        })?;
        if task.state().is_dead() {
            ensure(task.first_child == NONE, || "is dead and has children".into())?;
            return ensure(task.scopes.is_empty(), || format!("is dead and has the scopes {:?}", task.scopes));
        }
        self.check_parent(index, task)?;
        self.check_children(index, task)?;
        let suspends = task.scopes.iter().filter(|scope| matches!(scope.kind, ScopeKind::Suspended(_))).count();
        let counted = task.rare.as_ref().map_or(0, |rare| rare.suspends as usize);
        ensure(suspends == counted, || format!("suspends {suspends} tasks, and {counted} are counted"))?;
        self.check_waiting(index, task)
    }

    fn check_parent(&self, index: u32, task: &Task) -> Result<(), String> {
        let mut stops = task.own_stops();
        if task.parent != NONE {
            let parent = self.tasks.get(task.parent).filter(|parent| !parent.state().is_dead());
            let Some(parent) = parent else { return Err("outlives its parent".into()) };
            let before = task.previous_sibling;
            let is_linked = if before == NONE { parent.first_child } else { self.tasks[before].next_sibling } == index;
            ensure(is_linked, || "is no child of its parent".into())?;
            if !task.named_as_hook() && !parent.is_within_clean_up(task.parent_scope) {
                stops += parent.stop();
            }
        }
        ensure(stops == task.stop(), || format!("counts {} suspensions, and there are {stops}", task.stop()))
    }

    fn check_children(&self, index: u32, task: &Task) -> Result<(), String> {
        let mut counts = vec![0; task.scopes.len()];
        let mut at = task.first_child;
        let mut before = NONE;
        while at != NONE {
            let child = &self.tasks[at];
            ensure(child.parent == index && child.previous_sibling == before, || format!("a wrong link to {at}"))?;
            ensure(!child.state().is_dead(), || format!("the dead child {at} is still linked"))?;
            if !child.named_as_hook() {
                match counts.get_mut(child.parent_scope as usize) {
                    Some(count) => *count += 1,
                    None => return Err(format!("the child {at} belongs to a scope that is gone")),
                }
            }
            (before, at) = (at, child.next_sibling);
        }
        ensure(task.last_child == before, || "the last child is not the last".into())?;
        for (scope, count) in task.scopes.iter().zip(counts) {
            let known = match &scope.kind {
                ScopeKind::Children(children) => children.alive,
                ScopeKind::Call(call) => call.spawned,
                _ => 0,
            };
            ensure(known == count, || format!("counts {known} children of a scope, and there are {count}"))?;
        }
        Ok(())
    }

    fn check_waiting(&self, index: u32, task: &Task) -> Result<(), String> {
        ensure(self.clocks_are_right(index), || "counts time worked while it is suspended, or does not".into())?;
        let Some(waiting) = task.waiting() else { return Ok(()) };
        match waiting {
            Waiting::Fluent { fluent, .. } => {
                let Some(entry) = self.fluents.get(fluent) else {
                    return Err("waits for a fluent that is gone".into());
                };
                ensure(!entry.reading().is_true(), || "waits for a fluent that is true".into())?;
                Ok(())
            }
            Waiting::Watch(watch) => {
                let entry = self.watches.get(watch);
                ensure(entry.is_some_and(|entry| entry.task == index && entry.waits && entry.events == 0), || {
                    format!("waits for the watch {entry:?}")
                })
            }
            Waiting::Valve(valve) => {
                let waiter = self.valves[valve as usize].waiters.get(&index);
                ensure(waiter.is_some_and(|waiter| waiter.line.is_some() != task.is_held()), || {
                    "does not stand in the line of its valve, or is suspended and does".into()
                })
            }
            Waiting::Death(other) | Waiting::Swap(other) => {
                let other = self.tasks.get_alive(other).and_then(|other| other.rare.as_ref());
                let is_in_line = other.is_some_and(|other| self.stands_in(index, other.mourners));
                ensure(is_in_line, || "waits for nobody's death".into())
            }
            Waiting::Rest(other) => {
                let other = self.tasks.get_alive(other).and_then(|other| other.rare.as_ref());
                let is_in_line = other.is_some_and(|other| self.stands_in(index, other.resters));
                ensure(is_in_line, || "waits for nobody's rest".into())
            }
            Waiting::Children | Waiting::Spawned => {
                ensure(task.first_child != NONE, || "waits for children and has none".into())
            }
            Waiting::Hooks(hooks) => {
                let runs = self.tasks.get_alive(hooks).is_some_and(Task::named_as_hook);
                ensure(runs, || "waits for hooks that have ended".into())
            }
            Waiting::Time | Waiting::Signal(_) | Waiting::Answer => Ok(()),
        }
    }

    /// Whether a task's neighbours in a line know it. Cost: constant, if every task is asked.
    fn stands_in(&self, task: u32, line: Line) -> bool {
        let record = &self.tasks[task];
        let before = if record.previous == NONE { line.first } else { self.tasks[record.previous].next };
        let behind = if record.next == NONE { line.last } else { self.tasks[record.next].previous };
        before == task && behind == task
    }

    fn check_fluents(&self) -> Result<(), String> {
        let mut in_line = 0;
        for (index, fluent) in self.fluents.iter() {
            for &input in &fluent.inputs {
                let input = self.fluents.get(input);
                ensure(input.is_some_and(|input| input.dependents.contains(&index)), || {
                    format!("fluent {index} is no dependent of its input")
                })?;
            }
            for &dependent in fluent.dependents.iter() {
                let dependent = self.fluents.get(dependent);
                ensure(dependent.is_some_and(|dependent| dependent.inputs.contains(&index)), || {
                    format!("fluent {index} is no input of its dependent")
                })?;
            }
            for waiter in fluent.waiters.tasks(&self.tasks) {
                in_line += 1;
                let waits =
                    matches!(self.tasks[waiter].waiting(), Some(Waiting::Fluent { fluent, .. }) if fluent == index);
                ensure(waits, || format!("task {waiter} is a waiter of fluent {index} and does not wait for it"))?;
            }
            ensure(!fluent.is_pulsed && !fluent.is_changed, || format!("fluent {index} is pulsed at rest"))?;
        }
        let waiting =
            self.tasks.iter().filter(|(_, task)| matches!(task.waiting(), Some(Waiting::Fluent { .. }))).count();
        ensure(in_line == waiting, || format!("{waiting} tasks wait for fluents, and {in_line} stand in their lines"))
    }

    fn check_watches(&self) -> Result<(), String> {
        for (index, watch) in self.watches.iter() {
            let task = self.tasks.get(watch.task).filter(|task| !task.state().is_dead());
            let has_scope = |task: &Task| task.scopes.iter().any(|scope| scope.kind == ScopeKind::Watch(index));
            ensure(task.is_some_and(has_scope), || format!("watch {index} belongs to no task"))?;
            let fluent = self.fluents.get(watch.fluent);
            ensure(fluent.is_some_and(|fluent| fluent.watches.contains(&(watch.number, index))), || {
                format!("watch {index} is not known to its fluent")
            })?;
        }
        Ok(())
    }

    fn check_valves(&self) -> Result<(), String> {
        let mut claims = 0;
        let mut links = BTreeMap::new();
        for (number, valve) in self.valves.iter().enumerate() {
            self.check_line(number as u32, valve).map_err(|what| self.about_valve(valve, &what))?;
        }
        for (number, place) in self.places.iter().enumerate() {
            let valve = self.valve_at(number as u32);
            self.check_place(number as u32, valve, place).map_err(|what| self.about_valve(valve, &what))?;
            for link in &place.links {
                let is_hold = matches!(link.kind, LinkKind::Hold { .. });
                *links.entry((link.task.index, number as u32, is_hold)).or_insert(0) += 1;
            }
            claims += u32::from(place.claim.is_some());
        }
        ensure(claims == self.claims, || format!("{claims} places are claimed, and {} are counted", self.claims))?;
        let mut known = BTreeMap::new();
        for (index, task) in self.tasks.iter() {
            let Some(rare) = &task.rare else { continue };
            rare.held.iter().for_each(|&place| *known.entry((index, place, true)).or_insert(0) += 1);
            rare.marked.iter().for_each(|&place| *known.entry((index, place, false)).or_insert(0) += 1);
            let me = self.tasks.reference(index);
            let has_claim = |&place: &u32| self.places[place as usize].claim.is_some_and(|claim| claim.root == me);
            ensure(rare.claimed.iter().all(has_claim), || format!("task {index} is claimed for no valve"))?;
        }
        ensure(links == known, || format!("valves have the links {links:?}, and tasks know of {known:?}"))
    }

    fn about_valve(&self, valve: &Valve, what: &str) -> String {
        format!("`{}`: {what}", self.symbols.name(valve.name))
    }

    fn check_place(&self, number: u32, valve: &Valve, place: &Place) -> Result<(), String> {
        ensure(valve.places().contains(&number), || "a place is none of its own".into())?;
        let mut before = OPEN_LINE;
        for link in &place.links {
            let task = self.tasks.find_alive(link.task).map(|task| &self.tasks[task]);
            ensure(task.is_some(), || "a dead task has a link of it".into())?;
            let holds = task.and_then(|task| task.rare.as_ref()).map_or(0, |rare| rare.holds);
            ensure(link.kind != LinkKind::Mark || holds > 0, || "it has interrupted a task that runs on".into())?;
            ensure(before < link.number && link.number <= valve.last_link, || "its links have wrong numbers".into())?;
            before = link.number;
        }
        if let Some(claim) = place.claim {
            let root = self.tasks.find_alive(claim.root).and_then(|root| self.tasks[root].rare.as_ref());
            ensure(root.is_some_and(|root| root.claimed.contains(&number)), || "nobody knows of its claim".into())?;
        }
        let has_waiting = valve.open().is_some() || valve.places > 1 && self.first_interrupted(place.valve).is_some();
        let is_open = place.links.is_empty() && has_waiting || place.links.last().is_some_and(Link::is_mark);
        ensure(!is_open || place.handover.is_some(), || "it is free and somebody waits for it".into())
    }

    /// The lines are those that follow from who waits.
    fn check_line(&self, number: u32, valve: &Valve) -> Result<(), String> {
        let mut line = ValveLine::default();
        let mut lines: BTreeMap<u64, Below> = BTreeMap::new();
        for (&task, waiter) in &valve.waiters {
            let record = self.tasks.get_alive(task);
            let waits = record.is_some_and(|record| record.waiting() == Some(Waiting::Valve(number)));
            ensure(waits, || "a task stands in line that does not wait for it".into())?;
            let Some(name) = waiter.line else { continue };
            ensure(waiter.turn.priority == self.effective_priority(task), || {
                "a task waits with another priority than its own".into()
            })?;
            line.enter(&self.priorities, waiter.turn, task);
            let (line_above, link) = self.line_above(task, number);
            ensure(name == line_above, || "a task stands in a wrong line".into())?;
            let below = lines.entry(name).or_insert_with(|| Below { link, line: ValveLine::default() });
            below.line.enter(&self.priorities, waiter.turn, task);
        }
        ensure(line == valve.line && lines == valve.lines, || "its lines are not those who wait".into())
    }
}
