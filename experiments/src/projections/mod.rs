//! Whether what is projected comes true: missions in abstract worlds, each foretold by three forecasters before it runs.
//! One has the assumptions that a robot begins with, one has learned from missions in that world, one is told how likely
//! everything really is.

mod foretold_mission;
mod missions;
mod reliability;

use super::conduct::chosen;
use super::findings::Findings;
use super::kind::{ExperimentKind, Run};
use super::request::ExperimentRequest;
use anyhow::{Result, bail};
use foretold_mission::{ForetoldMission, foretold};
use missions::KINDS;
use rpl_mission::site::Site;

/// The world of the missions.
const WORLD: &str = "dept";

/// Foretold missions, kind by kind.
pub struct Projections {
    request: ExperimentRequest,
    kinds: Vec<&'static str>,
}

impl Projections {
    /// What is asked for.
    ///
    /// # Errors
    /// No row has the name.
    pub fn new(request: ExperimentRequest) -> Result<Self> {
        let kinds = chosen(&request, &KINDS, |kind| kind.0)?.into_iter().map(|kind| kind.0).collect();
        Ok(Self { request, kinds })
    }
}

/// The kinds of missions.
pub fn row_names() -> Vec<&'static str> {
    KINDS.iter().map(|kind| kind.0).collect()
}

impl ExperimentKind for Projections {
    type Ground = Site;
    type Record = ForetoldMission;
    type Tally = Vec<ForetoldMission>;

    fn series(&self) -> Vec<String> {
        self.kinds.iter().map(|kind| (*kind).to_string()).collect()
    }

    fn ground(&self, _: usize) -> Result<Site> {
        let site = self.request.office(WORLD)?;
        if let Some(office) = site.office().filter(|office| office.world.places.len() < 4) {
            bail!("missions lead between four places, and the world `{}` has fewer", office.world.name);
        }
        Ok(site)
    }

    fn run(&self, series: usize, site: &Site, run: Run) -> Result<ForetoldMission> {
        let kind = KINDS.iter().position(|kind| kind.0 == self.kinds[series]);
        foretold(kind.unwrap_or(0), site, run.seed)
    }

    fn head(&self, _: &ForetoldMission) -> String {
        "kind,seed,contingencies,at_first,after_lessons,told_the_truth,succeeded".to_string()
    }

    fn lines(&self, series: &str, run: Run, mission: &ForetoldMission) -> String {
        let ForetoldMission { contingencies, forecasts: [at_first, learned, told], is_success } = mission;
        format!(
            "{series},{},{contingencies},{at_first:.4},{learned:.4},{told:.4},{}\n",
            run.seed,
            u8::from(*is_success)
        )
    }

    fn findings(&self, tallies: Vec<Vec<ForetoldMission>>, _: bool) -> Result<Findings> {
        Ok(reliability::findings(&self.kinds, &tallies))
    }
}
