//! Earlier instants of a run: copies of its whole state now and then, and replay from the last one
//! before the instant that is asked for.
//!
//! Copies share what has not changed between them. When they hold too much, those are given up
//! without which replay grows least.

use crate::robot::Outside;
use crate::run::stepping::{Stepped, Stop};
use crate::run::system::{System, Turn};
use crate::state::failure::Failure;
use std::sync::Arc;
use std::time::Duration;

/// A copy is kept when computing has gone on for this time since the last one, so that no replay takes much longer
/// while there is room.
const COPY_EVERY: Duration = Duration::from_millis(40);

/// An instant in which tasks run is kept from its beginning on when computing has gone on for so
/// long: going back by steps is going to such instants.
const COPY_ACTIVE_EVERY: Duration = Duration::from_millis(4);

/// What the copies may hold together, each shared part counted once.
const MOST_BYTES: usize = 448 << 20;

/// Names, globals and other tables of a run, which every copy has for itself.
const TABLE_BYTES: usize = 256 << 10;

/// A place in the history of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct TimelinePosition {
    /// Counts instants, and what was handed in from outside.
    pub segment: u64,
    /// Forms stopped before in that instant; [`TimelinePosition::END`] when nothing is ready any more.
    pub step: u32,
}

impl TimelinePosition {
    /// The step of an instant that is over.
    pub const END: u32 = u32::MAX;
}

#[derive(Clone)]
struct KeptState<O> {
    segment: u64,
    // Forks of the run share their past.
    system: Arc<System<O>>,
    /// Computing between the copy before and this one.
    computing: Duration,
    /// What it holds and the copy before does not.
    bytes: usize,
    /// Something was handed in here, which no replay could do.
    is_handed_in: bool,
    /// The last instant up to the next copy in which tasks may have run; none if they did not.
    last_active: Option<u64>,
}

/// The history of a run.
#[derive(Clone)]
pub struct Timeline<O> {
    /// Where the run is.
    pub position: TimelinePosition,
    copies: Vec<KeptState<O>>,
    /// Computing since the last copy.
    since: Duration,
    /// Bytes of the outside of a state that an earlier state does not share.
    bytes_apart: fn(&O, &O) -> usize,
}

/// An earlier state, and where the stepper stood then.
pub struct Past<O> {
    /// The state.
    pub system: System<O>,
    /// Its place.
    pub position: TimelinePosition,
    /// The form a task stood before.
    pub stop: Option<Stop>,
}

impl<O: Outside + Clone> Timeline<O> {
    /// The history of a run that is at its start. `bytes_apart` tells how much the outside of a
    /// later state holds that an earlier one, given second, does not share.
    pub fn new(system: &System<O>, bytes_apart: fn(&O, &O) -> usize) -> Self {
        let position = TimelinePosition { segment: 0, step: TimelinePosition::END };
        let mut timeline = Self { position, copies: Vec::new(), since: Duration::ZERO, bytes_apart };
        timeline.copy(system, true);
        timeline
    }

    /// Something from outside has changed the run: replay cannot go over it, so it is kept.
    pub fn handed_in(&mut self, system: &System<O>) {
        self.position = TimelinePosition { segment: self.position.segment + 1, step: 0 };
        self.copy(system, true);
    }

    /// A new instant has begun, after this time of computing since the last one began.
    pub fn next_instant(&mut self, system: &System<O>, computing: Duration) {
        self.position = TimelinePosition { segment: self.position.segment + 1, step: 0 };
        self.since += computing;
        let is_active = !system.machine.is_idle();
        if self.since >= COPY_EVERY || is_active && self.since >= COPY_ACTIVE_EVERY {
            self.copy(system, false);
        }
        if is_active && let Some(copy) = self.copies.last_mut() {
            copy.last_active = Some(self.position.segment);
        }
    }

    fn copy(&mut self, system: &System<O>, is_handed_in: bool) {
        let system = Arc::new(system.clone());
        let bytes = match self.copies.last() {
            Some(before) => self.bytes_between(&before.system, &system),
            None => 0,
        };
        let computing = std::mem::take(&mut self.since);
        let segment = self.position.segment;
        let last_active = is_handed_in.then_some(segment);
        self.copies.push(KeptState { segment, system, computing, bytes, is_handed_in, last_active });
        self.thin_out();
    }

    fn bytes_between(&self, earlier: &System<O>, later: &System<O>) -> usize {
        TABLE_BYTES + later.machine.used_bytes() + (self.bytes_apart)(&later.outside, &earlier.outside)
    }

    /// Gives copies up until the others hold no more than they may, as far as replay can do without
    /// them. Cost: a look at all copies for each that is given up.
    fn thin_out(&mut self) {
        while self.held_bytes() > MOST_BYTES {
            let Some(at) = self.least_useful() else { return };
            let gone = self.copies.remove(at);
            self.copies[at].bytes = self.bytes_between(&self.copies[at - 1].system, &self.copies[at].system);
            self.copies[at].computing += gone.computing;
            self.copies[at - 1].last_active = gone.last_active.or(self.copies[at - 1].last_active);
        }
    }

    /// The copy without which the longest replay is shortest. The newest stays.
    fn least_useful(&self) -> Option<usize> {
        let inner = 1..self.copies.len().saturating_sub(1);
        let replay = |&at: &usize| self.copies[at].computing + self.copies[at + 1].computing;
        inner.filter(|&at| !self.copies[at].is_handed_in).min_by_key(replay)
    }

    /// What all copies hold, each shared part counted once.
    pub fn held_bytes(&self) -> usize {
        self.copies.iter().map(|copy| copy.bytes).sum()
    }

    /// Forgets what came after a position, and goes on from there.
    pub fn go_back_to(&mut self, position: TimelinePosition) {
        self.copies.retain(|copy| copy.segment <= position.segment);
        if let Some(copy) = self.copies.last_mut() {
            copy.last_active = copy.last_active.map(|segment| segment.min(position.segment));
        }
        self.position = position;
        self.since = Duration::ZERO;
    }

    /// The state `steps` steps before a position, at most the start's; `is_shown` tells which stops
    /// count as steps. None if `is_given_up` says so on the way.
    pub fn steps_before(
        &self,
        mut position: TimelinePosition,
        mut steps: usize,
        is_shown: impl Fn(&System<O>, &Stop) -> bool,
        is_given_up: &dyn Fn() -> bool,
    ) -> Option<Past<O>> {
        if steps == 0 {
            return self.at(position, is_given_up);
        }
        for (index, copy) in self.copies.iter().enumerate().rev() {
            if copy.segment > position.segment {
                continue;
            }
            let stops = stops_between(copy, position, &is_shown, is_given_up)?;
            match stops.len().checked_sub(steps) {
                Some(kept) if kept < stops.len() => return self.at(stops[kept], is_given_up),
                _ if index == 0 => break,
                _ => {
                    steps -= stops.len();
                    position = TimelinePosition { segment: copy.segment, step: 0 };
                }
            }
        }
        self.at(TimelinePosition { segment: 0, step: 0 }, is_given_up)
    }

    /// The state at a position. None if `is_given_up` says so on the way.
    pub fn at(&self, position: TimelinePosition, is_given_up: &dyn Fn() -> bool) -> Option<Past<O>> {
        let copy = self.last_copy(|copy| copy.segment <= position.segment);
        let mut system = System::clone(&copy.system);
        for _ in copy.segment..position.segment {
            settle_unless(&mut system, is_given_up)?;
            system.next_instant();
        }
        let mut reached = TimelinePosition { segment: position.segment, step: 0 };
        let mut stop = None;
        while reached.step < position.step {
            if is_given_up() {
                return None;
            }
            match system.step_form() {
                Stepped::Before(before) => {
                    stop = Some(before);
                    reached.step += 1;
                }
                Stepped::Ran => stop = None,
                Stepped::Settled => {
                    stop = None;
                    reached.step = TimelinePosition::END;
                }
            }
        }
        discard(&mut system);
        Some(Past { system, position: reached, stop })
    }

    /// The state when the last instant up to a time was over. None if `is_given_up` says so on the
    /// way.
    pub fn at_time(&self, time_us: u64, is_given_up: &dyn Fn() -> bool) -> Option<Past<O>> {
        let copy = self.last_copy(|copy| copy.system.machine.now_us <= time_us);
        let end = self.copies.iter().map(|copy| copy.segment).find(|&segment| segment > copy.segment);
        let last = end.unwrap_or(self.position.segment + 1) - 1;
        let mut system = System::clone(&copy.system);
        let mut segment = copy.segment;
        settle_unless(&mut system, is_given_up)?;
        while segment < last && system.next_instant_us().is_some_and(|next_us| next_us <= time_us) {
            system.next_instant();
            settle_unless(&mut system, is_given_up)?;
            segment += 1;
        }
        discard(&mut system);
        Some(Past { system, position: TimelinePosition { segment, step: TimelinePosition::END }, stop: None })
    }

    /// The state in which a failure of the run is about to be raised, with everything alive that
    /// raising it ends. None if no replay comes to it, or if `is_given_up` says so on the way.
    pub fn before_failure(&self, failure: &Failure, is_given_up: &dyn Fn() -> bool) -> Option<Past<O>> {
        let has_it = |system: &System<O>| system.machine.heap.failures.iter().any(|(_, other)| is_same(other, failure));
        let is_before = |copy: &KeptState<O>| copy.system.machine.now_us <= failure.time_us && !has_it(&copy.system);
        let (index, copy) = self.copies.iter().enumerate().rev().find(|(_, copy)| is_before(copy))?;
        // What is handed in from outside is not done again.
        let end = self.copies[index + 1..].iter().find(|copy| copy.is_handed_in).map(|copy| copy.segment);
        let last = end.map_or(self.position.segment, |segment| segment - 1);
        let mut system = System::clone(&copy.system);
        for segment in copy.segment..=last {
            if is_given_up() {
                return None;
            }
            system.settle();
            if has_it(&system) {
                return self.before_failure_in(segment, failure, &has_it, is_given_up);
            }
            system.next_instant();
            if has_it(&system) {
                return self.at(TimelinePosition { segment, step: TimelinePosition::END }, is_given_up);
            }
        }
        None
    }

    /// The same within an instant. What ran out of a limit did so in the whole of it.
    fn before_failure_in(
        &self,
        segment: u64,
        failure: &Failure,
        has_it: &impl Fn(&System<O>) -> bool,
        is_given_up: &dyn Fn() -> bool,
    ) -> Option<Past<O>> {
        let start = self.at(TimelinePosition { segment, step: 0 }, is_given_up)?;
        if failure.is_runaway {
            return Some(start);
        }
        let mut at_form = start.system;
        let forms = stops_until(&at_form, System::step_form, has_it, is_given_up)?;
        let last_form = go_over(&mut at_form, System::step_form, forms);
        let instructions = stops_until(&at_form, System::step_instruction, has_it, is_given_up)?;
        let stop = go_over(&mut at_form, System::step_instruction, instructions).or(last_form);
        // A task that is woken with the failure stands before no form.
        let machine = &at_form.machine;
        let path = |stop: &Stop| machine.tasks.find_alive(stop.task).map(|task| machine.path(task));
        let stop = stop.filter(|stop| path(stop).as_ref() == Some(&failure.path));
        discard(&mut at_form);
        // It stands behind the last form, and that one counts as a step back.
        Some(Past { system: at_form, position: TimelinePosition { segment, step: forms + 1 }, stop })
    }

    /// How many copies are kept.
    pub fn copies(&self) -> usize {
        self.copies.len()
    }

    fn last_copy(&self, fits: impl Fn(&KeptState<O>) -> bool) -> &KeptState<O> {
        self.copies.iter().rev().find(|copy| fits(copy)).unwrap_or(&self.copies[0])
    }
}

/// Every position between a copy and a later position at which a stepper would stop. None if
/// `is_given_up` says so on the way.
fn stops_between<O: Outside + Clone>(
    copy: &KeptState<O>,
    end: TimelinePosition,
    is_shown: &impl Fn(&System<O>, &Stop) -> bool,
    is_given_up: &dyn Fn() -> bool,
) -> Option<Vec<TimelinePosition>> {
    let mut stops = Vec::new();
    let Some(last) = copy.last_active else { return Some(stops) };
    let end = end.min(TimelinePosition { segment: last, step: TimelinePosition::END });
    let mut system = System::clone(&copy.system);
    let mut position = TimelinePosition { segment: copy.segment, step: 0 };
    while position < end {
        if is_given_up() {
            return None;
        }
        match system.step_form() {
            Stepped::Before(stop) => {
                position.step += 1;
                if position < end && is_shown(&system, &stop) {
                    stops.push(position);
                }
            }
            Stepped::Ran => {}
            Stepped::Settled if position.segment == end.segment => break,
            Stepped::Settled => {
                system.next_instant();
                position = TimelinePosition { segment: position.segment + 1, step: 0 };
            }
        }
    }
    Some(stops)
}

/// Runs ready tasks until all are blocked. None if `is_given_up` says so on the way.
fn settle_unless<O: Outside>(system: &mut System<O>, is_given_up: &dyn Fn() -> bool) -> Option<()> {
    loop {
        if is_given_up() {
            return None;
        }
        if system.step_slice() == Turn::Idle {
            return Some(());
        }
    }
}

/// Whether a failure is one of another state of the run.
fn is_same(one: &Failure, other: &Failure) -> bool {
    one.time_us == other.time_us
        && one.class == other.class
        && one.span == other.span
        && one.path == other.path
        && one.message == other.message
}

/// How often a state stops before something is so in this instant. None if `is_given_up` says so on
/// the way.
fn stops_until<O: Outside + Clone>(
    system: &System<O>,
    step: impl Fn(&mut System<O>) -> Stepped,
    is_so: &impl Fn(&System<O>) -> bool,
    is_given_up: &dyn Fn() -> bool,
) -> Option<u32> {
    let mut system = system.clone();
    let mut stops = 0;
    loop {
        let stepped = step(&mut system);
        if is_so(&system) || stepped == Stepped::Settled {
            return Some(stops);
        }
        if is_given_up() {
            return None;
        }
        stops += u32::from(matches!(stepped, Stepped::Before(_)));
    }
}

/// Goes on to a stop by its number; gives it.
fn go_over<O: Outside + Clone>(
    system: &mut System<O>,
    step: impl Fn(&mut System<O>) -> Stepped,
    stops: u32,
) -> Option<Stop> {
    let mut last = None;
    let mut left = stops;
    while left > 0 {
        match step(system) {
            Stepped::Before(stop) => {
                last = Some(stop);
                left -= 1;
            }
            Stepped::Ran => {}
            Stepped::Settled => return last,
        }
    }
    last
}

/// What is replayed has been printed and traced before.
fn discard<O: Outside>(system: &mut System<O>) {
    system.machine.output.clear();
    system.machine.trace.take();
}
