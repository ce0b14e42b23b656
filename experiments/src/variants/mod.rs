//! Experiments of one's own: a plan over many seeds, or variants of it beside each other, with the same seeds.

mod difference_chart;
mod paired;
mod variant;

use super::findings::Findings;
use super::kind::{ExperimentKind, Run};
use super::means_chart::means;
use super::missions::{Mission, over_time, remembering, results, status, whether_measured};
use super::over_time::OverTime;
use super::request::ExperimentRequest;
use super::row_result::RowResult;
use super::runs_file::quoted;
use super::trial::MissionTrial;
use anyhow::{Result, bail};
use difference_chart::differences;
use paired::{PairedDifferences, VariantTally};
use rpl_lang::suggest::suggest;
use rpl_mission::site::Setup;
use rpl_robot::office::OfficeSettings;
use rpl_shell::files::module_files::{self, GoingBack, ModuleVoices};
use rpl_shell::files::plans::{self, PlanText};
use rpl_shell::files::world_files;
use rpl_shell::sites;
use rpl_shell::terminal::page::Block;
use serde_json::json;
use std::path::Path;
use variant::Variant;

/// More runs of all variants together are not compared seed by seed: what was measured in each is kept until the end.
const MOST_COMPARED: u64 = 1_000_000;

/// A plan of the user's own, or variants of it.
pub struct Variants {
    request: ExperimentRequest,
    /// At least one.
    variants: Vec<Variant>,
    /// The names that may have been meant instead of a plan.
    experiments: Vec<&'static str>,
}

/// Where a variant runs.
pub enum VariantGround {
    /// The same place for all seeds.
    One(Mission),
    /// A world that is drawn from the seed.
    Drawn(PlanText, Option<PlanText>),
}

impl Variants {
    /// What is asked for.
    ///
    /// # Errors
    /// It has no variant of the row's name, or its variants are wrong; or they have more runs than are compared.
    pub fn new(request: ExperimentRequest, experiments: Vec<&'static str>) -> Result<Self> {
        let variants = Variant::all(&request)?;
        let runs = u64::from(request.runs) * variants.len() as u64;
        if variants.len() > 1 && runs > MOST_COMPARED {
            bail!(
                "the variants have {runs} runs together, and at most {MOST_COMPARED} are compared; ask for fewer \
                 `--runs`, or for one variant by `--row`"
            );
        }
        Ok(Self { request, variants, experiments })
    }

    fn at(&self, variant: &Variant, plan: &PlanText, scenario: Option<PlanText>, seed: u64) -> Result<Mission> {
        let robot = &variant.robot;
        let world = variant.world.as_deref().map(|name| world_files::named(name, robot, seed)).transpose()?;
        let settings = OfficeSettings::of(robot.clone());
        let rupart = remembering(&self.request, world.as_ref(), robot)?;
        let setup = Setup { world, settings, rupart, ..Setup::default() };
        let (_, modules) = module_files::named(&variant.modules, ModuleVoices::Processes(GoingBack::Never))?;
        let site = sites::build(setup, scenario, modules)?;
        if site.goes_by_clock() {
            bail!(
                "a run with a live module and no world takes as long as it takes on the clock, and an experiment is of many; \
                 write `pace = \"lock-step\"` into its manifest"
            );
        }
        let loaded = sites::load_with(&site, plan, &variant.set, self.request.colour)?;
        Ok(Mission { site, loaded, goal: None })
    }

    /// Figures of each variant, and each beside the first.
    fn compared(&self, tallies: &[VariantTally], results: &[RowResult]) -> (Vec<Block>, Vec<PairedDifferences>) {
        let mut blocks = Vec::new();
        for result in results {
            if !blocks.is_empty() {
                blocks.push(Block::Lines(String::new()));
            }
            blocks.extend(result.blocks());
        }
        let differences = PairedDifferences::of(&self.series(), tallies);
        blocks.extend(differences.iter().flat_map(PairedDifferences::blocks));
        (blocks, differences)
    }
}

impl ExperimentKind for Variants {
    type Ground = VariantGround;
    type Record = MissionTrial;
    type Tally = VariantTally;

    fn series(&self) -> Vec<String> {
        self.variants.iter().map(|variant| variant.name.clone()).collect()
    }

    fn ground(&self, series: usize) -> Result<VariantGround> {
        let variant = &self.variants[series];
        let name = &variant.plan;
        let plan = plans::plan(name).map_err(|error| {
            // Somebody may have meant an experiment and not a plan.
            match suggest(name, self.experiments.iter().copied()) {
                Some(meant) => error.context(format!("no experiment is called `{name}`; did you mean `{meant}`?")),
                None => error,
            }
        })?;
        let scenario = variant.scenario.as_deref().map(plans::scenario).transpose()?;
        let is_drawn = variant.world.as_deref().is_some_and(world_files::is_drawn);
        let first = self.at(variant, &plan, scenario.clone(), self.request.first_seed)?;
        Ok(if is_drawn { VariantGround::Drawn(plan, scenario) } else { VariantGround::One(first) })
    }

    fn run(&self, series: usize, ground: &VariantGround, run: Run) -> Result<MissionTrial> {
        let trial = match ground {
            VariantGround::One(mission) => mission.run(&self.request, run.seed)?,
            VariantGround::Drawn(plan, scenario) => {
                let mission = self.at(&self.variants[series], plan, scenario.clone(), run.seed)?;
                mission.run(&self.request, run.seed)?
            }
        };
        Ok(trial.without_samples())
    }

    fn tally(&self) -> VariantTally {
        VariantTally::new(self.variants.len() > 1)
    }

    fn head(&self, _: &MissionTrial) -> String {
        "row,seed,succeeded,fault,value".to_string()
    }

    fn lines(&self, series: &str, _: Run, trial: &MissionTrial) -> String {
        let outcome = trial.outcome();
        let value = quoted(trial.value.as_deref().unwrap_or_default());
        format!("{},{},{outcome},{value}\n", quoted(series), trial.seed)
    }

    fn further(&self, trial: &MissionTrial) -> Vec<(String, String)> {
        let text = |number: &Option<f64>| number.map_or(String::new(), |number| number.to_string());
        let named = trial.measures.iter().map(|(quantity, number)| (quantity.name().to_string(), text(number)));
        named.collect()
    }

    fn findings(&self, tallies: Vec<VariantTally>, wants_drawings: bool) -> Result<Findings> {
        let names = self.series();
        let results = results(&names, tallies.iter().map(|tally| &tally.row));
        let stem = |name: &str| match self.variants.len() {
            1 => Path::new(name).file_stem().map_or(name.to_string(), |stem| stem.to_string_lossy().into_owned()),
            _ => name.to_string(),
        };
        let stems: Vec<String> = names.iter().map(|name| stem(name)).collect();
        let rows: Vec<(&str, &OverTime)> =
            stems.iter().map(String::as_str).zip(tallies.iter().map(|tally| &tally.row.over_time)).collect();
        let mut drawings = if wants_drawings { over_time(&rows) } else { Vec::new() };
        if wants_drawings {
            drawings.extend(means(&results).map(|chart| ("measures.svg".to_string(), chart)));
        }
        let status = match &tallies[..] {
            [only] => status(&only.row),
            all => whether_measured(all.iter().map(|tally| &tally.row)),
        };
        let (blocks, paired) = self.compared(&tallies, &results);
        if wants_drawings {
            drawings.extend(differences(&paired).map(|chart| ("differences.svg".to_string(), chart)));
        }
        let mut figures = json!({ "rows": results });
        if self.variants.len() > 1 {
            figures["paired"] = json!(paired);
        }
        Ok(Findings { status, blocks, figures, drawings })
    }
}
