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

/// How many targets are looked at side by side; then it is seen whether a better one may be left.
const AT_A_TIME: usize = 64;

/// Chooses a target, argmin of E_a\[H\] + α v(a); none if there is no maximum or no way anywhere.
/// `obstacles_in_base` are points found occupied whatever the map says. Looks at targets in the order of their ways,
/// until these alone cost more than the best one is worth: some 10 ms with ten maxima.
pub fn choose(
    model: &LocalizationModel,
    maxima: &[Maximum],
    obstacles_in_base: &[Point],
    parameters: &ActiveParameters,
) -> Option<Choice> {
    let forecast = EntropyForecast::new(model, maxima, parameters);
    let actions = Actions::new(model, maxima, obstacles_in_base, parameters)?;
    let mut cells: Vec<usize> = actions.targets().filter(|&cell| actions.is_far_enough(cell)).collect();
    cells.sort_by(|&a, &b| actions.costs.cost_m[a].total_cmp(&actions.costs.cost_m[b]));
    let mut best: Option<Target> = None;
    for next in cells.chunks(AT_A_TIME) {
        // No entropy is below 0.
        let most = -parameters.alpha_per_m * actions.costs.cost_m[next[0]];
        if best.is_some_and(|best| best.payoff > most) {
            break;
        }
        best = best.into_iter().chain(actions.weighed(next, &forecast)).reduce(Target::better);
    }
    Some(actions.choice(best?, &forecast))
}

/// The same, and all that there is to choose from, whether it may be better or not.
pub fn consider(
    model: &LocalizationModel,
    maxima: &[Maximum],
    obstacles_in_base: &[Point],
    parameters: &ActiveParameters,
) -> Option<(Choice, ActionField)> {
    let forecast = EntropyForecast::new(model, maxima, parameters);
    consider_by(model, maxima, obstacles_in_base, parameters, &forecast)
}

/// The same for any hypotheses and a forecast over them.
pub(super) fn consider_by(
    model: &LocalizationModel,
    maxima: &[Maximum],
    obstacles_in_base: &[Point],
    parameters: &ActiveParameters,
    forecast: &EntropyForecast<'_>,
) -> Option<(Choice, ActionField)> {
    let actions = Actions::new(model, maxima, obstacles_in_base, parameters)?;
    let targets = actions.weighed(&actions.targets().collect::<Vec<usize>>(), forecast);
    let far = targets.iter().copied().filter(|target| actions.is_far_enough(target.cell));
    let choice = actions.choice(far.reduce(Target::better)?, forecast);
    let (expected_entropy, payoff) = actions.painted(&targets);
    let Actions { grid, occupancy, costs, .. } = actions;
    Some((choice, ActionField { grid, occupancy, cost_m: costs.cost_m, expected_entropy, payoff }))
}

/// A cell of the action grid, and what it is worth to go there.
#[derive(Clone, Copy)]
struct Target {
    cell: usize,
    expected_entropy: f64,
    payoff: f64,
}

impl Target {
    /// The one with the greater pay-off; of equal ones the first of the grid, in whatever order they come.
    fn better(self, other: Self) -> Self {
        let by_payoff = self.payoff.total_cmp(&other.payoff);
        if by_payoff.then(other.cell.cmp(&self.cell)).is_ge() { self } else { other }
    }
}

/// Where the robot could go, and at what cost.
struct Actions<'m> {
    parameters: &'m ActiveParameters,
    grid: ActionGrid,
    occupancy: Vec<f32>,
    costs: CostField,
}

impl<'m> Actions<'m> {
    /// None if there is no maximum.
    fn new(
        model: &LocalizationModel,
        maxima: &[Maximum],
        obstacles_in_base: &[Point],
        parameters: &'m ActiveParameters,
    ) -> Option<Self> {
        if maxima.is_empty() {
            return None;
        }
        let grid = ActionGrid::new(parameters.resolution_m, parameters.reach_m);
        let occupancy = occupancy(model, grid, maxima, obstacles_in_base, parameters);
        let costs = CostField::new(grid, &occupancy, parameters);
        Some(Self { parameters, grid, occupancy, costs })
    }

    /// Every `target_step`-th cell that a way leads to and that is not almost certainly occupied.
    fn targets(&self) -> impl Iterator<Item = usize> {
        let step = self.parameters.target_step.max(1);
        let on_raster = move |index: usize| index % step == self.grid.reach % step;
        let side = self.grid.side();
        let is_open = |cell: usize| f64::from(self.occupancy[cell]) <= self.parameters.blocked_probability;
        (0..self.grid.cells())
            .filter(move |&cell| on_raster(cell / side) && on_raster(cell % side))
            .filter(move |&cell| self.costs.cost_m[cell].is_finite() && is_open(cell))
    }

    fn is_far_enough(&self, cell: usize) -> bool {
        let least_m = self.parameters.min_target_m;
        self.grid.point_in_base(cell).coords.norm_squared() >= least_m * least_m
    }

    /// What it is worth to go to some cells.
    fn weighed(&self, cells: &[usize], forecast: &EntropyForecast<'_>) -> Vec<Target> {
        let target = |&cell: &usize| {
            let expected_entropy = forecast.expected(self.grid.point_in_base(cell));
            let payoff = -(expected_entropy + self.parameters.alpha_per_m * self.costs.cost_m[cell]);
            Target { cell, expected_entropy, payoff }
        };
        cells.par_iter().map(target).collect()
    }

    fn choice(&self, Target { cell, expected_entropy, .. }: Target, forecast: &EntropyForecast<'_>) -> Choice {
        let path: Vec<Point> = self.costs.path(cell).into_iter().map(|cell| self.grid.point_in_base(cell)).collect();
        Choice {
            target_in_base: self.grid.point_in_base(cell),
            path_in_base: corners(&path),
            current_entropy: forecast.current(),
            expected_entropy,
            cost_m: self.costs.cost_m[cell],
        }
    }

    /// Entropy and pay-off of the cells around each target.
    fn painted(&self, targets: &[Target]) -> (Vec<f32>, Vec<f32>) {
        let (grid, costs) = (self.grid, &self.costs);
        let (mut entropy, mut payoff) = (vec![f32::NAN; grid.cells()], vec![f32::NAN; grid.cells()]);
        let half = self.parameters.target_step.max(1) / 2;
        let around = |index: usize| index.saturating_sub(half)..=(index + half).min(grid.side() - 1);
        for target in targets {
            for row in around(target.cell / grid.side()) {
                for column in around(target.cell % grid.side()) {
                    let painted = row * grid.side() + column;
                    if costs.cost_m[painted].is_finite() {
                        entropy[painted] = target.expected_entropy as f32;
                        payoff[painted] =
                            -(target.expected_entropy + self.parameters.alpha_per_m * costs.cost_m[painted]) as f32;
                    }
                }
            }
        }
        (entropy, payoff)
    }
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
