//! Who has a valve, who may take it, and to whom it goes.

use super::tasks::is_higher;
use super::{Fact, Frame, Id, Life, Model, On, Place, What};
use std::cmp::Ordering;

/// A place that a task could have, and the subtree that must be suspended for that.
type Taking = (usize, Option<Id>);

fn compare(one: &[i64], other: &[i64]) -> Ordering {
    is_higher(one, other).cmp(&is_higher(other, one))
}

impl Place {
    fn holder(&self) -> Option<Id> {
        self.facts.iter().rev().find_map(|fact| match fact {
            Fact::Has(task, _) => Some(*task),
            Fact::TakenAway(..) => None,
        })
    }

    /// The interrupted subtrees above the latest hold, the latest last.
    fn interrupted(&self) -> Vec<Id> {
        let from = self.facts.iter().rposition(|fact| matches!(fact, Fact::Has(..))).map_or(0, |at| at + 1);
        let roots = self.facts[from..].iter();
        roots.filter_map(|fact| if let Fact::TakenAway(root, _) = fact { Some(*root) } else { None }).collect()
    }

    fn has_hold(&self, task: Id) -> bool {
        self.facts.iter().any(|fact| matches!(fact, Fact::Has(holder, _) if *holder == task))
    }

    fn is_about(&self, task: Id) -> bool {
        self.facts.iter().any(|fact| matches!(*fact, Fact::Has(other, _) | Fact::TakenAway(other, _) if other == task))
    }
}

impl Model<'_> {
    /// The outermost of a task and those above it that holds a place.
    fn owner(&self, task: Id, place: &Place) -> Option<Id> {
        self.above(task).into_iter().rfind(|&above| place.has_hold(above))
    }

    /// Whether a task above this one holds the place.
    fn is_lent_to(&self, task: Id, place: &Place) -> bool {
        self.tasks[task].parent.is_some_and(|parent| self.owner(parent, place).is_some())
    }

    /// The place a task has to do with: its own, or that of the nearest task above.
    fn own_place(&self, task: Id, valve: usize) -> Option<usize> {
        let places = &self.valves[valve].places;
        match places.len() {
            1 => Some(0),
            _ => self.above(task).into_iter().find_map(|above| places.iter().position(|place| place.is_about(above))),
        }
    }

    /// The place that a request gets without asking anybody.
    pub(super) fn place_at_once(&self, task: Id, valve: usize) -> Option<usize> {
        let places = &self.valves[valve].places;
        let own = self.own_place(task, valve);
        let is_had = |at: usize| {
            let has_it = places[at].holder().is_some_and(|holder| self.is_within(task, holder));
            places[at].interrupted().is_empty() && has_it
        };
        own.filter(|&at| is_had(at)).or_else(|| {
            let is_for_it = |&at: &usize| places[at].facts.is_empty() && (own.is_none() || own == Some(at));
            (0..places.len()).find(is_for_it)
        })
    }

    /// Whether nobody could use a place but those it was taken away from.
    fn is_free(&self, place: &Place) -> bool {
        let Some(holder) = place.holder() else { return true };
        let owner = self.owner(holder, place).unwrap_or(holder);
        place.interrupted().into_iter().any(|root| self.is_within(owner, root))
    }

    fn free_place(&self, valve: usize) -> Option<usize> {
        let places = &self.valves[valve].places;
        let free: Vec<usize> = (0..places.len()).filter(|&at| self.is_free(&places[at])).collect();
        free.iter().copied().find(|&at| places[at].facts.is_empty()).or(free.first().copied())
    }

    /// The owners that wait because their place was taken away: place, index of the fact, and whose priority counts.
    fn interrupted_owners(&self, valve: usize) -> Vec<(usize, usize, Id)> {
        let mut found = Vec::new();
        for (at, place) in self.valves[valve].places.iter().enumerate() {
            let (is_free, holder) = (self.is_free(place), place.holder());
            let waits = |fact: &Fact| match *fact {
                Fact::TakenAway(root, _) => {
                    let uses_it = !is_free && holder.is_some_and(|holder| self.is_within(holder, root));
                    !uses_it && !self.is_lent_to(root, place)
                }
                Fact::Has(..) => false,
            };
            let Some(index) = place.facts.iter().rposition(waits) else { continue };
            let Fact::TakenAway(root, _) = place.facts[index] else { continue };
            let had = place.facts[..index].iter().rev().find_map(|fact| match *fact {
                Fact::Has(task, _) => Some(task),
                Fact::TakenAway(..) => None,
            });
            found.push((at, index, had.filter(|&had| self.is_within(had, root)).unwrap_or(root)));
        }
        found
    }

    /// What is suspended when `task` takes the place from `holder`.
    fn to_interrupt(&self, task: Id, holder: Id, place: &Place) -> Option<Id> {
        if self.is_within(task, holder) {
            return None;
        }
        let (mine, theirs) = (self.above(task), self.above(holder));
        if theirs.iter().any(|&above| mine.contains(&above) && place.has_hold(above)) {
            // From inside: the branch below the nearest common ancestor.
            return theirs.into_iter().take_while(|above| !mine.contains(above)).last();
        }
        theirs.into_iter().rfind(|&above| place.has_hold(above))
    }

    fn rests(&self, root: Id) -> bool {
        !self.subtree(root).into_iter().any(|task| self.is_protected(task))
    }

    /// The places a task would take, the best first.
    fn wanted_places(&self, task: Id, valve: usize) -> Vec<usize> {
        if let Some(own) = self.own_place(task, valve) {
            return vec![own];
        }
        if let Some(free) = self.free_place(valve) {
            return vec![free];
        }
        let places = &self.valves[valve].places;
        let held_at = |at: usize| places[at].holder().map_or(&[][..], |holder| &self.tasks[holder].priority);
        let mut wanted: Vec<usize> = (0..places.len()).collect();
        wanted.sort_by(|&one, &other| {
            compare(held_at(one), held_at(other)).then(places[other].since.cmp(&places[one].since))
        });
        wanted
    }

    /// Whether a task that asks could have the valve now, and how.
    fn could_take(&self, task: Id, valve: usize) -> Option<Taking> {
        let runs_at = |task: Id| self.tasks[task].runs_at.as_slice();
        let is_first = |at: usize| {
            let others = self.interrupted_owners(valve).into_iter();
            others
                .filter(|other| other.0 != at || self.own_place(task, valve).is_none())
                .all(|(_, _, other)| is_higher(runs_at(task), runs_at(other)))
        };
        let has_more = self.valves[valve].places.len() > 1;
        self.wanted_places(task, valve).into_iter().find_map(|at| {
            let place = &self.valves[valve].places[at];
            if has_more && self.is_free(place) && self.own_place(task, valve).is_none() {
                return is_first(at).then_some((at, None));
            }
            match self.could_take_from(task, place, runs_at) {
                Some((None, false)) if has_more && self.is_free(place) && !is_first(at) => None,
                Some((root, false)) => Some((at, root)),
                Some((_, true)) | None => None,
            }
        })
    }

    /// What keeps a task waiting that could have a place but for a clean-up. What that clean-up runs at
    /// because of the task does not count against it.
    fn is_kept_by(&self, task: Id, valve: usize, at: usize) -> Option<Id> {
        if self.could_take(task, valve).is_some() || !self.wanted_places(task, valve).contains(&at) {
            return None;
        }
        let place = &self.valves[valve].places[at];
        if self.valves[valve].places.len() > 1 && self.is_free(place) {
            return None;
        }
        match self.could_take_from(task, place, |holder| &self.tasks[holder].priority) {
            Some((root, true)) => root,
            Some((_, false)) | None => None,
        }
    }

    fn could_take_from<'m>(
        &'m self,
        task: Id,
        place: &Place,
        holds_at: impl Fn(Id) -> &'m [i64],
    ) -> Option<(Option<Id>, bool)> {
        let interrupted = place.interrupted();
        let runs_at = |task: Id| self.tasks[task].runs_at.as_slice();
        let Some(holder) = place.holder() else {
            let is_first = interrupted.last().is_none_or(|&root| is_higher(runs_at(task), runs_at(root)));
            return is_first.then_some((None, false));
        };
        if interrupted.is_empty() && self.is_within(task, holder) {
            return Some((None, false));
        }
        if !is_higher(runs_at(task), holds_at(holder)) {
            return None;
        }
        let root = self.to_interrupt(task, holder, place);
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

    pub(super) fn grant(&mut self, task: Id, valve: usize, (at, root): Taking) {
        if let Some(root) = root {
            self.tell(root, What::Taken(valve));
            self.change_stops(root, |task| task.stops += 1);
            let when = self.next_event();
            self.valves[valve].places[at].facts.push(Fact::TakenAway(root, when));
        }
        self.valves[valve].asked.retain(|&other| other != task);
        if self.owner(task, &self.valves[valve].places[at]).is_none() {
            self.valves[valve].places[at].since = self.next_event();
        }
        match self.valves[valve].places[at].facts.last_mut() {
            Some(Fact::Has(holder, times)) if *holder == task => *times += 1,
            _ => {
                self.valves[valve].places[at].facts.push(Fact::Has(task, 1));
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

    /// The place that comes back to somebody next.
    fn place_to_give_back(&mut self, valve: usize) -> Option<usize> {
        let places = &self.valves[valve].places;
        let is_taken_away = |at: usize| matches!(places[at].facts.last(), Some(Fact::TakenAway(..)));
        if places.len() == 1 {
            return Some(0).filter(|&at| is_taken_away(at));
        }
        if let Some(lent) = (0..places.len()).find(|&at| is_taken_away(at) && !self.is_free(&places[at])) {
            return Some(lent);
        }
        let free = self.free_place(valve)?;
        let when = |at: usize, index: usize| match places[at].facts[index] {
            Fact::TakenAway(_, when) => when,
            Fact::Has(..) => 0,
        };
        let mut owners = self.interrupted_owners(valve);
        owners.sort_by(|&(at, index, one), &(other_at, other_index, other)| {
            compare(&self.tasks[one].runs_at, &self.tasks[other].runs_at)
                .then(when(at, index).cmp(&when(other_at, other_index)))
        });
        let &(at, index, _) = owners.last()?;
        if self.is_free(&places[at]) {
            return Some(at);
        }
        // Another place than its own is free: all that its subtree has to do with goes there.
        let Fact::TakenAway(root, _) = places[at].facts[index] else { return None };
        let subtree = self.subtree(root);
        let facts = std::mem::take(&mut self.valves[valve].places[at].facts);
        let is_its = |fact: &Fact| {
            let (Fact::Has(task, _) | Fact::TakenAway(task, _)) = *fact;
            subtree.contains(&task)
        };
        let (gone, left): (Vec<Fact>, Vec<Fact>) = facts.into_iter().partition(is_its);
        self.valves[valve].places[at].facts = left;
        self.valves[valve].places[free].facts.extend(gone);
        Some(free)
    }

    fn give_back(&mut self, valve: usize, at: usize) {
        let Some(Fact::TakenAway(root, _)) = self.valves[valve].places[at].facts.pop() else { return };
        if !self.is_lent_to(root, &self.valves[valve].places[at]) {
            self.valves[valve].places[at].since = self.next_event();
        }
        self.tell(root, What::Returned(valve));
        // Who asks in a subtree that is suspended cleans up.
        let heir = self.line(valve).into_iter().find(|&task| self.is_within(task, root));
        self.change_stops(root, |task| task.stops -= 1);
        let place = &self.valves[valve].places[at];
        let is_there = place.holder().is_some_and(|holder| self.is_within(holder, root));
        if let (Some(heir), false) = (heir, is_there)
            && let Some((root, false)) = self.could_take_from(heir, place, |task| &self.tasks[task].runs_at)
        {
            self.grant(heir, valve, (at, root));
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
                let next = self.line(valve).into_iter().find_map(|task| Some((task, self.could_take(task, valve)?)));
                if let Some((task, taking)) = next {
                    self.grant(task, valve, taking);
                    continue 'again;
                }
                if let Some(at) = self.place_to_give_back(valve) {
                    self.give_back(valve, at);
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
            let places = (0..self.valves.len())
                .flat_map(|valve| (0..self.valves[valve].places.len()).map(move |at| (valve, at)));
            for (valve, at) in places {
                let blocked =
                    self.line(valve).into_iter().find_map(|task| Some((task, self.is_kept_by(task, valve, at)?)));
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
                    // Among those that are ready it keeps its turn.
                    self.tasks[task].runs_at = std::mem::take(&mut due[task]);
                }
            }
            if is_same {
                return;
            }
        }
    }

    pub(super) fn release(&mut self, task: Id, valve: usize) {
        let Some(place) = self.valves[valve].places.iter_mut().find(|place| place.has_hold(task)) else { return };
        let at = place.facts.iter().rposition(|fact| matches!(fact, Fact::Has(holder, _) if *holder == task));
        let Some(at) = at else { return };
        if let Fact::Has(_, times) = &mut place.facts[at] {
            *times -= 1;
            if *times > 0 {
                return;
            }
        }
        place.facts.remove(at);
        self.tell(task, What::Released(valve));
        self.serve();
    }
}
