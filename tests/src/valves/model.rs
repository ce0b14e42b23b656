//! The rules of tasks and valves once more, to compare the runtime with: small, slow, and read off the
//! reference. Nothing here is shared with the runtime. A valve is a list of facts, and who may have it
//! is found by asking everybody, each time anew.

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

/// A fact about a valve, the latest last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fact {
    Has(Id, usize),
    TakenAway(Id),
}

#[derive(Clone, Debug, Default)]
struct Valve {
    facts: Vec<Fact>,
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
    running: Option<Id>,
    decisions: usize,
    serving: bool,
    /// What was told so far.
    pub told: Vec<Told>,
}

fn longer(priority: &[i64], number: i64) -> Vec<i64> {
    let mut longer = priority.to_vec();
    longer.push(number);
    longer
}

/// Missing numbers count 0.
fn is_higher(one: &[i64], other: &[i64]) -> bool {
    let at = |list: &[i64], at: usize| list.get(at).copied().unwrap_or(0);
    let first = (0..one.len().max(other.len())).find(|&index| at(one, index) != at(other, index));
    first.is_some_and(|index| at(one, index) > at(other, index))
}

impl<'p> Model<'p> {
    /// A program before its first step.
    pub fn new(program: &'p Program) -> Self {
        let mut model = Self {
            tasks: Vec::new(),
            valves: vec![Valve::default(); 2],
            timers: Vec::new(),
            now: 0,
            turns: 0,
            running: None,
            decisions: 0,
            serving: false,
            told: Vec::new(),
        };
        model.begin(None, false, Vec::new(), &program.acts);
        model
    }

    fn begin(&mut self, parent: Option<Id>, in_clean_up: bool, priority: Vec<i64>, acts: &'p [Act]) {
        let id = self.tasks.len();
        self.tasks.push(Task {
            parent,
            in_clean_up,
            runs_at: priority.clone(),
            priority,
            frames: vec![Frame::Acts(acts)],
            life: Life::Ready,
            begun: false,
            leaving: None,
            raises: None,
            wanted_dead: false,
            own_stops: 0,
            stops: 0,
            turn: 0,
        });
        if self.all_stops(id) > 0 {
            self.tell(id, What::Suspended);
        }
        self.queue(id);
    }

    /// How many tasks have begun.
    pub fn tasks(&self) -> usize {
        self.tasks.len()
    }

    /// Whether a task lives.
    pub fn lives(&self, task: Id) -> bool {
        self.tasks.get(task).is_some_and(|task| task.life != Life::Dead)
    }

    fn tell(&mut self, task: Id, what: What) {
        self.told.push((self.now, task, what));
    }

    fn above(&self, task: Id) -> Vec<Id> {
        std::iter::successors(Some(task), |&task| self.tasks[task].parent).collect()
    }

    fn is_within(&self, task: Id, other: Id) -> bool {
        self.above(task).contains(&other)
    }

    fn children(&self, task: Id) -> Vec<Id> {
        (0..self.tasks.len()).filter(|&child| self.tasks[child].parent == Some(task) && self.lives(child)).collect()
    }

    fn subtree(&self, root: Id) -> Vec<Id> {
        let mut all = vec![root];
        for child in self.children(root) {
            all.extend(self.subtree(child));
        }
        all
    }

    fn cleans_up(&self, task: Id) -> bool {
        self.tasks[task].frames.iter().any(|frame| matches!(frame, Frame::CleansUp(_)))
    }

    fn is_protected(&self, task: Id) -> bool {
        self.tasks[task].leaving.is_some() || self.cleans_up(task)
    }

    /// Its own suspensions, and those of the tasks above whose clean-up it does not belong to.
    fn all_stops(&self, task: Id) -> usize {
        let record = &self.tasks[task];
        let above = if record.in_clean_up { None } else { record.parent };
        record.own_stops + record.stops + above.map_or(0, |above| self.all_stops(above))
    }

    fn is_held(&self, task: Id) -> bool {
        self.all_stops(task) > 0 && !self.is_protected(task)
    }

    /// To the end of the line of the ready.
    fn queue(&mut self, task: Id) {
        self.turns += 1;
        self.tasks[task].turn = self.turns;
        self.tasks[task].life = Life::Ready;
    }

    fn next_ready(&self) -> Option<Id> {
        let ready = (0..self.tasks.len())
            .filter(|&task| self.tasks[task].life == Life::Ready && !self.is_held(task) && self.running != Some(task));
        ready.reduce(|best, task| {
            let (one, other) = (&self.tasks[task], &self.tasks[best]);
            let is_first = is_higher(&one.runs_at, &other.runs_at)
                || (!is_higher(&other.runs_at, &one.runs_at) && one.turn < other.turn);
            if is_first { task } else { best }
        })
    }

    fn change_stops(&mut self, root: Id, change: impl FnOnce(&mut Task<'p>)) {
        let subtree = self.subtree(root);
        let before: Vec<(usize, bool)> =
            subtree.iter().map(|&task| (self.all_stops(task), self.is_held(task))).collect();
        change(&mut self.tasks[root]);
        for (&task, (stops, was_held)) in subtree.iter().zip(before) {
            let now = self.all_stops(task);
            if was_held && !self.is_held(task) && self.tasks[task].life == Life::Ready {
                self.queue(task);
            }
            match (stops, now) {
                (0, 1..) => self.tell(task, What::Suspended),
                (1.., 0) => self.tell(task, What::Resumed),
                _ => {}
            }
        }
        self.serve();
    }

    // Valves.

    fn holder(&self, valve: usize) -> Option<Id> {
        self.valves[valve].facts.iter().rev().find_map(|fact| match fact {
            Fact::Has(task, _) => Some(*task),
            Fact::TakenAway(_) => None,
        })
    }

    /// The interrupted subtrees above the latest hold, the latest last.
    fn interrupted(&self, valve: usize) -> Vec<Id> {
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

    fn grant(&mut self, task: Id, valve: usize, root: Option<Id>) {
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

    fn serve(&mut self) {
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
    fn refresh_priorities(&mut self) {
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

    fn release(&mut self, task: Id, valve: usize) {
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

    // Ends.

    fn as_one(&mut self, act: impl FnOnce(&mut Self)) {
        self.decisions += 1;
        act(self);
        self.decisions -= 1;
        self.serve();
    }

    fn evaporate(&mut self, task: Id) {
        let record = &self.tasks[task];
        if record.life == Life::Dead {
            return;
        }
        let is_decided = matches!(record.frames.last(), Some(Frame::Children { decided: Some(_), .. }));
        if !record.begun {
            self.die(task, What::Evaporated);
        } else if self.is_protected(task) || (is_decided && record.life == Life::Blocked(On::Children)) {
            self.tasks[task].wanted_dead = true;
        } else if record.raises == Some(true) {
            self.tasks[task].wanted_dead = true;
            self.leave(task, Exit::Fail);
        } else {
            self.leave(task, Exit::Evaporate);
        }
    }

    /// A task that does not run starts to leave.
    fn leave(&mut self, task: Id, exit: Exit) {
        if let Life::Blocked(On::Valve(valve)) = self.tasks[task].life {
            self.valves[valve].asked.retain(|&other| other != task);
        }
        self.timers.retain(|&(_, other)| other != task);
        self.tasks[task].raises = None;
        self.tasks[task].leaving = Some(exit);
        self.tasks[task].life = Life::Blocked(On::Children);
        self.as_one(|model| {
            if model.unwind(task) {
                model.queue(task);
            }
        });
    }

    /// Leaves frames until a clean-up is to run: tells whether there is one. It waits at children.
    fn unwind(&mut self, task: Id) -> bool {
        loop {
            let Some(exit) = self.tasks[task].leaving else { return false };
            match self.tasks[task].frames.last().cloned() {
                None => {
                    self.die(task, if exit == Exit::Fail { What::Failed } else { What::Evaporated });
                    return false;
                }
                Some(Frame::Acts(_)) => {
                    self.tasks[task].frames.pop();
                }
                Some(Frame::Holds(valve)) => {
                    self.tasks[task].frames.pop();
                    self.release(task, valve);
                }
                Some(Frame::Children { .. }) => {
                    if let Some(Frame::Children { decided, .. }) = self.tasks[task].frames.last_mut() {
                        *decided = Some(true);
                    }
                    // It looks for itself when they are dead.
                    self.tasks[task].life = Life::Ready;
                    self.evaporate_children(task);
                    if let Some(Frame::Children { alive: 1.., .. }) = self.tasks[task].frames.last() {
                        self.tasks[task].life = Life::Blocked(On::Children);
                        return false;
                    }
                    self.tasks[task].frames.pop();
                }
                Some(Frame::Protect(_)) => return true,
                Some(Frame::CleansUp(then)) => {
                    self.tasks[task].frames.pop();
                    self.tasks[task].leaving = Some(then.unwrap_or(exit));
                }
            }
        }
    }

    /// The children of the innermost construct.
    fn evaporate_children(&mut self, task: Id) {
        let in_clean_up = self.cleans_up(task);
        self.decisions += 1;
        for child in self.children(task) {
            if self.tasks[child].in_clean_up == in_clean_up {
                self.evaporate(child);
            }
        }
        self.decisions -= 1;
    }

    fn die(&mut self, task: Id, how: What) {
        self.tasks[task].life = Life::Dead;
        self.tasks[task].leaving = None;
        self.tell(task, how);
        for valve in &mut self.valves {
            valve.asked.retain(|&other| other != task);
            valve.facts.retain(|fact| !matches!(*fact, Fact::Has(other, _) | Fact::TakenAway(other) if other == task));
        }
        match self.tasks[task].parent {
            Some(parent) => self.as_one(|model| model.child_ended(parent, how)),
            None => self.serve(),
        }
    }

    fn child_ended(&mut self, parent: Id, how: What) {
        let Some(Frame::Children { rule, alive, decided }) = self.tasks[parent].frames.last_mut() else { return };
        *alive -= 1;
        let verdict = match (*rule, how) {
            (Rule::Par | Rule::One, What::Failed) => Some(false),
            (Rule::One, _) => Some(true),
            (Rule::Par, _) => None,
        };
        let decides = decided.is_none() && verdict.is_some();
        if decides {
            *decided = verdict;
            self.evaporate_children(parent);
        }
        self.end_construct(parent);
    }

    fn end_construct(&mut self, parent: Id) {
        let Some(Frame::Children { alive: 0, decided, .. }) = self.tasks[parent].frames.last() else { return };
        let decided = *decided;
        if self.tasks[parent].life != Life::Blocked(On::Children) {
            return;
        }
        if self.tasks[parent].leaving.is_some() {
            if self.unwind(parent) {
                self.queue(parent);
            }
            return;
        }
        self.tasks[parent].frames.pop();
        let is_wanted = self.tasks[parent].wanted_dead && !self.cleans_up(parent);
        match (decided, is_wanted) {
            (Some(false), true) => self.leave(parent, Exit::Fail),
            (_, true) => self.leave(parent, Exit::Evaporate),
            (Some(false), false) => {
                self.tasks[parent].raises = Some(true);
                self.queue(parent);
            }
            (_, false) => self.queue(parent),
        }
    }

    // Steps.

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
        let facts = &self.valves[valve].facts;
        let is_free = facts.is_empty()
            || self.interrupted(valve).is_empty()
                && self.holder(valve).is_some_and(|holder| self.is_within(task, holder));
        if is_free {
            self.grant(task, valve, None);
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
