//! Priorities, the run queue and timers.

use crate::task::{NONE, Tasks};
use crate::value::TaskRef;
use serde::{Deserialize, Serialize};
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// A first-in first-out line of tasks, linked through the tasks themselves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Line {
    /// The first.
    pub first: u32,
    /// The last.
    pub last: u32,
}

impl Default for Line {
    fn default() -> Self {
        Self { first: NONE, last: NONE }
    }
}

impl Line {
    /// Adds at the end.
    #[inline]
    pub fn push_back(&mut self, tasks: &mut Tasks, task: u32) {
        let record = &mut tasks[task];
        record.previous = self.last;
        record.next = NONE;
        if self.last == NONE {
            self.first = task;
        } else {
            tasks[self.last].next = task;
        }
        self.last = task;
    }

    /// Adds at the front.
    pub fn push_front(&mut self, tasks: &mut Tasks, task: u32) {
        tasks[task].next = self.first;
        tasks[task].previous = NONE;
        if self.first == NONE {
            self.last = task;
        } else {
            tasks[self.first].previous = task;
        }
        self.first = task;
    }

    /// Takes the first task out.
    #[inline]
    pub fn pop_front(&mut self, tasks: &mut Tasks) -> Option<u32> {
        let task = self.first;
        if task == NONE {
            return None;
        }
        self.first = std::mem::replace(&mut tasks[task].next, NONE);
        if self.first == NONE {
            self.last = NONE;
        } else {
            tasks[self.first].previous = NONE;
        }
        Some(task)
    }

    /// The tasks in line, the first one first.
    pub fn tasks(&self, tasks: &Tasks) -> Vec<u32> {
        let mut line = Vec::new();
        let mut at = self.first;
        while at != NONE {
            line.push(at);
            at = tasks[at].next;
        }
        line
    }

    /// Takes a task out, wherever it stands.
    pub fn remove(&mut self, tasks: &mut Tasks, task: u32) {
        let (previous, next) = (tasks[task].previous, tasks[task].next);
        if previous == NONE {
            self.first = next;
        } else {
            tasks[previous].next = next;
        }
        if next == NONE {
            self.last = previous;
        } else {
            tasks[next].previous = previous;
        }
        tasks[task].next = NONE;
        tasks[task].previous = NONE;
    }
}

/// Priorities in use. A priority is a list of numbers, compared lexicographically, missing ones
/// counting 0; trailing zeros are not kept, for they make no difference there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Priorities {
    /// Lists by number.
    lists: Vec<Vec<i64>>,
    /// Place of each number in the order, highest first.
    ranks: Vec<u32>,
    /// The line of each number.
    lines: Vec<Line>,
    /// Numbers in the order of their ranks.
    order: Vec<u32>,
    /// Ranks below this have empty lines.
    first_used: u32,
}

impl Default for Priorities {
    fn default() -> Self {
        Self { lists: vec![Vec::new()], ranks: vec![0], lines: vec![Line::default()], order: vec![0], first_used: 1 }
    }
}

fn compare(left: &[i64], right: &[i64]) -> Ordering {
    let longest = left.len().max(right.len());
    (0..longest)
        .map(|at| left.get(at).unwrap_or(&0).cmp(right.get(at).unwrap_or(&0)))
        .find(|ordering| *ordering != Ordering::Equal)
        .unwrap_or(Ordering::Equal)
}

impl Priorities {
    /// The priority `list` with a number appended. `depth` keeps positions apart although zeros
    /// are not kept: a list that is shorter than `depth` is filled up.
    pub fn appended(&mut self, priority: u32, depth: usize, number: i64) -> u32 {
        let mut list = self.lists[priority as usize].clone();
        if number != 0 {
            list.resize(depth, 0);
            list.push(number);
        }
        if let Some(known) = self.lists.iter().position(|known| *known == list) {
            return known as u32;
        }
        self.lists.push(list);
        self.lines.push(Line::default());
        self.ranks.push(0);
        let number = self.lists.len() as u32 - 1;
        let lists = &self.lists;
        let place = self
            .order
            .partition_point(|&other| compare(&lists[other as usize], &lists[number as usize]) == Ordering::Greater);
        self.order.insert(place, number);
        for (rank, &number) in self.order.iter().enumerate() {
            self.ranks[number as usize] = rank as u32;
        }
        self.first_used = 0;
        number
    }

    /// Whether the first is more important.
    #[inline]
    pub fn is_higher(&self, left: u32, right: u32) -> bool {
        left != right && self.ranks[left as usize] < self.ranks[right as usize]
    }

    /// The more important of two.
    pub fn higher(&self, left: u32, right: u32) -> u32 {
        if self.is_higher(right, left) { right } else { left }
    }

    /// The list of a priority.
    pub fn list(&self, priority: u32) -> &[i64] {
        &self.lists[priority as usize]
    }

    /// Puts a task at the end of its line, or at the front.
    #[inline]
    pub fn enqueue(&mut self, tasks: &mut Tasks, task: u32, priority: u32, front: bool) {
        let line = &mut self.lines[priority as usize];
        if front {
            line.push_front(tasks, task);
        } else {
            line.push_back(tasks, task);
        }
        self.first_used = self.first_used.min(self.ranks[priority as usize]);
    }

    /// Takes a task out of its line.
    pub fn withdraw(&mut self, tasks: &mut Tasks, task: u32, priority: u32) {
        self.lines[priority as usize].remove(tasks, task);
    }

    /// The next task to run, taken out of its line.
    #[inline]
    pub fn pop(&mut self, tasks: &mut Tasks) -> Option<u32> {
        while let Some(&number) = self.order.get(self.first_used as usize) {
            if let Some(task) = self.lines[number as usize].pop_front(tasks) {
                return Some(task);
            }
            self.first_used += 1;
        }
        None
    }

    /// Whether a task more important than this priority is ready.
    pub fn has_higher(&self, priority: u32) -> bool {
        let mut rank = self.first_used;
        while rank < self.ranks[priority as usize] {
            if self.lines[self.order[rank as usize] as usize].first != NONE {
                return true;
            }
            rank += 1;
        }
        false
    }

    /// Whether a priority is in the table.
    pub(crate) fn knows(&self, priority: u32) -> bool {
        (priority as usize) < self.lists.len()
    }

    /// The line of each priority.
    pub(crate) fn lines(&self) -> impl Iterator<Item = Line> {
        self.lines.iter().copied()
    }

    /// Whether the order is one of all priorities, and each has its rank and its line.
    pub(crate) fn is_whole(&self) -> bool {
        let count = self.lists.len();
        let is_ranked = |(rank, &number): (usize, &u32)| self.ranks.get(number as usize) == Some(&(rank as u32));
        let first_line =
            self.order.iter().position(|&number| self.lines.get(number as usize).is_none_or(|line| line.first != NONE));
        count > 0
            && [self.ranks.len(), self.lines.len(), self.order.len()] == [count; 3]
            && self.order.iter().enumerate().all(is_ranked)
            && self.first_used as usize <= first_line.unwrap_or(count)
    }

    /// All tasks in the run queue.
    pub fn queued(&self, tasks: &Tasks) -> Vec<u32> {
        self.lines.iter().flat_map(|line| line.tasks(tasks)).collect()
    }

    /// Whether no task is ready.
    pub fn is_idle(&self) -> bool {
        self.lines.iter().all(|line| line.first == NONE)
    }
}

/// What a timer does when it is due.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Alarm {
    /// Ends the wait with this number.
    Wake(u32),
    /// Ends the timeout whose timer has this number.
    Deadline,
}

impl Alarm {
    /// Timeouts end last in an instant: what is done in the deadline's very instant is done in time.
    fn is_late(self) -> bool {
        self == Alarm::Deadline
    }
}

impl Ord for Timer {
    fn cmp(&self, other: &Self) -> Ordering {
        let key = |timer: &Timer| (timer.deadline_us, timer.alarm.is_late(), timer.number);
        key(self).cmp(&key(other))
    }
}

impl PartialOrd for Timer {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// A timer; the order is that of firing: time, then ends of waits before ends of timeouts, then
/// the order of setting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Timer {
    /// Microseconds of virtual time.
    pub deadline_us: u64,
    /// What it does.
    pub alarm: Alarm,
    /// Counts the timers set.
    pub number: u64,
    /// Whose.
    pub task: TaskRef,
}

/// All timers. A cancelled one stays until it is due or until cancelled ones are the majority.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Timers {
    heap: BinaryHeap<Reverse<Timer>>,
    next_number: u64,
    /// How many have nothing to do any more, as far as is known.
    cancelled: i64,
}

impl PartialEq for Timers {
    fn eq(&self, other: &Self) -> bool {
        let sorted = |timers: &Timers| {
            let mut all: Vec<Timer> = timers.heap.iter().map(|timer| timer.0).collect();
            all.sort_unstable();
            all
        };
        self.next_number == other.next_number && sorted(self) == sorted(other)
    }
}

impl Timers {
    /// Sets a timer and gives its number.
    pub fn set(&mut self, deadline_us: u64, task: TaskRef, alarm: Alarm) -> u64 {
        self.next_number += 1;
        self.heap.push(Reverse(Timer { deadline_us, number: self.next_number, task, alarm }));
        self.next_number
    }

    /// Notes that one timer will find nothing to do; with many such, the heap is cleaned by
    /// `is_current`.
    pub fn note_cancelled(&mut self, is_current: impl Fn(&Timer) -> bool) {
        self.cancelled += 1;
        if self.cancelled > 64 && self.cancelled * 2 > self.heap.len() as i64 {
            self.heap.retain(|timer| is_current(&timer.0));
            self.cancelled = 0;
        }
    }

    /// The next timer that is still wanted; unwanted ones before it are dropped.
    pub fn next(&mut self, is_current: impl Fn(&Timer) -> bool) -> Option<Timer> {
        while let Some(Reverse(timer)) = self.heap.peek().copied() {
            if is_current(&timer) {
                return Some(timer);
            }
            self.heap.pop();
            self.cancelled -= 1;
        }
        None
    }

    /// Takes the timer that [`Timers::next`] gave. What it ends notes it as cancelled.
    pub fn take(&mut self) {
        self.heap.pop();
        self.cancelled -= 1;
    }

    /// All timers.
    pub fn iter(&self) -> impl Iterator<Item = &Timer> {
        self.heap.iter().map(|timer| &timer.0)
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

    #[test]
    fn timers_that_fire_are_looked_at_once() {
        use std::cell::Cell;
        let (mut timers, looks) = (Timers::default(), Cell::new(0));
        let is_current = |_: &Timer| {
            looks.set(looks.get() + 1);
            true
        };
        for number in 0..1_000 {
            timers.set(number, TaskRef { index: 0, generation: 0 }, Alarm::Wake(0));
        }
        while timers.next(is_current).is_some() {
            timers.take();
            timers.note_cancelled(is_current);
        }
        assert_eq!(looks.get(), 1_000, "the heap is not cleaned while no timer was cancelled");
    }
}
