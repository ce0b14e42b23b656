//! Sites as the command builds them: who waits for a large world is told so before, and what is wrong
//! comes with the options that help.

use crate::files::overrides::{Overrides, OverridingLoader};
use crate::files::plans::PlanText;
use crate::terminal::console;
use anyhow::{Result, bail};
use rpl_lang::compile::Loader;
use rpl_mission::cost::{LargeWorld, TooLarge};
use rpl_mission::site::{Setup, Site};
use rpl_protocol::module::process_modules::ModuleSource;
use rpl_robot::office::OfficeSettings;
use rpl_robot::world::World;
use rpl_runtime::run::library::Loaded;

/// A site with modules in other processes, and what happens there if there is a scenario.
///
/// # Errors
/// The scenario's text or a module is wrong, or the world is too large or cannot be localized in.
pub fn build(setup: Setup, scenario: Option<PlanText>, modules: Vec<ModuleSource>) -> Result<Site> {
    match (&setup.world, &scenario) {
        (None, Some(scenario)) => bail!(needs_robot(scenario)),
        (None, None) => {}
        (Some(world), _) => announce(world, &setup.settings, setup.memory_gib)?,
    }
    let site = Site::with_processes(setup, modules)?;
    match scenario {
        Some(scenario) => with_scenario(&site, scenario),
        None => Ok(site),
    }
}

/// A site without a robot, for which no robot is described: of these modules in other processes, or of nothing.
///
/// # Errors
/// There is a scenario, or a module is wrong or needs a robot.
pub(crate) fn without_robot(scenario: Option<&PlanText>, modules: Vec<ModuleSource>) -> Result<Site> {
    match scenario {
        Some(scenario) => bail!(needs_robot(scenario)),
        None if modules.is_empty() => Ok(Site::without_robot()?),
        None => Ok(Site::with_processes(Setup::default(), modules)?),
    }
}

fn needs_robot(scenario: &PlanText) -> String {
    format!("the scenario `{}` needs a robot; add `--world dept`", scenario.name)
}

/// The same place with another scenario.
///
/// # Errors
/// There is no robot, or the scenario's text is wrong.
pub fn with_scenario(site: &Site, scenario: PlanText) -> Result<Site> {
    let PlanText { name, text, mut folder } = scenario;
    Ok(site.with_scenario(&name, &text, &mut folder)?)
}

/// A plan compiled for a site.
///
/// # Errors
/// Its text is wrong: the error shows where, in colour if that is asked for.
pub fn load(site: &Site, plan: &PlanText, colour: bool) -> Result<Loaded> {
    load_text(site, &plan.name, &plan.text, &mut plan.folder.clone(), colour)
}

/// The same with other first values for variables of the plan, each as `NAME=EXPR`.
///
/// # Errors
/// As for [`load`]; or a first value is wrong, or is of no variable of the plan.
pub fn load_with(site: &Site, plan: &PlanText, set: &[String], colour: bool) -> Result<Loaded> {
    let mut overrides = Overrides::parse(set)?;
    let text = overrides.apply(plan.text.clone());
    let mut loader = OverridingLoader { inner: &mut plan.folder.clone(), overrides: &mut overrides };
    let loaded = load_text(site, &plan.name, &text, &mut loader, colour)?;
    overrides.check_all_used()?;
    Ok(loaded)
}

/// The same for a text, and what gives it the files that it loads.
///
/// # Errors
/// As for [`load`].
pub fn load_text(site: &Site, name: &str, text: &str, loader: &mut dyn Loader, colour: bool) -> Result<Loaded> {
    match site.library.load(name, text, loader) {
        Ok(loaded) => Ok(loaded),
        Err(rejected) => bail!("{}", rejected.render(colour).trim_end()),
    }
}

/// Says what a large world costs before anything is built from it.
fn announce(world: &World, settings: &OfficeSettings, memory_gib: f64) -> Result<()> {
    if let Some(too_large) = TooLarge::of(world, settings, memory_gib) {
        bail!("{}", refusal(&too_large));
    }
    if let Some(large) = LargeWorld::of(world, settings) {
        console::note(&large.to_string());
    }
    Ok(())
}

/// Why a world cannot be used, and what to type instead.
pub fn refusal(too_large: &TooLarge) -> String {
    let mut advice = vec!["crop it to what is used".to_string()];
    if let Some(savings) = too_large.savings {
        advice.push(format!("take a coarser grid with `--grid coarse`, {:.1} GiB", savings.coarse_gib));
        advice.push(format!("drive without a map with `--map none`, {:.1} GiB", savings.mapless_gib));
    }
    format!("{too_large}\nto use it, allow more with `--memory GIB`; or {}", advice.join("; or "))
}
