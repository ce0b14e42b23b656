//! How the shortcut of active navigation, which sees only the maxima of the belief, does beside
//! the sum over the states of the belief.

use super::catalogue::Row;
use super::conduct::chosen;
use super::findings::Findings;
use super::kind::{ExperimentKind, Run};
use super::missions::Mission;
use super::request::ExperimentRequest;
use super::statistics::{Proportion, Summary};
use anyhow::{Context, Result, bail};
use rpl_drive::observed::Observed;
use rpl_drive::run_driver::{Pace, drive};
use rpl_drive::run_record::Records;
use rpl_drive::show::choice_figures;
use rpl_robot::active::{ActiveParameters, choose, choose_exactly, consider};
use rpl_robot::geometry::distance_m;
use rpl_robot::localization::{Localization, LocalizationModel};
use rpl_robot::office::OfficeModel;
use rpl_shell::files::outputs::OutputFolder;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::NOTHING;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Targets nearer to each other than this are the same choice.
const SAME_M: f64 = 1.0;

/// Choices of one run that are looked into: each takes seconds.
const PER_RUN: usize = 2;

/// Two answers to one question.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Pair {
    /// Between the two targets.
    apart_m: f64,
    /// What the shortcut loses, by the sum, in nats; none if it goes where the sum sees no way.
    regret: Option<f64>,
    /// Time of the shortcut.
    shortcut_ms: f64,
}

/// Missions up to their choices, each of which is answered twice.
pub struct Choices {
    request: ExperimentRequest,
    rows: Vec<&'static Row>,
    /// Where the choices are drawn as they come: all of the belief is too much to be written down.
    folder: Mutex<Option<OutputFolder>>,
}

impl Choices {
    /// The choices of some rows.
    ///
    /// # Errors
    /// The folder for results cannot be written.
    pub fn new(request: ExperimentRequest, rows: &'static [Row]) -> Result<Self> {
        let rows = chosen(&request, rows, |row| row.name)?;
        let folder = Mutex::new(request.results_folder()?);
        Ok(Self { request, rows, folder })
    }

    fn draw(&self, name: &str, office: &OfficeModel, localization: &Localization) -> Result<()> {
        let mut folder = self.folder.lock().unwrap_or_else(PoisonError::into_inner);
        let (Some(folder), Some(map)) = (folder.as_mut(), &office.map) else { return Ok(()) };
        let (model, parameters) = (&map.localization, &office.settings.active);
        let maxima = localization.maxima(model, parameters.max_maxima, parameters.min_mass);
        let considered = consider(model, &maxima, &[], parameters);
        considered.map_or(Ok(()), |(choice, field)| choice_figures::write(folder, name, &choice, &field))
    }
}

impl ExperimentKind for Choices {
    type Ground = Mission;
    type Record = Vec<Pair>;
    type Tally = Vec<Vec<Pair>>;

    fn series(&self) -> Vec<String> {
        self.rows.iter().map(|row| row.name.to_string()).collect()
    }

    fn ground(&self, series: usize) -> Result<Mission> {
        Mission::of(&self.request, self.rows[series])
    }

    fn run(&self, _: usize, mission: &Mission, Run { seed, .. }: Run) -> Result<Vec<Pair>> {
        let Some(office) = mission.site.office() else { bail!("there is no robot; add `--world dept`") };
        let mut system = mission.site.start_traced(mission.loaded.clone(), seed);
        let observed = Observed { choices: Some(Vec::new()), ..Observed::default() };
        let mut records = Records { observed, ..Records::default() };
        let pace = Pace { until_us: Some(self.request.until_us), ..Pace::default() };
        drive(&mut system, pace, &mut Console::silent(), &mut records).context("a run could not be driven")?;
        let mut pairs = Vec::new();
        for (number, localization) in records.observed.choices.iter().flatten().take(PER_RUN).enumerate() {
            if let Some(map) = &office.map {
                pairs.extend(pair(&map.localization, localization, &office.settings.active));
            }
            self.draw(&format!("seed-{seed}-choice-{}", number + 1), office, localization)?;
        }
        Ok(pairs)
    }

    fn head(&self, _: &Vec<Pair>) -> String {
        "row,seed,apart [m],lost [nats],shortcut [ms]".to_string()
    }

    fn lines(&self, series: &str, run: Run, pairs: &Vec<Pair>) -> String {
        let line = |pair: &Pair| {
            let lost = pair.regret.map_or(String::new(), |lost| lost.to_string());
            format!("\"{series}\",{},{},{lost},{}\n", run.seed, pair.apart_m, pair.shortcut_ms)
        };
        pairs.iter().map(line).collect()
    }

    fn findings(&self, tallies: Vec<Vec<Vec<Pair>>>, _: bool) -> Result<Findings> {
        let pairs: Vec<Pair> = tallies.into_iter().flatten().flatten().collect();
        let comparison = Comparison::of(&pairs);
        let blocks = vec![Block::Lines(comparison.text())];
        let figures = json!({ "choices": comparison });
        Ok(Findings { status: Status::Succeeded, blocks, figures, drawings: Vec::new() })
    }

    /// What is measured is time.
    fn jobs(&self, _: usize) -> usize {
        1
    }
}

fn pair(model: &LocalizationModel, localization: &Localization, parameters: &ActiveParameters) -> Option<Pair> {
    let began = Instant::now();
    let maxima = localization.maxima(model, parameters.max_maxima, parameters.min_mass);
    let shortcut = choose(model, &maxima, &[], parameters)?;
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
