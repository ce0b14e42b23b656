//! What a plan is run in, as the command line names it: the world, what happens there, and the seed.

use crate::completion;
use crate::files;
use crate::localize::positive;
use crate::mission::{self, MEMORY_GIB, Site};
use anyhow::Result;
use clap_complete::engine::ArgValueCompleter;
use rpl_robot::localization::LocalizationParameters;
use rpl_robot::office::OfficeSettings;
use rpl_robot::world::World;

/// Arguments that say where a plan runs.
#[derive(clap::Args, Clone, Debug)]
pub struct Setting {
    /// The world the robot is in: a built-in name, or a .toml file
    #[arg(long, value_name = "W", add = ArgValueCompleter::new(completion::worlds))]
    pub world: Option<String>,
    /// What the robot knows of the world: what is mapped there (`world`), or nothing (`none`)
    #[arg(
        long,
        value_name = "M",
        value_enum,
        default_value_t = Map::World,
        requires = "world",
        hide_possible_values = true
    )]
    pub map: Map,
    /// How fine the grid of the robot's belief is: 15 cm and 2° (`fine`), or, for larger worlds,
    /// 30 cm and 6° (`coarse`)
    #[arg(
        long,
        value_name = "G",
        value_enum,
        default_value_t = Grid::Fine,
        requires = "world",
        hide_possible_values = true
    )]
    pub grid: Grid,
    /// The memory that the map and the belief of a world may take, in GiB
    #[arg(long, value_name = "GIB", requires = "world", default_value_t = MEMORY_GIB, value_parser = positive)]
    pub memory: f64,
    /// Seed of every random stream
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// What happens on the way: a plan with hands in the world, such as (rotate-robot! 180deg)
    #[arg(long, value_name = "FILE", add = ArgValueCompleter::new(completion::scenarios))]
    pub scenario: Option<String>,
}

/// What the robot knows of the world.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Map {
    /// What the world says is mapped
    World,
    /// Nothing
    None,
}

impl Map {
    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Map::World => "world",
            Map::None => "none",
        }
    }
}

/// How fine the grid of the belief is.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grid {
    /// 15 cm and 2°
    Fine,
    /// 30 cm and 6°
    Coarse,
}

impl Setting {
    /// The site, and the world of its robot if there is one.
    ///
    /// # Errors
    /// There is no such world or scenario, or it has faults.
    pub fn site(&self) -> Result<(Site, Option<World>)> {
        let world = self.world.as_deref().map(mission::world).transpose()?;
        let scenario = self.scenario.as_deref().map(files::scenario).transpose()?;
        let localization = match self.grid {
            Grid::Fine => LocalizationParameters::default(),
            Grid::Coarse => LocalizationParameters::coarse(),
        };
        let settings = OfficeSettings { map_known: self.map == Map::World, localization, ..OfficeSettings::default() };
        let site = Site::within(world.clone(), scenario, settings, self.memory)?;
        Ok((site, world))
    }
}
