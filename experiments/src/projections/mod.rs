//! Whether what is projected comes true: missions in abstract worlds, each foretold by three forecasters before it runs.
//! One has the assumptions that a robot begins with, one has learned from missions in that world, one is told how likely
//! everything really is.

mod missions;
mod reliability;

use super::conduct::chosen;
use super::findings::Findings;
use super::kind::{ExperimentKind, Run};
use super::request::ExperimentRequest;
use anyhow::{Result, anyhow, bail};
use missions::{KINDS, NOTHING_BETWEEN, compiled, drawn_chances, drawn_deadline, drawn_plan};
use rpl_mission::modules::SiteRobot;
use rpl_mission::run::{Reached, run_to};
use rpl_mission::site::Site;
use rpl_random::Stream;
use rpl_robot::foresight::abstract_robot::{AbstractRobot, Experience};
use rpl_robot::foresight::models::{Chances, Models};
use rpl_runtime::robot::{ForeseenRobot, Outside};
use rpl_runtime::run::system::{Outcome, System};
use serde::{Deserialize, Serialize};
use std::any::{Any, TypeId};
use std::ops::ControlFlow::Continue;

/// The world of the missions.
const WORLD: &str = "dept";

/// Projected runs of which a forecast is made.
const RUNS: u32 = 100;

/// Missions from which the robot has learned.
const LESSONS: usize = 100;

/// How far is projected; no mission takes as long.
const HORIZON_US: u64 = 3_600_000_000;

/// The forecasters, in the order of the forecasts.
pub(super) const FORECASTERS: [&str; 3] = ["at first", "after 100 missions", "told the truth"];

/// A mission that was foretold and has run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ForetoldMission {
    contingencies: usize,
    /// The share of success that each forecaster has projected.
    forecasts: [f64; 3],
    is_success: bool,
}

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

/// One mission, foretold and run.
fn foretold(kind: usize, site: &Site, seed: u64) -> Result<ForetoldMission> {
    let mut stream = Stream::new(seed, KINDS[kind].0);
    let (chances, contingencies) = drawn_chances(&mut stream);
    let Some(robot) = site.office_robot(seed) else { bail!("missions need a world") };
    let plan = drawn_plan(kind, site, &mut stream);
    let ask = |plan: &str, models: Models, runs: u32, seed: u64| -> Result<_> {
        let robot = robot_with(&robot, models)?;
        let system = System::new(site.library.clone(), compiled(site, plan)?, robot.clone(), seed);
        let figures = system.project_rest_with(robot, runs, HORIZON_US, seed);
        figures.map_err(|why| anyhow!("the mission `{plan}` is not projected: {why}"))
    };
    let undisturbed = ask(&plan, Models::exactly(&NOTHING_BETWEEN), 1, seed)?.time_s;
    let Some([_, undisturbed_s, _]) = undisturbed else { bail!("the mission `{plan}` fails by itself") };
    let plan = format!("(with-timeout {:.3} {plan})", undisturbed_s * drawn_deadline(&mut stream));
    let experience = lessons(site, &robot, &chances, &mut stream)?;
    let description = &robot.model().settings.robot;
    let nothing = Experience::default();
    let believed = |experience: &Experience| Models::learned(description, &experience.grasps, &experience.drives);
    let forecast_seed = stream.seed();
    let mut forecasts = [0.0; 3];
    let models = [believed(&nothing), believed(&experience), Models::exactly(&chances)];
    for (forecast, models) in forecasts.iter_mut().zip(models) {
        *forecast = ask(&plan, models, RUNS, forecast_seed)?.success[0];
    }
    let (is_success, _) = happened(site, &robot, &chances, &plan, stream.seed())?;
    Ok(ForetoldMission { contingencies, forecasts, is_success })
}

/// What the robot has learned of missions of all kinds in that world.
fn lessons(site: &Site, robot: &SiteRobot, chances: &Chances, stream: &mut Stream) -> Result<Experience> {
    let mut learned = Experience::default();
    for number in 0..LESSONS {
        let plan = drawn_plan(number % KINDS.len(), site, stream);
        learned.add(&happened(site, robot, chances, &plan, stream.seed())?.1);
    }
    Ok(learned)
}

/// A mission as it really goes in the abstract world: whether it succeeds, and what the robot learns.
fn happened(site: &Site, robot: &SiteRobot, chances: &Chances, plan: &str, seed: u64) -> Result<(bool, Experience)> {
    let mut world = robot_with(robot, Models::exactly(chances))?;
    world.begin_run(seed);
    let mut system = System::new(site.library.clone(), compiled(site, plan)?, world, seed);
    let reached = run_to(&mut system, HORIZON_US, |system| {
        system.machine.output.clear();
        Continue(())
    });
    let robot = system.outside.part(TypeId::of::<AbstractRobot>()).and_then(<dyn Any>::downcast_mut::<AbstractRobot>);
    let experience = robot.map(|robot| robot.experience.clone()).unwrap_or_default();
    Ok((matches!(reached, Reached::End(Outcome::Succeeded(_))), experience))
}

fn robot_with(robot: &SiteRobot, models: Models) -> Result<ForeseenRobot> {
    robot.abstract_robot(models).map_err(|_| anyhow!("missions need a map"))
}
