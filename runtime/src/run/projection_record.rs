//! What is kept of projected runs, and the figures that plans get of it.

use crate::state::figures::{Comparison, FailureFigure, Figures, FluentFigure, Foresight, StepFigure};
use crate::state::machine::Machine;
use crate::state::projected::Grain;
use crate::state::value::Value;
use rpl_lang::code::Program;
use rpl_lang::symbol::{Symbol, Symbols};
use std::collections::BTreeMap;

/// Instants that are projected in a second: that is how long thinking takes in a run, whatever the machine. It is
/// chosen, and not measured on any.
const INSTANTS_A_SECOND: f64 = 50_000.0;

/// A run that fails is worth 0, one that succeeds at once 1, and one that succeeds at the horizon this.
const WORTH_AT_HORIZON: f64 = 0.5;

/// How a projected run has ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Ended {
    /// Well.
    Succeeded,
    /// With a failure.
    Failed(Value),
    /// It was ended by another task.
    Evaporated,
    /// It goes on beyond the horizon.
    Open,
    /// It took too many steps.
    GivenUp,
}

/// A failure of a projected run, as text: its heap is gone.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Cause {
    class: String,
    place: String,
}

/// What is kept of a run.
#[derive(Clone, Debug)]
pub(crate) struct RunEnd {
    seed: u64,
    took_us: u64,
    instants: u64,
    is_success: bool,
    is_certain: bool,
    cause: Option<(Cause, String)>,
    /// The last number of each named fluent that has one.
    numbers: BTreeMap<Symbol, f64>,
    begun: Vec<(String, u64)>,
}

impl RunEnd {
    pub fn new(
        machine: &Machine,
        program: &Program,
        ended: Ended,
        seed: u64,
        begun_us: u64,
        instants: u64,
        is_certain: bool,
    ) -> Self {
        let told = |class: &str, message: &str| {
            Some((Cause { class: class.to_string(), place: String::new() }, message.to_string()))
        };
        let cause = match ended {
            Ended::Succeeded => None,
            Ended::Failed(failure) => Some(machine.cause(program, failure)),
            Ended::Evaporated => told("evaporated", "another task ended it"),
            Ended::Open => told("unfinished", "it goes on beyond the horizon"),
            Ended::GivenUp => told("runaway", "it took more steps than are projected"),
        };
        let run = machine.projected.as_deref();
        let begun = run.map_or_else(Vec::new, |run| run.begun.clone());
        Self {
            seed,
            took_us: machine.now_us - begun_us,
            instants,
            is_success: ended == Ended::Succeeded,
            is_certain,
            cause,
            numbers: named_fluents(machine).filter_map(|(name, value)| Some((name, value.as_f64()?))).collect(),
            begun: begun.into_iter().map(|(path, at_us)| (path, at_us - begun_us)).collect(),
        }
    }

    /// By the number that a fluent has in the end, 0 without one, or else by success and time.
    fn worth(&self, horizon_us: u64, fluent: Option<Symbol>) -> f64 {
        if let Some(name) = fluent {
            return self.numbers.get(&name).copied().unwrap_or(0.0);
        }
        match self.is_success {
            true => 1.0 - (1.0 - WORTH_AT_HORIZON) * self.took_us as f64 / horizon_us as f64,
            false => 0.0,
        }
    }
}

impl Machine {
    /// The class of a failure, where it was raised, and its message; of one that has parts, of the first.
    fn cause(&self, program: &Program, failure: Value) -> (Cause, String) {
        let mut value = failure;
        let mut first = None;
        while let Value::Failure(index) = value {
            let found = &self.heap.failures[index];
            first = Some(found);
            match found.parts.first() {
                Some(&part) => value = part,
                None => break,
            }
        }
        let Some(found) = first else {
            let class = self.show(program, failure);
            return (Cause { class, place: String::new() }, String::new());
        };
        let place = found.span.map_or_else(String::new, |span| program.sources.place(span));
        (Cause { class: self.symbols.name(found.class).to_string(), place }, found.message.clone())
    }
}

fn named_fluents(machine: &Machine) -> impl Iterator<Item = (Symbol, Value)> {
    machine.fluents.iter().filter_map(|(_, fluent)| fluent.name.map(|name| (name, fluent.value)))
}

/// The runs of one plan.
#[derive(Clone, Debug)]
pub(crate) struct Projection {
    horizon_us: u64,
    grain: Grain,
    /// Names of the fluents that are told.
    fluents: Vec<Symbol>,
    pub runs: Vec<RunEnd>,
}

impl Projection {
    pub fn new(horizon_us: u64, grain: Grain, base: &Machine) -> Self {
        Self { horizon_us, grain, fluents: named_fluents(base).map(|(name, _)| name).collect(), runs: Vec::new() }
    }

    /// Whether nothing was left to chance: all further runs go like these.
    pub fn is_certain(&self) -> bool {
        self.runs.iter().all(|run| run.is_certain)
    }

    /// Counts its only run as `runs` runs, of which one was thought through.
    pub fn repeat(&mut self, runs: u32) {
        let first = self.runs.first().map(|run| RunEnd { instants: 0, ..run.clone() });
        self.runs.extend(std::iter::repeat_n(first, runs.saturating_sub(1) as usize).flatten());
    }

    /// How much more each run was worth than the same run of another plan.
    pub fn gains_over(&self, other: &Self, fluent: Option<Symbol>) -> Vec<f64> {
        let worth = |run: &RunEnd| run.worth(self.horizon_us, fluent);
        self.runs.iter().zip(&other.runs).map(|(run, other)| worth(run) - worth(other)).collect()
    }

    /// The figures.
    pub fn figures(&self, symbols: &Symbols) -> Figures {
        let took = |run: &RunEnd| run.took_us as f64 / 1e6;
        let instants: u64 = self.runs.iter().map(|run| run.instants).sum();
        Figures {
            runs: self.runs.len(),
            successes: self.successes(),
            success: self.success(),
            time_s: quantiles(self.runs.iter().filter(|run| run.is_success).map(took).collect()),
            failures: self.failures(),
            fluents: self.fluents(symbols),
            timeline: self.timeline(),
            horizon_s: self.horizon_us as f64 / 1e6,
            grain: self.grain,
            thinking_s: instants as f64 / INSTANTS_A_SECOND,
        }
    }

    fn successes(&self) -> usize {
        self.runs.iter().filter(|run| run.is_success).count()
    }

    /// How probable success is and the ends of its 95 % interval, by the distribution that the successes in these runs
    /// leave of it where nothing was known before. The mean is Laplace's rule of succession, (s + 1) / (n + 2): a few
    /// runs that all succeed do not make it certain.
    fn success(&self) -> [f64; 3] {
        let count = self.runs.len() as f64;
        let successes = self.successes() as f64;
        let share = (successes + 1.0) / (count + 2.0);
        let reach = 1.96 * libm::sqrt(share * (1.0 - share) / (count + 3.0));
        [share, (share - reach).max(0.0), (share + reach).min(1.0)]
    }

    fn failures(&self) -> Vec<FailureFigure> {
        let mut kinds: BTreeMap<&Cause, (usize, &str, u64)> = BTreeMap::new();
        for run in &self.runs {
            if let Some((cause, message)) = &run.cause {
                kinds.entry(cause).or_insert((0, message, run.seed)).0 += 1;
            }
        }
        let mut kinds: Vec<_> = kinds.into_iter().collect();
        kinds.sort_by_key(|&(_, (count, ..))| std::cmp::Reverse(count));
        kinds
            .into_iter()
            .map(|(cause, (count, message, seed))| FailureFigure {
                share: count as f64 / self.runs.len() as f64,
                class: cause.class.clone(),
                place: cause.place.clone(),
                message: message.to_string(),
                seed,
            })
            .collect()
    }

    fn fluents(&self, symbols: &Symbols) -> Vec<FluentFigure> {
        let numbers = |name: &Symbol| self.runs.iter().filter_map(|run| run.numbers.get(name).copied()).collect();
        let told = |name: &Symbol| {
            Some(FluentFigure { name: symbols.name(*name).to_string(), quantiles: quantiles(numbers(name))? })
        };
        self.fluents.iter().filter_map(told).collect()
    }

    fn timeline(&self) -> Vec<StepFigure> {
        let mut steps: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        for run in &self.runs {
            for (path, at_us) in &run.begun {
                steps.entry(path).or_default().push(*at_us as f64 / 1e6);
            }
        }
        let count = self.runs.len() as f64;
        let told = |(path, times): (&str, Vec<f64>)| {
            let share = times.len() as f64 / count;
            Some(StepFigure { path: path.to_string(), share, begins_s: quantiles(times)? })
        };
        let mut steps: Vec<StepFigure> = steps.into_iter().filter_map(told).collect();
        steps.sort_by(|a, b| a.begins_s[1].total_cmp(&b.begins_s[1]));
        steps
    }
}

impl Foresight {
    /// As a list, the time first that has passed while it was thought about; nil if none has, and it is still to pass.
    pub(crate) fn to_value(&self, machine: &mut Machine, passed_s: Option<f64>) -> Value {
        let comparisons: Vec<Value> = self.comparisons.iter().map(|comparison| comparison.to_value(machine)).collect();
        let mut parts = vec![passed_s.map_or(Value::Nil, Value::Float), machine.heap.list(&comparisons)];
        for figures in &self.plans {
            parts.push(figures.to_value(machine));
        }
        machine.heap.list(&parts)
    }
}

impl Figures {
    /// As a list of keywords and values.
    fn to_value(&self, machine: &mut Machine) -> Value {
        let success = floats(machine, &self.success);
        let time = self.time_s.map_or(Value::Nil, |quantiles| floats(machine, &quantiles));
        let mut failures = Vec::new();
        for FailureFigure { share, class, place, message, seed } in &self.failures {
            let class = Value::Symbol(machine.symbols.intern(class));
            let [place, message] = [place, message].map(|text| machine.heap.string(text));
            // Integers of plans have a sign.
            let seed = Value::Int(i64::from_ne_bytes(seed.to_ne_bytes()));
            failures.push(machine.heap.list(&[Value::Float(*share), class, place, message, seed]));
        }
        let mut fluents = Vec::new();
        for FluentFigure { name, quantiles } in &self.fluents {
            let (name, tail) = (Value::Symbol(machine.symbols.intern(name)), floats(machine, quantiles));
            fluents.push(machine.heap.cons(name, tail));
        }
        let mut timeline = Vec::new();
        for StepFigure { path, share, begins_s } in &self.timeline {
            let tail = floats(machine, begins_s);
            let tail = machine.heap.cons(Value::Float(*share), tail);
            let path = machine.heap.string(path);
            timeline.push(machine.heap.cons(path, tail));
        }
        let [failures, fluents, timeline] = [failures, fluents, timeline].map(|lists| machine.heap.list(&lists));
        let values = [
            ("runs", Value::Int(self.runs as i64)),
            ("successes", Value::Int(self.successes as i64)),
            ("success", success),
            ("time", time),
            ("failures", failures),
            ("fluents", fluents),
            ("timeline", timeline),
            ("horizon", Value::Float(self.horizon_s)),
            ("grain", Value::Keyword(machine.symbols.intern(self.grain.name()))),
            ("thinking", Value::Float(self.thinking_s)),
        ];
        property_list(machine, &values)
    }
}

impl Comparison {
    /// As a list of keywords and values.
    fn to_value(self, machine: &mut Machine) -> Value {
        let values = [
            ("better", Value::truth(self.is_better)),
            ("certain", Value::truth(self.is_certain)),
            ("difference", Value::Float(self.difference)),
            ("error", Value::Float(self.error)),
            ("runs", Value::Int(i64::from(self.runs))),
        ];
        property_list(machine, &values)
    }
}

/// The numbers below which a tenth, a half and nine tenths lie; none without numbers.
fn quantiles(mut numbers: Vec<f64>) -> Option<[f64; 3]> {
    numbers.sort_by(f64::total_cmp);
    let last = numbers.len().checked_sub(1)?;
    Some([0.1, 0.5, 0.9].map(|share| {
        let at = share * last as f64;
        let (below, part) = (at as usize, at - libm::floor(at));
        numbers[below] + (numbers[(below + 1).min(last)] - numbers[below]) * part
    }))
}

fn floats(machine: &mut Machine, numbers: &[f64]) -> Value {
    let values: Vec<Value> = numbers.iter().copied().map(Value::Float).collect();
    machine.heap.list(&values)
}

fn property_list(machine: &mut Machine, values: &[(&str, Value)]) -> Value {
    let flat: Vec<Value> =
        values.iter().flat_map(|&(name, value)| [Value::Keyword(machine.symbols.intern(name)), value]).collect();
    machine.heap.list(&flat)
}
