//! The choice by the sum over the states of the belief: the oracle for the shortcut by maxima.

use super::choice::{ActionField, Choice, consider_by};
use super::entropy::EntropyForecast;
use super::parameters::ActiveParameters;
use crate::geometry::Point;
use crate::localization::{Localization, LocalizationModel, Maximum};

/// Most states taken into account; more are thinned out evenly.
const STATES: usize = 600;

/// States whose sensings the expectation is taken over, drawn evenly from the belief.
const SENSINGS: usize = 24;

/// States outside this share of the belief are left out.
const SHARE: f64 = 0.95;

/// The choice by the sum over states, and what the choice of `other` would be worth by it: the
/// pay-off of both, Eq. (9).
#[derive(Clone, Debug, PartialEq)]
pub struct ExactChoice {
    /// The best action.
    pub choice: Choice,
    /// Its pay-off, in nats.
    pub payoff: f64,
    /// Everything that was considered.
    pub field: ActionField,
    /// Pay-off of the other target by the same sum; none if no way leads there.
    pub payoff_of_other: Option<f64>,
}

/// Chooses as [`choose`](super::choose) does, with every state of the belief as a hypothesis in
/// place of its maxima: Eqs. (5) to (9) without the summary of the belief, but for the thinning
/// stated at the constants. A sensing is the noise-free scan at a state. Takes seconds.
pub fn choose_exactly(
    model: &LocalizationModel,
    localization: &Localization,
    other_in_base: Point,
    parameters: &ActiveParameters,
) -> Option<ExactChoice> {
    let states = thinned(localization.likely_states(model, SHARE), STATES);
    let truths = thinned(states.clone(), SENSINGS);
    let forecast = EntropyForecast::over(model, &states, &truths, parameters);
    let (choice, field) = consider_by(model, &states, &[], parameters, &forecast)?;
    let worth = |cost_m: f64, entropy: f64| -(entropy + parameters.alpha_per_m * cost_m);
    let payoff = worth(choice.cost_m, choice.expected_entropy);
    let payoff_of_other = field
        .grid
        .cell_at(other_in_base)
        .filter(|&cell| field.cost_m[cell].is_finite())
        .map(|cell| worth(field.cost_m[cell], forecast.expected(other_in_base)));
    Some(ExactChoice { choice, payoff, field, payoff_of_other })
}

/// At most `count` of them, evenly by mass: each stands for an equal share.
fn thinned(states: Vec<Maximum>, count: usize) -> Vec<Maximum> {
    if states.len() <= count {
        return states;
    }
    let total: f64 = states.iter().map(|state| state.mass).sum();
    let share = total / count as f64;
    let mut thinned = Vec::with_capacity(count);
    let (mut passed, mut due) = (0.0, share / 2.0);
    for state in states {
        passed += state.mass;
        while passed > due && thinned.len() < count {
            thinned.push(Maximum { mass: share, ..state });
            due += share;
        }
    }
    thinned
}
