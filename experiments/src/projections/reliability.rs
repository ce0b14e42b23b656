//! How reliable forecasts are: bins of about the same forecast beside what then happened, and the score of Brier
//! ("Verification of forecasts expressed in terms of probability", 1950).

use super::foretold_mission::{FORECASTERS, ForetoldMission};
use crate::findings::Findings;
use crate::statistics::Proportion;
use rpl_shell::status::Status;
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::{NOTHING, Table};
use serde::Serialize;
use serde_json::json;

/// Bins of as many missions each.
const BINS: usize = 10;

/// Missions of about the same forecast.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct Bin {
    /// Mean forecast.
    forecast: f64,
    /// How many succeeded.
    succeeded: Proportion,
}

impl Bin {
    fn error(&self) -> f64 {
        self.forecast - self.succeeded.rate.unwrap_or(0.0)
    }

    /// Whether the error is more than 0.05 and two standard errors of a share of that forecast.
    fn is_off(&self) -> bool {
        let deviation = (self.forecast * (1.0 - self.forecast) / self.succeeded.of as f64).sqrt();
        self.error().abs() > 0.05 + 2.0 * deviation
    }
}

/// How one forecaster did.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Reliability {
    row: String,
    forecaster: &'static str,
    missions: usize,
    /// Mean forecast.
    forecast: f64,
    succeeded: Proportion,
    /// Mean of the absolute errors of the bins.
    bin_error: f64,
    /// Bins that are off.
    bins_off: usize,
    /// Mean squared error of the forecasts.
    brier: f64,
    /// By what part that is less than for who always forecasts the share of all that succeed; none where all end alike.
    skill: Option<f64>,
    /// The part that this is of the skill of who is told the truth, where that one has any.
    skill_of_truth: Option<f64>,
    bins: Vec<Bin>,
}

impl Reliability {
    /// Of some missions by a forecaster's number; there is one at least.
    fn of(row: &str, forecaster: usize, missions: &[ForetoldMission]) -> Self {
        let mut foretold: Vec<(f64, bool)> =
            missions.iter().map(|mission| (mission.forecasts[forecaster], mission.is_success)).collect();
        foretold.sort_by(|a, b| a.0.total_cmp(&b.0));
        let bins: Vec<Bin> = foretold.chunks(foretold.len().div_ceil(BINS)).map(bin).collect();
        let count = foretold.len() as f64;
        let whole = bin(&foretold);
        let brier = foretold.iter().map(|&(forecast, is)| (forecast - f64::from(is)).powi(2)).sum::<f64>() / count;
        let share = whole.succeeded.rate.unwrap_or(0.0);
        let uncertainty = share * (1.0 - share);
        Self {
            row: row.to_string(),
            forecaster: FORECASTERS[forecaster],
            missions: foretold.len(),
            forecast: whole.forecast,
            succeeded: whole.succeeded,
            bin_error: bins.iter().map(|bin| bin.error().abs()).sum::<f64>() / bins.len() as f64,
            bins_off: bins.iter().filter(|bin| bin.is_off()).count(),
            brier,
            skill: (uncertainty > 0.0).then(|| 1.0 - brier / uncertainty),
            skill_of_truth: None,
            bins,
        }
    }
}

/// Each forecaster beside who is told the truth, the last one.
fn of_all(row: &str, missions: &[ForetoldMission]) -> [Reliability; 3] {
    let mut all = [0, 1, 2].map(|forecaster| Reliability::of(row, forecaster, missions));
    let truth = all[2].skill.filter(|&skill| skill > 0.0);
    for told in &mut all {
        told.skill_of_truth = told.skill.zip(truth).map(|(skill, truth)| skill / truth);
    }
    all
}

fn bin(foretold: &[(f64, bool)]) -> Bin {
    let forecast = foretold.iter().map(|mission| mission.0).sum::<f64>() / foretold.len() as f64;
    Bin { forecast, succeeded: Proportion::new(foretold.iter().filter(|mission| mission.1).count(), foretold.len()) }
}

/// The tables: forecasters over all kinds, kind by kind, and the bins of all kinds.
pub(super) fn findings(kinds: &[&'static str], tallies: &[Vec<ForetoldMission>]) -> Findings {
    let all = tallies.concat();
    let mut rows: Vec<(&str, &[ForetoldMission])> =
        kinds.iter().copied().zip(tallies.iter().map(Vec::as_slice)).collect();
    if rows.len() > 1 {
        rows.push(("all", &all));
    }
    rows.retain(|row| !row.1.is_empty());
    let told: Vec<Reliability> = rows.iter().flat_map(|row| of_all(row.0, row.1)).collect();
    let number = |number: &Option<f64>| number.map_or_else(|| NOTHING.to_string(), |number| format!("{number:.3}"));
    let heads = [
        "missions",
        "forecaster",
        "number",
        "forecast",
        "succeeded",
        "95 % interval",
        "bin error",
        "bins off",
        "Brier",
        "skill",
        "of the truth's",
    ];
    let mut table = Table::new(&heads);
    for reliability in &told {
        let Reliability { row, forecaster, missions, forecast, succeeded, bin_error, bins_off, brier, .. } =
            reliability;
        table.row([
            row.clone(),
            (*forecaster).to_string(),
            missions.to_string(),
            format!("{forecast:.3}"),
            format!("{:.3}", succeeded.rate.unwrap_or(0.0)),
            succeeded.interval(),
            format!("{bin_error:.3}"),
            bins_off.to_string(),
            format!("{brier:.4}"),
            number(&reliability.skill),
            number(&reliability.skill_of_truth),
        ]);
    }
    let mut blocks = vec![Block::Table(table)];
    let last = told.len().saturating_sub(FORECASTERS.len());
    for reliability in &told[last..] {
        let mut table = Table::new(&["forecast", "succeeded", "missions", "95 % interval"]);
        for Bin { forecast, succeeded } in &reliability.bins {
            let share = format!("{:.3}", succeeded.rate.unwrap_or(0.0));
            table.row([format!("{forecast:.3}"), share, succeeded.of.to_string(), succeeded.interval()]);
        }
        blocks.push(Block::Lines(format!("{}, {}:", reliability.row, reliability.forecaster)));
        blocks.push(Block::Table(table));
    }
    Findings { status: Status::Succeeded, blocks, figures: json!({ "rows": told }), drawings: Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn missions(of: impl Iterator<Item = (f64, bool)>) -> Vec<ForetoldMission> {
        of.map(|(forecast, is_success)| ForetoldMission { contingencies: 0, forecasts: [forecast; 3], is_success })
            .collect()
    }

    #[test]
    fn who_forecasts_what_happens_has_no_error_and_the_skill_of_the_textbook() {
        // Half of the missions succeed in 1 of 5, half in 4 of 5: Brier 0.16 of an uncertainty of 0.25.
        let of = |share: f64, every: usize| (0..500).map(move |n| (share, (n % 5 < every)));
        let [told, ..] = of_all("all", &missions(of(0.2, 1).chain(of(0.8, 4))));
        assert_eq!(told.skill_of_truth, Some(1.0), "all forecast alike");
        assert!(told.bin_error < 1e-9 && told.bins_off == 0, "{told:?}");
        assert!((told.brier - 0.16).abs() < 1e-9 && (told.skill.expect("some fail") - 0.36).abs() < 1e-9);
    }

    #[test]
    fn who_is_too_sure_is_off() {
        let told = Reliability::of("all", 0, &missions((0..1000).map(|n| (0.9, n % 2 == 0))));
        assert!((told.bin_error - 0.4).abs() < 1e-9 && told.bins_off == told.bins.len() && told.skill < Some(0.0));
    }
}
