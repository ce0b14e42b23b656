//! What a plan is run in, as the command line names it: the world, what happens there, and the seed.

use crate::arguments::completion;
use crate::arguments::numbers::positive;
use crate::files::case_files::KeptCases;
use crate::files::module_files::{self, ModuleVoices, Modules};
use crate::files::project_file::ProjectFile;
use crate::files::{plans, robot_files, world_files};
use crate::sites;
use anyhow::{Result, bail};
use clap::ValueHint;
use clap_complete::engine::ArgValueCompleter;
use rpl_mission::cost::MEMORY_GIB;
use rpl_mission::site::{Setup, Site};
use rpl_robot::office::OfficeSettings;
use rpl_robot::world::World;
use rpl_rupart::RupartSettings;
use std::env;
use std::path::Path;
use std::thread;

/// Arguments that say where a plan runs.
#[derive(clap::Args, Clone, Debug)]
pub struct SiteArguments {
    /// World that the robot is in: a built-in name, a .toml file, or a ROS map; `arena` is drawn from the seed
    #[arg(long, value_name = "W", add = ArgValueCompleter::new(completion::worlds))]
    pub world: Option<String>,
    /// Robot: a built-in name or a .toml file (default: b21)
    #[arg(long, value_name = "R", add = ArgValueCompleter::new(completion::robots))]
    pub robot: Option<String>,
    /// Map that the robot has: that of the world (`world`, the default), or no map (`none`)
    #[arg(long, value_name = "M", value_enum, hide_possible_values = true)]
    pub map: Option<MapArgument>,
    /// Cell size of the robot's belief: 15 cm and 2° (`fine`, the default), or, for larger worlds, 30 cm and 6°
    /// (`coarse`)
    #[arg(long, value_name = "G", value_enum, hide_possible_values = true)]
    pub grid: Option<GridArgument>,
    #[arg(long, value_name = "GIB", help = memory_help(), value_parser = positive)]
    /// Memory limit for the map and the belief of a world, in GiB
    pub memory: Option<f64>,
    /// Seed of every random stream (default: 1)
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Manifest of a module in another process; can be repeated
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub module: Vec<String>,
    /// Whether they were named elsewhere than on the command line, so that it is told what is started.
    #[arg(skip)]
    pub tells_modules: bool,
    /// A scenario: a second plan that disturbs the world (turns the robot, closes doors, sends messages)
    #[arg(long, value_name = "FILE", add = ArgValueCompleter::new(completion::scenarios))]
    pub scenario: Option<String>,
}

fn memory_help() -> String {
    format!("Memory limit for the map and the belief of a world, in GiB (default: {MEMORY_GIB})")
}

/// What the robot knows of the world.
#[derive(clap::ValueEnum, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MapArgument {
    #[default]
    /// What the world says is mapped
    World,
    /// Nothing
    None,
}

impl MapArgument {
    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            MapArgument::World => "world",
            MapArgument::None => "none",
        }
    }
}

/// How fine the grid of the belief is.
#[derive(clap::ValueEnum, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GridArgument {
    #[default]
    /// 15 cm and 2°
    Fine,
    /// 30 cm and 6°
    Coarse,
}

/// Where nothing else is said.
pub const FIRST_SEED: u64 = 1;

impl SiteArguments {
    /// The seed of every random stream.
    pub fn seed(&self) -> u64 {
        self.seed.unwrap_or(FIRST_SEED)
    }

    /// What the robot knows of the world.
    pub fn map(&self) -> MapArgument {
        self.map.unwrap_or_default()
    }

    /// How fine the grid of the belief is.
    pub fn grid(&self) -> GridArgument {
        self.grid.unwrap_or_default()
    }

    /// The memory that the map and the belief of a world may take, in GiB.
    pub fn memory_gib(&self) -> f64 {
        self.memory.unwrap_or(MEMORY_GIB)
    }

    /// Takes from a project what is not said here.
    pub fn in_project(&mut self, project: &ProjectFile) {
        let or = |mine: &mut Option<String>, its: &Option<String>| *mine = mine.take().or_else(|| its.clone());
        or(&mut self.world, &project.world);
        or(&mut self.robot, &project.robot);
        or(&mut self.scenario, &project.scenario);
        if self.module.is_empty() {
            self.module.clone_from(&project.modules);
            self.tells_modules = true;
        }
        self.seed = self.seed.or(project.seed);
    }

    /// # Errors
    /// Something is said of a robot, and there is none.
    fn must_have_robot_or_nothing_of_it(&self) -> Result<()> {
        let said = [
            ("--robot", self.robot.is_some()),
            ("--map", self.map.is_some()),
            ("--grid", self.grid.is_some()),
            ("--memory", self.memory.is_some()),
        ];
        match said.iter().find(|(_, is_said)| *is_said && self.world.is_none()) {
            Some((option, _)) => bail!(needs_world(option)),
            None => Ok(()),
        }
    }

    /// The site, the world of its robot if there is one, and its modules, which have not been started.
    ///
    /// # Errors
    /// There is no such world, scenario, robot or module, or it has faults.
    pub fn build(&self, voices: ModuleVoices<'_>) -> Result<(Site, Option<World>, Modules)> {
        let (site, world, modules, _) = self.build_with(voices, None)?;
        Ok((site, world, modules))
    }

    /// The same for a robot that remembers what is in a case file, if one is named.
    ///
    /// # Errors
    /// As for [`SiteArguments::build`]; the file cannot be read or written, or has faults.
    pub fn build_with(
        &self,
        voices: ModuleVoices<'_>,
        cases: Option<&Path>,
    ) -> Result<(Site, Option<World>, Modules, Option<KeptCases>)> {
        self.must_have_robot_or_nothing_of_it()?;
        let Some(world) = &self.world else {
            if cases.is_some() {
                bail!(needs_world("--cases"));
            }
            let scenario = self.scenario.as_deref().map(plans::scenario).transpose()?;
            let (modules, sources) = module_files::named(&self.module, voices)?;
            return Ok((sites::without_robot(scenario.as_ref(), sources)?, None, modules, None));
        };
        let robot = robot_files::named(self.robot.as_deref())?;
        let world = world_files::named(world, &robot, self.seed())?;
        let opened = cases.map(|path| KeptCases::open(path, &world, &robot)).transpose()?;
        let (cases, memory) = opened.unzip();
        let rupart = RupartSettings { memory: memory.flatten(), ..RupartSettings::default() };
        let scenario = self.scenario.as_deref().map(plans::scenario).transpose()?;
        let (modules, sources) = module_files::named(&self.module, voices)?;
        let usual = OfficeSettings::of(robot);
        let localization = match self.grid() {
            GridArgument::Fine => usual.localization,
            GridArgument::Coarse => usual.localization.coarsened(),
        };
        let settings = OfficeSettings { map_known: self.map() == MapArgument::World, localization, ..usual };
        compute_along();
        let site = sites::build(
            Setup { world: Some(world.clone()), settings, memory_gib: self.memory_gib(), rupart, ..Setup::default() },
            scenario,
            sources,
        )?;
        Ok((site, Some(world), modules, cases))
    }
}

/// What is said of an option that is about a robot in a world, and there is none.
pub fn needs_world(option: &str) -> String {
    format!("`{option}` is about a robot in a world, and there is none; add `--world dept`")
}

/// Makes this thread one of those that compute what is shared out. Otherwise it would wait for as many others, and they
/// could not use the memory it has given back to the allocator, which is much where the map is large.
fn compute_along() {
    // One that is alone would be waited for by all others, and who says how many there are to be has them as usual.
    let are_several = thread::available_parallelism().is_ok_and(|threads| threads.get() > 1);
    if are_several && env::var_os("RAYON_NUM_THREADS").is_none() {
        // An error tells that there are threads already.
        let _ = rayon::ThreadPoolBuilder::new().use_current_thread().build_global();
    }
}
