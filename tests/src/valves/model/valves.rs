//! Who has a valve, who may take it, and to whom it goes.

use super::tasks::is_higher;
use super::{Fact, Frame, Id, Life, Model, On, What};

impl Model<'_> {
    pub(super) fn holder(&self, valve: usize) -> Option<Id> {
        self.valves[valve].facts.iter().rev().find_map(|fact| match fact {
            Fact::Has(task, _) => Some(*task),
            Fact::TakenAway(_) => None,
        })
    }

    /// The interrupted subtrees above the latest hold, the latest last.
    pub(super) fn interrupted(&self, valve: usize) -> Vec<Id> {
        let facts = &self.valves[valve].facts;
        let from = facts.iter().rposition(|fact| matches!(fact, Fact::Has(..))).map_or(0, |at| at + 1);
        let roots = facts[from..].iter();
        roots.filter_map(|fact| if let Fact::TakenAway(root) = fact { Some(*root) } else { None }).collect()
    }

    fn has_hold(&self, task: Id, valve: usize) -> bool {
        self.valves[valve].facts.iter().any(|fact| matches!(fact, Fact::Has(holder, _) if *holder == task))
    }

    /// What is suspended when `task` takes the valve from `holder`.
    fn to_interrupt(&self, task: Id, holder: Id, valve: usize) -> Option<Id> {
        if self.is_within(task, holder) {
            return None;
        }
        let (mine, theirs) = (self.above(task), self.above(holder));
        if theirs.iter().any(|&above| mine.contains(&above) && self.has_hold(above, valve)) {
            // From inside: the branch below the nearest common ancestor.
            return theirs.into_iter().take_while(|above| !mine.contains(above)).last();
        }
        theirs.into_iter().rfind(|&above| self.has_hold(above, valve))
    }

    fn rests(&self, root: Id) -> bool {
        !self.subtree(root).into_iter().any(|task| self.is_protected(task))
    }

    /// Whether a task that asks could have the valve now: what must be suspended for that, and
    /// whether a clean-up keeps it from being so.
    fn could_take(&self, task: Id, valve: usize) -> Option<(Option<Id>, bool)> {
        self.could_take_from(task, valve, |holder| &self.tasks[holder].runs_at)
    }

    /// What keeps a task waiting that could have the valve but for a clean-up. What that clean-up runs at
    /// because of the task does not count against it.
    fn is_kept_by(&self, task: Id, valve: usize) -> Option<Id> {
        match self.could_take_from(task, valve, |holder| &self.tasks[holder].priority) {
            Some((root, true)) => root,
            Some((_, false)) | None => None,
        }
    }

    fn could_take_from<'m>(
        &'m self,
        task: Id,
        valve: usize,
        holds_at: impl Fn(Id) -> &'m [i64],
    ) -> Option<(Option<Id>, bool)> {
        let interrupted = self.interrupted(valve);
        let runs_at = |task: Id| self.tasks[task].runs_at.as_slice();
        let Some(holder) = self.holder(valve) else {
            let is_first = interrupted.last().is_none_or(|&root| is_higher(runs_at(task), runs_at(root)));
            return is_first.then_some((None, false));
        };
        if interrupted.is_empty() && self.is_within(task, holder) {
            return Some((None, false));
        }
        if !is_higher(runs_at(task), holds_at(holder)) {
            return None;
        }
        let root = self.to_interrupt(task, holder, valve);
        let root = root.filter(|&root| !interrupted.iter().any(|&done| self.is_within(root, done)));
        Some((root, root.is_some_and(|root| !self.rests(root))))
    }

    /// Those who ask and are not suspended, the first to be served first.
    fn line(&self, valve: usize) -> Vec<Id> {
        let mut line: Vec<Id> = self.valves[valve].asked.clone();
        line.retain(|&task| !self.is_held(task));
        let mut sorted: Vec<Id> = Vec::new();
        for task in line {
            let behind =
                sorted.iter().position(|&other| is_higher(&self.tasks[task].runs_at, &self.tasks[other].runs_at));
            sorted.insert(behind.unwrap_or(sorted.len()), task);
        }
        sorted
    }

    pub(super) fn grant(&mut self, task: Id, valve: usize, root: Option<Id>) {
        if let Some(root) = root {
            self.tell(root, What::Taken(valve));
            self.change_stops(root, |task| task.stops += 1);
            self.valves[valve].facts.push(Fact::TakenAway(root));
        }
        self.valves[valve].asked.retain(|&other| other != task);
        match self.valves[valve].facts.last_mut() {
            Some(Fact::Has(holder, times)) if *holder == task => *times += 1,
            _ => {
                self.valves[valve].facts.push(Fact::Has(task, 1));
                self.tell(task, What::Granted(valve));
            }
        }
        // The body it is for stands on top already.
        let body = self.tasks[task].frames.len() - 1;
        self.tasks[task].frames.insert(body, Frame::Holds(valve));
        if self.running != Some(task) && self.tasks[task].life == Life::Blocked(On::Valve(valve)) {
            self.queue(task);
        }
    }

    fn give_back(&mut self, valve: usize) {
        let Some(Fact::TakenAway(root)) = self.valves[valve].facts.pop() else { return };
        self.tell(root, What::Returned(valve));
        // Who asks in a subtree that is suspended cleans up.
        let heir = self.line(valve).into_iter().find(|&task| self.is_within(task, root));
        self.change_stops(root, |task| task.stops -= 1);
        let is_there = self.holder(valve).is_some_and(|holder| self.is_within(holder, root));
        if let (Some(heir), false) = (heir, is_there)
            && let Some((root, false)) = self.could_take(heir, valve)
        {
            self.grant(heir, valve, root);
        }
    }

    pub(super) fn serve(&mut self) {
        if self.decisions > 0 || self.serving {
            return;
        }
        self.serving = true;
        'again: loop {
            self.refresh_priorities();
            for valve in 0..self.valves.len() {
                let open = self.line(valve).into_iter().find_map(|task| match self.could_take(task, valve) {
                    Some((root, false)) => Some((task, root)),
                    Some((_, true)) | None => None,
                });
                if let Some((task, root)) = open {
                    self.grant(task, valve, root);
                    continue 'again;
                }
                if matches!(self.valves[valve].facts.last(), Some(Fact::TakenAway(_))) {
                    self.give_back(valve);
                    continue 'again;
                }
            }
            break;
        }
        self.serving = false;
    }

    /// A clean-up runs at the priority of the first whom it keeps waiting.
    pub(super) fn refresh_priorities(&mut self) {
        for _ in 0..self.tasks.len() + 1 {
            let mut due: Vec<Vec<i64>> = self.tasks.iter().map(|task| task.priority.clone()).collect();
            for valve in 0..self.valves.len() {
                let blocked = self.line(valve).into_iter().find_map(|task| Some((task, self.is_kept_by(task, valve)?)));
                let Some((first, root)) = blocked else { continue };
                let runs_at = self.tasks[first].runs_at.clone();
                for task in self.subtree(root) {
                    let path: Vec<Id> = self.above(task).into_iter().take_while(|&above| above != root).collect();
                    let cleans_up = self.is_protected(task) || path.iter().any(|&above| self.tasks[above].in_clean_up);
                    if cleans_up && is_higher(&runs_at, &due[task]) {
                        due[task].clone_from(&runs_at);
                    }
                }
            }
            let mut is_same = true;
            for task in self.subtree(0) {
                let is_equal = !is_higher(&due[task], &self.tasks[task].runs_at)
                    && !is_higher(&self.tasks[task].runs_at, &due[task]);
                if !is_equal {
                    is_same = false;
                    self.tasks[task].runs_at = std::mem::take(&mut due[task]);
                    if self.tasks[task].life == Life::Ready && !self.is_held(task) && self.running != Some(task) {
                        self.queue(task);
                    }
                }
            }
            if is_same {
                return;
            }
        }
    }

    pub(super) fn release(&mut self, task: Id, valve: usize) {
        let facts = &mut self.valves[valve].facts;
        let at = facts.iter().rposition(|fact| matches!(fact, Fact::Has(holder, _) if *holder == task));
        let Some(at) = at else { return };
        if let Fact::Has(_, times) = &mut facts[at] {
            *times -= 1;
            if *times > 0 {
                return;
            }
        }
        facts.remove(at);
        self.tell(task, What::Released(valve));
        self.serve();
    }
}
