//! Runs a generated program under disturbances and judges the run.

use super::robot::{Whim, library};
use super::{Dice, grammar};
use rpl_lang::compile::NoFiles;
use rpl_runtime::run::disturbance::Disturbance;
use rpl_runtime::run::library::Loaded;
use rpl_runtime::run::system::{Outcome, System};
use rpl_runtime::state::limits::Limits;
use rpl_runtime::state::task::State;
use rpl_runtime::state::value::{TaskRef, Value};
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Steps of the scheduler before a run is told to stop.
const STEPS: usize = 160;

/// Steps of the scheduler in which it must then have ended.
const STEPS_TO_END: usize = 100_000;

/// The function whose plan tasks are given.
const NEW_PLAN: &str = "new-plan";

/// What cases with revisions have beside the generated text.
const REVISIONS: &str = "(defun new-plan () (wait-time 0.1) 'new)\n\
    (defmacro revise (task) `(ignore-failures (control-error deadlock) (swap-plan ,task '(seq (wait-time 0.1) (note 'new)))))\n\
    (defmacro keep (task) `(no-revision (wait-time 0.1) (note (finished? ,(if (consp task) 'none task)))))\n";

/// What else happens to a run that must make no difference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variation {
    /// Nothing.
    Plain,
    /// It is replaced by its fork now and then.
    Forked,
    /// It is saved and loaded now and then.
    Saved,
    /// Garbage is collected as often as can be.
    Collected,
    /// Control comes back from the middle of a task every few steps.
    Sliced,
}

const VARIATIONS: [Variation; 5] =
    [Variation::Plain, Variation::Forked, Variation::Saved, Variation::Collected, Variation::Sliced];

/// A run to be judged.
#[derive(Clone, Debug)]
pub struct Case {
    /// Of the disturbances, and of the program if that was generated.
    pub seed: u64,
    /// The program.
    pub text: String,
}

/// What a run left behind.
#[derive(Clone, Debug, PartialEq)]
struct Record {
    trace: Vec<String>,
    notes: Vec<String>,
    ending: String,
}

/// How many of the cases took which way.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    /// Runs that were judged, each once as it was and once varied.
    pub runs: u64,
    /// Texts that were refused.
    pub rejected: usize,
    /// Runs whose main task succeeded.
    pub succeeded: usize,
    /// Runs whose main task failed.
    pub failed: usize,
    /// Runs that were told to stop.
    pub stopped: usize,
    /// Steps of the scheduler.
    pub steps: usize,
    /// Clean-ups that ran.
    pub clean_ups: usize,
}

impl Case {
    /// The case of a seed.
    pub fn generated(seed: u64) -> Self {
        Self { seed, text: grammar::program(seed) }
    }

    /// The case of a seed in which tasks are given other plans where they would be ended, and where others
    /// are suspended, they are kept from that.
    pub fn revised(seed: u64) -> Self {
        let text = grammar::program(seed).replace("(evaporate ", "(revise ").replace("(suspend ", "(keep ");
        Self { seed, text: format!("{REVISIONS}{text}") }
    }

    /// Judges the runs of the case in which some task is given another plan before the first step, before
    /// the second, and so on, nothing else happening to them.
    ///
    /// # Errors
    /// The first thing that should not have happened.
    pub fn judge_swaps(&self, tally: &mut Tally) -> Result<(), String> {
        let text = format!("{REVISIONS}{}", self.text);
        let judged = catch_unwind(AssertUnwindSafe(|| {
            let loaded = library().load("generated.rpl", &text, &mut NoFiles).map_err(|found| found.render(false))?;
            for at in 0..STEPS {
                let seed = self.seed.wrapping_add((at as u64) << 40);
                let steps = judge_run(&loaded, seed, Some(at), tally).map_err(|what| format!("swap {at}: {what}"))?;
                if steps <= at {
                    break;
                }
            }
            Ok(())
        }));
        judged.unwrap_or_else(|panic| Err(format!("panic: {}", said(&*panic))))
    }

    /// Compiles the case and judges a number of its runs, each under disturbances of its own.
    ///
    /// # Errors
    /// The first thing that should not have happened.
    pub fn judge(&self, runs: u64, tally: &mut Tally) -> Result<(), String> {
        let judged = catch_unwind(AssertUnwindSafe(|| {
            let Ok(loaded) = library().load("generated.rpl", &self.text, &mut NoFiles) else {
                tally.rejected += 1;
                return Ok(());
            };
            (0..runs)
                .try_for_each(|number| judge_run(&loaded, self.seed.wrapping_add(number << 40), None, tally).map(drop))
        }));
        judged.unwrap_or_else(|panic| Err(format!("panic: {}", said(&*panic))))
    }
}

/// One run as it is, and once more with a variation; before a certain step, some task of it is given another
/// plan. Gives how many steps it took.
fn judge_run(loaded: &Loaded, seed: u64, swap_at: Option<usize>, tally: &mut Tally) -> Result<usize, String> {
    let mut dice = Dice::new(seed ^ 0xd15e_a5ed);
    let period_us = [None, None, Some(70_000), Some(300_000)][dice.below(4)];
    let mischief = [0, 40, 12, 6, 3][dice.below(5)];
    // What a limit of memory leaves, in bytes; without one nothing is short of it.
    let room = [None, None, None, Some(30_000), Some(100_000), Some(400_000)][dice.below(6)];
    let variation = match (VARIATIONS[dice.below(VARIATIONS.len())], room) {
        // Where memory runs out depends on what was collected when, and on how often registers were laid
        // aside.
        (Variation::Collected | Variation::Sliced, Some(_)) => Variation::Forked,
        (variation, _) => variation,
    };
    let run = |variation| Run {
        system: start(loaded, period_us, room),
        is_short: room.is_some(),
        loaded,
        dice: Dice::new(seed),
        variation,
        vary: Dice::new(!seed),
        mischief: if swap_at.is_none() { mischief } else { 0 },
        swap_at,
        entries: BTreeMap::new(),
        record: Record { trace: Vec::new(), notes: Vec::new(), ending: String::new() },
        steps: 0,
    };
    let (plain, steps) = run(Variation::Plain).go()?;
    let (varied, _) = run(variation).go().map_err(|what| format!("{variation:?}: {what}"))?;
    compare(&plain, &varied).map_err(|what| format!("{variation:?} makes a difference: {what}"))?;
    tally.runs += 1;
    tally.steps += steps;
    tally.clean_ups += plain.notes.iter().filter(|note| note.starts_with("clean")).count();
    match plain.ending.split(' ').next() {
        Some("succeeded") => tally.succeeded += 1,
        Some("failed") => tally.failed += 1,
        _ => tally.stopped += 1,
    }
    Ok(steps)
}

/// What a panic said.
pub fn said(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().cloned();
    text.or_else(|| panic.downcast_ref::<&str>().map(ToString::to_string)).unwrap_or_default()
}

fn start(loaded: &Loaded, period_us: Option<u64>, room: Option<usize>) -> System<Whim> {
    let robot = Whim { period_us, ..Whim::default() };
    let mut system = System::traced(library().clone(), loaded.clone(), robot, 0);
    system.machine.limits = Limits { steps: 300, frames: 60, ..Limits::default() };
    if let Some(room) = room {
        system.machine.collect();
        // A share of the limit is kept in reserve.
        system.machine.limits.bytes = (system.machine.used_bytes() + room) / 63 * 64;
        system.machine.collect();
    }
    system
}

/// A line without the numbers of unnamed objects, which depend on collections.
fn without_slots(line: &str) -> String {
    let mut parts = line.split("#<");
    let first = parts.next().unwrap_or_default().to_string();
    parts.fold(first, |text, part| {
        let (object, rest) = part.split_once('>').unwrap_or((part, ""));
        text + "#<" + object.trim_end_matches(|letter: char| letter.is_ascii_digit()) + ">" + rest
    })
}

fn compare(plain: &Record, varied: &Record) -> Result<(), String> {
    for (one, other) in plain.trace.iter().zip(&varied.trace) {
        if one != other {
            return Err(format!("`{one}` became `{other}`"));
        }
    }
    if plain == varied { Ok(()) } else { Err(format!("`{}` became `{}`", plain.ending, varied.ending)) }
}

struct Run<'l> {
    system: System<Whim>,
    loaded: &'l Loaded,
    dice: Dice,
    variation: Variation,
    vary: Dice,
    /// The number of steps in which a disturbance comes once; never if 0.
    mischief: usize,
    /// Before this step, some task is given another plan.
    swap_at: Option<usize>,
    /// Memory is short: what was entered may fail before its clean-up is there.
    is_short: bool,
    /// Parts that were entered and whose clean-up has not run: their tasks, in the order of entering.
    entries: BTreeMap<i64, TaskRef>,
    record: Record,
    steps: usize,
}

impl Run<'_> {
    fn go(mut self) -> Result<(Record, usize), String> {
        while self.system.outcome().is_none() && self.steps < STEPS {
            if self.mischief > 0 && self.dice.once_in(self.mischief) {
                self.disturb();
                self.check("after a disturbance")?;
            }
            if self.swap_at == Some(self.steps) {
                self.swap();
                self.check("after another plan was given")?;
            }
            self.step()?;
        }
        if self.system.outcome().is_none() {
            self.system.stop();
            self.system.outside.period_us = None;
        }
        while self.system.outcome().is_none() {
            if self.steps > STEPS + STEPS_TO_END {
                return Err("it was told to stop and does not end".into());
            }
            self.step()?;
        }
        self.record.ending = match self.system.outcome() {
            Some(Outcome::Succeeded(value)) => {
                format!("succeeded {}", self.system.machine.write(&self.system.program, value))
            }
            Some(Outcome::Failed(value)) => format!("failed {}", self.system.machine.show(&self.system.program, value)),
            Some(Outcome::Evaporated) | None => "evaporated".into(),
        };
        self.record.ending = without_slots(&self.record.ending);
        self.check_end()?;
        Ok((self.record, self.steps))
    }

    fn step(&mut self) -> Result<(), String> {
        self.steps += 1;
        self.vary()?;
        if !self.system.step_task() {
            self.system.next_instant();
        }
        self.check("after a step")
    }

    fn vary(&mut self) -> Result<(), String> {
        match self.variation {
            Variation::Plain => {}
            Variation::Forked => {
                if self.vary.once_in(4) {
                    self.system = self.system.fork();
                }
            }
            Variation::Saved => {
                if self.vary.once_in(16) {
                    let saved = self.system.save();
                    let again = System::load(&saved, library().clone(), self.loaded.clone(), Whim::default());
                    let again = again.map_err(|error| format!("what was saved is not loaded: {error}"))?;
                    if again.save() != saved {
                        return Err("saved again, the bytes differ".into());
                    }
                    self.system = again;
                }
            }
            Variation::Collected => self.system.machine.heap.threshold = self.vary.below(8),
            Variation::Sliced => self.system.slice_steps = 1 + self.vary.below(7) as u32,
        }
        Ok(())
    }

    /// A task of the tree; by its place there, for which slot it has depends on collections.
    fn some_task(&mut self) -> TaskRef {
        let machine = &self.system.machine;
        let mut living = vec![machine.main];
        let mut at = 0;
        while let Some(&task) = living.get(at) {
            living.extend(machine.children(task));
            at += 1;
        }
        machine.tasks.reference(living[self.dice.below(living.len())])
    }

    /// A fluent that the text names: which others there are depends on what was collected.
    fn some_fluent(&mut self) -> u32 {
        let globals = self.system.machine.globals.iter();
        let named: Vec<u32> =
            globals.filter_map(|value| if let Value::Fluent(fluent) = value { Some(*fluent) } else { None }).collect();
        named[self.dice.below(named.len())]
    }

    fn disturb(&mut self) {
        let task = self.some_task();
        let main = self.system.machine.main;
        let disturbance = match self.dice.below(16) {
            0..=2 if task.index != main || self.dice.once_in(4) => Disturbance::Evaporate(task),
            3..=5 => Disturbance::Suspend(task),
            6..=8 => Disturbance::Resume(task),
            9..=11 => Disturbance::Fail(task),
            12 | 13 => {
                let value = [Value::True, Value::Nil, Value::Int(2)][self.dice.below(3)];
                Disturbance::Assign(self.some_fluent(), value)
            }
            _ => Disturbance::Pulse(self.some_fluent()),
        };
        self.system.disturb(disturbance);
    }

    /// Some task is given the plan of the function `new-plan`.
    fn swap(&mut self) {
        let task = self.some_task();
        let (program, machine) = (&self.system.program, &self.system.machine);
        let name = machine.symbols.find(NEW_PLAN).and_then(|name| program.names.get(&name));
        if let Some(Value::Function(code)) = name.and_then(|&global| machine.globals.get(global as usize)) {
            let code = *code;
            self.system.disturb(Disturbance::Swap(task, code));
        }
    }

    fn check(&mut self, when: &str) -> Result<(), String> {
        let steps = self.steps;
        let at = |what: String| format!("{when} ({steps}): {what}");
        for event in self.system.machine.trace.take() {
            self.record.trace.push(without_slots(&event.to_string()));
        }
        let output = std::mem::take(&mut self.system.machine.output);
        for line in output {
            let line = line.text;
            take_note(&mut self.entries, &line).or_else(|what| if self.is_short { Ok(()) } else { Err(at(what)) })?;
            // Which slot a task has is nobody's business: collections free some earlier.
            let is_about_part = matches!(line.split(' ').next(), Some("enter" | "clean" | "pass"));
            self.record.notes.push(if is_about_part {
                line.split(' ').take(2).collect()
            } else {
                without_slots(&line)
            });
        }
        let tasks = &self.system.machine.tasks;
        let lost = self.entries.iter().find(|&(_, &task)| tasks.find_alive(task).is_none());
        if let Some((entry, _)) = lost.filter(|_| !self.is_short) {
            let trace = self.record.trace.join("\n");
            return Err(at(format!(
                "the task of part {entry} is dead and its clean-up has not run\n{trace}\n{:?}",
                self.record.notes
            )));
        }
        self.system.machine.check_invariants().map_err(at)
    }

    fn check_end(&mut self) -> Result<(), String> {
        let machine = &self.system.machine;
        if let Some((index, task)) = machine.tasks.iter().skip(1).find(|(_, task)| !task.state().is_dead()) {
            return Err(format!("main is dead and {} is {}", machine.path(index), task.state().name()));
        }
        if let Some(place) = machine.places.iter().find(|place| !place.is_at_rest()) {
            return Err(format!("main is dead and a place of a valve is not free: {place:?}"));
        }
        if let Some(valve) = machine.valves.iter().find(|valve| !valve.waiters.is_empty()) {
            return Err(format!("main is dead and somebody waits for a valve: {valve:?}"));
        }
        if machine.watches.iter().next().is_some() {
            return Err("main is dead and a watch is left".into());
        }
        if let Some((_, fluent)) = machine.fluents.iter().find(|(_, fluent)| fluent.waiters != Default::default()) {
            return Err(format!("main is dead and a fluent has waiters: {fluent:?}"));
        }
        if let Some(next_us) = self.system.next_instant_us()
            && self.system.outside.period_us.is_none()
        {
            return Err(format!("main is dead and a timer is left for {next_us}"));
        }
        match self.system.machine.tasks[self.system.machine.main].state() {
            State::Succeeded | State::Failed | State::Evaporated => Ok(()),
            other => Err(format!("main is {}", other.name())),
        }
    }
}

/// What a note says about a part: entered, cleaned up once, and innermost first within its task.
fn take_note(entries: &mut BTreeMap<i64, TaskRef>, line: &str) -> Result<(), String> {
    let words: Vec<&str> = line.split(' ').collect();
    let [what @ ("enter" | "clean" | "pass" | "early"), entry, index, generation] = words[..] else { return Ok(()) };
    let (Ok(entry), Ok(index), Ok(generation)) = (entry.parse::<i64>(), index.parse(), generation.parse()) else {
        return Err(format!("a note that nobody writes: {line}"));
    };
    let task = TaskRef { index, generation };
    match what {
        "enter" => {
            entries.insert(entry, task);
        }
        "early" => return Err(format!("the clean-up of part {entry} runs while something of the part is left")),
        _ => {
            if entries.remove(&entry) != Some(task) {
                return Err(format!("the clean-up of part {entry} runs twice, or in another task"));
            }
            if let Some(inner) = entries.range(entry..).find(|&(_, &other)| other == task) {
                return Err(format!("part {entry} is left before the part {} inside it", inner.0));
            }
        }
    }
    Ok(())
}
