//! How the shortcut of active navigation, which sees only the maxima of the belief, does beside
//! the sum over the states of the belief.

use super::catalogue::Row;
use super::findings::ExperimentResult;
use super::missions::site_of;
use super::request::ExperimentRequest;
use super::statistics::{Proportion, Summary};
use crate::drive::{Pace, drive};
use crate::files::plans;
use crate::run_record::Records;
use crate::show::choice_figures;
use crate::sites;
use crate::status::Status;
use crate::terminal::console::Console;
use crate::terminal::page::Block;
use crate::terminal::table::NOTHING;
use anyhow::{Context, Result, bail};
use rpl_robot::active::{ActiveParameters, choose, choose_exactly};
use rpl_robot::geometry::distance_m;
use rpl_robot::localization::{Localization, LocalizationModel};
use serde::Serialize;
use serde_json::json;
use std::time::Instant;

/// Targets nearer to each other than this are the same choice.
const SAME_M: f64 = 1.0;

/// Choices of one run that are looked into: each takes seconds.
const PER_RUN: usize = 2;

/// Two answers to one question.
struct Pair {
    /// Between the two targets.
    apart_m: f64,
    /// What the shortcut loses, by the sum, in nats; none if it goes where the sum sees no way.
    regret: Option<f64>,
    /// Time of the shortcut.
    shortcut_ms: f64,
}

/// Runs missions up to their choices and answers each of these twice.
///
/// # Errors
/// The plan's text is wrong, a run cannot be driven, or the figures cannot be written.
pub fn run(request: &ExperimentRequest, rows: &[&'static Row], console: &mut Console) -> Result<ExperimentResult> {
    let mut pairs = Vec::new();
    let mut folder = request.results_folder()?;
    for row in rows {
        let (site, _) = site_of(request, row)?;
        let Some(office) = site.office().cloned() else { bail!("there is no robot; add `--world dept`") };
        let loaded = sites::load(&site, &plans::plan(row.plan)?, console.colour)?;
        for seed in request.seeds() {
            let mut system = site.start_traced(loaded.clone(), seed);
            let mut records = Records { choices: Some(Vec::new()), ..Records::default() };
            let pace = Pace { until_us: Some(request.until_us), ..Pace::default() };
            drive(&mut system, pace, &mut Console::silent(), &mut records).context("a run could not be driven")?;
            for (number, localization) in records.choices.iter().flatten().take(PER_RUN).enumerate() {
                let parameters = &office.settings.active;
                if let Some(map) = &office.map {
                    pairs.extend(pair(&map.localization, localization, parameters));
                }
                if let Some(folder) = &mut folder {
                    let name = format!("seed-{seed}-choice-{}", number + 1);
                    choice_figures::write(folder, &name, &office, localization)?;
                }
            }
        }
    }
    let comparison = Comparison::of(&pairs);
    let blocks = vec![Block::Lines(comparison.text())];
    Ok(ExperimentResult { status: Status::Succeeded, blocks, figures: json!({ "choices": comparison }) })
}

fn pair(model: &LocalizationModel, localization: &Localization, parameters: &ActiveParameters) -> Option<Pair> {
    let began = Instant::now();
    let maxima = localization.maxima(model, parameters.max_maxima, parameters.min_mass);
    let (shortcut, _) = choose(model, &maxima, &[], parameters)?;
    let shortcut_ms = began.elapsed().as_secs_f64() * 1e3;
    let exact = choose_exactly(model, localization, shortcut.target_in_base, parameters)?;
    Some(Pair {
        apart_m: distance_m(shortcut.target_in_base, exact.choice.target_in_base),
        regret: exact.payoff_of_other.map(|payoff| exact.payoff - payoff),
        shortcut_ms,
    })
}

/// How the two answers differ on the whole.
#[derive(Clone, Debug, Serialize)]
struct Comparison {
    /// Choices whose targets lie apart.
    differ: Proportion,
    apart_m: Option<Summary>,
    lost_nats: Option<Summary>,
    /// Targets the sum sees no way to.
    no_way: usize,
    shortcut_ms: Option<Summary>,
}

impl Comparison {
    fn of(pairs: &[Pair]) -> Self {
        let of = |numbers: Vec<f64>| Summary::of(&numbers);
        Self {
            differ: Proportion::new(pairs.iter().filter(|pair| pair.apart_m > SAME_M).count(), pairs.len()),
            apart_m: of(pairs.iter().map(|pair| pair.apart_m).collect()),
            lost_nats: of(pairs.iter().filter_map(|pair| pair.regret).collect()),
            no_way: pairs.iter().filter(|pair| pair.regret.is_none()).count(),
            shortcut_ms: of(pairs.iter().map(|pair| pair.shortcut_ms).collect()),
        }
    }

    fn text(&self) -> String {
        let told = |summary: &Option<Summary>| {
            summary.map_or(NOTHING.to_string(), |Summary { spread, .. }| {
                format!("mean {:.3}, median {:.3}, largest {:.3}", spread.mean, spread.median, spread.max)
            })
        };
        [
            format!("choices of active navigation, by the maxima and by the sum over the belief: {}", self.differ.of),
            format!("targets more than {SAME_M} m apart: {}", self.differ.sentence()),
            format!("apart [m]: {}", told(&self.apart_m)),
            format!("pay-off lost [nats]: {}", told(&self.lost_nats)),
            format!("targets the sum sees no way to: {}", self.no_way),
            format!("time of the shortcut [ms]: {}", told(&self.shortcut_ms)),
        ]
        .join("\n")
    }
}
