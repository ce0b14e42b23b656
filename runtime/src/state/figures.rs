//! What projecting plans has found, as figures.

use crate::state::projected::Grain;
use rpl_lang::number::{format_float, non_finite};
use serde::de::Error;
use serde::{Deserialize, Serialize};

/// The answer to a question about plans.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Foresight {
    /// Of the first plan with each of the others, if they were compared.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub comparisons: Vec<Comparison>,
    /// Of each plan.
    pub plans: Vec<Figures>,
}

/// A comparison of two plans.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// How much more the second was worth than the first in the same run, on average.
    #[serde(with = "any_number")]
    pub difference: f64,
    /// The standard error of that.
    #[serde(with = "any_number")]
    pub error: f64,
    /// Whether the second is better by as much as was asked for.
    pub is_better: bool,
    /// Nothing was left to chance in either plan.
    pub is_certain: bool,
    /// How many runs tell it.
    pub runs: u32,
}

/// How a plan would go. Three numbers are those below which a tenth, a half and nine tenths lie.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// How often it was projected.
    pub runs: usize,
    /// How many of these runs succeeded.
    pub successes: usize,
    /// How probable success is, as they tell it, and the ends of its 95 % interval.
    pub success: [f64; 3],
    /// How long those take that succeed, if any does.
    pub time_s: Option<[f64; 3]>,
    /// What goes wrong, the most frequent first.
    pub failures: Vec<FailureFigure>,
    /// What fluents with a number are in the end.
    pub fluents: Vec<FluentFigure>,
    /// When tagged steps begin, the earliest first.
    pub timeline: Vec<StepFigure>,
    /// How far from now the runs go, in seconds.
    pub horizon_s: f64,
    /// In which detail the robot was projected.
    pub grain: Grain,
    /// How long a plan that asks thinks, in seconds of the run.
    pub thinking_s: f64,
}

/// One kind of failure in projected runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FailureFigure {
    /// Of all runs.
    pub share: f64,
    /// Its class, or `evaporated`, `unfinished`, `runaway`.
    pub class: String,
    /// Where it was raised; empty if nowhere in a text.
    pub place: String,
    /// What the first of them says.
    pub message: String,
    /// The seed of the run of the first.
    pub seed: u64,
}

/// What a fluent is in the end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FluentFigure {
    /// Its name.
    pub name: String,
    /// Its number.
    #[serde(with = "any_numbers")]
    pub quantiles: [f64; 3],
}

/// When a tagged step begins.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepFigure {
    /// The path of its task.
    pub path: String,
    /// Of the runs that come to it.
    pub share: f64,
    /// From now.
    pub begins_s: [f64; 3],
}

/// A number as JSON has it, and one that JSON has not as plans write it: what is recorded is read again.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum WrittenNumber {
    Finite(f64),
    Other(String),
}

impl From<f64> for WrittenNumber {
    fn from(number: f64) -> Self {
        if number.is_finite() { Self::Finite(number) } else { Self::Other(format_float(number)) }
    }
}

impl WrittenNumber {
    fn read<E: Error>(self) -> Result<f64, E> {
        match self {
            Self::Finite(number) => Ok(number),
            Self::Other(text) => non_finite(&text).ok_or_else(|| E::custom(format!("`{text}` is no number"))),
        }
    }
}

mod any_number {
    use super::WrittenNumber;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<S: Serializer>(number: &f64, to: S) -> Result<S::Ok, S::Error> {
        WrittenNumber::from(*number).serialize(to)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
        WrittenNumber::deserialize(from)?.read()
    }
}

mod any_numbers {
    use super::WrittenNumber;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<S: Serializer>(numbers: &[f64; 3], to: S) -> Result<S::Ok, S::Error> {
        numbers.map(WrittenNumber::from).serialize(to)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<[f64; 3], D::Error> {
        let [low, median, high] = <[WrittenNumber; 3]>::deserialize(from)?;
        Ok([low.read()?, median.read()?, high.read()?])
    }
}
