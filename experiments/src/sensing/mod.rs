//! Active sensing (Fox, Burgard, Thrun, *Active Markov Localization for Mobile Robots*, §5.3): a
//! robot is moved up and down a corridor that looks the same from both ends, but for a box that only
//! the sonars see, and reads one sensor at a time.

mod course;
mod picture;
mod settings;
mod shuttle;
mod table;

use super::conduct::chosen;
use super::findings::Findings;
use super::kind::{ExperimentKind, Run};
use super::request::ExperimentRequest;
use anyhow::Result;
use course::{EndPoint, Hall, NEVER_LONGER_US, SensingRun, SensingRuns};
use rpl_shell::files::world_files;
use rpl_shell::status::Status;
use serde_json::json;
use settings::{SETTINGS, SensingSetting};

/// The experiment; its status is about its first row.
pub struct Sensing {
    request: ExperimentRequest,
    settings: Vec<&'static SensingSetting>,
}

impl Sensing {
    /// What is asked for.
    ///
    /// # Errors
    /// No row has the name.
    pub fn new(request: ExperimentRequest) -> Result<Self> {
        let settings = chosen(&request, &SETTINGS, |setting| setting.name)?;
        Ok(Self { request, settings })
    }

    fn hall(&self) -> Result<Hall> {
        let world = self.request.world.as_deref().unwrap_or("sensing");
        Hall::new(world_files::for_all_seeds(world, &self.request.robot)?)
    }

    fn sense(&self, hall: &Hall, setting: &SensingSetting, seed: u64) -> (SensingRun, Vec<EndPoint>) {
        hall.run(setting, seed, self.request.until_us.min(NEVER_LONGER_US))
    }
}

impl ExperimentKind for Sensing {
    type Ground = Hall;
    type Record = SensingRun;
    type Tally = Vec<SensingRun>;

    fn series(&self) -> Vec<String> {
        self.settings.iter().map(|setting| setting.name.to_string()).collect()
    }

    fn ground(&self, _: usize) -> Result<Hall> {
        self.hall()
    }

    fn run(&self, series: usize, hall: &Hall, run: Run) -> Result<SensingRun> {
        Ok(self.sense(hall, self.settings[series], run.seed).0)
    }

    fn head(&self, _: &SensingRun) -> String {
        table::HEAD.to_string()
    }

    fn lines(&self, series: &str, _: Run, course: &SensingRun) -> String {
        table::line(series, course)
    }

    fn findings(&self, tallies: Vec<Vec<SensingRun>>, wants_drawings: bool) -> Result<Findings> {
        let rows: SensingRuns = self.settings.iter().copied().zip(tallies).collect();
        let mut drawings = Vec::new();
        if wants_drawings {
            drawings = picture::over_time(&rows);
            let shown = rows.iter().find(|(setting, _)| picture::shows_readings(setting));
            if let Some((setting, course)) = shown.and_then(|(setting, courses)| Some((setting, courses.first()?))) {
                // A run is a function of its seed: what was read in it need not be kept.
                let hall = self.hall()?;
                drawings.extend(picture::readings(&hall, course.seed, &self.sense(&hall, setting, course.seed).1));
            }
        }
        let succeeded = rows.first().is_some_and(|(_, courses)| courses.iter().all(SensingRun::succeeded));
        let status = if succeeded { Status::Succeeded } else { Status::Failed };
        let results = table::results(&rows);
        Ok(Findings { status, blocks: table::blocks(&results), figures: json!({ "rows": results }), drawings })
    }
}

/// What can be asked for with `--row`.
pub fn row_names() -> Vec<&'static str> {
    SETTINGS.iter().map(|setting| setting.name).collect()
}
