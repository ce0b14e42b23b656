//! Experiments: a plan over many seeds, in parallel, as a table.
//!
//! An experiment is a *kind* (`kind`): a run as a function of its seed, with a record that can be written down, and a
//! table that is a fold of the records in the order of the seeds. So the records may come from threads of this process,
//! or from parts that others have written (`part`), and the table cannot tell. Where a drawing needs more of a run than
//! its record, the run is driven again.
//!
//! `conduct` sees no types of a kind (`any_kind`): it is compiled once, and not for each kind. A cluster is somebody
//! else's: the package for Python makes each shard a task of Ray, and puts the parts together as they come.
//!
//! Read in this order:
//!
//! - `kind`, `any_kind`, `seeds`, `part`, `runs_file`, `conduct`, `findings`, `request`: how experiments are done;
//! - `statistics`, `numbers`, `samples`, `reliability`, `over_time`, `failed_runs`, `chart`, `means_chart`: figures made of their
//!   records;
//! - `quantity`, `trial`, `row_result`, `missions`, `calibration`, `day`: missions over seeds;
//! - `experiment_file`, `variants`: a plan of one's own, and variants of it beside each other;
//! - `catalogue`: rows of experiments that are missions; those that are none have a file or a folder of their own;
//! - `registry`: the experiments with a name.

mod any_kind;
mod barn;
mod buildings;
mod calibration;
mod cases;
mod catalogue;
pub mod chart;
mod choices;
mod conduct;
mod crowd;
mod day;
mod doors;
mod drive_times;
mod errands;
pub mod experiment_file;
mod failed_runs;
mod findings;
mod foresight;
mod grains;
mod instructions;
mod kind;
mod means_chart;
mod missions;
mod numbers;
pub mod one_scan;
mod over_time;
pub mod part;
mod projections;
mod quantity;
mod registry;
pub mod reliability;
mod request;
mod row_result;
mod runs_file;
mod samples;
mod seeds;
mod sensing;
pub mod statistics;
mod trial;
mod variants;
mod worlds;

pub use conduct::{Conduct, RunSource};
pub use findings::Findings;
pub use request::ExperimentRequest;

use any_kind::{AnyKind, Hidden};
use anyhow::{Result, bail};
use conduct::conduct;
use registry::{EXPERIMENTS, Experiment};
use rpl_shell::terminal::console::Console;
use std::sync::Arc;
use variants::Variants;

/// Does an experiment, or one with a plan of the user's own.
///
/// # Errors
/// No experiment or plan has the name, the plan's text is wrong, or something cannot be read or written.
pub fn run(request: &ExperimentRequest, how: Conduct, console: &mut Console) -> Result<Findings> {
    let kind = match Experiment::of(&request.name) {
        Some(experiment) => experiment.prepared(request)?,
        None => own_plan(request)?,
    };
    conduct(&kind, request, how, console)
}

fn own_plan(request: &ExperimentRequest) -> Result<Arc<dyn AnyKind>> {
    if request.maps.is_some() {
        bail!("a plan of your own drives on a map by `--world map.yaml`; `--maps` is for `buildings`");
    }
    let experiments = EXPERIMENTS.iter().map(|known| known.name).collect();
    Ok(Arc::new(Hidden(Variants::new(request.clone(), experiments)?)))
}

/// The experiments with a name, each with its rows.
pub fn names() -> impl Iterator<Item = (&'static str, Vec<&'static str>)> {
    EXPERIMENTS.iter().map(|experiment| (experiment.name, (experiment.rows)()))
}
