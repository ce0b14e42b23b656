//! How the shortcut of active navigation, which sees only the maxima of the belief, does beside
//! the sum over the states of the belief.

use super::catalogue::Row;
use super::statistics::{Spread, wilson_95};
use super::{Arguments, results_folder, seeds, site_of};
use crate::choice_figures;
use crate::console::Console;
use crate::drive::{Pace, Records, drive};
use crate::files;
use crate::status::Status;
use anyhow::{Context, Result, bail};
use rpl_robot::active::{ActiveParameters, choose, choose_exactly};
use rpl_robot::geometry::distance_m;
use rpl_robot::localization::{Localization, LocalizationModel};
use rpl_runtime::system::System;
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
pub fn run(arguments: &Arguments, rows: &[&'static Row], console: &mut Console) -> Result<Status> {
    let mut pairs = Vec::new();
    let mut folder = results_folder(arguments)?;
    for row in rows {
        let (site, _) = site_of(arguments, row)?;
        let Some(office) = site.office().cloned() else { bail!("there is no robot; add `--world dept`") };
        let plan = files::plan(row.plan)?;
        let loaded = match site.library.load(&plan.name, &plan.text, &mut plan.folder.clone()) {
            Ok(loaded) => loaded,
            Err(rejected) => bail!("{}", rejected.render(console.colour).trim_end()),
        };
        for seed in seeds(arguments) {
            let mut system = System::traced(site.library.clone(), loaded.clone(), site.robot(seed), seed);
            let mut records = Records { choices: Some(Vec::new()), ..Records::default() };
            let pace = Pace { until_us: Some(arguments.until), factor: None };
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
    console.print(&table(&pairs))?;
    Ok(Status::Succeeded)
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

fn table(pairs: &[Pair]) -> String {
    let differ = pairs.iter().filter(|pair| pair.apart_m > SAME_M).count();
    let (low, high) = wilson_95(differ, pairs.len());
    let of = |numbers: Vec<f64>| {
        Spread::of(&numbers).map_or("–".to_string(), |spread| {
            format!("mean {:.3}, median {:.3}, largest {:.3}", spread.mean, spread.median, spread.max)
        })
    };
    let no_way = pairs.iter().filter(|pair| pair.regret.is_none()).count();
    [
        format!("choices of active navigation, by the maxima and by the sum over the belief: {}", pairs.len()),
        format!(
            "targets more than {SAME_M} m apart: {differ}, {:.1} %, 95 % interval {:.1} to {:.1} %",
            100.0 * differ as f64 / pairs.len().max(1) as f64,
            100.0 * low,
            100.0 * high
        ),
        format!("apart [m]: {}", of(pairs.iter().map(|pair| pair.apart_m).collect())),
        format!("pay-off lost [nats]: {}", of(pairs.iter().filter_map(|pair| pair.regret).collect())),
        format!("targets the sum sees no way to: {no_way}"),
        format!("time of the shortcut [ms]: {}", of(pairs.iter().map(|pair| pair.shortcut_ms).collect())),
    ]
    .join("\n")
}
