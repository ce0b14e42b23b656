//! The series of the experiment: buildings of a kind, or on a recorded floor plan, with a disturbance.

use super::disturbance::Disturbance;
use crate::request::ExperimentRequest;
use anyhow::{Context, Result, anyhow, bail};
use rpl_robot::buildings::{Building, BuildingKind, Furniture};
use rpl_robot::world::World;
use rpl_shell::files::maps::{MAP_FILE, ros_map};
use rpl_shell::files::shown::Shown;
use rpl_shell::terminal::console;
use std::path::{Path, PathBuf};

/// Folders in folders are looked into so deep.
const DEEPEST: usize = 8;

/// What buildings are drawn on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ground {
    /// A floor plan that is drawn, too.
    Kind(BuildingKind),
    /// One that was recorded: its name, and the file of the map.
    Map(String, PathBuf),
}

impl Ground {
    /// What it is called.
    pub fn name(&self) -> &str {
        match self {
            Self::Kind(kind) => kind.name(),
            Self::Map(name, _) => name,
        }
    }

    fn has(&self, disturbance: Disturbance) -> bool {
        match (self, disturbance) {
            (Self::Kind(kind), Disturbance::Doors) => kind.has_doors(),
            (Self::Map(..), Disturbance::Doors) => false,
            (_, _) => true,
        }
    }
}

/// A series.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BuildingRow {
    /// Where.
    pub ground: Ground,
    /// What happens there.
    pub disturbance: Disturbance,
}

impl BuildingRow {
    /// What it is called.
    pub fn name(&self) -> String {
        format!("{}/{}", self.ground.name(), self.disturbance.name())
    }

    /// All of these grounds.
    fn all(grounds: &[Ground]) -> Vec<Self> {
        let of = |ground: &Ground| {
            let disturbances = Disturbance::ALL.into_iter().filter(|&disturbance| ground.has(disturbance));
            disturbances.map(|disturbance| Self { ground: ground.clone(), disturbance }).collect::<Vec<_>>()
        };
        grounds.iter().flat_map(of).collect()
    }

    /// Those that are asked for: all, or by ground, disturbance, or both.
    ///
    /// # Errors
    /// None has the name, or the folder of maps has none.
    pub fn asked(request: &ExperimentRequest) -> Result<Vec<Self>> {
        let grounds = match &request.maps {
            Some(folder) => maps(folder)?,
            None => kinds(),
        };
        let mut rows = Self::all(&grounds);
        let Some(wanted) = request.row.as_deref() else { return Ok(rows) };
        rows.retain(|row| [row.ground.name(), row.disturbance.name(), &row.name()].contains(&wanted));
        if rows.is_empty() {
            let names = names(&grounds);
            bail!(request.no_row(wanted, &names.iter().map(String::as_str).collect::<Vec<_>>()));
        }
        Ok(rows)
    }

    /// What became of the furniture since the map was made.
    pub fn furniture(&self) -> Furniture {
        match self.disturbance {
            Disturbance::Furniture => Furniture::Rearranged,
            Disturbance::None | Disturbance::Turned | Disturbance::Carried | Disturbance::Doors | Disturbance::Slip => {
                Furniture::AsMapped
            }
        }
    }
}

fn kinds() -> Vec<Ground> {
    BuildingKind::ALL.map(Ground::Kind).to_vec()
}

/// Where, what happens, and both.
fn names(grounds: &[Ground]) -> Vec<String> {
    let rows = BuildingRow::all(grounds);
    let places = grounds.iter().map(|ground| ground.name().to_string());
    let disturbances =
        Disturbance::ALL.into_iter().filter(|&disturbance| grounds.iter().any(|ground| ground.has(disturbance)));
    places
        .chain(disturbances.map(|disturbance| disturbance.name().to_string()))
        .chain(rows.iter().map(BuildingRow::name))
        .collect()
}

/// What can be asked for with `--row`, without `--maps`.
pub fn row_names() -> Vec<&'static str> {
    static NAMES: std::sync::LazyLock<Vec<String>> = std::sync::LazyLock::new(|| names(&kinds()));
    NAMES.iter().map(String::as_str).collect()
}

/// A ground, ready for drawing buildings on it.
pub enum Plot {
    /// Of a kind.
    Kind(BuildingKind),
    /// The map, read.
    Map(Box<World>),
}

impl Plot {
    /// Reads the map, if it is one.
    ///
    /// # Errors
    /// It has faults, or the robot fits nowhere.
    pub fn of(ground: &Ground, robot_radius_m: f64) -> Result<Self> {
        match ground {
            Ground::Kind(kind) => Ok(Self::Kind(*kind)),
            Ground::Map(name, path) => {
                let map = ros_map(path)?;
                map.warnings.iter().for_each(|warning| console::note(warning));
                let world = World::from_map(name, map.grid, robot_radius_m)
                    .with_context(|| format!("the map `{}` is no world", path.shown()))?;
                Ok(Self::Map(Box::new(world)))
            }
        }
    }

    /// The building of a seed.
    ///
    /// # Errors
    /// None leaves the robot room.
    pub fn building(&self, seed: u64, robot_radius_m: f64, furniture: Furniture) -> Result<Building> {
        Ok(match self {
            Self::Kind(kind) => Building::draw(*kind, seed, robot_radius_m, furniture)?,
            Self::Map(plan) => Building::on_plan(plan, seed, robot_radius_m, furniture)
                .with_context(|| format!("the map `{}` cannot be driven on", plan.name))?,
        })
    }
}

/// The maps below a folder, by their names there.
fn maps(folder: &Path) -> Result<Vec<Ground>> {
    let mut found = Vec::new();
    collect(folder, folder, 0, &mut found)?;
    if found.is_empty() {
        bail!(
            "there is no map below `{}`: a map is a file that ends in .yaml beside its image, as the ROS map_server \
             writes them, such as `{MAP_FILE}`",
            folder.shown()
        );
    }
    Ok(found)
}

fn collect(top: &Path, folder: &Path, depth: usize, found: &mut Vec<Ground>) -> Result<()> {
    let cannot = |error: std::io::Error| anyhow!("cannot read the folder `{}`: {error}", folder.shown());
    let entries = folder.read_dir().map_err(cannot)?;
    let mut paths: Vec<PathBuf> = entries.map(|entry| Ok(entry?.path())).collect::<Result<_, _>>().map_err(cannot)?;
    paths.sort();
    for path in paths {
        let is_link = path.is_symlink();
        if path.is_dir() && !is_link && depth < DEEPEST {
            collect(top, &path, depth + 1, found)?;
        } else if path.is_file() && path.extension().is_some_and(|extension| extension == "yaml" || extension == "yml")
        {
            found.push(Ground::Map(name_of(top, &path), path));
        }
    }
    Ok(())
}

/// The folder of a map that is called as most are, else its file without the ending.
fn name_of(top: &Path, path: &Path) -> String {
    let below = path.strip_prefix(top).unwrap_or(path);
    let folder = below.parent().filter(|folder| !folder.as_os_str().is_empty());
    match folder {
        Some(folder) if path.file_name().is_some_and(|file| file == MAP_FILE) => folder.to_string_lossy().into_owned(),
        _ => below.with_extension("").to_string_lossy().into_owned(),
    }
}
