//! The tables: a line for each kind of building, for each disturbance, and for all of them together.

use super::certainty::CertaintyCell;
use super::disturbance::Disturbance;
use super::rows::BuildingRow;
use super::trial::BuildingTrial;
use crate::failed_runs::{FailedRun, FailedRuns};
use crate::reliability::{self, Bin, Counted};
use crate::statistics::{Dispersion, PerKm, Proportion};
use rpl_robot::localization::{Calibration, LocalizationParameters};
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::{NOTHING, Table};
use serde::Serialize;
use serde_json::{Value, json};

/// How near to the last place an arrival is looked for.
const REACHES_M: [f64; 2] = [1.0, 0.5];

/// Figures of some runs.
#[derive(Clone, Debug, Serialize)]
struct RowFigures {
    name: String,
    runs: usize,
    /// Runs that count for nothing, because their scenario failed.
    not_measured: usize,
    /// The plan succeeded.
    arrived: Proportion,
    /// It did, and the robot really is within 1 m of the last place ...
    within_1_m: Proportion,
    /// ... and within 0.5 m.
    within_05_m: Proportion,
    /// How far it is from there in the median and at most, of the runs that have arrived.
    median_off_m: Option<f64>,
    largest_off_m: Option<f64>,
    /// Of the arrivals that the plan told of, those that were more than 1 m off.
    wrong_arrivals: Proportion,
    /// How often the position counted as lost ...
    losses: u32,
    /// ... and the estimate was right.
    false_losses_per_km: Option<PerKm>,
    /// Of the moments at which the robot was sure, those at which it was right.
    sure: Proportion,
    /// The certainty beside the truth.
    bins: Vec<Bin>,
    largest_error: f64,
    /// Of the robots that somebody turned or carried: those that know where they are at the end ...
    found_again: Proportion,
    /// ... those that noticed it soon ...
    noticed_within_3_m: Proportion,
    /// ... and runs in which a position counted as found where it was not, disturbed or not.
    wrong_recoveries: Proportion,
    blocked: u32,
    contacts: u32,
    median_time_s: Option<f64>,
    failures: Vec<FailedRun>,
    #[serde(skip)]
    failed_seeds: Option<String>,
}

impl RowFigures {
    fn of(name: &str, trials: &[&BuildingTrial]) -> Self {
        let measured: Vec<&BuildingTrial> = trials.iter().copied().filter(|trial| trial.is_measured()).collect();
        let count = |is_so: &dyn Fn(&BuildingTrial) -> bool| {
            Proportion::new(measured.iter().filter(|trial| is_so(trial)).count(), measured.len())
        };
        let sum = |of: fn(&BuildingTrial) -> u32| measured.iter().map(|trial| of(trial)).sum::<u32>();
        let spread = |of: fn(&BuildingTrial) -> f64, counts: fn(&BuildingTrial) -> bool| {
            let numbers: Vec<f64> = measured.iter().filter(|trial| counts(trial)).map(|trial| of(trial)).collect();
            Dispersion::of(&numbers)
        };
        let off_m = spread(|trial| trial.off_m, BuildingTrial::has_arrived);
        let arrivals: Vec<(usize, usize)> =
            measured.iter().map(|trial| (trial.wrong_arrivals, trial.arrivals)).collect();
        let sure: Vec<(usize, usize)> = measured.iter().map(|trial| trial.sure()).collect();
        let way_m: f64 = measured.iter().map(|trial| trial.way_m).sum();
        let bins = reliability::bins(counted(&measured, |trial| &trial.certainty));
        let by_hand = || measured.iter().filter_map(|trial| trial.by_hand);
        let noticed: Vec<bool> = by_hand().filter_map(|by_hand| by_hand.is_noticed()).collect();
        let mut failed = FailedRuns::default();
        for trial in &measured {
            let fault = match &trial.fault {
                Some(fault) => fault.clone(),
                None if trial.is_within(REACHES_M[0]) => continue,
                None => "wrong place".to_string(),
            };
            failed.add(FailedRun { seed: trial.seed, fault });
        }
        Self {
            name: name.to_string(),
            runs: trials.len(),
            not_measured: trials.len() - measured.len(),
            arrived: count(&BuildingTrial::has_arrived),
            within_1_m: count(&|trial| trial.is_within(REACHES_M[0])),
            within_05_m: count(&|trial| trial.is_within(REACHES_M[1])),
            median_off_m: off_m.map(|off_m| off_m.median),
            largest_off_m: off_m.map(|off_m| off_m.max),
            wrong_arrivals: Proportion::in_groups(&arrivals),
            losses: sum(|trial| trial.losses),
            false_losses_per_km: PerKm::new(sum(|trial| trial.false_losses), way_m / 1000.0),
            sure: Proportion::in_groups(&sure),
            largest_error: reliability::largest_error(&bins),
            bins,
            found_again: Proportion::new(by_hand().filter(|by_hand| by_hand.is_found).count(), by_hand().count()),
            noticed_within_3_m: Proportion::new(noticed.iter().filter(|noticed| **noticed).count(), noticed.len()),
            wrong_recoveries: count(&|trial| trial.wrong_recoveries > 0),
            blocked: sum(|trial| trial.blocked),
            contacts: sum(|trial| trial.contacts),
            median_time_s: spread(|trial| trial.time_s, |_| true).map(|time_s| time_s.median),
            failures: failed.told().to_vec(),
            failed_seeds: failed.seeds_and_classes(),
        }
    }

    /// Whether and how it arrived.
    fn arrival(&self) -> [String; 6] {
        let losses = |losses: &PerKm| {
            let (low, high) = losses.interval_95;
            format!("{:.0} ({:.0}–{:.0})", 10.0 * losses.rate, 10.0 * low, 10.0 * high)
        };
        [
            self.name.clone(),
            self.arrived.fraction(),
            self.arrived.interval(),
            self.within_1_m.count.to_string(),
            percent(&self.wrong_arrivals),
            self.false_losses_per_km.as_ref().map_or(NOTHING.to_string(), losses),
        ]
    }

    /// What it knew of its position.
    fn knowledge(&self) -> [String; 8] {
        let error = if self.bins.is_empty() { NOTHING.to_string() } else { format!("{:.3}", self.largest_error) };
        [
            self.name.clone(),
            percent(&self.sure),
            error,
            of_some(&self.found_again),
            of_some(&self.noticed_within_3_m),
            self.wrong_recoveries.count.to_string(),
            self.blocked.to_string(),
            self.contacts.to_string(),
        ]
    }
}

/// `99.8 (98.1–99.9)`
fn percent(share: &Proportion) -> String {
    let (low, high) = share.interval_95;
    let told = |rate: f64| format!("{:.1} ({:.1}–{:.1})", 100.0 * rate, 100.0 * low, 100.0 * high);
    share.rate.map_or(NOTHING.to_string(), told)
}

fn of_some(share: &Proportion) -> String {
    if share.of == 0 { NOTHING.to_string() } else { share.fraction() }
}

/// What some runs said of their positions.
fn counted<'t>(
    trials: &'t [&BuildingTrial],
    cells: fn(&BuildingTrial) -> &[CertaintyCell],
) -> impl Iterator<Item = Counted> + 't {
    trials.iter().enumerate().flat_map(move |(run, trial)| cells(trial).iter().map(move |cell| cell.counted(run)))
}

/// All figures.
pub struct Tables {
    series: Vec<RowFigures>,
    grounds: Vec<RowFigures>,
    disturbances: Vec<RowFigures>,
    all: RowFigures,
    /// Share of the belief and how often it is right, fitted to all runs ...
    fitted: Vec<[f64; 2]>,
    /// ... and share that dead reckoning has left near the estimate.
    fitted_reckoning: Vec<[f64; 2]>,
}

impl Tables {
    /// Of series, whose certainty was told by these parameters.
    pub fn of(rows: &[BuildingRow], tallies: &[Vec<BuildingTrial>], parameters: &LocalizationParameters) -> Self {
        let used = |by: &Option<Calibration>| by.clone().unwrap_or_else(|| Calibration::new(&[]));
        let of = |name: &str, counts: &dyn Fn(&BuildingRow) -> bool| {
            let of_row = |(row, trials)| if counts(row) { trials } else { &[][..] };
            let trials: Vec<&BuildingTrial> =
                rows.iter().zip(tallies.iter().map(Vec::as_slice)).flat_map(of_row).collect();
            RowFigures::of(name, &trials)
        };
        let mut grounds: Vec<&str> = rows.iter().map(|row| row.ground.name()).collect();
        grounds.dedup();
        let disturbances =
            Disturbance::ALL.into_iter().filter(|disturbance| rows.iter().any(|row| row.disturbance == *disturbance));
        let everything: Vec<&BuildingTrial> = tallies.iter().flatten().filter(|trial| trial.is_measured()).collect();
        Self {
            series: rows.iter().map(|row| of(&row.name(), &|other| other == row)).collect(),
            grounds: grounds.iter().map(|name| of(name, &|row| row.ground.name() == *name)).collect(),
            disturbances: disturbances
                .map(|disturbance| of(disturbance.name(), &|row| row.disturbance == disturbance))
                .collect(),
            all: of("all", &|_| true),
            fitted: reliability::fitted(counted(&everything, |trial| &trial.tracking), &used(&parameters.calibration)),
            fitted_reckoning: reliability::fitted(
                counted(&everything, |trial| &trial.reckoning),
                &used(&parameters.reckoning),
            ),
        }
    }

    /// The lines of the tables: of a table with one series there is nothing to sum up.
    fn lines(&self) -> Vec<&RowFigures> {
        if let [only] = &self.series[..] {
            return vec![only];
        }
        let mut lines: Vec<&RowFigures> = Vec::new();
        lines.extend(self.grounds.iter().filter(|_| self.grounds.len() > 1));
        lines.extend(self.disturbances.iter().filter(|_| self.disturbances.len() > 1));
        lines.push(&self.all);
        lines
    }

    /// For people.
    pub fn blocks(&self) -> Vec<Block> {
        let mut arrival =
            Table::new(&["", "arrived", "95 % interval", "there", "wrong [%] (95 %)", "lost/10 km (95 %)"]);
        let mut knowledge =
            Table::new(&["", "sure: right [%]", "error", "found", "≤ 3 m", "astray", "blocked", "contacts"]);
        for line in self.lines() {
            arrival.row(line.arrival());
            knowledge.row(line.knowledge());
        }
        let mut blocks = vec![
            Block::Table(arrival),
            Block::Lines(String::new()),
            Block::Table(knowledge),
            Block::Lines(String::new()),
            Block::Table(reliability::table(&self.all.bins)),
            Block::Lines(format!(
                "share of the belief and how often it is right, fitted to these runs:\n{}\n\
                 share that dead reckoning leaves near the estimate, and the same:\n{}",
                reliability::knots_text(&self.fitted),
                reliability::knots_text(&self.fitted_reckoning)
            )),
        ];
        blocks.extend(self.series.iter().filter_map(|row| {
            let seeds = row.failed_seeds.as_ref()?;
            Some(Block::Lines(format!("{}: not with seed {seeds}", row.name)))
        }));
        blocks.extend(self.series.iter().filter(|row| row.not_measured > 0).map(|row| {
            let RowFigures { name, not_measured, runs, .. } = row;
            Block::Lines(format!("{name}: {not_measured} of {runs} not measured, because the scenario failed"))
        }));
        blocks.push(Block::Lines(
            "arrived: by the plan; there: of these, really within 1 m of the last place; wrong: of the arrivals at any \
             place, more than 1 m off; lost: position lost while the estimate was right; sure: right, of the moments \
             with a certainty of 0.99 and above, by 0.5 m and 15°; error: the largest of ten bins of the certainty; \
             found, ≤ 3 m: of robots that were turned or carried, right at the end, and noticed or right again within \
             3 m; astray: runs in which the position counted as found where it was not; blocked, contacts: total"
                .into(),
        ));
        blocks
    }

    /// For programs.
    pub fn figures(&self) -> Value {
        let Self { series, grounds, disturbances, all, fitted, fitted_reckoning } = self;
        json!({ "rows": series, "grounds": grounds, "disturbances": disturbances, "all": all,
            "fitted": fitted, "fitted_reckoning": fitted_reckoning })
    }
}
