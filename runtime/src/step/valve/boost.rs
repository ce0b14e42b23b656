//! Priorities lent to clean-ups and hooks that somebody waits for.

use crate::state::machine::Machine;
use crate::state::slab::NONE;
use crate::state::valve_line::Turn;
use crate::state::valve_place::Claim;
use crate::step::native::Surroundings;

/// Changes of a boost while valves are served, before it only rises.
const MAX_BOOST_CHANGES: u32 = 16;

impl Machine {
    /// What keeps the first in line waiting runs at its priority: a subtree with clean-ups, or one
    /// whose hooks run.
    pub(crate) fn set_claim(&mut self, place: u32, blocked: Option<(Turn, u32)>) {
        let entry = &self.places[place as usize];
        let line = &self.valves[entry.valve as usize].line;
        let with_hooks = entry.handover.and(entry.links.iter().rev().find(|link| link.is_mark()));
        let claim = match (with_hooks, line.first(), blocked) {
            (Some(mark), Some((first, _)), _) => Some(Claim { root: mark.task, priority: first.priority }),
            (None, _, Some((turn, root))) => Some(Claim { root: self.tasks.reference(root), priority: turn.priority }),
            (Some(_), None, _) | (None, _, None) => None,
        };
        let before = std::mem::replace(&mut self.places[place as usize].claim, claim);
        if before == claim {
            return;
        }
        if let Some(root) = before.and_then(|claim| self.tasks.find(claim.root)) {
            self.claims -= 1;
            self.tasks[root].rare().claimed.retain(|&known| known != place);
            self.refresh_boosts(root);
        }
        if let Some(root) = claim.and_then(|claim| self.tasks.find(claim.root)) {
            self.claims += 1;
            self.tasks[root].rare().claimed.push(place);
            self.refresh_boosts(root);
        }
    }

    /// A clean-up has ended: valves for which somebody waits for that are served.
    pub(crate) fn stir_claims_above(&mut self, around: &mut Surroundings<'_>, task: u32) {
        let mut at = task;
        while self.claims > 0 && at != NONE {
            if let Some(rare) = &self.tasks[at].rare {
                self.scratch.restless.extend(rare.claimed.iter().map(|&place| self.places[place as usize].valve));
            }
            at = self.tasks[at].parent;
        }
        self.serve_valves(around);
    }

    fn refresh_boosts(&mut self, root: u32) {
        let mut waiting = vec![root];
        while let Some(task) = waiting.pop() {
            waiting.extend(self.children(task).into_iter().rev());
            self.refresh_boost(task);
        }
    }

    /// The priority of who waits for the clean-up or the hooks a task belongs to.
    fn boost_due(&self, task: u32) -> Option<u32> {
        let mut due: Option<u32> = None;
        let (mut at, mut is_in_the_way) = (task, self.tasks[task].is_protected());
        while at != NONE {
            let record = &self.tasks[at];
            is_in_the_way |= record.named_as_hook();
            if let (true, Some(rare)) = (is_in_the_way, &record.rare) {
                for claim in rare.claimed.iter().filter_map(|&place| self.places[place as usize].claim) {
                    due = Some(due.map_or(claim.priority, |due| self.priorities.higher(due, claim.priority)));
                }
            }
            let parent = self.tasks.get(record.parent);
            is_in_the_way |= parent.is_some_and(|parent| parent.is_within_clean_up(record.parent_scope));
            at = record.parent;
        }
        due
    }

    /// A task that stands in no line comes to its due priority.
    pub(crate) fn renew_boost(&mut self, task: u32) {
        let due = self.boost_due(task);
        if due.is_some() || self.tasks[task].rare.is_some() {
            self.tasks[task].rare().boost = due;
        }
    }

    /// A task has begun or ended a clean-up, or somebody has begun or ended to wait for it.
    pub(crate) fn refresh_boost(&mut self, task: u32) {
        let due = if self.claims > 0 { self.boost_due(task) } else { None };
        let known = self.tasks[task].rare.as_ref().and_then(|rare| rare.boost);
        if due == known || !self.may_settle_at(task, known, due) {
            return;
        }
        let is_queued = self.is_queued(task) && task != self.current;
        if is_queued {
            self.unqueue(task);
        }
        self.change_line(task, |machine| machine.tasks[task].rare().boost = due);
        if is_queued {
            let line = self.effective_priority(task);
            self.priorities.rejoin(&mut self.tasks, task, line);
        }
        // Its priority counts for those who want its valves.
        let rare = self.tasks[task].rare();
        let valves = rare.held.iter().chain(&rare.marked).map(|&place| self.places[place as usize].valve);
        self.scratch.restless.extend(valves);
        self.scratch.switch = true;
    }

    /// Whether a task may come to this boost now. Boosts depend on lines and lines on boosts: one that has
    /// changed often while valves are served only rises any more, so that this comes to an end.
    fn may_settle_at(&mut self, task: u32, known: Option<u32>, due: Option<u32>) -> bool {
        if !self.scratch.is_serving {
            return true;
        }
        let changes = self.scratch.boost_changes.entry(task).or_insert(0);
        *changes += 1;
        let rises = match (known, due) {
            (Some(known), Some(due)) => self.priorities.is_higher(due, known),
            (None, _) => true,
            (Some(_), None) => false,
        };
        *changes <= MAX_BOOST_CHANGES || rises
    }
}
