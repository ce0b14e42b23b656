//! `routes`: how good the routes of the case memory are, and how much work.

use super::route_rows::{ROWS, RouteRow};
use super::{Building, pictures};
use crate::experiment::conduct::chosen;
use crate::experiment::findings::Findings;
use crate::experiment::kind::{ExperimentKind, Run};
use crate::experiment::request::ExperimentRequest;
use crate::experiment::statistics::Dispersion;
use crate::status::Status;
use crate::terminal::page::Block;
use crate::terminal::table::Table;
use anyhow::Result;
use rpl_rupart::trial::{RouteAsked, run_routes};
use serde::Serialize;
use serde_json::json;

/// A route is near the quickest if it takes at most this many times as long.
const NEAR: f64 = 1.1;

/// It is poor if it takes more than this.
const POOR: f64 = 1.5;

/// Steps that are few to add (Fox and Anderson-Sprecher, Route plan quality).
const FEW_STEPS: usize = 2;

/// What can be asked for with `--row`.
pub fn row_names() -> Vec<&'static str> {
    ROWS.iter().map(|row| row.name).collect()
}

/// Asks for routes, row by row.
pub struct Routes {
    request: ExperimentRequest,
    rows: Vec<&'static RouteRow>,
}

impl Routes {
    /// What is asked for.
    ///
    /// # Errors
    /// No row has the name.
    pub fn new(request: ExperimentRequest) -> Result<Self> {
        let rows = chosen(&request, &ROWS, |row| row.name)?;
        Ok(Self { request, rows })
    }
}

impl ExperimentKind for Routes {
    type Ground = Building;
    type Record = Vec<RouteAsked>;
    type Tally = Vec<Vec<RouteAsked>>;

    fn series(&self) -> Vec<String> {
        self.rows.iter().map(|row| row.name.to_string()).collect()
    }

    fn ground(&self, _: usize) -> Result<Building> {
        Building::of(&self.request)
    }

    fn run(&self, series: usize, building: &Building, run: Run) -> Result<Vec<RouteAsked>> {
        let home = building.places.closest(building.world.start_in_map.point());
        Ok(run_routes(&building.places, home, &self.rows[series].trial, run.seed))
    }

    fn head(&self, _: &Vec<RouteAsked>) -> String {
        "row,seed,number,ratio,generated,new,expanded,a_star_expanded,repaired,first".to_string()
    }

    fn lines(&self, series: &str, run: Run, asked: &Vec<RouteAsked>) -> String {
        lines(series, run.seed, asked)
    }

    fn findings(&self, tallies: Vec<Vec<Vec<RouteAsked>>>, wants_drawings: bool) -> Result<Findings> {
        let rows: Vec<(&RouteRow, Vec<Vec<RouteAsked>>)> = self.rows.iter().copied().zip(tallies).collect();
        let results: Vec<RouteResult> = rows.iter().map(|(row, asked)| RouteResult::of(row, asked)).collect();
        let drawings = match wants_drawings {
            true => {
                let building = Building::of(&self.request)?;
                pictures::files(&building.world, &building.places, &rows)
            }
            false => Vec::new(),
        };
        let (blocks, figures) = (blocks(&results), json!({ "rows": results }));
        Ok(Findings { status: Status::Succeeded, blocks, figures, drawings })
    }
}

/// What came of the routes of a row.
#[derive(Clone, Debug, Serialize)]
pub struct RouteResult {
    /// What the row is called.
    pub name: String,
    /// Sequences of goals.
    pub runs: usize,
    /// Routes that count.
    pub routes: usize,
    /// Different problems in a run, on the average.
    pub different: f64,
    /// Of the runs: the share of routes that take at most 1.1 times as long as the quickest.
    pub near: Option<Dispersion>,
    /// The share that 95 % of the runs reach.
    pub near_fifth_percentile: f64,
    /// The share of routes that take at most 1.5 times as long.
    pub not_poor: f64,
    /// How many times as long the worst takes.
    pub worst: f64,
    /// How long the quickest takes for each second of the route, on the average.
    pub efficiency: f64,
    /// Routes for which the planner generated at most two steps; the same among different problems.
    pub few_generated: f64,
    /// Of different problems.
    pub few_generated_different: f64,
    /// Routes of which at most two steps are not the case's.
    pub few_new: f64,
    /// Of different problems.
    pub few_new_different: f64,
    /// Steps the planner generated for a route.
    pub generated_steps: f64,
    /// Steps of a route that are not the case's.
    pub new_steps: f64,
    /// Places the planner expanded for a route.
    pub expanded: f64,
    /// Places that A* expands for the whole of it.
    pub a_star_expanded: f64,
    /// The share of routes that were poor by the bound, and made anew.
    pub repaired: f64,
}

impl RouteResult {
    /// The figures of some runs.
    pub fn of(row: &RouteRow, runs: &[Vec<RouteAsked>]) -> Self {
        let counted: Vec<&[RouteAsked]> = runs.iter().map(|asked| asked.get(row.learned_on..).unwrap_or(&[])).collect();
        let all: Vec<&RouteAsked> = counted.iter().copied().flatten().collect();
        let different: Vec<&RouteAsked> = all.iter().copied().filter(|asked| asked.is_first).collect();
        let is_near = |asked: &&RouteAsked| asked.ratio <= NEAR + 1e-9;
        let mut near: Vec<f64> = counted
            .iter()
            .filter(|run| !run.is_empty())
            .map(|run| run.iter().filter(|asked| is_near(asked)).count() as f64 / run.len() as f64)
            .collect();
        near.sort_by(f64::total_cmp);
        let few_generated = |asked: &RouteAsked| asked.adapted.generated_steps <= FEW_STEPS;
        let few_new = |asked: &RouteAsked| asked.adapted.new_steps <= FEW_STEPS;
        Self {
            name: row.name.to_string(),
            runs: runs.len(),
            routes: all.len(),
            different: different.len() as f64 / runs.len().max(1) as f64,
            near_fifth_percentile: near.get(near.len() / 20).copied().unwrap_or(f64::NAN),
            near: Dispersion::of(&near),
            not_poor: share(&all, |asked| asked.ratio <= POOR),
            worst: all.iter().map(|asked| asked.ratio).fold(1.0, f64::max),
            efficiency: mean(&all, |asked| 1.0 / asked.ratio),
            few_generated: share(&all, few_generated),
            few_generated_different: share(&different, few_generated),
            few_new: share(&all, few_new),
            few_new_different: share(&different, few_new),
            generated_steps: mean(&all, |asked| asked.adapted.generated_steps as f64),
            new_steps: mean(&all, |asked| asked.adapted.new_steps as f64),
            expanded: mean(&all, |asked| asked.adapted.expanded as f64),
            a_star_expanded: mean(&all, |asked| asked.from_scratch_expanded as f64),
            repaired: share(&all, |asked| asked.adapted.is_repaired),
        }
    }
}

fn mean(asked: &[&RouteAsked], number: impl Fn(&RouteAsked) -> f64) -> f64 {
    asked.iter().map(|asked| number(asked)).sum::<f64>() / asked.len().max(1) as f64
}

fn share(asked: &[&RouteAsked], is_so: impl Fn(&RouteAsked) -> bool) -> f64 {
    mean(asked, |asked| f64::from(is_so(asked)))
}

/// How good, and how much work: two tables with a line for each row.
pub fn blocks(rows: &[RouteResult]) -> Vec<Block> {
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let mut good = Table::new(&["", "routes", "≤ 1.1", "of 95 % of runs", "≤ 1.5", "worst", "efficiency"]);
    let mut work = Table::new(&[
        "",
        "generated",
        "≤ 2",
        "≤ 2, different",
        "new",
        "≤ 2",
        "≤ 2, different",
        "expanded",
        "A*",
        "repaired",
    ]);
    for row in rows {
        good.row([
            row.name.clone(),
            row.routes.to_string(),
            percent(row.near.map_or(f64::NAN, |near| near.mean)),
            percent(row.near_fifth_percentile),
            percent(row.not_poor),
            format!("{:.2}", row.worst),
            percent(row.efficiency),
        ]);
        work.row([
            row.name.clone(),
            format!("{:.2}", row.generated_steps),
            percent(row.few_generated),
            percent(row.few_generated_different),
            format!("{:.2}", row.new_steps),
            percent(row.few_new),
            percent(row.few_new_different),
            format!("{:.1}", row.expanded),
            format!("{:.1}", row.a_star_expanded),
            percent(row.repaired),
        ]);
    }
    vec![
        Block::Lines("how long routes take, for each second of the quickest there is".to_string()),
        Block::Table(good),
        Block::Lines(String::new()),
        Block::Lines(
            "work for a route: steps the planner generated, steps the case does not have, places expanded".into(),
        ),
        Block::Table(work),
    ]
}

/// The routes of a run as lines of comma-separated values.
fn lines(row: &str, seed: u64, run: &[RouteAsked]) -> String {
    let line = |(number, asked): (u32, &RouteAsked)| {
        let adapted = &asked.adapted;
        format!(
            "\"{row}\",{seed},{number},{:.4},{},{},{},{},{},{}\n",
            asked.ratio,
            adapted.generated_steps,
            adapted.new_steps,
            adapted.expanded,
            asked.from_scratch_expanded,
            adapted.is_repaired,
            asked.is_first
        )
    };
    (1..).zip(run).map(line).collect()
}
