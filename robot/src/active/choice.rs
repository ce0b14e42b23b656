//! Eq. (9): which target point to drive to.

use super::action::ActionGrid;
use super::cost::CostField;
use super::entropy::EntropyForecast;
use super::occupancy::occupancy;
use super::parameters::ActiveParameters;
use crate::geometry::Point;
use crate::localization::{LocalizationModel, Maximum};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// The chosen action.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// Where to go, relative to the robot now.
    pub target_in_base: Point,
    /// The way there: corners of the cost-optimal path, the target last.
    pub path_in_base: Vec<Point>,
    /// Entropy of the maxima now, in nats.
    pub current_entropy: f64,
    /// Entropy of the maxima expected at the target, in nats.
    pub expected_entropy: f64,
    /// v(a), in metres of free way.
    pub cost_m: f64,
}

/// Everything that was considered, for pictures; `[row][column]` as in [`ActionGrid`].
#[derive(Clone, Debug, PartialEq)]
pub struct ActionField {
    /// Where the cells lie.
    pub grid: ActionGrid,
    /// P_occ(a), Eq. (7).
    pub occupancy: Vec<f32>,
    /// v(a), Eq. (8), in metres of free way; infinite where no way leads.
    pub cost_m: Vec<f64>,
    /// E_a\[H\], Eq. (6), in nats; NaN where no way leads.
    pub expected_entropy: Vec<f32>,
    /// −(E_a\[H\] + α v(a)), Eq. (9); NaN where no way leads.
    pub payoff: Vec<f32>,
}

/// Chooses a target, argmin of E_a\[H\] + α v(a); none if there is no maximum or no way anywhere.
/// `obstacles_in_base` are points found occupied whatever the map says. Takes some 50 ms with ten
/// maxima.
pub fn choose(
    model: &LocalizationModel,
    maxima: &[Maximum],
    obstacles_in_base: &[Point],
    parameters: &ActiveParameters,
) -> Option<(Choice, ActionField)> {
    let forecast = EntropyForecast::new(model, maxima, parameters);
    choose_among(model, maxima, obstacles_in_base, parameters, &forecast)
}

/// The same for any hypotheses and a forecast over them.
pub(super) fn choose_among(
    model: &LocalizationModel,
    maxima: &[Maximum],
    obstacles_in_base: &[Point],
    parameters: &ActiveParameters,
    forecast: &EntropyForecast<'_>,
) -> Option<(Choice, ActionField)> {
    if maxima.is_empty() {
        return None;
    }
    let grid = ActionGrid::new(parameters.resolution_m, parameters.reach_m);
    let occupancy = occupancy(model, grid, maxima, obstacles_in_base, parameters);
    let costs = CostField::new(grid, &occupancy, parameters);
    let targets = targets(grid, &occupancy, &costs, parameters);
    let entropies: Vec<f64> = targets.par_iter().map(|&cell| forecast.expected(grid.point_in_base(cell))).collect();
    let payoff = |&(cell, entropy): &(usize, f64)| -(entropy + parameters.alpha_per_m * costs.cost_m[cell]);
    let candidates = targets.iter().copied().zip(entropies.iter().copied());
    let (cell, expected_entropy) = candidates
        .clone()
        .filter(|&(cell, _)| far_enough(grid.point_in_base(cell), parameters))
        .reduce(|best, next| if payoff(&next) > payoff(&best) { next } else { best })?;
    let path: Vec<Point> = costs.path(cell).into_iter().map(|cell| grid.point_in_base(cell)).collect();
    let choice = Choice {
        target_in_base: grid.point_in_base(cell),
        path_in_base: corners(&path),
        current_entropy: forecast.current(),
        expected_entropy,
        cost_m: costs.cost_m[cell],
    };
    let (expected_entropy, payoff) = paint(grid, &costs, candidates, parameters);
    Some((choice, ActionField { grid, occupancy, cost_m: costs.cost_m, expected_entropy, payoff }))
}

/// Every `target_step`-th cell that a way leads to and that is not almost certainly occupied.
fn targets(grid: ActionGrid, occupancy: &[f32], costs: &CostField, parameters: &ActiveParameters) -> Vec<usize> {
    let step = parameters.target_step.max(1);
    let on_raster = |index: usize| index % step == grid.reach % step;
    (0..grid.cells())
        .filter(|&cell| on_raster(cell / grid.side()) && on_raster(cell % grid.side()))
        .filter(|&cell| costs.cost_m[cell].is_finite() && f64::from(occupancy[cell]) <= parameters.blocked_probability)
        .collect()
}

fn far_enough(target_in_base: Point, parameters: &ActiveParameters) -> bool {
    target_in_base.coords.norm_squared() >= parameters.min_target_m * parameters.min_target_m
}

/// Fills the cells around each target with its entropy and pay-off.
fn paint(
    grid: ActionGrid,
    costs: &CostField,
    targets: impl Iterator<Item = (usize, f64)>,
    parameters: &ActiveParameters,
) -> (Vec<f32>, Vec<f32>) {
    let (mut entropy, mut payoff) = (vec![f32::NAN; grid.cells()], vec![f32::NAN; grid.cells()]);
    let half = parameters.target_step.max(1) / 2;
    let around = |index: usize| index.saturating_sub(half)..=(index + half).min(grid.side() - 1);
    for (cell, expected) in targets {
        for row in around(cell / grid.side()) {
            for column in around(cell % grid.side()) {
                let painted = row * grid.side() + column;
                if costs.cost_m[painted].is_finite() {
                    entropy[painted] = expected as f32;
                    payoff[painted] = -(expected + parameters.alpha_per_m * costs.cost_m[painted]) as f32;
                }
            }
        }
    }
    (entropy, payoff)
}

/// The points where a path of cells changes its direction, and its end.
fn corners(path: &[Point]) -> Vec<Point> {
    let turns = |window: &[Point]| {
        let (a, b) = (window[1] - window[0], window[2] - window[1]);
        libm::fabs(a.x - b.x) + libm::fabs(a.y - b.y) > 1e-9
    };
    let mut corners: Vec<Point> = path.windows(3).filter(|window| turns(window)).map(|window| window[1]).collect();
    corners.extend(path.last());
    corners
}
