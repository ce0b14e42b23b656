//! Timers, in the order in which they fire.

use crate::state::value::TaskRef;
use serde::{Deserialize, Serialize};
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// What a timer does when it is due.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Alarm {
    /// Ends the wait with this number.
    Wake(u32),
    /// Ends the request of a valve.
    Request {
        /// The number of the wait.
        wait: u32,
        /// When the valve was asked for.
        asked_us: u64,
    },
    /// Ends the timeout whose timer has this number.
    Deadline,
}

impl Alarm {
    /// Timeouts end last in an instant: what is done in the deadline's very instant is done in time.
    pub(crate) fn is_late(self) -> bool {
        match self {
            Alarm::Wake(_) => false,
            Alarm::Request { .. } | Alarm::Deadline => true,
        }
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

    /// Takes a timer out, wherever it stands.
    pub fn remove(&mut self, number: u64) {
        self.heap.retain(|timer| timer.0.number != number);
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
