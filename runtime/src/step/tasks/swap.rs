//! Revision: a task is given another plan while it runs.
//!
//! It leaves the plan it runs like one that is evaporated, clean-ups included, and then begins the new one
//! with the same record: its parent, its path, its fluents and those who wait for it notice nothing.
//!
//! While a departure, a clean-up, a hook or `no-revision` is in the way, the new plan waits in the record.

use crate::state::failure::Raise;
use crate::state::machine::Machine;
use crate::state::slab::NONE;
use crate::state::stack::Stack;
use crate::state::task::{Frame, Leaving, ScopeKind, State, Swap, Task, Then, Waiting, Wake};
use crate::state::value::{TaskRef, Value};
use crate::state::valve_place::{HoldPurpose, LinkKind};
use crate::step::native::{Reply, Surroundings};
use crate::step::tasks::unwind::Unwound;
use rpl_lang::code::{Op, Program};
use std::collections::BTreeSet;

impl Machine {
    /// `(swap-plan TASK PLAN)` by the current task: t when the task has begun the plan, nil if it is to be
    /// asked again, because the task has ended before or somebody else gave it a plan.
    ///
    /// # Errors
    /// The task has ended or is about to; it has no plan that could be taken from it; a task that swaps its
    /// own plan or that of a task above has something else to do; a kept valve is not there.
    pub(crate) fn swap_plan(
        &mut self,
        around: &mut Surroundings<'_>,
        task: TaskRef,
        code: u32,
        kept: Vec<u32>,
    ) -> Result<Reply, Raise> {
        let index = self.revisable_task(around, task)?;
        let current = self.current;
        let is_own = self.is_within(current, index);
        if is_own {
            self.check_own_swap(around.program, index)?;
        }
        let by = Some(self.tasks.reference(current));
        let swap = Swap { code, kept, by, in_the_way: self.in_the_way_of(index) };
        if self.has_swap(index) {
            return self.wait_to_revise(around, index, is_own);
        }
        if !swap.in_the_way.is_empty() {
            self.wait_for_plan(around, index, is_own)?;
            self.tasks[index].rare().swap_pending = Some(Box::new(swap));
            self.swaps_pending += 1;
            return Ok(Reply::Wait);
        }
        self.begin_swap(around, index, swap)?;
        if is_own {
            return Ok(Reply::Leave);
        }
        match self.tasks.find_alive(task) {
            None => Ok(Reply::Value(Value::Nil)),
            // Among equals the task begins its plan before who gave it goes on.
            Some(_) if !self.tasks[index].is_leaving() => {
                self.give_way(Value::True);
                Ok(Reply::Wait)
            }
            Some(_) => {
                self.wait_for_plan(around, index, false)?;
                Ok(Reply::Wait)
            }
        }
    }

    /// The same by nobody in the run. What cannot be is not done.
    pub(crate) fn revise(&mut self, around: &mut Surroundings<'_>, task: TaskRef, code: u32) {
        let Ok(task) = self.revisable_task(around, task) else { return };
        if !self.has_swap(task) {
            self.tasks[task].rare().swap_pending =
                Some(Box::new(Swap { code, kept: Vec::new(), by: None, in_the_way: BTreeSet::new() }));
            self.swaps_pending += 1;
            self.take_up_swaps(around, task);
        }
    }

    /// Lets the current task wait until another has begun the plan it gives to it.
    fn wait_for_plan(&mut self, around: &Surroundings<'_>, task: u32, is_own: bool) -> Result<(), Raise> {
        let current = self.current;
        if !is_own {
            self.check_circle(around.program, current, Waiting::Swap(task))?;
        }
        self.join_line(current, task, |rare| &mut rare.mourners);
        self.tasks[current].wait(Waiting::Swap(task));
        Ok(())
    }

    fn has_swap(&self, task: u32) -> bool {
        self.tasks[task].rare.as_ref().is_some_and(|rare| rare.swap_pending.is_some())
    }

    /// Who wanted to give a task a plan waits for that no more.
    pub(crate) fn forget_swap(&mut self, task: u32, by: u32) {
        let by = self.tasks.reference(by);
        let is_own = |swap: &Swap| swap.by == Some(by);
        if self.tasks[task].rare.as_ref().and_then(|rare| rare.swap_pending.as_deref()).is_some_and(is_own) {
            self.swaps_pending -= 1;
            self.tasks[task].take_swap();
        }
    }

    /// Something has ended in a task that may have kept it, or a task above it, from being given the plan
    /// that somebody wants to give to it.
    pub(crate) fn take_up_swaps(&mut self, around: &mut Surroundings<'_>, task: u32) {
        let mut at = task;
        while self.swaps_pending > 0 && at != NONE {
            if self.has_swap(at) && !self.will_end(around, at) && self.is_way_clear(at) {
                self.take_up_swap(around, at);
            }
            at = self.tasks[at].parent;
        }
    }

    fn take_up_swap(&mut self, around: &mut Surroundings<'_>, task: u32) {
        let Some(swap) = self.tasks[task].take_swap() else { return };
        self.swaps_pending -= 1;
        let by = swap.by.and_then(|by| self.tasks.find_alive(by));
        // Who asks for what cannot be any more asks once more, and is told.
        if self.begin_swap(around, task, *swap).is_err()
            && let Some(by) = by
        {
            self.wake(by, Wake::Value(Value::Nil));
        }
    }

    /// The task of a name, if it has a plan that can be swapped, now or later.
    fn revisable_task(&self, around: &Surroundings<'_>, task: TaskRef) -> Result<u32, Raise> {
        let refused = |message: String| Err(Raise::new("control-error", message));
        let Some(index) = self.tasks.find_alive(task) else {
            // What was around it may be forgotten already.
            let name = self.tasks.find(task).map_or("it", |index| self.symbols.name(self.tasks[index].name));
            return refused(format!("the task `{name}` has ended: no other plan can be put in place of its own"));
        };
        let path = self.path(index);
        if index == self.main {
            return refused(
                "main cannot be given another plan; name the part that may be revised by `(:tag NAME FORM...)`".into(),
            );
        }
        if self.tasks[index].named_as_hook() {
            return refused(format!("{path} runs hooks of a valve, and cannot be given another plan"));
        }
        if self.tasks[index].state() == State::Created && self.tasks[index].parent == NONE {
            return refused(format!(
                "{path} is a tag that was not reached yet: the plan around it would begin its own text there"
            ));
        }
        if self.will_end(around, index) {
            return refused(format!("{path} is on its way out: no other plan can be put in place of its own"));
        }
        Ok(index)
    }

    /// Whether a task is about to die, whatever comes.
    fn will_end(&self, around: &Surroundings<'_>, task: u32) -> bool {
        let record = &self.tasks[task];
        let is_cut_short = |(_, then): (usize, &Then)| matches!(then, Then::Leave(Leaving::Evaporate));
        record.is_evaporation_pending()
            || record.leaving() == Some(&Leaving::Evaporate)
            || record.scopes.clean_ups().any(is_cut_short)
            || self.fixed_failure(around, task).is_some()
    }

    /// Whether the current task may swap its own plan, or that of a task above: it must have nothing else
    /// to do, and no clean-up, hook or fence, which would have to end first, may be around it.
    fn check_own_swap(&self, program: &Program, root: u32) -> Result<(), Raise> {
        let current = self.current;
        let mut at = current;
        loop {
            let record = &self.tasks[at];
            let is_in_the_way = record.is_protected() || record.named_as_hook() || is_fenced(record);
            if is_in_the_way {
                let (path, around) = (self.path(current), self.path(at));
                return Err(Raise::new(
                    "control-error",
                    format!(
                        "{path} would wait for itself: a clean-up, a hook or `no-revision` of {around} is around it"
                    ),
                ));
            }
            if at == root {
                break;
            }
            at = record.parent;
        }
        let returns = |frame: &Frame| {
            let ops = &program.codes[frame.code as usize].ops;
            matches!(ops.get(frame.pc as usize), Some(Op::Return(_)))
        };
        if !self.tasks[current].scopes.is_empty() || !self.scratch.frames.iter().all(returns) {
            let path = self.path(current);
            return Err(Raise::new(
                "control-error",
                format!(
                    "{path} swaps its own plan or that of a task around it, and has more to do then, which would never \
                     run; let `swap-plan` be the last form of the task, outside of plans, loops and valves"
                ),
            ));
        }
        Ok(())
    }

    /// Whether a departure, clean-up, hook or fence is under way in a task itself.
    fn is_in_the_way(&self, task: u32) -> bool {
        let record = &self.tasks[task];
        let is_in_the_way = record.is_protected() || record.named_as_hook() || is_fenced(record);
        is_in_the_way && !record.state().is_dead()
    }

    /// The tasks at and below one that keep it from being given another plan. Cost: all tasks there.
    fn in_the_way_of(&mut self, root: u32) -> BTreeSet<TaskRef> {
        let (mut found, mut waiting) = (BTreeSet::new(), vec![root]);
        while let Some(task) = waiting.pop() {
            self.scratch.work += 1;
            if self.is_in_the_way(task) {
                found.insert(self.tasks.reference(task));
            }
            waiting.extend(self.children(task));
        }
        found
    }

    /// Whether nothing keeps a task any more from the plan it is to be given. Cost: what has ended since the last
    /// time; all tasks below only once nothing that is known is in the way.
    fn is_way_clear(&mut self, root: u32) -> bool {
        let Some(mut swap) = self.tasks[root].take_swap() else { return false };
        while let Some(&task) = swap.in_the_way.last()
            && self.tasks.find_alive(task).is_none_or(|task| !self.is_in_the_way(task))
        {
            swap.in_the_way.pop_last();
            self.scratch.work += 1;
        }
        if swap.in_the_way.is_empty() {
            swap.in_the_way = self.in_the_way_of(root);
        }
        let is_clear = swap.in_the_way.is_empty();
        self.tasks[root].rare().swap_pending = Some(swap);
        is_clear
    }

    /// A task has begun something that keeps it and those above it from being given other plans.
    pub(crate) fn note_in_the_way(&mut self, task: u32) {
        let reference = self.tasks.reference(task);
        let mut at = task;
        while self.swaps_pending > 0 && at != NONE {
            if let Some(swap) = self.tasks[at].rare.as_mut().and_then(|rare| rare.swap_pending.as_mut()) {
                swap.in_the_way.insert(reference);
            }
            self.scratch.work += 1;
            at = self.tasks[at].parent;
        }
    }

    /// Lets the current task wait until another has been given the plan that somebody else has for it.
    fn wait_to_revise(&mut self, around: &Surroundings<'_>, task: u32, is_own: bool) -> Result<Reply, Raise> {
        let current = self.current;
        if !is_own {
            self.check_circle(around.program, current, Waiting::Rest(task))?;
        }
        self.join_line(current, task, |rare| &mut rare.resters);
        self.tasks[current].wait(Waiting::Rest(task));
        self.waits_for_rest += 1;
        Ok(Reply::Wait)
    }

    /// A task takes the valves over that it or a task below it holds and that are to be kept; gives those
    /// that it has to give back if the new plan does not.
    fn keep_valves(&mut self, task: u32, valves: Vec<u32>) -> Result<Vec<u32>, Raise> {
        let valves: BTreeSet<u32> = valves.into_iter().collect();
        let is_there = |valve: u32| self.holds_valve(task, valve) || self.place_had_below(task, valve).is_some();
        if let Some(&valve) = valves.iter().find(|&&valve| !is_there(valve)) {
            let (path, name) = (self.path(task), self.valve_name(valve));
            return Err(Raise::new(
                "valve-error",
                format!("neither {path} nor a task below it holds the valve `{name}` now, so it cannot be kept"),
            ));
        }
        let place_of = |&valve: &u32| Some((valve, self.place_had_below(task, valve)?));
        let (taken, places): (Vec<u32>, Vec<u32>) = valves.iter().filter_map(place_of).unzip();
        places.into_iter().for_each(|place| self.take(task, place, HoldPurpose::Plan));
        Ok(taken)
    }

    /// The place of a valve that a task has now, itself or by lending it, or else the first that one below it has.
    fn place_had_below(&self, task: u32, valve: u32) -> Option<u32> {
        let is_had = |&place: &u32| {
            let top = self.places[place as usize].links.last().filter(|link| link.is_hold());
            top.and_then(|hold| self.tasks.find(hold.task)).is_some_and(|holder| self.is_within(holder, task))
        };
        let own = self.place_taken_by(task, valve);
        own.filter(is_had).or_else(|| self.valves[valve as usize].places().find(is_had))
    }

    /// A task that may be revised begins to leave its plan for another. One that has not started starts
    /// with the other.
    ///
    /// # Errors
    /// A valve to be kept is not there.
    pub(crate) fn begin_swap(&mut self, around: &mut Surroundings<'_>, task: u32, mut swap: Swap) -> Result<(), Raise> {
        swap.kept = self.keep_valves(task, swap.kept)?;
        if self.tasks[task].state() == State::Created {
            self.trace_swapped(around.program, task, &swap);
            self.put_at_start(task, swap.code);
        } else {
            self.depart(around, task, Leaving::Swap(Box::new(swap)));
        }
        Ok(())
    }

    /// No scope is left: the task begins the plan it was given.
    pub(crate) fn begin_plan(&mut self, around: &mut Surroundings<'_>, task: u32, swap: &Swap) -> Unwound {
        self.as_one(around, |machine, around| {
            machine.tasks[task].take_leaving();
            machine.tasks[task].set_wake(Wake::Nothing);
            machine.trace_swapped(around.program, task, swap);
            machine.end_activations_of(around, task);
            machine.give_back_valves(around, task, &swap.kept);
            machine.put_at_start(task, swap.code);
        });
        // Whoever has become ready meanwhile and is more important goes first.
        self.scratch.switch = true;
        Unwound::Swapped { by: swap.by }
    }

    /// Lets who gave a task its plan go on. Among equals the task comes first, which is ready by now.
    pub(crate) fn tell_swapped(&mut self, by: Option<TaskRef>, task: u32) {
        let by = by.and_then(|by| self.tasks.find_alive(by));
        if let Some(by) = by.filter(|&by| self.tasks[by].waiting() == Some(Waiting::Swap(task))) {
            self.wake(by, Wake::Value(Value::True));
        }
    }

    /// A task goes on at the first instruction of a code, and knows no other.
    fn put_at_start(&mut self, task: u32, code: u32) {
        let record = &mut self.tasks[task];
        record.frame = Frame { code, pc: 0, base: 0 };
        record.frames = Stack::default();
        self.tasks.set_registers(task, &[]);
    }

    /// A task that has left its plan gives back what it had requested, but for one hold of each kept valve.
    fn give_back_valves(&mut self, around: &mut Surroundings<'_>, task: u32, kept: &[u32]) {
        let me = self.tasks.reference(task);
        let held: BTreeSet<u32> = self.tasks[task].held().iter().copied().collect();
        for place in held {
            let valve = self.valve_of_place(place);
            let links = &mut self.places[place as usize].links;
            let mut own: Vec<usize> = (0..links.len())
                .rev()
                .filter(|&at| links[at].task == me && links[at].serves(HoldPurpose::Plan))
                .collect();
            if kept.contains(&valve)
                && !own.is_empty()
                && let LinkKind::Hold { count, .. } = &mut links[own.remove(0)].kind
            {
                *count = 1;
            }
            own.into_iter().for_each(|at| self.remove_link(place, at));
            self.stir(around, valve);
        }
    }
}

/// Whether a task is inside `no-revision`.
fn is_fenced(task: &Task) -> bool {
    task.scopes.iter().any(|scope| scope.kind == ScopeKind::Fence)
}
