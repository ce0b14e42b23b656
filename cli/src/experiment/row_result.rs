//! What came of the runs of a row: every figure the tables show, and the tables.

use super::statistics::{Dispersion, PerKm, Proportion, Summary};
use super::trial::MissionTrial;
use crate::terminal::page::Block;
use crate::terminal::table::{NOTHING, Table};
use serde::Serialize;

/// Seeds of runs that failed, named in the tables.
const NAMED: usize = 20;

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
    /// Runs that did not, with the reason.
    pub failures: Vec<FailedRun>,
    /// Runs that count for nothing, with the failure of their scenario.
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
}

/// A run that failed.
#[derive(Clone, Debug, Serialize)]
pub struct FailedRun {
    /// Its seed.
    pub seed: u64,
    /// What went wrong, the class of the failure first.
    pub fault: String,
}

/// What was measured in the runs of a row.
#[derive(Clone, Debug, Serialize)]
pub struct Measure {
    /// What was measured, with its unit.
    pub name: &'static str,
    /// What it was on the whole.
    #[serde(flatten)]
    pub summary: Summary,
    /// What nine of ten numbers do not exceed.
    pub nine_in_ten: f64,
    /// Their sum.
    pub total: f64,
}

impl Measure {
    fn of(name: &'static str, mut numbers: Vec<f64>) -> Option<Self> {
        numbers.sort_by(f64::total_cmp);
        let nine_in_ten = *numbers.get(numbers.len() * 9 / 10)?;
        Some(Self { name, summary: Summary::of(&numbers)?, nine_in_ten, total: numbers.iter().sum() })
    }
}

impl RowResult {
    /// The figures of some runs.
    pub fn of(name: &str, trials: &[MissionTrial]) -> Self {
        let numbers =
            |measure: &str| -> Vec<f64> { trials.iter().filter_map(|trial| trial.measure(measure)).collect() };
        let names = trials.first().map_or(&[][..], |trial| &trial.measures[..]);
        let total = |measure: &str| numbers(measure).iter().fold(0.0, |sum, number| sum + number);
        let runs = |why: fn(&MissionTrial) -> &Option<String>| {
            let run = |trial: &MissionTrial| Some(FailedRun { seed: trial.seed, fault: why(trial).clone()? });
            trials.iter().filter_map(run).collect::<Vec<_>>()
        };
        let measured = trials.iter().filter(|trial| trial.is_measured()).count();
        // Of the runs that had a way to notice.
        let noticed_m = trials.iter().filter(|trial| trial.measure("noticed within 2 m").is_some());
        let noticed_m: Vec<f64> =
            noticed_m.map(|trial| trial.measure("noticed after [m]").unwrap_or(f64::INFINITY)).collect();
        Self {
            name: name.to_string(),
            runs: trials.len(),
            seeds: trials.first().zip(trials.last()).map(|(first, last)| (first.seed, last.seed)),
            succeeded: Proportion::new(trials.iter().filter(|trial| trial.succeeded()).count(), measured),
            failures: runs(|trial| &trial.fault),
            not_measured: runs(|trial| &trial.unmeasured),
            measures: names.iter().filter_map(|&(name, _)| Measure::of(name, numbers(name))).collect(),
            wrong_recoveries: Proportion::among(&numbers("wrong recoveries"), |count| count > 0.0),
            noticed_within_1_m: Proportion::among(&noticed_m, |way_m| way_m <= 1.0),
            noticed_within_2_m: Proportion::among(&numbers("noticed within 2 m"), |within| within > 0.0),
            false_alarms_per_km: PerKm::new(total("false alarms") as u32, total("distance [m]") / 1000.0),
        }
    }

    fn measure(&self, name: &str) -> Option<&Measure> {
        self.measures.iter().find(|measure| measure.name == name)
    }

    /// The sum over the runs, as a cell of a table.
    pub fn total(&self, name: &str) -> String {
        self.measure(name).map_or("0".to_string(), |measure| measure.total.to_string())
    }

    /// The median over the runs, as a cell of a table.
    pub fn median(&self, name: &str) -> String {
        self.measure(name).map_or(NOTHING.to_string(), |measure| format!("{:.2}", measure.summary.spread.median))
    }

    /// What nine of ten runs do not exceed, as a cell of a table.
    pub fn nine_in_ten(&self, name: &str) -> String {
        self.measure(name).map_or(NOTHING.to_string(), |measure| format!("{:.2}", measure.nine_in_ten))
    }

    /// The seeds of the first runs that failed, each with the kind of fault; none if none did.
    pub fn failed_seeds(&self) -> Option<String> {
        let kind = |fault: &str| fault.split(':').next().unwrap_or_default().to_string();
        let named: Vec<String> =
            self.failures.iter().take(NAMED).map(|run| format!("{} ({})", run.seed, kind(&run.fault))).collect();
        let more = self.failures.len().saturating_sub(NAMED);
        let more = if more > 0 { format!(", and {more} more") } else { String::new() };
        (!named.is_empty()).then(|| named.join(", ") + &more)
    }

    /// How many runs count for nothing, and why; none if all count.
    fn unmeasured_seeds(&self) -> Option<String> {
        let named: Vec<String> =
            self.not_measured.iter().take(NAMED).map(|run| format!("{} ({})", run.seed, run.fault)).collect();
        let count = self.not_measured.len();
        let more = if count > NAMED { ", …" } else { "" };
        (count > 0).then(|| {
            let (all, named) = (self.runs, named.join(", "));
            format!("not measured: {count} of {all}, because the scenario failed with seed {named}{more}")
        })
    }

    /// The row as a table of its own, with all that was measured.
    pub fn blocks(&self) -> Vec<Block> {
        let seeds = match self.seeds {
            Some((first, last)) if self.runs > 1 => format!("seeds {first} to {last}"),
            Some((first, _)) => format!("seed {first}"),
            None => "no seeds".to_string(),
        };
        let mut table = Table::new(&["", "runs", "mean", "± 95 %", "deviation", "min", "median", "max"]);
        for Measure { name, summary: Summary { count, spread, half_95 }, .. } in &self.measures {
            let Dispersion { mean, deviation, min, median, max } = spread;
            let numbers = [mean, half_95, deviation, min, median, max].map(|number| format!("{number:.2}"));
            table.row([(*name).to_string(), count.to_string()].into_iter().chain(numbers));
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
        blocks.extend(self.failed_seeds().map(|seeds| Block::Lines(format!("failed with seed {seeds}"))));
        blocks.extend(self.unmeasured_seeds().map(Block::Lines));
        blocks
    }
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
        "alarms/km (95 %)",
    ]);
    rows.iter().for_each(|row| table.row(compared(row)));
    let mut blocks = vec![Block::Table(table)];
    let unmeasured = rows.iter().filter_map(|row| Some(format!("{}: {}", row.name, row.unmeasured_seeds()?)));
    blocks.extend(unmeasured.map(Block::Lines));
    blocks.push(Block::Lines(
        "contacts: caused by the robot, total; wrong: runs in which the position counted as found where it \
         was not; noticed [m] and time [s]: medians; alarms: position lost while the estimate was right"
            .into(),
    ));
    blocks
}

fn compared(row: &RowResult) -> [String; 9] {
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
        row.total("contacts caused"),
        row.wrong_recoveries.as_ref().map_or(NOTHING.to_string(), wrong),
        row.median("noticed after [m]"),
        row.noticed_within_2_m.as_ref().map_or(NOTHING.to_string(), percent),
        row.median("time [s]"),
        row.false_alarms_per_km.as_ref().map_or(NOTHING.to_string(), alarms),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trial(seed: u64, fault: Option<&str>, time_s: Option<f64>) -> MissionTrial {
        let fault = fault.map(str::to_string);
        MissionTrial { seed, fault, unmeasured: None, measures: vec![("time [s]", time_s)], samples: vec![] }
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
        let text = text(&RowResult::of("rotated", &trials).blocks());
        assert!(text.contains("succeeded 2 of 3: 66.7 %"), "{text}");
        assert!(text.contains("time [s]     2  20.00   19.60"), "{text}");
        assert!(text.ends_with("failed with seed 2 (blocked)"), "{text}");
    }

    #[test]
    fn seeds_that_are_not_named_are_counted() {
        let trials: Vec<MissionTrial> = (1..=25).map(|seed| trial(seed, Some("timeout"), None)).collect();
        let seeds = RowResult::of("rotated", &trials).failed_seeds().expect("all failed");
        assert!(seeds.starts_with("1 (timeout), ") && seeds.ends_with("20 (timeout), and 5 more"), "{seeds}");
    }
}
