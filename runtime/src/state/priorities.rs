//! Priorities, their order, and the tasks that are ready at each.

use crate::state::block::entry;
use crate::state::line::Line;
use crate::state::slab::{Marks, NONE, Slab};
use crate::state::tasks::Tasks;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A priority: a list of numbers, compared lexicographically, missing ones counting 0; zeros at its
/// end are not kept, for they make no difference there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Priority {
    /// Where it stands among all: the more important one has the greater.
    rank: u64,
    /// Its neighbours in that order.
    above: u32,
    below: u32,
    /// The tasks of this priority that are ready.
    line: Line,
    /// Its last number, and what it is appended to.
    place: ListPlace,
}

/// A number at a depth behind the list of another priority, zeros between. Places behind one priority
/// come in the order of their importance, that priority itself between the positive and the negative
/// numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
struct ListPlace {
    prefix: u32,
    is_negative: bool,
    /// The depth; from the end if the number is negative, for less is lost the deeper it stands.
    turn: u32,
    /// The number taken from the greatest.
    lack: u64,
}

impl ListPlace {
    fn new(prefix: u32, depth: u32, number: i64) -> Self {
        let is_negative = number < 0;
        let turn = if is_negative { u32::MAX - depth } else { depth };
        Self { prefix, is_negative, turn, lack: i64::MAX.abs_diff(number) }
    }

    fn depth(&self) -> u32 {
        if self.is_negative { u32::MAX - self.turn } else { self.turn }
    }

    fn number(&self) -> i64 {
        i64::MAX.wrapping_sub_unsigned(self.lack)
    }

    /// The first or the last place of one sign behind a priority.
    fn edge(prefix: u32, is_negative: bool, is_last: bool) -> Self {
        let (turn, lack) = if is_last { (u32::MAX, u64::MAX) } else { (0, 0) };
        Self { prefix, is_negative, turn, lack }
    }
}

/// Priorities in use, and the tasks that are ready.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Priorities {
    /// By number. The first is the empty list.
    all: Slab<Priority>,
    /// Their numbers by their places.
    places: BTreeMap<ListPlace, u32>,
    /// Those with ready tasks, the most important last.
    ready: Vec<u32>,
    /// Turns of the loops that keep the order.
    #[serde(skip)]
    work: WorkCount,
}

/// How much was done is no part of a state.
#[derive(Clone, Copy, Debug, Default)]
struct WorkCount(u64);

impl PartialEq for WorkCount {
    fn eq(&self, _other: &Self) -> bool {
        true
    }
}

impl Default for Priorities {
    fn default() -> Self {
        let place = ListPlace::edge(NONE, false, false);
        let mut all = Slab::default();
        all.insert(Priority { rank: 1 << 63, above: NONE, below: NONE, line: Line::default(), place });
        Self { all, places: BTreeMap::new(), ready: Vec::new(), work: WorkCount::default() }
    }
}

/// Where a new priority goes in the order: next to another.
enum Neighbour {
    Above(u32),
    Below(u32),
}

impl Priorities {
    /// A priority with a number appended at a depth, which keeps positions apart although zeros are not
    /// kept.
    pub fn appended(&mut self, priority: u32, depth: usize, number: i64) -> u32 {
        if number == 0 {
            return priority;
        }
        let place = ListPlace::new(priority, depth as u32, number);
        if let Some(&known) = self.places.get(&place) {
            return known;
        }
        let beside = self.neighbour(place);
        self.add(place, beside)
    }

    /// What a priority at a new place stands next to.
    fn neighbour(&mut self, place: ListPlace) -> Neighbour {
        let ListPlace { prefix, is_negative, .. } = place;
        if is_negative {
            let before = self.places.range(ListPlace::edge(prefix, true, false)..place).next_back();
            return match before.map(|(_, &before)| before) {
                Some(before) => Neighbour::Below(self.outermost(before, true)),
                None => Neighbour::Below(prefix),
            };
        }
        let behind = self.places.range(place..=ListPlace::edge(prefix, false, true)).next();
        match behind.map(|(_, &behind)| behind) {
            Some(behind) => Neighbour::Above(self.outermost(behind, false)),
            None => Neighbour::Above(prefix),
        }
    }

    /// The least important of all that begin with a priority, or the most important one.
    fn outermost(&mut self, priority: u32, least: bool) -> u32 {
        let mut at = priority;
        loop {
            self.work.0 += 1;
            let mut longer = self.places.range(ListPlace::edge(at, least, false)..=ListPlace::edge(at, least, true));
            let next = if least { longer.next_back() } else { longer.next() };
            match next {
                Some((_, &next)) => at = next,
                None => return at,
            }
        }
    }

    fn add(&mut self, place: ListPlace, beside: Neighbour) -> u32 {
        let (above, below) = match beside {
            Neighbour::Above(below) => (self.all[below].above, below),
            Neighbour::Below(above) => (above, self.all[above].below),
        };
        let rank = self.rank_between(above, below);
        let priority = self.all.insert(Priority { rank, above, below, line: Line::default(), place });
        if let Some(above) = self.all.get_mut(above) {
            above.below = priority;
        }
        if let Some(below) = self.all.get_mut(below) {
            below.above = priority;
        }
        self.places.insert(place, priority);
        priority
    }

    /// A rank between two neighbours, at least one of which there is. If there is none left, the
    /// neighbourhood is spread out: the smallest one that is sparse enough for its size, so that a
    /// new priority costs the logarithm of their number on average (Bender, Cole, Demaine,
    /// Farach-Colton, Zito 2002).
    fn rank_between(&mut self, above: u32, below: u32) -> u64 {
        loop {
            let low = self.all.get(below).map_or(0, |below| below.rank);
            let high = self.all.get(above).map_or(u64::MAX, |above| above.rank);
            if high - low > 1 {
                return low + (high - low) / 2;
            }
            self.spread(if below == NONE { above } else { below });
        }
    }

    fn spread(&mut self, around: u32) {
        let rank = self.all[around].rank;
        let (mut first, mut last, mut count) = (around, around, 1u64);
        // The more ranks, the smaller the share of them that may be taken.
        for bits in 1..64 {
            let (low, high) = (rank >> bits << bits, rank | ((1 << bits) - 1));
            while let Some(below) = self.all.get(first).map(|first| first.below).filter(|&below| below != NONE)
                && self.all[below].rank >= low
            {
                (first, count) = (below, count + 1);
                self.work.0 += 1;
            }
            while let Some(above) = self.all.get(last).map(|last| last.above).filter(|&above| above != NONE)
                && self.all[above].rank <= high
            {
                (last, count) = (above, count + 1);
                self.work.0 += 1;
            }
            let room = high - low;
            if bits == 63 || count.saturating_mul(count) < room {
                self.space_out(first, low, room / (count + 1), count);
                return;
            }
        }
    }

    /// Gives `count` priorities, from the least important one on, ranks at equal distances.
    fn space_out(&mut self, first: u32, low: u64, distance: u64, count: u64) {
        let mut at = first;
        for turn in 1..=count {
            self.work.0 += 1;
            self.all[at].rank = low + turn * distance;
            at = self.all[at].above;
        }
    }

    /// Whether the first is more important.
    #[inline]
    pub fn is_higher(&self, left: u32, right: u32) -> bool {
        left != right && self.all[left].rank > self.all[right].rank
    }

    /// The more important of two.
    pub fn higher(&self, left: u32, right: u32) -> u32 {
        if self.is_higher(right, left) { right } else { left }
    }

    /// The list of a priority.
    pub fn list(&self, priority: u32) -> Vec<i64> {
        let mut list = Vec::new();
        let mut at = priority;
        while at != 0 {
            let place = self.all[at].place;
            let depth = place.depth() as usize;
            list.resize(list.len().max(depth + 1), 0);
            list[depth] = place.number();
            at = place.prefix;
        }
        list
    }

    /// Where a priority stands, or would stand, among those with ready tasks.
    fn turn(&self, priority: u32) -> usize {
        let rank = self.all[priority].rank;
        self.ready.partition_point(|&ready| self.all[ready].rank < rank)
    }

    /// Puts a task at the end of its line, or at the front.
    #[inline]
    pub fn enqueue(&mut self, tasks: &mut Tasks, task: u32, priority: u32, front: bool) {
        if !front {
            return self.append(tasks, Line { first: task, last: task }, priority);
        }
        let line = &mut self.all[priority].line;
        let was_empty = line.first == NONE;
        line.push_front(tasks, task);
        if was_empty {
            self.note_ready(priority);
        }
    }

    /// Puts tasks that stand behind one another at the end of a line.
    #[inline]
    pub fn append(&mut self, tasks: &mut Tasks, stretch: Line, priority: u32) {
        let line = &mut self.all[priority].line;
        let was_empty = line.first == NONE;
        line.append(tasks, stretch);
        if was_empty {
            self.note_ready(priority);
        }
    }

    /// Puts a task into the line of another priority, behind those that became ready before it. Cost: those behind it.
    pub fn rejoin(&mut self, tasks: &mut Tasks, task: u32, priority: u32) {
        let ready = tasks[task].wait_number;
        let is_later = |other: u32| tasks[other].wait_number.wrapping_sub(ready) as i32 > 0;
        let line = &mut self.all[priority].line;
        let mut before = line.last;
        while before != NONE && is_later(before) {
            before = tasks[before].previous;
            self.work.0 += 1;
        }
        if before == line.last {
            return self.append(tasks, Line { first: task, last: task }, priority);
        }
        line.insert_behind(tasks, task, before);
    }

    /// Notes that a priority, which had none, has ready tasks.
    #[inline]
    fn note_ready(&mut self, priority: u32) {
        let turn = if self.ready.is_empty() { 0 } else { self.turn(priority) };
        self.ready.insert(turn, priority);
    }

    /// Takes a task out of its line.
    pub fn withdraw(&mut self, tasks: &mut Tasks, task: u32, priority: u32) {
        let line = &mut self.all[priority].line;
        line.remove(tasks, task);
        if line.first == NONE {
            let turn = self.turn(priority);
            self.ready.remove(turn);
        }
    }

    /// The next task to run, taken out of its line.
    #[inline]
    pub fn pop(&mut self, tasks: &mut Tasks) -> Option<u32> {
        let &priority = self.ready.last()?;
        let line = &mut self.all[priority].line;
        let task = line.pop_front(tasks);
        if line.first == NONE {
            self.ready.pop();
        }
        task
    }

    /// The line of the most important ready tasks.
    pub fn first_line(&self) -> Option<Line> {
        self.ready.last().map(|&priority| self.all[priority].line)
    }

    /// Whether a task more important than this priority is ready.
    #[inline]
    pub fn has_higher(&self, priority: u32) -> bool {
        self.ready.last().is_some_and(|&ready| self.is_higher(ready, priority))
    }

    /// Whether a priority is in the table.
    pub(crate) fn knows(&self, priority: u32) -> bool {
        self.all.get(priority).is_some()
    }

    /// The line of each priority.
    pub(crate) fn lines(&self) -> impl Iterator<Item = Line> {
        self.all.iter().map(|(_, priority)| priority.line)
    }

    /// Turns of the loops that keep the order.
    pub(crate) fn work(&self) -> u64 {
        self.work.0
    }

    /// Forgets the priorities that are not marked and that none of the marked begins with.
    pub(crate) fn retain(&mut self, mut used: Marks, slack: usize) {
        let marked: Vec<u32> =
            self.all.iter().map(|(number, _)| number).filter(|&number| used.is_set(number)).collect();
        used.set(0);
        for priority in marked {
            let mut at = self.all[priority].place.prefix;
            while at != NONE && used.set(at) {
                at = self.all[at].place.prefix;
            }
        }
        let unused: Vec<u32> =
            self.all.iter().map(|(number, _)| number).filter(|&number| !used.is_set(number)).collect();
        for priority in unused {
            let Some(Priority { above, below, place, .. }) = self.all.remove(priority) else { continue };
            self.places.remove(&place);
            if let Some(above) = self.all.get_mut(above) {
                above.below = below;
            }
            if let Some(below) = self.all.get_mut(below) {
                below.above = above;
            }
        }
        self.all.shrink(slack);
    }

    /// How many priorities there are.
    #[allow(clippy::len_without_is_empty, reason = "there is always one")]
    pub fn len(&self) -> usize {
        self.all.iter().count()
    }

    /// Bytes of the table.
    pub(crate) fn bytes(&self) -> usize {
        self.all.slots() * (size_of::<Option<Priority>>() + entry::<(ListPlace, u32)>())
    }

    /// How many numbers there may be.
    pub(crate) fn slots(&self) -> usize {
        self.all.slots()
    }

    /// Whether the order is one of all priorities, each is found at its place, and those with ready
    /// tasks are known.
    pub(crate) fn is_whole(&self) -> bool {
        let is_placed = |(number, priority): (u32, &Priority)| match number {
            0 => true,
            _ => self.places.get(&priority.place) == Some(&number) && self.knows(priority.place.prefix),
        };
        let count = self.all.iter().count();
        let has_root = self.all.get(0).is_some() && count == self.places.len() + 1;
        has_root
            && self.all.is_whole()
            && self.all.iter().all(is_placed)
            && self.all.iter().all(|(number, _)| self.reaches_root(number))
            && self.is_ordered(count)
            && self.is_ready_known()
    }

    /// Whether the places behind one another end at the empty list.
    fn reaches_root(&self, priority: u32) -> bool {
        let mut at = priority;
        let mut depth = u32::MAX;
        while at != 0 {
            let Some(place) = self.all.get(at).map(|priority| priority.place) else { return false };
            if place.depth() >= depth {
                return false;
            }
            (at, depth) = (place.prefix, place.depth());
        }
        true
    }

    fn is_ordered(&self, count: usize) -> bool {
        let Some((mut at, _)) = self.all.iter().find(|(_, priority)| priority.above == NONE) else { return false };
        for _ in 1..count {
            let below = self.all[at].below;
            let Some(next) = self.all.get(below) else { return false };
            if next.above != at || next.rank >= self.all[at].rank {
                return false;
            }
            at = below;
        }
        self.all[at].below == NONE
    }

    fn is_ready_known(&self) -> bool {
        let is_used = |&priority: &u32| self.all.get(priority).is_some_and(|entry| entry.line.first != NONE);
        self.ready.iter().all(is_used)
            && self.ready.is_sorted_by(|&left, &right| self.is_higher(right, left))
            && self.lines().filter(|line| line.first != NONE).count() == self.ready.len()
    }

    /// All tasks in the run queue.
    pub fn queued(&self, tasks: &Tasks) -> Vec<u32> {
        self.lines().flat_map(|line| line.tasks(tasks)).collect()
    }

    /// Whether no task is ready.
    pub fn is_idle(&self) -> bool {
        self.ready.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn priorities_compare_as_lists() {
        let mut priorities = Priorities::default();
        let outer_policy = priorities.appended(0, 0, 1);
        let body = priorities.appended(0, 0, 0);
        let inner_policy = priorities.appended(body, 1, 1);
        let demoted = priorities.appended(0, 0, -1);
        assert!(priorities.is_higher(outer_policy, inner_policy));
        assert!(priorities.is_higher(inner_policy, body));
        assert!(priorities.is_higher(body, demoted));
        assert!(!priorities.is_higher(body, 0) && !priorities.is_higher(0, body));
    }

    /// Against lists of numbers, compared as such.
    #[test]
    fn priorities_are_ordered_as_their_lists_are() {
        let mut dice = 1u64;
        let mut below = |end: u64| {
            dice = dice.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (dice >> 33) % end
        };
        let mut priorities = Priorities::default();
        let mut known: Vec<(u32, Vec<i64>)> = vec![(0, Vec::new())];
        for _ in 0..3_000 {
            let (priority, mut list) = known[below(known.len() as u64) as usize].clone();
            let depth = list.len() + below(3) as usize;
            let number = below(7) as i64 - 3;
            let appended = priorities.appended(priority, depth, number);
            list.resize(depth, 0);
            list.push(number);
            while list.last() == Some(&0) {
                list.pop();
            }
            assert_eq!(priorities.list(appended), list);
            known.push((appended, list));
        }
        assert!(priorities.is_whole());
        let padded = |list: &[i64]| {
            let mut list = list.to_vec();
            list.resize(100, 0);
            list
        };
        known.sort_by_key(|(_, list)| padded(list));
        for pair in known.windows(2) {
            let is_higher = padded(&pair[1].1) > padded(&pair[0].1);
            assert_eq!(priorities.is_higher(pair[1].0, pair[0].0), is_higher, "{pair:?}");
            assert_eq!(pair[1].0 == pair[0].0, !is_higher, "equal lists are one priority: {pair:?}");
        }
    }

    #[test]
    fn a_new_priority_costs_little_however_many_there_are() {
        type Step = dyn Fn(&mut Priorities, u32, usize) -> u32;
        let work = |count: usize, step: &Step| {
            let mut priorities = Priorities::default();
            (0..count).fold(0, |at, turn| step(&mut priorities, at, turn));
            assert!(priorities.is_whole());
            priorities.work()
        };
        let steps: [&Step; 5] = [
            &|priorities, at, turn| priorities.appended(at, turn, 1),
            &|priorities, at, turn| priorities.appended(at, turn, -1),
            &|priorities, _, turn| priorities.appended(0, turn, 1),
            &|priorities, _, turn| priorities.appended(0, 0, turn as i64),
            &|priorities, _, turn| priorities.appended(0, 0, -(turn as i64)),
        ];
        for (number, step) in steps.iter().enumerate() {
            let (few, many) = (work(2_000, step), work(8_000, step));
            assert!(many < few.max(2_000) * 8, "step {number}: {few} turns for 2,000, {many} for 8,000");
        }
    }
}
