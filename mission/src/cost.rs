//! What a large world takes in memory and time: told before anything is built from it, and refused if
//! it is too much.

use rpl_robot::geometry::Vector;
use rpl_robot::office::{Cost, OfficeModel, OfficeSettings};
use rpl_robot::world::World;
use std::fmt;

/// Memory for the models of a world, if nobody says how much.
pub const MEMORY_GIB: f64 = 4.0;

/// Whoever waits longer for the first step is told.
const LONG_S: f64 = 5.0;

/// A world that takes its time before the first step: worth telling whoever waits for it.
#[derive(Clone, Debug, PartialEq)]
pub struct LargeWorld {
    /// The world.
    pub world: String,
    /// What it takes.
    pub cost: Cost,
}

impl LargeWorld {
    /// Whether a world takes long with these settings, and how long.
    pub fn of(world: &World, settings: &OfficeSettings) -> Option<Self> {
        let cost = OfficeModel::cost(world, settings);
        (cost.seconds > LONG_S).then(|| Self { world: world.name.clone(), cost })
    }
}

impl fmt::Display for LargeWorld {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the world `{}` is large: {}", self.world, costs(self.cost))
    }
}

/// A world that would take more memory than it may.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "the world `{world}` of {:.0} m by {:.0} m is too large: {}, and {allowed_gib} GiB are allowed",
    size_m.x,
    size_m.y,
    costs(*cost)
)]
pub struct TooLarge {
    /// The world.
    pub world: String,
    /// Its extent.
    pub size_m: Vector,
    /// What it takes.
    pub cost: Cost,
    /// The memory it may take.
    pub allowed_gib: f64,
    /// What would take less, if the robot is to have a map.
    pub savings: Option<Savings>,
}

/// The memory that a world takes with other settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Savings {
    /// With a belief on a coarse grid ([`LocalizationParameters::coarsened`](rpl_robot::localization::LocalizationParameters::coarsened)).
    pub coarse_gib: f64,
    /// Without a map (`map_known` false in [`OfficeSettings`]).
    pub mapless_gib: f64,
}

impl TooLarge {
    /// What there is to say of a world that may take `allowed_gib` of memory; nothing if it takes no more.
    pub fn of(world: &World, settings: &OfficeSettings, allowed_gib: f64) -> Option<Self> {
        let cost = OfficeModel::cost(world, settings);
        if gib(cost) <= allowed_gib {
            return None;
        }
        let coarse = OfficeSettings { localization: settings.localization.clone().coarsened(), ..settings.clone() };
        let mapless = OfficeSettings { map_known: false, ..settings.clone() };
        let takes_gib = |settings: &OfficeSettings| gib(OfficeModel::cost(world, settings));
        let savings = || Savings { coarse_gib: takes_gib(&coarse), mapless_gib: takes_gib(&mapless) };
        Some(Self {
            world: world.name.clone(),
            size_m: world.size_m,
            cost,
            allowed_gib,
            savings: settings.map_known.then(savings),
        })
    }
}

fn gib(cost: Cost) -> f64 {
    cost.bytes / f64::from(1 << 30)
}

fn costs(cost: Cost) -> String {
    let time = if cost.seconds < 90.0 {
        format!("{:.0} s", cost.seconds.max(1.0))
    } else {
        format!("{:.0} min", cost.seconds / 60.0)
    };
    format!("its map and belief take up to {:.1} GiB of memory, and {time} before the first step", gib(cost))
}
