//! `routes`: how good the routes of the case memory are, and how much work.

use super::route_rows::{ROWS, RouteRow};
use super::{Building, pictures};
use crate::conduct::chosen;
use crate::findings::Findings;
use crate::kind::{ExperimentKind, Run};
use crate::request::ExperimentRequest;
use crate::statistics::Summary;
use anyhow::Result;
use rpl_rupart::trial::{RouteAsked, run_routes};
use rpl_shell::status::Status;
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::{NOTHING, Table};
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

/// What came of the routes of a row. Shares are those of a run; their mean is over the runs, and so is its interval.
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
    /// The share of routes that take at most 1.1 times as long as the quickest.
    pub near: Option<Summary>,
    /// The share that 95 % of the runs reach.
    pub near_fifth_percentile: f64,
    /// The share of routes that take at most 1.5 times as long.
    pub not_poor: Option<Summary>,
    /// How many times as long the worst takes.
    pub worst: f64,
    /// How long the quickest takes for each second of the route, on the average.
    pub efficiency: f64,
    /// Routes for which the planner generated at most two steps.
    pub few_generated: Option<Summary>,
    /// Of different problems.
    pub few_generated_different: f64,
    /// Routes of which at most two steps are not the case's.
    pub few_new: Option<Summary>,
    /// Of different problems.
    pub few_new_different: f64,
    /// Steps the planner generated for a route.
    pub generated_steps: f64,
    /// Those of a run, as a share of the steps of routes made from scratch.
    pub generated_of_scratch: Option<Summary>,
    /// Steps of a route that are not the case's.
    pub new_steps: f64,
    /// Places the planner expanded for a route.
    pub expanded: f64,
    /// Those of a run, as a share of the places that A* expands for all of its routes.
    pub expanded_of_a_star: Option<Summary>,
    /// Places that A* expands for the whole of a route.
    pub a_star_expanded: f64,
    /// The share of routes that were poor by the bound, and made anew.
    pub repaired: f64,
}

impl RouteResult {
    /// The figures of some runs.
    pub fn of(row: &RouteRow, runs: &[Vec<RouteAsked>]) -> Self {
        let counted = runs.iter().map(|asked| asked.get(row.learned_on..).unwrap_or(&[]));
        let counted: Vec<Vec<&RouteAsked>> =
            counted.filter(|run| !run.is_empty()).map(|run| run.iter().collect()).collect();
        let all: Vec<&RouteAsked> = counted.iter().flatten().copied().collect();
        let different: Vec<&RouteAsked> = all.iter().copied().filter(|asked| asked.is_first).collect();
        let of_runs = |of: &dyn Fn(&[&RouteAsked]) -> f64| {
            let shares: Vec<f64> = counted.iter().map(|run| of(run)).collect();
            Summary::of(&shares)
        };
        let is_near = |asked: &RouteAsked| asked.ratio <= NEAR + 1e-9;
        let mut near: Vec<f64> = counted.iter().map(|run| share(run, is_near)).collect();
        near.sort_by(f64::total_cmp);
        let few_generated = |asked: &RouteAsked| asked.adapted.generated_steps <= FEW_STEPS;
        let few_new = |asked: &RouteAsked| asked.adapted.new_steps <= FEW_STEPS;
        let generated = |asked: &RouteAsked| asked.adapted.generated_steps as f64;
        let expanded = |asked: &RouteAsked| asked.adapted.expanded as f64;
        let of_a_star = |asked: &RouteAsked| asked.from_scratch_expanded as f64;
        let of_scratch = |asked: &RouteAsked| asked.from_scratch_steps as f64;
        Self {
            name: row.name.to_string(),
            runs: runs.len(),
            routes: all.len(),
            different: different.len() as f64 / runs.len().max(1) as f64,
            near_fifth_percentile: near.get(near.len() / 20).copied().unwrap_or(f64::NAN),
            near: Summary::of(&near),
            not_poor: of_runs(&|run| share(run, |asked| asked.ratio <= POOR)),
            worst: all.iter().map(|asked| asked.ratio).fold(1.0, f64::max),
            efficiency: mean(&all, |asked| 1.0 / asked.ratio),
            few_generated: of_runs(&|run| share(run, few_generated)),
            few_generated_different: share(&different, few_generated),
            few_new: of_runs(&|run| share(run, few_new)),
            few_new_different: share(&different, few_new),
            generated_steps: mean(&all, generated),
            generated_of_scratch: of_runs(&|run| mean(run, generated) / mean(run, of_scratch)),
            new_steps: mean(&all, |asked| asked.adapted.new_steps as f64),
            expanded: mean(&all, expanded),
            expanded_of_a_star: of_runs(&|run| mean(run, expanded) / mean(run, of_a_star)),
            a_star_expanded: mean(&all, of_a_star),
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

/// How good, how much is new, and how much work: three tables with a line for each row.
pub fn blocks(rows: &[RouteResult]) -> Vec<Block> {
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let of_runs = |share: Option<Summary>| {
        let told = |share: Summary| format!("{} %", share.told(100.0, 1));
        share.map_or(NOTHING.to_string(), told)
    };
    let mut good = Table::new(&["", "routes", "≤ 1.1", "of 95 % of runs", "≤ 1.5", "worst", "efficiency"]);
    let mut steps = Table::new(&["", "generated ≤ 2", "different", "new", "new ≤ 2", "different"]);
    let mut work = Table::new(&["", "generated", "of scratch", "expanded", "A*", "of A*", "repaired"]);
    for row in rows {
        good.row([
            row.name.clone(),
            row.routes.to_string(),
            of_runs(row.near),
            percent(row.near_fifth_percentile),
            of_runs(row.not_poor),
            format!("{:.2}", row.worst),
            percent(row.efficiency),
        ]);
        steps.row([
            row.name.clone(),
            of_runs(row.few_generated),
            percent(row.few_generated_different),
            format!("{:.2}", row.new_steps),
            of_runs(row.few_new),
            percent(row.few_new_different),
        ]);
        work.row([
            row.name.clone(),
            format!("{:.2}", row.generated_steps),
            of_runs(row.generated_of_scratch),
            format!("{:.1}", row.expanded),
            format!("{:.1}", row.a_star_expanded),
            of_runs(row.expanded_of_a_star),
            percent(row.repaired),
        ]);
    }
    let blank = || Block::Lines(String::new());
    let titled = |title: &str, table: Table| [Block::Lines(title.to_string()), Block::Table(table), blank()];
    let mut blocks: Vec<Block> = [
        titled("how long routes take, for each second of the quickest there is; intervals over the runs", good),
        titled("steps of a route that the planner generated, and that its case does not have", steps),
        titled("work: steps generated, of those of routes from scratch; places expanded, of those of A*", work),
    ]
    .into_iter()
    .flatten()
    .collect();
    blocks.pop();
    blocks
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
