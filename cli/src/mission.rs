//! What a plan runs with: the library, and a robot in a world or none.

use crate::console;
use crate::files::{self, MapFile, PlanText};
use anyhow::{Context, Result, anyhow, bail};
use rpl_lang::suggest::suggest;
use rpl_lang::symbol::Symbol;
use rpl_robot::geometry::{Point, Pose, Vector};
use rpl_robot::localization::LocalizationParameters;
use rpl_robot::occupancy::OccupancyGrid;
use rpl_robot::office::{self, Cost, OfficeModel, OfficeRobot, OfficeSettings, Oracle, SimulatedHost};
use rpl_robot::world::World;
use rpl_runtime::robot::{NoRobot, Outbox, Outside, RobotTables, Stop};
use rpl_runtime::run::library::{Library, Loaded};
use rpl_runtime::run::system::{Outcome, System};
use rpl_runtime::state::activation::Phases;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::Native;
use serde::Serialize;
use std::any::Any;
use std::path::Path;
use std::sync::Arc;

/// Memory for the models of a world, if nobody says how much.
pub const MEMORY_GIB: f64 = 4.0;

/// Whoever waits longer for the first step is told.
const LONG_S: f64 = 5.0;

/// Everything that is the same in all runs of a mission: library, world and scenario.
#[derive(Clone)]
pub struct Site {
    /// What plans can call here.
    pub library: Arc<Library>,
    office: Option<Arc<OfficeModel>>,
    scenario: Option<Scenario>,
    /// Plans can name a robot here, and there is none.
    pub lacks_world: bool,
}

/// The experimenter's plan, compiled.
#[derive(Clone)]
struct Scenario {
    library: Arc<Library>,
    loaded: Loaded,
}

impl Site {
    /// A site without a robot.
    ///
    /// # Errors
    /// The prelude does not compile.
    pub fn without_robot() -> Result<Self> {
        Ok(Self {
            library: plan_library(base_natives(), RobotTables::EMPTY, &[], &office::robot_names())?,
            office: None,
            scenario: None,
            lacks_world: false,
        })
    }

    /// A site with what plans can call on a robot, but with no world to run them in.
    ///
    /// # Errors
    /// The prelude does not compile.
    pub fn for_checking() -> Result<Self> {
        Ok(Self { library: robot_library()?, office: None, scenario: None, lacks_world: true })
    }

    /// A site with what scenarios can call, but with no world to meddle with.
    ///
    /// # Errors
    /// The prelude does not compile.
    pub fn for_checking_scenarios() -> Result<Self> {
        Ok(Self { library: scenario_library()?, office: None, scenario: None, lacks_world: true })
    }

    /// A site with the robot in a world; none is a site without a robot.
    ///
    /// # Errors
    /// The scenario's text is wrong, or the world is too large or cannot be localized in.
    pub fn new(world: Option<World>, scenario: Option<PlanText>, settings: OfficeSettings) -> Result<Self> {
        Self::within(world, scenario, settings, MEMORY_GIB)
    }

    /// The same, with so much memory for the models of the world.
    ///
    /// # Errors
    /// As for a new site.
    pub fn within(
        world: Option<World>,
        scenario: Option<PlanText>,
        settings: OfficeSettings,
        memory_gib: f64,
    ) -> Result<Self> {
        let Some(world) = world else {
            if let Some(scenario) = scenario {
                bail!("the scenario `{}` needs a robot; add `--world dept`", scenario.name);
            }
            return Self::without_robot();
        };
        afford(&world, &settings, memory_gib)?;
        let name = world.name.clone();
        let office = OfficeModel::new(world, settings)
            .with_context(|| format!("the robot cannot be put into the world `{name}`"))?;
        let scenario = scenario.map(Scenario::compile).transpose()?;
        Ok(Self { library: robot_library()?, office: Some(Arc::new(office)), scenario, lacks_world: false })
    }

    /// The same place with another scenario.
    ///
    /// # Errors
    /// There is no robot, or the scenario's text is wrong.
    pub fn with_scenario(&self, scenario: PlanText) -> Result<Self> {
        if self.office.is_none() {
            bail!("the scenario `{}` needs a robot", scenario.name);
        }
        Ok(Self { scenario: Some(Scenario::compile(scenario)?), ..self.clone() })
    }

    /// What was built from the world, if there is one.
    pub fn office(&self) -> Option<&Arc<OfficeModel>> {
        self.office.as_ref()
    }

    /// The robot at the start of a run, if there is one.
    pub fn robot(&self, seed: u64) -> Robot {
        let Some(office) = &self.office else { return Robot::Absent(NoRobot) };
        let scenario = self.scenario.as_ref().map(|scenario| {
            let oracle = Oracle::new(office.simulator.clone(), seed);
            System::new(scenario.library.clone(), scenario.loaded.clone(), oracle, seed)
        });
        let host = SimulatedHost::new(office.simulator.clone(), seed, scenario);
        Robot::Office(Box::new(OfficeRobot::new(office.clone(), host, seed)))
    }
}

impl Scenario {
    fn compile(plan: PlanText) -> Result<Self> {
        let library = scenario_library()?;
        let PlanText { name, text, mut folder } = plan;
        match library.load(&name, &text, &mut folder) {
            Ok(loaded) => Ok(Self { library, loaded }),
            Err(rejected) => bail!("the scenario `{name}` is wrong\n{}", rejected.render(false).trim_end()),
        }
    }
}

/// Says what a large world costs before anything is built from it.
///
/// # Errors
/// It costs more memory than it may.
fn afford(world: &World, settings: &OfficeSettings, memory_gib: f64) -> Result<()> {
    let cost = OfficeModel::cost(world, settings);
    if gib(cost) > memory_gib {
        bail!("{}", too_large(world, settings, memory_gib));
    }
    if cost.seconds > LONG_S {
        console::note(&format!("the world `{}` is large: {}", world.name, costs(cost)));
    }
    Ok(())
}

/// Why a world cannot be used, and what to do.
pub fn too_large(world: &World, settings: &OfficeSettings, memory_gib: f64) -> String {
    let coarse = OfficeSettings { localization: LocalizationParameters::coarse(), ..settings.clone() };
    let mapless = OfficeSettings { map_known: false, ..settings.clone() };
    let takes = |settings: &OfficeSettings| gib(OfficeModel::cost(world, settings));
    let mut advice = vec!["crop it to what is used".to_string()];
    if settings.map_known {
        advice.push(format!("take a coarser grid with `--grid coarse`, {:.1} GiB", takes(&coarse)));
        advice.push(format!("drive without a map with `--map none`, {:.1} GiB", takes(&mapless)));
    }
    format!(
        "the world `{}` of {:.0} m by {:.0} m is too large: {}, and {memory_gib} GiB are allowed\n\
         to use it, allow more with `--memory GIB`; or {}",
        world.name,
        world.size_m.x,
        world.size_m.y,
        costs(OfficeModel::cost(world, settings)),
        advice.join("; or ")
    )
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
    format!("its map and belief take about {:.1} GiB of memory and {time} before the first step", gib(cost))
}

/// The robot of a run, if it has one.
#[derive(Clone)]
pub enum Robot {
    /// No world, no robot.
    Absent(NoRobot),
    /// The office robot, simulated.
    Office(Box<OfficeRobot>),
}

/// What can be seen of a robot from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// Where it is.
    pub robot_in_map: Pose,
    /// Where it believes it is.
    pub estimate_in_map: Pose,
    /// How sure it is of that, from 0 to 1.
    pub certainty: f64,
}

/// What a robot did on the whole.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Account {
    /// How often it moved into something it could see.
    pub contacts: u32,
    /// How often it moved into something none of its sensors could see.
    pub contacts_unseen: u32,
    /// How often a person ran into it.
    pub contacts_by_people: u32,
    /// How far it drove.
    pub distance_m: f64,
}

/// Where the robot may be: a probability for each cell, `cells[row][column]`, row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct PositionBelief {
    /// Edge of a cell.
    pub resolution_m: f64,
    /// Lower left corner of cell (0, 0).
    pub origin_in_map: Point,
    /// Cells along x.
    pub columns: usize,
    /// Summed over headings; the sum of all is 1.
    pub cells: Vec<f64>,
}

impl Robot {
    /// What can be seen of it.
    pub fn sight(&self) -> Option<Sight> {
        match self {
            Robot::Absent(_) => None,
            Robot::Office(robot) => Some(Sight {
                robot_in_map: robot.true_pose_in_map(),
                estimate_in_map: robot.estimated_pose_in_map(),
                certainty: robot.estimate().certainty,
            }),
        }
    }

    /// Whether it does not know where it is.
    pub fn is_lost(&self) -> bool {
        match self {
            Robot::Absent(_) => false,
            Robot::Office(robot) => robot.estimate().certainty <= robot.model().settings.active.certainty,
        }
    }

    /// The scenario beside it, if that has failed, and its failure.
    pub fn failed_scenario(&self) -> Option<(&System<Oracle>, Value)> {
        let Robot::Office(robot) = self else { return None };
        let scenario = robot.host.scenario.as_deref()?;
        match scenario.outcome()? {
            Outcome::Failed(failure) => Some((scenario, failure)),
            Outcome::Succeeded(_) | Outcome::Evaporated => None,
        }
    }

    /// What it did so far.
    pub fn account(&self) -> Option<Account> {
        match self {
            Robot::Absent(_) => None,
            Robot::Office(robot) => {
                let contacts = robot.contacts();
                Some(Account {
                    contacts: contacts.caused,
                    contacts_unseen: contacts.unseen,
                    contacts_by_people: contacts.run_into,
                    distance_m: robot.distance_driven_m(),
                })
            }
        }
    }

    /// Bytes of its state that an earlier state does not share.
    pub fn bytes_apart(&self, earlier: &Self) -> usize {
        match (self, earlier) {
            (Robot::Office(robot), Robot::Office(earlier)) => robot.bytes_apart(earlier),
            (Robot::Absent(_), _) | (Robot::Office(_), Robot::Absent(_)) => 0,
        }
    }

    /// Where it may be.
    pub fn belief(&self) -> Option<PositionBelief> {
        match self {
            Robot::Absent(_) => None,
            Robot::Office(robot) => {
                let grid = &robot.model().map.as_ref()?.localization.grid;
                Some(PositionBelief {
                    resolution_m: grid.cell_m,
                    // The grid names the middle of its first cell, a drawing wants its corner.
                    origin_in_map: grid.origin_in_map - Vector::new(grid.cell_m, grid.cell_m) / 2.0,
                    columns: grid.columns,
                    cells: robot.belief_xy()?,
                })
            }
        }
    }

    fn outside(&self) -> &dyn Outside {
        match self {
            Robot::Absent(robot) => robot,
            Robot::Office(robot) => robot.as_ref(),
        }
    }

    fn outside_mut(&mut self) -> &mut dyn Outside {
        match self {
            Robot::Absent(robot) => robot,
            Robot::Office(robot) => robot.as_mut(),
        }
    }
}

impl Outside for Robot {
    fn tables(&self) -> &RobotTables {
        self.outside().tables()
    }

    fn start(
        &mut self,
        machine: &Machine,
        behaviour: u16,
        arguments: &[(Symbol, Value)],
        outbox: &mut Outbox,
    ) -> Result<(), Raise> {
        self.outside_mut().start(machine, behaviour, arguments, outbox)
    }

    fn stop(&mut self, behaviour: u16, how: Stop, outbox: &mut Outbox) {
        self.outside_mut().stop(behaviour, how, outbox);
    }

    fn period_us(&self) -> Option<u64> {
        self.outside().period_us()
    }

    fn step(&mut self, phases: Phases<'_>, outbox: &mut Outbox) {
        self.outside_mut().step(phases, outbox);
    }

    fn as_any(&mut self) -> &mut dyn Any {
        self.outside_mut().as_any()
    }
}

fn base_natives() -> Vec<Native> {
    [rpl_runtime::step::natives::natives(), rpl_stdlib::natives()].concat()
}

/// All native functions of plans, with their documentation.
pub fn natives() -> Vec<Native> {
    [base_natives(), office::natives()].concat()
}

fn robot_library() -> Result<Arc<Library>> {
    plan_library(natives(), office::tables(), &[("robot", office::PLANS)], &office::reserved_names())
}

fn scenario_library() -> Result<Arc<Library>> {
    Ok(Arc::new(library([base_natives(), office::oracle_natives()].concat(), office::oracle_tables(), &[], &[])?))
}

fn plan_library(
    natives: Vec<Native>,
    tables: &RobotTables,
    plans: &[(&str, &str)],
    robot_names: &[String],
) -> Result<Arc<Library>> {
    Ok(Arc::new(library(natives, tables, plans, robot_names)?.without_scenario_names(&office::scenario_names())))
}

fn library(
    natives: Vec<Native>,
    tables: &RobotTables,
    plans: &[(&str, &str)],
    robot_names: &[String],
) -> Result<Library> {
    let preludes = [&[("prelude", rpl_stdlib::PRELUDE)], plans].concat();
    match Library::new(natives, &preludes, tables, robot_names) {
        Ok(library) => Ok(library),
        Err(rejected) => bail!("the prelude does not compile, which is a fault of rpl\n{}", rejected.render(false)),
    }
}

/// A world by its name, or from a file.
///
/// # Errors
/// No world has the name, or the file has faults.
pub fn world(name: &str) -> Result<World> {
    if let Some(world) = World::builtin(name) {
        return Ok(world);
    }
    let path = Path::new(name);
    if is_map(path) {
        let title = path.file_stem().map_or(name.into(), |stem| stem.to_string_lossy());
        let map = read_map(path)?;
        return World::from_map(&title, map).with_context(|| format!("the map `{name}` is no world"));
    }
    let is_there = path.metadata().is_ok_and(|known| !known.is_dir());
    if path.extension().is_some_and(|extension| extension == "toml") || is_there {
        let text = world_text(name)?;
        let beside = path.parent().unwrap_or(Path::new("."));
        let load_map = |map: &str| read_map(&beside.join(map)).map_err(|error| format!("{error:#}"));
        return World::parse_with_map(&text, name, load_map)
            .map_err(|error| anyhow!("the world `{name}` has faults\n{error}"));
    }
    match suggest(name, World::builtin_names()) {
        Some(meant) => bail!("no world is called `{name}`; did you mean `{meant}`?"),
        None => {
            let names: Vec<&str> = World::builtin_names().collect();
            bail!(
                "no world is called `{name}`; there are {}, files that end in .toml, and ROS maps (a map.yaml or its folder)",
                names.join(", ")
            )
        }
    }
}

/// What a world file is called in messages about it; none for a recorded map, which has no text.
pub fn world_file(name: &str) -> Option<String> {
    if World::builtin_text(name).is_some() {
        return Some(format!("{name}.toml"));
    }
    let path = Path::new(name);
    (!is_map(path)).then(|| name.to_string())
}

fn is_map(path: &Path) -> bool {
    let is_yaml = path.extension().is_some_and(|extension| extension == "yaml" || extension == "yml");
    is_yaml || path.join(files::MAP_FILE).is_file()
}

/// The text of a world file, or of a built-in world.
///
/// # Errors
/// It cannot be read.
pub fn world_text(name: &str) -> Result<String> {
    if let Some(text) = World::builtin_text(name) {
        return Ok(text.to_string());
    }
    files::world_text(Path::new(name)).map_err(|reason| anyhow!("cannot read the world `{name}`: {reason}"))
}

fn read_map(path: &Path) -> Result<OccupancyGrid> {
    let MapFile { grid, warnings } = files::ros_map(path)?;
    for warning in warnings {
        console::note(&warning);
    }
    Ok(grid)
}
