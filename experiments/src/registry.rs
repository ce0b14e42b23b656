//! The experiments with a name: one line for each, and a file with what it is.

use super::any_kind::{AnyKind, Hidden};
use super::cases::{behaviours, kinds, routes};
use super::catalogue::{
    CALIBRATION_ROWS, CHOICES_ROWS, DEVIATIONS_ROWS, FALSE_ALARMS_ROWS, GLOBAL_ROWS, KIDNAPPED_ROWS, OFFICE_ROWS,
    PEOPLE_ROWS, ROTATED_ROWS, RUPART_ROWS, Row, WORLDS,
};
use super::conduct::chosen;
use super::instructions::{delivery, features, markers, openings, topological};
use super::kind::ExperimentKind;
use super::missions::{EveryMoment, Look, MissionTable, Missions};
use super::request::ExperimentRequest;
use super::{
    barn, buildings, choices, crowd, doors, drive_times, errands, foresight, grains, one_scan, projections, sensing,
    worlds,
};
use anyhow::{Result, bail};
use rpl_robot::description::RobotDescription;
use std::sync::Arc;

/// An experiment with a name.
pub struct Experiment {
    /// What a user types.
    pub name: &'static str,
    /// What it can be given.
    takes: Takes,
    /// What can be asked for with `--row`.
    pub rows: fn() -> Vec<&'static str>,
    /// Makes of what is asked what is run, measured and shown.
    kind: fn(ExperimentRequest) -> Result<Arc<dyn AnyKind>>,
}

/// What an experiment can be given besides seeds and a row.
struct Takes {
    /// Another robot.
    robot: bool,
    /// Recorded floor plans.
    maps: bool,
    /// A memory of cases.
    cases: bool,
}

/// Its robots, worlds and memories are its own.
const NOTHING: Takes = Takes { robot: false, maps: false, cases: false };
const ROBOT: Takes = Takes { robot: true, ..NOTHING };
const MAPS: Takes = Takes { maps: true, ..ROBOT };
const CASES: Takes = Takes { cases: true, ..NOTHING };

/// All of them, in the order in which they are listed.
pub const EXPERIMENTS: &[Experiment] = &[
    known("rotated", ROBOT, || named(ROTATED_ROWS), |asked| missions(asked, ROTATED_ROWS, MissionTable::FirstRow)),
    known(
        "kidnapped",
        ROBOT,
        || named(KIDNAPPED_ROWS),
        |asked| missions(asked, KIDNAPPED_ROWS, MissionTable::FirstRow),
    ),
    known("global", ROBOT, || named(GLOBAL_ROWS), |asked| missions(asked, GLOBAL_ROWS, MissionTable::FirstRow)),
    known(
        "false-alarms",
        ROBOT,
        || named(FALSE_ALARMS_ROWS),
        |asked| missions(asked, FALSE_ALARMS_ROWS, MissionTable::Lines),
    ),
    known("calibration", ROBOT, || named(CALIBRATION_ROWS), |asked| missions(asked, CALIBRATION_ROWS, EveryMoment)),
    known(
        "deviations",
        ROBOT,
        || named(DEVIATIONS_ROWS),
        |asked| missions(asked, DEVIATIONS_ROWS, MissionTable::Lines),
    ),
    known("people", ROBOT, || named(PEOPLE_ROWS), |asked| missions(asked, PEOPLE_ROWS, MissionTable::FirstRow)),
    known("office", ROBOT, || named(OFFICE_ROWS), |asked| missions(asked, OFFICE_ROWS, MissionTable::FirstRow)),
    known("crowd", ROBOT, crowd::row_names, |asked| made(crowd::Crowds::new(asked))),
    known("worlds", ROBOT, || WORLDS.to_vec(), |asked| made(worlds::WorldDrives::new(asked))),
    known("buildings", MAPS, buildings::row_names, |asked| made(buildings::Buildings::new(asked))),
    known("doors", ROBOT, || doors::WORLDS.to_vec(), |asked| made(doors::drives(asked))),
    known("barn", NOTHING, barn::row_names, |asked| made(barn::Barn::new(asked))),
    known("choices", ROBOT, || named(CHOICES_ROWS), |asked| made(choices::Choices::new(asked, CHOICES_ROWS))),
    known("drive-times", ROBOT, || drive_times::WORLDS.to_vec(), |asked| made(drive_times::TimedDrives::new(asked))),
    known("grains", ROBOT, || drive_times::WORLDS.to_vec(), |asked| made(grains::Grains::new(asked))),
    known("projections", ROBOT, projections::row_names, |asked| made(projections::Projections::new(asked))),
    known("foresight", ROBOT, foresight::row_names, |asked| made(foresight::Foresight::new(asked))),
    known("one-scan", NOTHING, one_scan::row_names, |asked| made(one_scan::OneScans::new(&asked))),
    known("sensing", NOTHING, sensing::row_names, |asked| made(sensing::Sensing::new(asked))),
    known("hallway-features", ROBOT, features::row_names, |asked| made(features::HallwayFeatures::new(asked))),
    known("count-openings", ROBOT, openings::row_names, |asked| made(openings::CountOpenings::new(asked))),
    known("office-delivery", ROBOT, delivery::row_names, |asked| made(delivery::OfficeDelivery::new(asked))),
    known("topological-global", ROBOT, topological::row_names, |asked| {
        made(topological::TopologicalDrives::new(&asked))
    }),
    known("marker-detection", ROBOT, markers::row_names, |asked| made(markers::MarkerDetections::new(asked))),
    known("routes", NOTHING, routes::row_names, |asked| made(routes::Routes::new(asked))),
    known("case-kinds", NOTHING, kinds::row_names, |asked| made(kinds::Kinds::new(asked))),
    known("behaviours", NOTHING, behaviours::row_names, |asked| made(behaviours::Behaviours::new(asked))),
    known("rupart", CASES, || errands::row_names(RUPART_ROWS), |asked| made(errands::Errands::new(asked, RUPART_ROWS))),
];

const fn known(
    name: &'static str,
    takes: Takes,
    rows: fn() -> Vec<&'static str>,
    kind: fn(ExperimentRequest) -> Result<Arc<dyn AnyKind>>,
) -> Experiment {
    Experiment { name, takes, rows, kind }
}

fn named(rows: &[Row]) -> Vec<&'static str> {
    rows.iter().map(|row| row.name).collect()
}

fn made(kind: Result<impl ExperimentKind>) -> Result<Arc<dyn AnyKind>> {
    Ok(Arc::new(Hidden(kind?)))
}

fn missions(request: ExperimentRequest, rows: &'static [Row], look: impl Look) -> Result<Arc<dyn AnyKind>> {
    let rows = chosen(&request, rows, |row| row.name)?;
    made(Ok(Missions { request, rows, look }))
}

impl Experiment {
    /// The experiment of a name.
    pub fn of(name: &str) -> Option<&'static Self> {
        EXPERIMENTS.iter().find(|known| known.name == name)
    }

    /// What is to be done.
    ///
    /// # Errors
    /// It has no such row, cannot be given what is asked for, or cannot be prepared.
    pub fn prepared(&self, request: &ExperimentRequest) -> Result<Arc<dyn AnyKind>> {
        let name = self.name;
        if !self.takes.robot && request.robot.name != RobotDescription::PAPERS {
            bail!("the experiment `{name}` has a robot of its own; leave `--robot` away");
        }
        if !self.takes.maps && request.maps.is_some() {
            bail!("the experiment `{name}` has worlds of its own; `--maps` is for `buildings`");
        }
        let own = [("--module", &request.modules), ("--set", &request.set), ("--vary", &request.vary)];
        if let Some((option, _)) = own.iter().find(|(_, given)| !given.is_empty()) {
            bail!("the experiment `{name}` has plans of its own; `{option}` is for plans of yours");
        }
        if !self.takes.cases && request.cases.is_some() {
            bail!(
                "the experiment `{name}` drives by no case file; `--cases` is for `rupart`, and for plans of your own"
            );
        }
        (self.kind)(request.clone())
    }
}
