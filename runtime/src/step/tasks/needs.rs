//! What a task needs before it can go on, and whether that can happen at all.

use crate::state::machine::Machine;
use std::collections::{BTreeMap, VecDeque};

/// The tasks that must go on before one can.
#[derive(Clone, Debug, Default)]
pub(super) struct Needs {
    /// Each of these.
    pub(super) all: Vec<u32>,
    /// One of each of these lists.
    pub(super) any: Vec<Vec<u32>>,
}

impl Needs {
    pub(super) fn add(&mut self, other: Self) {
        self.all.extend(other.all);
        self.any.extend(other.any);
    }

    /// All of them.
    pub(super) fn tasks(&self) -> Vec<u32> {
        self.all.iter().chain(self.any.iter().flatten()).copied().collect()
    }
}

/// Which of a task's needs another one meets: one more of all, or a list of which one is enough.
#[derive(Clone, Copy, Debug)]
enum Need {
    All,
    Any(usize),
}

/// What is still missing until a task can go on.
#[derive(Clone, Debug, Default)]
struct Missing {
    all: usize,
    any: Vec<bool>,
}

impl Missing {
    fn is_nothing(&self) -> bool {
        self.all == 0 && !self.any.contains(&true)
    }

    fn meet(&mut self, need: Need) {
        match need {
            Need::All => self.all -= 1,
            Need::Any(list) => self.any[list] = false,
        }
    }
}

/// Tasks, what each misses, and who waits for it.
#[derive(Debug, Default)]
struct Search {
    missing: BTreeMap<u32, Missing>,
    waited_for_by: BTreeMap<u32, Vec<(u32, Need)>>,
    open: VecDeque<u32>,
}

impl Search {
    /// Notes what a task needs.
    fn note(&mut self, task: u32, needs: &Needs) {
        let missing = Missing { all: needs.all.len(), any: needs.any.iter().map(|list| !list.is_empty()).collect() };
        let lists = needs.any.iter().enumerate();
        let any = lists.flat_map(|(at, list)| list.iter().map(move |&first| (first, Need::Any(at))));
        for (first, need) in needs.all.iter().map(|&first| (first, Need::All)).chain(any) {
            self.waited_for_by.entry(first).or_default().push((task, need));
            self.open.push_back(first);
        }
        let can_go_on = missing.is_nothing();
        self.missing.insert(task, missing);
        if can_go_on {
            self.goes_on(task);
        }
    }

    /// A task can go on, and so can those who waited for no other.
    fn goes_on(&mut self, task: u32) {
        let mut going = vec![task];
        while let Some(task) = going.pop() {
            for (other, need) in self.waited_for_by.remove(&task).unwrap_or_default() {
                let Some(missing) = self.missing.get_mut(&other) else { continue };
                let was_nothing = missing.is_nothing();
                missing.meet(need);
                if !was_nothing && missing.is_nothing() {
                    going.push(other);
                }
            }
        }
    }

    fn can_go_on(&self, task: u32) -> bool {
        self.missing.get(&task).is_some_and(Missing::is_nothing)
    }
}

impl Machine {
    /// Whether a task that needs this can go on some time. Looks no further than it must, the nearest tasks first.
    pub(super) fn can_go_on(&self, task: u32, needs: Needs) -> bool {
        let mut search = Search::default();
        search.note(task, &needs);
        while let Some(next) = search.open.pop_front().filter(|_| !search.can_go_on(task)) {
            match search.missing.get(&next).map(Missing::is_nothing) {
                None => search.note(next, &self.must_happen_first(next)),
                Some(true) => search.goes_on(next),
                Some(false) => {}
            }
        }
        search.can_go_on(task)
    }
}
