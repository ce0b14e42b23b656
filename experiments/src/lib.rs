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
//! - `kind`, `any_kind`, `seeds`, `part`, `conduct`, `findings`, `request`: how experiments are done;
//! - `statistics`, `numbers`, `samples`, `reliability`, `over_time`, `failed_runs`, `chart`: figures made of their
//!   records;
//! - `trial`, `row_result`, `missions`, `calibration`, `day`: missions over seeds;
//! - `catalogue`: the experiments with a name; those that are no missions have a file or a folder of their own.

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
mod failed_runs;
mod findings;
mod foresight;
mod grains;
mod instructions;
mod kind;
mod missions;
mod numbers;
pub mod one_scan;
mod over_time;
pub mod part;
mod projections;
pub mod reliability;
mod request;
mod row_result;
mod samples;
mod seeds;
mod sensing;
pub mod statistics;
mod trial;
mod worlds;

pub use conduct::{Conduct, RunSource};
pub use findings::Findings;
pub use request::ExperimentRequest;

use anyhow::{Result, bail};
use catalogue::{EXPERIMENTS, Experiment, ExperimentSubject, Row};
use conduct::{chosen, conduct};
use missions::{EveryMoment, MissionTable, Missions, OwnPlan};
use rpl_robot::description::RobotDescription;
use rpl_shell::terminal::console::Console;

/// Does an experiment, or one with a plan of the user's own.
///
/// # Errors
/// No experiment or plan has the name, the plan's text is wrong, or something cannot be read or written.
pub fn run(request: &ExperimentRequest, how: Conduct, console: &mut Console) -> Result<Findings> {
    let experiment = EXPERIMENTS.iter().find(|known| known.name == request.name);
    let Some(experiment) = experiment else {
        if request.maps.is_some() {
            bail!("a plan of your own drives on a map by `--world map.yaml`; `--maps` is for `buildings`");
        }
        return conduct(OwnPlan::new(request.clone())?, request, how, console);
    };
    let has_own_robot = matches!(
        experiment.subject,
        ExperimentSubject::Barn
            | ExperimentSubject::Sensing
            | ExperimentSubject::OneScan
            | ExperimentSubject::Routes
            | ExperimentSubject::CaseKinds
            | ExperimentSubject::Behaviours
    ) || experiment.rows.iter().any(Row::chooses_robot);
    if has_own_robot && request.robot.name != RobotDescription::PAPERS {
        bail!("the experiment `{}` has a robot of its own; leave `--robot` away", experiment.name);
    }
    if request.maps.is_some() && experiment.subject != ExperimentSubject::Buildings {
        bail!("the experiment `{}` has worlds of its own; `--maps` is for `buildings`", experiment.name);
    }
    if request.cases.is_some() && experiment.subject != ExperimentSubject::Errands {
        bail!(
            "the experiment `{}` drives by no case file; `--cases` is for `rupart`, and for plans of your own",
            experiment.name
        );
    }
    let asked = request.clone();
    let rows = || chosen(request, experiment.rows, |row| row.name);
    match experiment.subject {
        ExperimentSubject::Success => {
            conduct(Missions { request: asked, rows: rows()?, look: MissionTable::FirstRow }, request, how, console)
        }
        ExperimentSubject::Comparison => {
            conduct(Missions { request: asked, rows: rows()?, look: MissionTable::Lines }, request, how, console)
        }
        ExperimentSubject::Calibration => {
            conduct(Missions { request: asked, rows: rows()?, look: EveryMoment }, request, how, console)
        }
        ExperimentSubject::Choices => conduct(choices::Choices::new(asked, rows()?)?, request, how, console),
        ExperimentSubject::Barn => conduct(barn::Barn::new(asked)?, request, how, console),
        ExperimentSubject::Crowd => conduct(crowd::Crowds::new(asked)?, request, how, console),
        ExperimentSubject::Worlds => conduct(worlds::WorldDrives::new(asked)?, request, how, console),
        ExperimentSubject::Buildings => conduct(buildings::Buildings::new(asked)?, request, how, console),
        ExperimentSubject::Doors => conduct(doors::drives(asked)?, request, how, console),
        ExperimentSubject::DriveTimes => conduct(drive_times::TimedDrives::new(asked)?, request, how, console),
        ExperimentSubject::Grains => conduct(grains::Grains::new(asked)?, request, how, console),
        ExperimentSubject::Projections => conduct(projections::Projections::new(asked)?, request, how, console),
        ExperimentSubject::Foresight => conduct(foresight::Foresight::new(asked)?, request, how, console),
        ExperimentSubject::OneScan => conduct(one_scan::OneScans::new(request)?, request, how, console),
        ExperimentSubject::Sensing => conduct(sensing::Sensing::new(asked)?, request, how, console),
        ExperimentSubject::HallwayFeatures => {
            conduct(instructions::HallwayFeatures::new(asked)?, request, how, console)
        }
        ExperimentSubject::CountOpenings => conduct(instructions::CountOpenings::new(asked)?, request, how, console),
        ExperimentSubject::OfficeDelivery => conduct(instructions::OfficeDelivery::new(asked)?, request, how, console),
        ExperimentSubject::TopologicalGlobal => {
            conduct(instructions::TopologicalDrives::new(request)?, request, how, console)
        }
        ExperimentSubject::MarkerDetection => {
            conduct(instructions::MarkerDetections::new(asked)?, request, how, console)
        }
        ExperimentSubject::Routes => conduct(cases::Routes::new(asked)?, request, how, console),
        ExperimentSubject::CaseKinds => conduct(cases::Kinds::new(asked)?, request, how, console),
        ExperimentSubject::Behaviours => conduct(cases::Behaviours::new(asked)?, request, how, console),
        ExperimentSubject::Errands => conduct(errands::Errands::new(asked, experiment.rows)?, request, how, console),
    }
}

/// What can be asked for with `--row`.
fn row_names(experiment: &Experiment) -> Vec<&'static str> {
    match experiment.subject {
        ExperimentSubject::Barn => barn::row_names(),
        ExperimentSubject::Crowd => crowd::row_names(),
        ExperimentSubject::Worlds => catalogue::WORLDS.to_vec(),
        ExperimentSubject::Buildings => buildings::row_names(),
        ExperimentSubject::Doors => doors::WORLDS.to_vec(),
        ExperimentSubject::DriveTimes | ExperimentSubject::Grains => drive_times::WORLDS.to_vec(),
        ExperimentSubject::Projections => projections::row_names(),
        ExperimentSubject::Foresight => foresight::row_names(),
        ExperimentSubject::OneScan => one_scan::row_names(),
        ExperimentSubject::Sensing => sensing::row_names(),
        ExperimentSubject::HallwayFeatures => instructions::feature_rows(),
        ExperimentSubject::CountOpenings => instructions::counting_rows(),
        ExperimentSubject::OfficeDelivery => instructions::delivery_rows(),
        ExperimentSubject::TopologicalGlobal => instructions::map_rows(),
        ExperimentSubject::MarkerDetection => instructions::marker_rows(),
        ExperimentSubject::Routes => cases::route_rows(),
        ExperimentSubject::CaseKinds => cases::kind_rows(),
        ExperimentSubject::Behaviours => cases::behaviour_rows(),
        ExperimentSubject::Errands => errands::row_names(experiment.rows),
        ExperimentSubject::Success
        | ExperimentSubject::Comparison
        | ExperimentSubject::Calibration
        | ExperimentSubject::Choices => experiment.rows.iter().map(|row| row.name).collect(),
    }
}

/// The experiments with a name, each with its rows.
pub fn names() -> impl Iterator<Item = (&'static str, Vec<&'static str>)> {
    EXPERIMENTS.iter().map(|experiment| (experiment.name, row_names(experiment)))
}
