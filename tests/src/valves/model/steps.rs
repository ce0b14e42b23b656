//! One step after the other, and what happens from outside in between.

use super::tasks::{is_higher, longer};
use super::{Blow, Exit, Frame, Id, Life, Model, On, What};
use crate::valves::program::Act;

impl<'p> Model<'p> {
    /// Something happens from outside.
    pub fn strike(&mut self, blow: Blow) {
        match blow {
            Blow::Evaporate(task) if self.lives(task) => self.as_one(|model| model.evaporate(task)),
            Blow::Suspend(task) if self.lives(task) => self.change_stops(task, |task| task.own_stops += 1),
            Blow::Resume(task) if self.lives(task) && self.tasks[task].own_stops > 0 => {
                self.change_stops(task, |task| task.own_stops -= 1);
            }
            Blow::Fail(task) if self.lives(task) && self.tasks[task].life == Life::Blocked(On::Time) => {
                self.timers.retain(|&(_, other)| other != task);
                self.tasks[task].raises = Some(false);
                self.queue(task);
            }
            Blow::Evaporate(_) | Blow::Suspend(_) | Blow::Resume(_) | Blow::Fail(_) => {}
        }
    }

    /// Runs one ready task until it blocks, ends or gives way; without one, goes to the next timer.
    /// Tells whether anything was left to do.
    pub fn step(&mut self) -> bool {
        if let Some(task) = self.next_ready() {
            self.run(task);
            return true;
        }
        let Some(&(next, _)) = self.timers.iter().min_by_key(|&&(time, _)| time) else { return false };
        self.now = next;
        let (due, later): (Vec<_>, Vec<_>) = self.timers.iter().partition(|&&(time, _)| time == next);
        self.timers = later;
        due.into_iter().for_each(|(_, task)| self.queue(task));
        true
    }

    fn run(&mut self, task: Id) {
        self.running = Some(task);
        self.tasks[task].begun = true;
        if let Some(_failure) = self.tasks[task].raises.take() {
            self.tasks[task].leaving = Some(Exit::Fail);
        }
        loop {
            if self.tasks[task].life == Life::Dead {
                break;
            }
            if self.tasks[task].leaving.is_some() {
                if !self.unwind(task) {
                    break;
                }
                let Some(Frame::Protect(clean_up)) = self.tasks[task].frames.pop() else { break };
                let exit = self.tasks[task].leaving.take();
                self.tasks[task].frames.push(Frame::CleansUp(exit));
                self.tasks[task].frames.push(Frame::Acts(clean_up));
                continue;
            }
            if self.goes_on(task) {
                continue;
            }
            break;
        }
        self.running = None;
    }

    /// Whether a more important task is ready, or this one suspended: it keeps its place at the front.
    fn gives_way(&mut self, task: Id) -> bool {
        let is_later = |other: Id| is_higher(&self.tasks[other].runs_at, &self.tasks[task].runs_at);
        if !self.is_held(task) && !self.next_ready().is_some_and(is_later) {
            return false;
        }
        let front = self.tasks.iter().map(|task| task.turn).min().unwrap_or(0) - 1;
        self.tasks[task].turn = front;
        true
    }

    /// One act; tells whether the task runs on.
    fn goes_on(&mut self, task: Id) -> bool {
        match self.tasks[task].frames.last_mut() {
            None => {
                self.die(task, What::Succeeded);
                false
            }
            Some(Frame::Acts(acts)) => match acts.split_first() {
                None => {
                    self.tasks[task].frames.pop();
                    true
                }
                Some((act, rest)) => {
                    *acts = rest;
                    self.act(task, act)
                }
            },
            Some(&mut Frame::Holds(valve)) => {
                self.tasks[task].frames.pop();
                self.release(task, valve);
                !self.gives_way(task)
            }
            Some(&mut Frame::Protect(clean_up)) => {
                self.tasks[task].frames.pop();
                self.tasks[task].frames.push(Frame::CleansUp(None));
                self.tasks[task].frames.push(Frame::Acts(clean_up));
                self.refresh_priorities();
                true
            }
            Some(&mut Frame::CleansUp(then)) => {
                self.tasks[task].frames.pop();
                if let Some(exit) = then {
                    self.tasks[task].leaving = Some(exit);
                    return true;
                }
                if self.tasks[task].wanted_dead && !self.cleans_up(task) {
                    self.tasks[task].leaving = Some(Exit::Evaporate);
                    return true;
                }
                self.serve();
                !self.gives_way(task)
            }
            Some(Frame::Children { .. }) => unreachable!("a construct takes its own frame away"),
        }
    }

    fn act(&mut self, task: Id, act: &'p Act) -> bool {
        match act {
            Act::Wait(time) => {
                self.timers.push((self.now + time, task));
                self.tasks[task].life = Life::Blocked(On::Time);
                false
            }
            Act::With(valve, acts) => {
                // What follows stands above the hold.
                self.ask(task, *valve, acts)
            }
            Act::Children(rule, children) => {
                self.tasks[task].frames.push(Frame::Children { rule: *rule, alive: children.len(), decided: None });
                let in_clean_up = self.cleans_up(task);
                let priority = self.tasks[task].priority.clone();
                self.tasks[task].life = Life::Blocked(On::Children);
                for child in children {
                    let priority = child.priority.map_or_else(|| priority.clone(), |number| longer(&priority, number));
                    self.begin(Some(task), in_clean_up, priority, &child.acts);
                }
                false
            }
            Act::Protect(acts, clean_up) => {
                self.tasks[task].frames.push(Frame::Protect(clean_up));
                self.tasks[task].frames.push(Frame::Acts(acts));
                true
            }
            Act::Fail => {
                self.tasks[task].leaving = Some(Exit::Fail);
                true
            }
        }
    }

    fn ask(&mut self, task: Id, valve: usize, acts: &'p [Act]) -> bool {
        // The body stands below the hold until it is there.
        self.tasks[task].frames.push(Frame::Acts(acts));
        self.tasks[task].life = Life::Blocked(On::Valve(valve));
        if let Some(place) = self.place_at_once(task, valve) {
            self.grant(task, valve, (place, None));
        } else {
            self.valves[valve].asked.push(task);
            self.serve();
        }
        let has_it = !self.valves[valve].asked.contains(&task);
        if has_it {
            self.tasks[task].life = Life::Ready;
            return !self.gives_way(task);
        }
        false
    }
}
