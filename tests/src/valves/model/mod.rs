//! The rules of tasks and valves once more, to compare the runtime with: small, slow, and read off the
//! reference. Nothing here is shared with the runtime. A place of a valve is a list of facts, and who may have
//! it is found by asking everybody, each time anew.

mod ends;
mod steps;
mod tasks;
mod valves;

use super::program::{Act, Program, Rule};

/// A task by the order of beginning; 0 is main.
pub type Id = usize;

/// What is told of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum What {
    /// It got the valve.
    Granted(usize),
    /// It gave the valve back.
    Released(usize),
    /// The valve was taken away from its subtree.
    Taken(usize),
    /// The valve came back to its subtree.
    Returned(usize),
    /// It was suspended.
    Suspended,
    /// It may go on.
    Resumed,
    /// It ended well.
    Succeeded,
    /// It failed.
    Failed,
    /// It was ended from outside.
    Evaporated,
}

/// Something told: when, of whom, what.
pub type Told = (u64, Id, What);

/// What happens from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blow {
    /// It is ended.
    Evaporate(Id),
    /// It is suspended once more.
    Suspend(Id),
    /// One suspension is taken back.
    Resume(Id),
    /// What it waits for fails, if that is time.
    Fail(Id),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Exit {
    Evaporate,
    Fail,
}

/// Where a task stands, outermost first.
#[derive(Clone, Debug)]
enum Frame<'p> {
    /// What is left to do.
    Acts(&'p [Act]),
    Holds(usize),
    Children {
        rule: Rule,
        alive: usize,
        decided: Option<bool>,
    },
    Protect(&'p [Act]),
    CleansUp(Option<Exit>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Life {
    Ready,
    Blocked(On),
    Dead,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum On {
    Time,
    Children,
    Valve(usize),
}

#[derive(Clone, Debug)]
struct Task<'p> {
    parent: Option<Id>,
    /// It belongs to a clean-up of its parent, which the parent's suspensions do not reach.
    in_clean_up: bool,
    priority: Vec<i64>,
    runs_at: Vec<i64>,
    frames: Vec<Frame<'p>>,
    life: Life,
    begun: bool,
    leaving: Option<Exit>,
    /// It goes on with a failure; true if that is its construct's.
    raises: Option<bool>,
    wanted_dead: bool,
    /// Suspensions of its own that `resume` takes back, and others.
    own_stops: usize,
    stops: usize,
    /// Its place among the ready.
    turn: i64,
}

/// A fact about a place of a valve, the latest last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fact {
    Has(Id, usize),
    /// With the number of the event.
    TakenAway(Id, u64),
}

#[derive(Clone, Debug, Default)]
struct Place {
    facts: Vec<Fact>,
    /// The number of the event by which its owner got it.
    since: u64,
}

#[derive(Clone, Debug, Default)]
struct Valve {
    places: Vec<Place>,
    /// In the order of asking.
    asked: Vec<Id>,
}

/// A run.
#[derive(Clone, Debug)]
pub struct Model<'p> {
    tasks: Vec<Task<'p>>,
    valves: Vec<Valve>,
    timers: Vec<(u64, Id)>,
    now: u64,
    turns: i64,
    events: u64,
    running: Option<Id>,
    decisions: usize,
    serving: bool,
    /// What was told so far.
    pub told: Vec<Told>,
}

impl<'p> Model<'p> {
    /// A program before its first step.
    pub fn new(program: &'p Program) -> Self {
        let mut model = Self {
            tasks: Vec::new(),
            valves: program
                .places
                .map(|count| Valve { places: vec![Place::default(); count], asked: Vec::new() })
                .into(),
            timers: Vec::new(),
            now: 0,
            turns: 0,
            events: 0,
            running: None,
            decisions: 0,
            serving: false,
            told: Vec::new(),
        };
        model.begin(None, false, Vec::new(), &program.acts);
        model
    }

    fn next_event(&mut self) -> u64 {
        self.events += 1;
        self.events
    }

    fn tell(&mut self, task: Id, what: What) {
        self.told.push((self.now, task, what));
    }
}
