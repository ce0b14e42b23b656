//! What a plan is run in, as the command line names it: the world, what happens there, and the seed.

use crate::files;
use crate::mission::{self, Site};
use anyhow::Result;
use rpl_robot::office::OfficeSettings;
use rpl_robot::world::World;

/// Arguments that say where a plan runs.
#[derive(clap::Args, Clone, Debug)]
pub struct Setting {
    /// The world the robot is in: a built-in name, or a .toml file
    #[arg(long, value_name = "W")]
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
    /// Seed of every random stream
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// What happens on the way: a plan with hands in the world, such as (rotate-robot! 180deg)
    #[arg(long, value_name = "FILE")]
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

impl Setting {
    /// The site, and the world of its robot if there is one.
    ///
    /// # Errors
    /// There is no such world or scenario, or it has faults.
    pub fn site(&self) -> Result<(Site, Option<World>)> {
        let world = self.world.as_deref().map(mission::world).transpose()?;
        let scenario = self.scenario.as_deref().map(files::scenario).transpose()?;
        let settings = OfficeSettings { map_known: self.map == Map::World, ..OfficeSettings::default() };
        let site = Site::new(world.clone(), scenario, settings)?;
        Ok((site, world))
    }
}
