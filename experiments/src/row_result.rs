//! What came of the runs of a row: every figure the tables show, and the tables.

use super::failed_runs::{FailedClass, FailedRun, FailedRuns};
use super::kind::Tally;
use super::numbers::Numbers;
use super::over_time::OverTime;
use super::quantity::{Quantity, as_name};
use super::statistics::{Dispersion, PerKm, Proportion, Summary};
use super::trial::MissionTrial;
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::{NOTHING, Table};
use serde::Serialize;

/// What came of the runs of a row.
#[derive(Clone, Debug, Serialize)]
pub struct RowResult {
    /// What the row is called.
    pub name: String,
    /// How many runs.
    pub runs: usize,
    /// The first and the last seed.
    pub seeds: Option<(u64, u64)>,
    /// Runs that succeeded.
    pub succeeded: Proportion,
    /// The first runs that did not, with the reason.
    pub failures: Vec<FailedRun>,
    /// How many failed in which way, the most frequent first.
    pub failure_classes: Vec<FailedClass>,
    /// The first runs that count for nothing, with the failure of their scenario.
    pub not_measured: Vec<FailedRun>,
    /// What was measured.
    pub measures: Vec<Measure>,
    /// Disturbed runs in which a position counted as found where it was not.
    pub wrong_recoveries: Option<Proportion>,
    /// Disturbances that were noticed within a metre.
    pub noticed_within_1_m: Option<Proportion>,
    /// Disturbances that were noticed within two metres.
    pub noticed_within_2_m: Option<Proportion>,
    /// How often the position counted as lost while the estimate was right.
    pub false_alarms_per_km: Option<PerKm>,
    /// The seeds of the first runs that failed, each with the class of its failure, as the tables name them.
    #[serde(skip)]
    pub failed_seeds: Option<String>,
    /// How many runs count for nothing, and why.
    #[serde(skip)]
    unmeasured_seeds: Option<String>,
}

/// What was measured in the runs of a row.
#[derive(Clone, Debug, Serialize)]
pub struct Measure {
    /// What was measured.
    #[serde(rename = "name", serialize_with = "as_name")]
    pub quantity: Quantity,
    /// What it was on the whole.
    #[serde(flatten)]
    pub summary: Summary,
    /// What nine of ten numbers do not exceed.
    pub nine_in_ten: f64,
    /// Their sum.
    pub total: f64,
}

impl Measure {
    fn of(quantity: Quantity, numbers: &Numbers) -> Option<Self> {
        let nine_in_ten = numbers.of_ten(9)?;
        Some(Self { quantity, summary: numbers.summary()?, nine_in_ten, total: numbers.total() })
    }
}

/// What is kept of the runs of a row. Its memory does not grow with their number.
#[derive(Clone, Debug, Default)]
pub struct RowTally {
    runs: usize,
    seeds: Option<(u64, u64)>,
    succeeded: usize,
    failures: FailedRuns,
    not_measured: FailedRuns,
    /// In the order in which they came up.
    measures: Vec<(Quantity, Numbers)>,
    /// Of the disturbed runs: those with a wrong recovery.
    wrong_recoveries: Share,
    noticed_within_1_m: Share,
    noticed_within_2_m: Share,
    /// How the runs go over time.
    pub over_time: OverTime,
}

/// How many of some runs.
#[derive(Clone, Copy, Debug, Default)]
struct Share {
    count: usize,
    of: usize,
}

impl Share {
    fn add(&mut self, is_so: bool) {
        self.count += usize::from(is_so);
        self.of += 1;
    }

    fn proportion(self) -> Option<Proportion> {
        (self.of > 0).then(|| Proportion::new(self.count, self.of))
    }
}

impl Tally<MissionTrial> for RowTally {
    fn add(&mut self, trial: MissionTrial) {
        self.runs += 1;
        self.seeds = Some((self.seeds.map_or(trial.seed, |(first, _)| first), trial.seed));
        self.succeeded += usize::from(trial.succeeded());
        for (quantity, number) in &trial.measures {
            let at = self.measures.iter().position(|(known, _)| known == quantity).unwrap_or_else(|| {
                self.measures.push((quantity.clone(), Numbers::default()));
                self.measures.len() - 1
            });
            number.iter().for_each(|number| self.measures[at].1.add(*number));
        }
        if let Some(count) = trial.measure(&Quantity::WrongRecoveries) {
            self.wrong_recoveries.add(count > 0.0);
        }
        // Of the runs that had a way to notice.
        if let Some(within) = trial.measure(&Quantity::NoticedWithin2M) {
            self.noticed_within_2_m.add(within > 0.0);
            self.noticed_within_1_m.add(trial.measure(&Quantity::NoticedAfter).is_some_and(|way_m| way_m <= 1.0));
        }
        if trial.is_measured() {
            self.over_time.add(&trial);
        }
        let failed = |fault| FailedRun { seed: trial.seed, fault };
        trial.fault.map(failed).into_iter().for_each(|run| self.failures.add(run));
        trial.unmeasured.map(failed).into_iter().for_each(|run| self.not_measured.add(run));
    }
}

impl RowTally {
    /// Whether all runs succeeded, of which there are some.
    pub fn has_succeeded(&self) -> bool {
        self.succeeded == self.runs
    }

    /// Whether all runs count.
    pub fn is_measured(&self) -> bool {
        self.not_measured.count() == 0
    }
}

impl RowResult {
    /// The figures of some runs.
    pub fn of(name: &str, tally: &RowTally) -> Self {
        let total = |quantity: Quantity| {
            tally.measures.iter().find(|(known, _)| *known == quantity).map_or(0.0, |(_, numbers)| numbers.total())
        };
        let counting = tally.runs - tally.not_measured.count();
        Self {
            name: name.to_string(),
            runs: tally.runs,
            seeds: tally.seeds,
            succeeded: Proportion::new(tally.succeeded, counting),
            failures: tally.failures.told().to_vec(),
            failure_classes: tally.failures.classes(),
            not_measured: tally.not_measured.told().to_vec(),
            measures: tally.measures.iter().filter_map(|(what, numbers)| Measure::of(what.clone(), numbers)).collect(),
            wrong_recoveries: tally.wrong_recoveries.proportion(),
            noticed_within_1_m: tally.noticed_within_1_m.proportion(),
            noticed_within_2_m: tally.noticed_within_2_m.proportion(),
            false_alarms_per_km: PerKm::new(total(Quantity::FalseAlarms) as u32, total(Quantity::Distance) / 1000.0),
            failed_seeds: tally.failures.seeds_and_classes(),
            unmeasured_seeds: unmeasured_seeds(tally),
        }
    }

    fn measure(&self, quantity: &Quantity) -> Option<&Measure> {
        self.measures.iter().find(|measure| measure.quantity == *quantity)
    }

    /// The sum over the runs, as a cell of a table.
    pub fn total(&self, quantity: &Quantity) -> String {
        self.measure(quantity).map_or(NOTHING.to_string(), |measure| measure.total.to_string())
    }

    /// The median over the runs, as a cell of a table.
    pub fn median(&self, quantity: &Quantity) -> String {
        self.measure(quantity).map_or(NOTHING.to_string(), |measure| format!("{:.2}", measure.summary.spread.median))
    }

    /// What nine of ten runs do not exceed, as a cell of a table.
    pub fn nine_in_ten(&self, quantity: &Quantity) -> String {
        self.measure(quantity).map_or(NOTHING.to_string(), |measure| format!("{:.2}", measure.nine_in_ten))
    }

    /// The row as a table of its own, with all that was measured.
    pub fn blocks(&self) -> Vec<Block> {
        let seeds = match self.seeds {
            Some((first, last)) if self.runs > 1 => format!("seeds {first} to {last}"),
            Some((first, _)) => format!("seed {first}"),
            None => "no seeds".to_string(),
        };
        let mut table = Table::new(&["", "runs", "mean", "± 95 %", "deviation", "min", "median", "max"]);
        for Measure { quantity, summary: Summary { count, spread, half_95 }, .. } in &self.measures {
            let Dispersion { mean, deviation, min, median, max } = spread;
            let numbers = [mean, half_95, deviation, min, median, max].map(|number| format!("{number:.2}"));
            table.row([quantity.name().to_string(), count.to_string()].into_iter().chain(numbers));
        }
        let mut blocks = vec![
            Block::Lines(format!(
                "{}: {} {}, {seeds}",
                self.name,
                self.runs,
                if self.runs == 1 { "run" } else { "runs" }
            )),
            Block::Lines(format!("succeeded {}", self.succeeded.sentence())),
            Block::Table(table),
        ];
        blocks.extend(self.failed_seeds.iter().map(|seeds| Block::Lines(format!("failed with seed {seeds}"))));
        blocks.extend(self.unmeasured_seeds.clone().map(Block::Lines));
        blocks
    }
}

/// How many runs count for nothing, and why; none if all count.
fn unmeasured_seeds(tally: &RowTally) -> Option<String> {
    let seeds = tally.not_measured.sentence(|run| &run.fault)?;
    let (count, all) = (tally.not_measured.count(), tally.runs);
    Some(format!("not measured: {count} of {all}, because the scenario failed with seed {seeds}"))
}

/// One line for each row of an experiment, so that they can be compared.
pub fn comparison(rows: &[RowResult]) -> Vec<Block> {
    let mut table = Table::new(&[
        "",
        "succeeded",
        "95 % interval",
        "contacts",
        "wrong (95 %)",
        "noticed",
        "≤ 2 m",
        "time",
        "off",
        "astray",
        "alarms/km (95 %)",
    ]);
    rows.iter().for_each(|row| table.row(compared(row)));
    let mut blocks = vec![Block::Table(table)];
    let unmeasured = rows.iter().filter_map(|row| Some(format!("{}: {}", row.name, row.unmeasured_seeds.as_ref()?)));
    blocks.extend(unmeasured.map(Block::Lines));
    blocks.push(Block::Lines(
        "contacts: caused by the robot, total; wrong: runs in which the position counted as found where it \
         was not; noticed [m], time [s] and off [m], how far the estimate was on the average: medians; astray: \
         the share of the time with an estimate more than a metre off, the mean; alarms: position lost while \
         the estimate was right"
            .into(),
    ));
    blocks
}

fn compared(row: &RowResult) -> [String; 11] {
    let wrong = |share: &Proportion| format!("{} (≤{:.1} %)", share.count, 100.0 * share.interval_95.1);
    let percent = |share: &Proportion| share.rate.map_or(NOTHING.to_string(), |rate| format!("{:.1} %", 100.0 * rate));
    let alarms = |alarms: &PerKm| {
        let (low, high) = alarms.interval_95;
        format!("{:.2} ({low:.2}–{high:.2})", alarms.rate)
    };
    [
        row.name.clone(),
        row.succeeded.fraction(),
        row.succeeded.interval(),
        row.total(&Quantity::ContactsCaused),
        row.wrong_recoveries.as_ref().map_or(NOTHING.to_string(), wrong),
        row.median(&Quantity::NoticedAfter),
        row.noticed_within_2_m.as_ref().map_or(NOTHING.to_string(), percent),
        row.median(&Quantity::Time),
        row.median(&Quantity::EstimateOff),
        row.measure(&Quantity::Astray)
            .map_or(NOTHING.to_string(), |share| format!("{:.1} %", share.summary.spread.mean)),
        row.false_alarms_per_km.as_ref().map_or(NOTHING.to_string(), alarms),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::ErrorTrack;

    fn trial(seed: u64, fault: Option<&str>, time_s: Option<f64>) -> MissionTrial {
        let fault = fault.map(str::to_string);
        let (measures, error) = (vec![(Quantity::Time, time_s)], ErrorTrack::default());
        MissionTrial { seed, fault, unmeasured: None, value: None, measures, error, samples: vec![] }
    }

    fn row(name: &str, trials: impl IntoIterator<Item = MissionTrial>) -> RowResult {
        let mut tally = RowTally::default();
        trials.into_iter().for_each(|trial| tally.add(trial));
        RowResult::of(name, &tally)
    }

    fn text(blocks: &[Block]) -> String {
        let texts = blocks.iter().map(|block| match block {
            Block::Lines(text) => text.clone(),
            Block::Table(table) => table.text(None),
        });
        texts.collect::<Vec<_>>().join("\n")
    }

    #[test]
    fn the_table_counts_successes_and_names_failed_seeds() {
        let blocked = Some("blocked: for 20 s");
        let trials = [trial(1, None, Some(10.0)), trial(2, blocked, Some(30.0)), trial(3, None, None)];
        let text = text(&row("rotated", trials).blocks());
        assert!(text.contains("succeeded 2 of 3: 66.7 %"), "{text}");
        assert!(text.contains("time [s]     2  20.00  127.06"), "{text}");
        assert!(text.ends_with("failed with seed 2 (blocked)"), "{text}");
    }
}
