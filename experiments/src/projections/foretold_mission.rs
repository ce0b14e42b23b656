//! A mission that is foretold, and then runs.

use super::missions::{KINDS, NOTHING_BETWEEN, compiled, drawn_chances, drawn_deadline, drawn_plan};
use anyhow::{Result, anyhow, bail};
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

/// Projected runs of which a forecast is made.
const RUNS: u32 = 100;

/// Missions from which the robot has learned.
const LESSONS: usize = 100;

/// How far is projected; no mission takes as long.
const HORIZON_US: u64 = 3_600_000_000;

/// The forecasters, in the order of the forecasts.
pub const FORECASTERS: [&str; 3] = ["at first", "after 100 missions", "told the truth"];

/// A mission that was foretold and has run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ForetoldMission {
    pub contingencies: usize,
    /// The share of success that each forecaster has projected.
    pub forecasts: [f64; 3],
    pub is_success: bool,
}

/// One mission, foretold and run.
pub fn foretold(kind: usize, site: &Site, seed: u64) -> Result<ForetoldMission> {
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
