//! Valves: pre-emptible semaphores that guard effectors.
//!
//! # The rule
//!
//! A valve is a stack. A *hold* says that a task has taken the valve; a *mark* above holds says that
//! the valve was taken away there, and names the root of the subtree that has been suspended for it.
//! The topmost hold is the *holder's*, as long as no mark lies above it.
//!
//! - **Taking.** Whoever is the holder or below it takes the valve at once: it *borrows* it, and its
//!   hold goes on top. So borrowing nests, and one borrows at a time. A valve nobody holds is free.
//! - **Waiting.** Everybody else waits in line, by priority, then by the order of asking. A suspended
//!   task keeps its place and is passed over.
//! - **Pre-empting.** Who has a higher priority than the holder takes the valve away. If a task that
//!   holds it is above both of them, that is done from *inside*: what is suspended is the branch
//!   below the nearest common ancestor that contains the holder. Otherwise it is done from *outside*:
//!   what is suspended is the whole subtree of the *owner*, the outermost task above the holder that
//!   holds the valve. A mark with that root goes on top, and the requester's hold above it. As long as
//!   a clean-up runs anywhere in that subtree, the requester is passed over, nothing is suspended,
//!   and the clean-up runs at its priority.
//! - **Giving back.** With its hold gone from the top, the valve goes to the first in line who can
//!   have it. If a mark has come to the top, the interrupted one is asked as well, with the priority
//!   of the hold below: only a higher priority goes first, and suspends what is not suspended yet.
//!   Otherwise the mark goes away and its root is resumed; if nobody below that root holds the valve
//!   any more, a clean-up there that waits for it comes before its equals.
//! - **Dying.** The holds of a dead task, and the marks of which it is the root, are taken out
//!   wherever they are. What lies below keeps its place: the valve goes back to the next living hold.
//!   A mark whose interrupted hold is gone stays as long as its root lives, which is suspended until
//!   the valve comes back to it.
//! - **Hooks.** Between the mark and the requester's hold, and before the mark goes away, the hooks
//!   of the subtree run in a task that holds the valve meanwhile; nothing else is served. Scopes in
//!   a subtree that is interrupted already have had their turn.
//! - **One decision is one.** What a construct ends, it ends before any valve goes on to somebody.
//!
//! # Cost
//!
//! A request, a release and a death cost the logarithm of the number of waiters, times the depth of
//! the task in the tree. To find the first who can have a valve looks at the first in line and at the
//! first of those below the holder; only while somebody waits for a clean-up to end are there more:
//! the first in each line, and those of the lines of lenders above the holder who could pre-empt it.

use crate::failure::Raise;
use crate::machine::{Machine, Surroundings};
use crate::memory;
use crate::registers::Registers;
use crate::scheduler::Priorities;
use crate::task::{NONE, ScopeKind, State, Task, Waiting, Wake};
use crate::value::{TaskRef, Value};
use crate::valve_line::{Place, ValveLine};
use rpl_lang::symbol::Symbol;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// What a hold is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Purpose {
    /// `with-valve` or `request-valve`.
    Plan,
    /// A behaviour drives with it.
    Activation(u16),
    /// Hooks run while it changes hands.
    Hooks,
}

/// What an entry of the stack is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LinkKind {
    /// The task has taken the valve.
    Hold {
        /// How often.
        count: u32,
        /// What for.
        purpose: Purpose,
    },
    /// The valve was taken away here, and the task and all below it are suspended.
    Mark,
}

/// An entry of the stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Link {
    /// Names it; those above it have higher numbers.
    pub number: u64,
    /// Whose it is.
    pub task: TaskRef,
    /// The line of those for whom it is the topmost link they are below.
    pub line: u64,
    /// What it is.
    pub kind: LinkKind,
}

impl Link {
    fn is_hold(&self) -> bool {
        matches!(self.kind, LinkKind::Hold { .. })
    }

    pub(crate) fn is_mark(&self) -> bool {
        !self.is_hold()
    }

    fn serves(&self, wanted: Purpose) -> bool {
        matches!(self.kind, LinkKind::Hold { purpose, .. } if purpose == wanted)
    }
}

/// Changes of a boost while valves are served, before it only rises.
const MAX_BOOST_CHANGES: u32 = 16;

/// No link, and the first line of those who are below none.
pub const NO_LINK: u64 = 0;

/// Those who are below a link and below none above it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Below {
    /// The link, [`NO_LINK`] for none.
    pub link: u64,
    /// They, in line; never empty.
    pub line: ValveLine,
}

/// A task that waits for a valve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Waiter {
    /// Its place in line.
    pub place: Place,
    /// The line it stands in; none while it is suspended.
    pub line: Option<u64>,
}

/// What hooks run for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Handover {
    /// The subtree of the topmost mark is being interrupted.
    Lend,
    /// It is about to go on.
    GiveBack,
}

/// A subtree whose clean-ups or hooks keep somebody waiting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Claim {
    /// Its root.
    pub root: TaskRef,
    /// The priority of who waits.
    pub priority: u32,
}

/// A valve.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Valve {
    /// Its name.
    pub name: Symbol,
    /// Holds and marks, the topmost last.
    pub links: Vec<Link>,
    /// Who waits for it, by slot, the suspended ones as well.
    pub waiters: BTreeMap<u32, Waiter>,
    /// Those who wait and are not suspended.
    pub line: ValveLine,
    /// The same, by the link they are below.
    pub lines: BTreeMap<u64, Below>,
    /// The line of those who are below no link.
    pub open_line: u64,
    /// Links there have been.
    pub last_link: u64,
    /// Requests that had to wait.
    pub asked: u64,
    /// Hooks under way.
    pub handover: Option<Handover>,
    /// What keeps the first in line from pre-empting.
    pub claim: Option<Claim>,
}

impl Valve {
    /// A valve nobody holds.
    pub fn new(name: Symbol) -> Self {
        Self {
            name,
            links: Vec::new(),
            waiters: BTreeMap::new(),
            line: ValveLine::default(),
            lines: BTreeMap::new(),
            open_line: NO_LINK,
            last_link: NO_LINK,
            asked: 0,
            handover: None,
            claim: None,
        }
    }

    /// Tasks that hold it, the present holder last. Hooks do so only for the time of a handover.
    pub fn holders(&self) -> impl DoubleEndedIterator<Item = TaskRef> {
        self.links.iter().filter(|link| link.is_hold() && !link.serves(Purpose::Hooks)).map(|link| link.task)
    }

    /// Roots of the subtrees it was taken away from, and that are suspended for it.
    pub fn interrupted(&self) -> impl Iterator<Item = TaskRef> {
        self.links.iter().filter(|link| link.is_mark()).map(|link| link.task)
    }

    /// Slots of those who wait for it, in the order in which they are served; the suspended ones last.
    pub fn in_line(&self) -> Vec<u32> {
        let mut suspended: Vec<(u64, u32)> = self
            .waiters
            .iter()
            .filter(|(_, waiter)| waiter.line.is_none())
            .map(|(&task, waiter)| (waiter.place.asked, task))
            .collect();
        suspended.sort_unstable();
        let waiting = self.line.iter().map(|(_, task)| task);
        waiting.chain(suspended.into_iter().map(|(_, task)| task)).collect()
    }

    /// Whether a task has taken it and not given it back.
    pub(crate) fn is_taken_by(&self, task: TaskRef) -> bool {
        self.links.iter().any(|link| link.task == task && link.serves(Purpose::Plan))
    }

    /// Whether nobody has anything to do with it.
    pub fn is_at_rest(&self) -> bool {
        self.links.is_empty() && self.waiters.is_empty() && self.handover.is_none() && self.claim.is_none()
    }

    /// Its topmost hold and where that is.
    fn top_hold(&self) -> Option<(usize, Link)> {
        let at = self.links.iter().rposition(Link::is_hold)?;
        Some((at, self.links[at]))
    }

    /// The topmost link, if that is a mark.
    fn top_mark(&self) -> Option<Link> {
        self.links.last().copied().filter(Link::is_mark)
    }

    fn push(&mut self, task: TaskRef, kind: LinkKind) -> u64 {
        self.last_link += 1;
        self.links.push(Link { number: self.last_link, task, line: self.last_link, kind });
        self.last_link
    }

    /// The line of a link, or of those who are below none.
    pub(crate) fn line_of(&self, link: u64) -> u64 {
        match self.links.binary_search_by_key(&link, |known| known.number) {
            Ok(at) => self.links[at].line,
            Err(_) => self.open_line,
        }
    }

    /// One who waits takes its place in the line of a link.
    fn enter(&mut self, priorities: &Priorities, task: u32, link: u64) {
        let number = self.line_of(link);
        let Some(waiter) = self.waiters.get_mut(&task) else { return };
        waiter.line = Some(number);
        self.line.enter(priorities, waiter.place, task);
        let below = self.lines.entry(number).or_insert_with(|| Below { link, line: ValveLine::default() });
        below.line.enter(priorities, waiter.place, task);
    }

    /// One who waits keeps its place and is passed over.
    fn leave(&mut self, priorities: &Priorities, task: u32) {
        let Some(waiter) = self.waiters.get_mut(&task) else { return };
        let Some(number) = waiter.line.take() else { return };
        self.line.leave(priorities, waiter.place);
        if let Some(below) = self.lines.get_mut(&number) {
            below.line.leave(priorities, waiter.place);
            if below.line.is_empty() {
                self.lines.remove(&number);
            }
        }
    }

    /// All in one line stand in that of another link from now on; the shorter line is moved.
    fn join_lines(&mut self, priorities: &Priorities, gone: u64, link: u64) {
        let known = self.line_of(link);
        let Some(mut longer) = self.lines.remove(&gone) else { return };
        let shorter = self.lines.remove(&known).unwrap_or_default();
        let (mut number, mut shorter) = (gone, shorter.line);
        if shorter.len() > longer.line.len() {
            number = known;
            std::mem::swap(&mut shorter, &mut longer.line);
        }
        for (place, task) in shorter.iter() {
            longer.line.enter(priorities, place, task);
            if let Some(waiter) = self.waiters.get_mut(&task) {
                waiter.line = Some(number);
            }
        }
        longer.link = link;
        self.lines.insert(number, longer);
        match self.links.binary_search_by_key(&link, |known| known.number) {
            Ok(at) => self.links[at].line = number,
            Err(_) => self.open_line = number,
        }
    }
}

/// How a task that waits can come to have the valve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    /// Nothing more is to be suspended.
    Open,
    /// This subtree is to be interrupted.
    Through(u32),
    /// This subtree is to be interrupted, and a clean-up runs in it.
    Blocked(u32),
    /// Its priority is not higher than the holder's.
    Closed,
}

/// Who is served next, and what keeps a more important one from it.
#[derive(Clone, Copy, Debug, Default)]
struct Next {
    served: Option<(Place, u32, Option<u32>)>,
    blocked: Option<(Place, u32)>,
    /// How many were looked at.
    looks: u64,
}

impl Next {
    /// Notes the way of one who waits; tells whether it leads on.
    fn note(&mut self, priorities: &Priorities, place: Place, task: u32, way: Way) -> bool {
        self.looks += 1;
        let is_first = |known: Option<Place>| known.is_none_or(|known| place.is_before(known, priorities));
        match way {
            Way::Open | Way::Through(_) => {
                if is_first(self.served.map(|(place, ..)| place)) {
                    let root = if let Way::Through(root) = way { Some(root) } else { None };
                    self.served = Some((place, task, root));
                }
                true
            }
            Way::Blocked(root) => {
                if is_first(self.blocked.map(|(place, _)| place)) {
                    self.blocked = Some((place, root));
                }
                false
            }
            Way::Closed => false,
        }
    }
}

impl Task {
    /// Whether the task runs hooks of its parent and is no child of a construct.
    pub(crate) fn named_as_hook(&self) -> bool {
        self.rare.as_ref().is_some_and(|rare| rare.hooks_for.is_some())
    }

    /// Valves it has holds of, one for each hold.
    fn held(&self) -> &[u32] {
        self.rare.as_ref().map_or(&[], |rare| &rare.held)
    }
}

impl Machine {
    /// How many links and waiters were looked at for valves, in this value's own life: what a test of
    /// growth counts.
    pub fn valve_work(&self) -> u64 {
        self.scratch.valve_looks
    }

    pub(crate) fn valve_name(&self, valve: u32) -> &str {
        self.symbols.name(self.valves[valve as usize].name)
    }

    /// The task that has the valve now or had it last.
    pub(crate) fn holder_of(&self, valve: u32) -> Option<u32> {
        self.valves[valve as usize].top_hold().and_then(|(_, hold)| self.tasks.find_alive(hold.task))
    }

    /// Whether a task, or one above it, holds the valve now.
    pub fn holds_valve(&self, task: u32, valve: u32) -> bool {
        let top = self.valves[valve as usize].links.last().filter(|link| link.is_hold());
        top.and_then(|hold| self.tasks.find(hold.task)).is_some_and(|holder| self.is_within(task, holder))
    }

    /// Asks for a valve; tells whether the task has it now. If not, it waits in line.
    pub(crate) fn request_valve(
        &mut self,
        around: &mut Surroundings<'_>,
        task: u32,
        valve: u32,
    ) -> Result<bool, Raise> {
        if self.valves[valve as usize].links.is_empty() || self.holds_valve(task, valve) {
            self.take(task, valve, Purpose::Plan);
            return Ok(true);
        }
        let is_open = matches!(self.way(task, self.effective_priority(task), valve), Way::Open | Way::Through(_));
        if let Some(holder) = self.holder_of(valve).filter(|_| !is_open) {
            self.check_circle(around.program, task, holder, Waiting::Valve(valve))?;
        }
        self.trace_valve(task, valve, "requested");
        self.tasks[task].waiting = Waiting::Valve(valve);
        self.join_valve_line(task, valve);
        self.stir(around, valve);
        Ok(self.tasks[task].waiting != Waiting::Valve(valve))
    }

    /// A request takes its place.
    fn join_valve_line(&mut self, task: u32, valve: u32) {
        let priority = self.effective_priority(task);
        let entry = &mut self.valves[valve as usize];
        entry.asked += 1;
        let place = Place { priority, asked: entry.asked };
        entry.waiters.insert(task, Waiter { place, line: None });
        self.heap.allocated += memory::WAITER;
        self.enter_line(task, valve);
    }

    /// A task that waits stands in line, unless it is suspended.
    fn enter_line(&mut self, task: u32, valve: u32) {
        if self.tasks[task].is_held() {
            return;
        }
        let priority = self.effective_priority(task);
        let link = self.link_above(task, valve);
        let entry = &mut self.valves[valve as usize];
        self.scratch.valve_looks += entry.links.len() as u64;
        if let Some(waiter) = entry.waiters.get_mut(&task) {
            waiter.place.priority = priority;
        }
        entry.enter(&self.priorities, task, link);
    }

    /// A task waits no longer.
    pub(crate) fn leave_valve_line(&mut self, task: u32, valve: u32) {
        let entry = &mut self.valves[valve as usize];
        entry.leave(&self.priorities, task);
        entry.waiters.remove(&task);
        // Whoever kept it waiting is to know.
        if entry.claim.is_some() {
            self.scratch.restless.insert(valve);
        }
    }

    /// A task that waits for a valve was suspended, resumed, or has another priority now.
    pub(crate) fn change_line(&mut self, task: u32, change: impl FnOnce(&mut Self)) {
        let Waiting::Valve(valve) = self.tasks[task].waiting else { return change(self) };
        self.valves[valve as usize].leave(&self.priorities, task);
        change(self);
        self.enter_line(task, valve);
        self.scratch.restless.insert(valve);
    }

    /// The topmost link whose task is this one or above it.
    pub(crate) fn link_above(&self, task: u32, valve: u32) -> u64 {
        let links = self.valves[valve as usize].links.iter().rev();
        let mut above =
            links.filter(|link| self.tasks.find(link.task).is_some_and(|other| self.is_within(task, other)));
        above.next().map_or(NO_LINK, |link| link.number)
    }

    /// Gives the valve to a task that waits for it.
    fn grant(&mut self, around: &mut Surroundings<'_>, task: u32, valve: u32) {
        self.interrupt_activations(around, task, valve);
        self.leave_valve_line(task, valve);
        self.take(task, valve, Purpose::Plan);
        if task == self.current {
            self.tasks[task].waiting = Waiting::Nothing;
        } else {
            self.wake(task, Wake::Value(Value::Nil));
        }
    }

    /// The task's hold goes on top, or counts once more.
    fn take(&mut self, task: u32, valve: u32, purpose: Purpose) {
        let me = self.tasks.reference(task);
        let top = self.valves[valve as usize].links.last_mut().filter(|top| top.task == me && top.serves(purpose));
        if let Some(LinkKind::Hold { count, .. }) = top.map(|top| &mut top.kind) {
            *count += 1;
            return;
        }
        let number = self.valves[valve as usize].push(me, LinkKind::Hold { count: 1, purpose });
        self.tasks[task].rare().held.push(valve);
        self.heap.allocated += memory::LINK;
        if purpose != Purpose::Hooks {
            self.trace_valve(task, valve, "granted");
        }
        self.gather_line(task, valve, number);
    }

    /// Those who wait below a task that has taken the valve just now stand in its line.
    fn gather_line(&mut self, task: u32, valve: u32, number: u64) {
        if self.tasks[task].first_child == NONE {
            return;
        }
        let line = &self.valves[valve as usize].line;
        self.scratch.valve_looks += line.len() as u64;
        let below: Vec<u32> =
            line.iter().map(|(_, other)| other).filter(|&other| self.is_within(other, task)).collect();
        below.into_iter().for_each(|other| self.move_to_line(other, valve, number));
    }

    /// One who waits stands in the line of another link from now on.
    fn move_to_line(&mut self, task: u32, valve: u32, link: u64) {
        let entry = &mut self.valves[valve as usize];
        entry.leave(&self.priorities, task);
        entry.enter(&self.priorities, task, link);
    }

    /// Takes a link out of the stack; its line goes to the links below.
    fn remove_link(&mut self, valve: u32, at: usize) {
        self.scratch.valve_looks += (self.valves[valve as usize].links.len() - at) as u64;
        let link = self.valves[valve as usize].links.remove(at);
        if let Some(task) = self.tasks.find(link.task) {
            let rare = self.tasks[task].rare();
            let list = if link.is_hold() { &mut rare.held } else { &mut rare.marked };
            if let Some(at) = list.iter().rposition(|&known| known == valve) {
                list.swap_remove(at);
            }
            if let LinkKind::Hold { purpose: Purpose::Plan | Purpose::Activation(_), .. } = link.kind {
                self.trace_valve(task, valve, "released");
            }
        }
        if self.valves[valve as usize].lines.contains_key(&link.line) {
            self.pass_line_down(valve, at, link);
        }
    }

    /// Those below a link that is gone stand in the line of the next one they are below.
    fn pass_line_down(&mut self, valve: u32, at: usize, gone: Link) {
        let next = self.valves[valve as usize].links[..at].last().copied();
        let contains = |link: Link| match (self.tasks.find(link.task), self.tasks.find(gone.task)) {
            (Some(above), Some(gone)) => self.is_within(gone, above),
            _ => false,
        };
        if next.is_none_or(contains) {
            let link = next.map_or(NO_LINK, |next| next.number);
            self.valves[valve as usize].join_lines(&self.priorities, gone.line, link);
            return;
        }
        let Some(below) = self.valves[valve as usize].lines.get(&gone.line) else { return };
        let waiters: Vec<u32> = below.line.iter().map(|(_, task)| task).collect();
        for task in waiters {
            let link = self.link_above(task, valve);
            self.move_to_line(task, valve, link);
        }
    }

    /// Gives one hold of a task back.
    pub(crate) fn release_valve(&mut self, around: &mut Surroundings<'_>, task: u32, valve: u32) {
        let me = self.tasks.reference(task);
        let links = &mut self.valves[valve as usize].links;
        let Some(at) = links.iter().rposition(|link| link.task == me && link.serves(Purpose::Plan)) else { return };
        if let LinkKind::Hold { count: count @ 2.., .. } = &mut links[at].kind {
            *count -= 1;
            return;
        }
        self.remove_link(valve, at);
        self.stir(around, valve);
    }

    /// A dead task holds nothing, and nothing is suspended below it.
    pub(crate) fn drop_links_of(&mut self, around: &mut Surroundings<'_>, task: u32) {
        let me = self.tasks.reference(task);
        let Some(rare) = &mut self.tasks[task].rare else { return };
        let claimed = std::mem::take(&mut rare.claimed);
        let valves: BTreeSet<u32> = rare.held.iter().chain(&rare.marked).copied().collect();
        for valve in claimed {
            self.valves[valve as usize].claim = None;
            self.claims -= 1;
            self.scratch.restless.insert(valve);
        }
        for valve in valves {
            while let Some(at) = self.valves[valve as usize].links.iter().rposition(|link| link.task == me) {
                self.remove_link(valve, at);
            }
            self.scratch.restless.insert(valve);
        }
        self.serve_valves(around);
    }

    /// A borrowed hold for a behaviour.
    pub(crate) fn hold_for_activation(&mut self, task: u32, valve: u32, behaviour: u16) {
        self.take(task, valve, Purpose::Activation(behaviour));
    }

    /// The behaviour has ended: its hold is given back.
    pub(crate) fn release_activation(&mut self, around: &mut Surroundings<'_>, behaviour: u16, owner: Option<TaskRef>) {
        let purpose = Purpose::Activation(behaviour);
        let held = owner.and_then(|owner| self.tasks.find(owner)).map_or(&[][..], |owner| self.tasks[owner].held());
        let drives = |&&valve: &&u32| self.valves[valve as usize].links.iter().any(|link| link.serves(purpose));
        let Some(&valve) = held.iter().find(drives) else { return };
        if let Some(at) = self.valves[valve as usize].links.iter().rposition(|link| link.serves(purpose)) {
            self.remove_link(valve, at);
            self.stir(around, valve);
        }
    }

    /// Behaviours that drive with a valve lose it to a task they do not belong to.
    fn interrupt_activations(&mut self, around: &mut Surroundings<'_>, task: u32, valve: u32) {
        let mut driving = Vec::new();
        for (at, link) in self.valves[valve as usize].links.iter().enumerate().rev() {
            let owner = self.tasks.find(link.task);
            if let LinkKind::Hold { purpose: Purpose::Activation(behaviour), .. } = link.kind
                && !owner.is_some_and(|owner| self.is_within(task, owner))
            {
                driving.push((at, behaviour));
            }
        }
        driving.iter().for_each(|&(at, _)| self.remove_link(valve, at));
        driving.iter().rev().for_each(|&(_, behaviour)| self.interrupt_behaviour(around, behaviour));
    }

    /// Something has changed about a valve.
    pub(crate) fn stir(&mut self, around: &mut Surroundings<'_>, valve: u32) {
        self.scratch.restless.insert(valve);
        self.serve_valves(around);
    }

    /// Lets valves about which something has changed go on to whom they are due, unless something
    /// is just being decided.
    pub(crate) fn serve_valves(&mut self, around: &mut Surroundings<'_>) {
        if self.scratch.is_serving || self.scratch.is_departing {
            return;
        }
        self.scratch.is_serving = true;
        while let Some(valve) = self.scratch.restless.pop_first() {
            self.serve_valve(around, valve);
        }
        self.scratch.boost_changes.clear();
        self.scratch.is_serving = false;
    }

    /// Lets a valve go on until nobody can have it any more.
    fn serve_valve(&mut self, around: &mut Surroundings<'_>, valve: u32) {
        loop {
            let next = self.next_served(valve);
            self.scratch.valve_looks += 1 + next.looks;
            if let Some((_, task, root)) = next.served {
                self.let_in(around, task, valve, root);
            } else if self.valves[valve as usize].top_mark().is_some() && self.valves[valve as usize].handover.is_none()
            {
                self.give_back(around, valve);
            } else {
                self.set_claim(valve, next.blocked);
                return;
            }
        }
    }

    /// Who is served next, and who would be if no clean-up kept it waiting.
    fn next_served(&self, valve: u32) -> Next {
        let entry = &self.valves[valve as usize];
        let mut next = Next::default();
        let Some((first, task)) = entry.line.first() else { return next };
        let Some((_, hold)) = entry.top_hold() else {
            let way = self.way(task, first.priority, valve);
            next.note(&self.priorities, first, task, way);
            return next;
        };
        let Some(holder) = self.tasks.find_alive(hold.task) else { return next };
        let lent = entry.lines.get(&hold.line).filter(|_| entry.top_mark().is_none());
        if let Some((place, task)) = lent.and_then(|below| below.line.first()) {
            next.note(&self.priorities, place, task, Way::Open);
        }
        let floor = self.tasks[holder].priority;
        if entry.handover.is_none() && self.priorities.is_higher(first.priority, floor) {
            for below in entry.lines.values() {
                self.look_along(&mut next, valve, below, holder, floor);
            }
        }
        next
    }

    /// Looks for who can pre-empt the holder in one line. Those who are below no task that is above
    /// the holder too all want the same subtree suspended: the first speaks for all.
    fn look_along(&self, next: &mut Next, valve: u32, below: &Below, holder: u32, floor: u32) {
        let entry = &self.valves[valve as usize];
        let link = entry.links.binary_search_by_key(&below.link, |link| link.number).ok().map(|at| entry.links[at]);
        let lender = link.filter(Link::is_hold).and_then(|link| self.tasks.find(link.task));
        let is_inside = lender.is_some_and(|lender| self.is_within(holder, lender));
        let most = if is_inside { usize::MAX } else { 1 };
        for (place, task) in below.line.iter().take(most) {
            let is_higher = self.priorities.is_higher(place.priority, floor);
            if !is_higher || next.note(&self.priorities, place, task, self.way(task, place.priority, valve)) {
                return;
            }
        }
    }

    /// How a task with this priority could come to have the valve.
    fn way(&self, task: u32, priority: u32, valve: u32) -> Way {
        let entry = &self.valves[valve as usize];
        if entry.handover.is_some() {
            return Way::Closed;
        }
        let Some((at, hold)) = entry.top_hold() else {
            let interrupted = entry.top_mark().and_then(|mark| self.tasks.find_alive(mark.task));
            let is_first =
                interrupted.is_none_or(|root| self.priorities.is_higher(priority, self.effective_priority(root)));
            return if is_first { Way::Open } else { Way::Closed };
        };
        let Some(holder) = self.tasks.find_alive(hold.task) else { return Way::Closed };
        // Who is kept waiting by a clean-up is so whatever that runs at because of it.
        if !self.priorities.is_higher(priority, self.tasks[holder].priority) {
            return Way::Closed;
        }
        let root = self.subtree_to_interrupt(task, holder, valve);
        let mut marks = entry.links[at + 1..].iter().filter_map(|mark| self.tasks.find_alive(mark.task));
        let root = root.filter(|&root| !marks.any(|mark| self.is_within(root, mark)));
        match root {
            Some(root) if !self.is_at_rest(root) => Way::Blocked(root),
            _ if !self.priorities.is_higher(priority, self.effective_priority(holder)) => Way::Closed,
            Some(root) => Way::Through(root),
            None => Way::Open,
        }
    }

    /// What is suspended when a task pre-empts the holder; none if it is below the holder itself.
    fn subtree_to_interrupt(&self, task: u32, holder: u32, valve: u32) -> Option<u32> {
        let mut around = BTreeSet::new();
        let mut at = task;
        while at != NONE {
            around.insert(at);
            at = self.tasks[at].parent;
        }
        let (mut branch, mut owner, mut is_inside) = (None, holder, false);
        let (mut at, mut below) = (holder, NONE);
        while at != NONE {
            if around.contains(&at) && branch.is_none() {
                branch = Some(below);
            }
            if self.tasks[at].held().contains(&valve) {
                is_inside |= branch.is_some();
                owner = at;
            }
            (below, at) = (at, self.tasks[at].parent);
        }
        match branch {
            Some(branch) if is_inside => Some(branch).filter(|&branch| branch != NONE),
            _ => Some(owner),
        }
    }

    /// A task gets the valve, or hooks run first.
    fn let_in(&mut self, around: &mut Surroundings<'_>, task: u32, valve: u32, root: Option<u32>) {
        let Some(root) = root else { return self.grant(around, task, valve) };
        self.trace_valve(root, valve, "pre-empted");
        let hooks = self.hooks_of(root, valve, true);
        self.hold(around, root);
        let reference = self.tasks.reference(root);
        self.valves[valve as usize].push(reference, LinkKind::Mark);
        self.tasks[root].rare().marked.push(valve);
        self.heap.allocated += memory::LINK;
        if !self.start_hooks(around, root, valve, &hooks, Handover::Lend) {
            self.grant(around, task, valve);
        }
    }

    /// The valve comes back to whom it was taken away from last.
    fn give_back(&mut self, around: &mut Surroundings<'_>, valve: u32) {
        let mark = self.valves[valve as usize].top_mark();
        let Some(root) = mark.and_then(|mark| self.tasks.find_alive(mark.task)) else { return };
        let hooks = if self.tasks[root].is_protected() { Vec::new() } else { self.hooks_of(root, valve, false) };
        if !self.start_hooks(around, root, valve, &hooks, Handover::GiveBack) {
            self.lift_mark(around, valve);
        }
    }

    /// The topmost mark goes away, and its root goes on.
    fn lift_mark(&mut self, around: &mut Surroundings<'_>, valve: u32) {
        let Some(mark) = self.valves[valve as usize].top_mark() else { return };
        let Some(root) = self.tasks.find_alive(mark.task) else { return };
        let first = self.valves[valve as usize].lines.get(&mark.line).and_then(|below| below.line.first());
        let at = self.valves[valve as usize].links.len() - 1;
        self.remove_link(valve, at);
        self.trace_valve(root, valve, "returned");
        self.unhold(around, root);
        let holder = self.holder_of(valve);
        let Some((place, task)) = first.filter(|_| !holder.is_some_and(|holder| self.is_within(holder, root))) else {
            return;
        };
        // A clean-up of the interrupted stands for it.
        let mut next = Next::default();
        let way = if self.holds_valve(task, valve) { Way::Open } else { self.way(task, place.priority, valve) };
        if next.note(&self.priorities, place, task, way)
            && let Some((_, task, root)) = next.served
        {
            self.let_in(around, task, valve, root);
        }
    }

    /// Closures of the active hooks of a subtree, innermost first, but for what is interrupted
    /// already.
    fn hooks_of(&self, root: u32, valve: u32, on_interrupt: bool) -> Vec<Value> {
        let marks = self.valves[valve as usize].interrupted().filter_map(|mark| self.tasks.find(mark));
        let interrupted: BTreeSet<u32> = marks.filter(|&mark| mark != root).collect();
        let mut hooks = Vec::new();
        let mut waiting = vec![(root, false)];
        while let Some((task, children_done)) = waiting.pop() {
            if !children_done {
                waiting.push((task, true));
                let children = self.children(task).into_iter().rev();
                waiting.extend(children.filter(|child| !interrupted.contains(child)).map(|child| (child, false)));
                continue;
            }
            hooks.extend(self.tasks[task].scopes.iter().rev().filter_map(|scope| match scope.kind {
                ScopeKind::OnInterrupt(hook) if on_interrupt => Some(hook),
                ScopeKind::OnResume(hook) if !on_interrupt => Some(hook),
                _ => None,
            }));
        }
        hooks
    }

    /// Runs hooks in a task of their own below the subtree's root, which holds the valve meanwhile.
    /// Tells whether there is anything to run.
    fn start_hooks(
        &mut self,
        around: &mut Surroundings<'_>,
        root: u32,
        valve: u32,
        hooks: &[Value],
        handover: Handover,
    ) -> bool {
        let runner = self.symbols.find("%run-hooks").and_then(|name| around.program.names.get(&name));
        let runner = runner.map(|&global| self.globals[global as usize]);
        let (Some(Value::Function(code)), false) = (runner, hooks.is_empty()) else { return false };
        self.valves[valve as usize].handover = Some(handover);
        let list = self.heap.list(hooks);
        let name = self.symbols.intern("hooks");
        let registers = self.tasks.registers.set(Registers::default(), &[list]);
        let mut task = Task::new(code, registers, name, self.tasks[root].priority);
        task.priority_depth = self.tasks[root].priority_depth;
        task.rare().hooks_for = Some(valve);
        task.occurrence = self.count_use(root, name);
        let index = self.tasks.insert(task);
        self.adopt(root, self.tasks[root].scopes.len() as u32, index);
        self.take(index, valve, Purpose::Hooks);
        self.set_claim(valve, None);
        self.make_ready(index);
        self.trace_task_begin(index);
        true
    }

    /// If the task ran hooks, the valve changes hands now.
    pub(crate) fn hooks_ended(&mut self, around: &mut Surroundings<'_>, task: u32) {
        let Some(valve) = self.tasks[task].rare.as_ref().and_then(|rare| rare.hooks_for) else { return };
        if self.tasks[task].state == State::Failed {
            let failure = self.tasks[task].value;
            self.warn_of_failure(around.program, failure, "in a hook");
        }
        if self.valves[valve as usize].handover.take() == Some(Handover::GiveBack) {
            self.lift_mark(around, valve);
        }
        self.stir(around, valve);
    }

    /// What keeps the first in line waiting runs at its priority: a subtree with clean-ups, or one
    /// whose hooks run.
    fn set_claim(&mut self, valve: u32, blocked: Option<(Place, u32)>) {
        let entry = &self.valves[valve as usize];
        let with_hooks = entry.handover.and(entry.links.iter().rev().find(|link| link.is_mark()));
        let claim = match (with_hooks, entry.line.first(), blocked) {
            (Some(mark), Some((first, _)), _) => Some(Claim { root: mark.task, priority: first.priority }),
            (None, _, Some((place, root))) => {
                Some(Claim { root: self.tasks.reference(root), priority: place.priority })
            }
            (Some(_), None, _) | (None, _, None) => None,
        };
        let before = std::mem::replace(&mut self.valves[valve as usize].claim, claim);
        if before == claim {
            return;
        }
        if let Some(root) = before.and_then(|claim| self.tasks.find(claim.root)) {
            self.claims -= 1;
            self.tasks[root].rare().claimed.retain(|&known| known != valve);
            self.refresh_boosts(root);
        }
        if let Some(root) = claim.and_then(|claim| self.tasks.find(claim.root)) {
            self.claims += 1;
            self.tasks[root].rare().claimed.push(valve);
            self.refresh_boosts(root);
        }
    }

    /// A clean-up has ended: valves for which somebody waits for that are served.
    pub(crate) fn stir_claims_above(&mut self, around: &mut Surroundings<'_>, task: u32) {
        let mut at = task;
        while self.claims > 0 && at != NONE {
            if let Some(rare) = &self.tasks[at].rare {
                self.scratch.restless.extend(&rare.claimed);
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
                for claim in rare.claimed.iter().filter_map(|&valve| self.valves[valve as usize].claim) {
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
            self.priorities.enqueue(&mut self.tasks, task, line, false);
        }
        // Its priority counts for those who want its valves.
        let rare = self.tasks[task].rare();
        self.scratch.restless.extend(rare.held.iter().chain(&rare.marked));
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
