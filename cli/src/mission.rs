//! What a plan runs with: the library, and a robot in a world or none.

use anyhow::{Result, anyhow, bail};
use rpl_lang::suggest::suggest;
use rpl_lang::symbol::Symbol;
use rpl_robot::geometry::Pose;
use rpl_robot::world::World;
use rpl_runtime::behaviour::{BehaviourSpec, FluentSpec, NoRobot, Outbox, Outside, Stop};
use rpl_runtime::failure::Raise;
use rpl_runtime::library::Library;
use rpl_runtime::machine::Machine;
use rpl_runtime::native::Native;
use rpl_runtime::value::Value;
use serde::Serialize;
use std::any::Any;
use std::path::Path;
use std::sync::Arc;

/// Names that a plan can use only with a robot, so that a plan without one is told to add a world.
const ROBOT_NAMES: &[&str] = &[
    "x*",
    "y*",
    "o*",
    "pos-certainty*",
    "navigation-active?*",
    "nr-of-nav-goals*",
    "position-tracking",
    "active-localization",
    "navigation",
    "wheels",
    "at-destination?",
    "generate-navigation-plan",
    "plan-remove-all-goals",
    "go-to",
    "deliver",
];

/// Fluents that change with every step of the robot: a trace that told each change would tell
/// nothing else.
pub const CONTINUOUS_FLUENTS: &[&str] = &["x*", "y*", "o*", "pos-certainty*"];

/// Where and how the robot starts.
#[derive(Clone, Debug, Default)]
pub struct Setting {
    /// The world; without one there is no robot.
    pub world: Option<World>,
    /// The seed of every random stream.
    pub seed: u64,
    /// What happens on the way: the text of a scenario file.
    pub scenario: Option<String>,
}

/// The robot of a run, if it has one.
#[derive(Clone)]
pub enum Robot {
    /// No world, no robot.
    Absent(NoRobot),
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
    /// How often it touched something.
    pub contacts: u64,
    /// How far it drove.
    pub distance_m: f64,
    /// How often active localization was started.
    pub relocalizations: u64,
}

/// Where the robot may be: a probability for each cell, `cells[row][column]`, row-major.
#[derive(Clone, Debug, PartialEq)]
pub struct PositionBelief {
    /// Edge of a cell.
    pub resolution_m: f64,
    /// Lower left corner of cell (0, 0).
    pub origin_in_map: rpl_robot::geometry::Point,
    /// Cells along x.
    pub columns: usize,
    /// Summed over headings; the sum of all is 1.
    pub cells: Vec<f64>,
}

impl Robot {
    /// The robot of a setting.
    ///
    /// # Errors
    /// The scenario is wrong, or there is no robot for the world.
    pub fn new(setting: Setting) -> Result<Self> {
        match setting.world {
            None if setting.scenario.is_some() => bail!("a scenario needs a robot; add `--world dept`"),
            None => Ok(Robot::Absent(NoRobot)),
            Some(world) => bail!("no robot can be put into the world `{}` yet", world.name),
        }
    }

    /// What can be seen of it.
    pub fn sight(&self) -> Option<Sight> {
        match self {
            Robot::Absent(_) => None,
        }
    }

    /// What it did so far.
    pub fn account(&self) -> Option<Account> {
        match self {
            Robot::Absent(_) => None,
        }
    }

    /// Where it may be.
    pub fn belief(&self) -> Option<PositionBelief> {
        match self {
            Robot::Absent(_) => None,
        }
    }

    fn outside(&self) -> &dyn Outside {
        match self {
            Robot::Absent(robot) => robot,
        }
    }

    fn outside_mut(&mut self) -> &mut dyn Outside {
        match self {
            Robot::Absent(robot) => robot,
        }
    }
}

impl Outside for Robot {
    fn behaviours(&self) -> &'static [BehaviourSpec] {
        self.outside().behaviours()
    }

    fn fluents(&self) -> &'static [FluentSpec] {
        self.outside().fluents()
    }

    fn valves(&self) -> &'static [&'static str] {
        self.outside().valves()
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

    fn step(&mut self, outbox: &mut Outbox) {
        self.outside_mut().step(outbox);
    }

    fn as_any(&mut self) -> &mut dyn Any {
        self.outside_mut().as_any()
    }
}

/// All native functions a plan can call, with their documentation.
pub fn natives() -> Vec<Native> {
    [rpl_runtime::natives::natives(), rpl_stdlib::natives()].concat()
}

/// The library for plans that run with this robot.
///
/// # Errors
/// The prelude does not compile, which is a fault of this program.
pub fn library(robot: &Robot) -> Result<Arc<Library>> {
    let preludes = [("prelude", rpl_stdlib::PRELUDE)];
    match Library::new(natives(), &preludes, robot, ROBOT_NAMES) {
        Ok(library) => Ok(Arc::new(library)),
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
    if path.extension().is_some_and(|extension| extension == "toml") || path.is_file() {
        let text =
            crate::files::read_text(path).map_err(|reason| anyhow!("cannot read the world `{name}`: {reason}"))?;
        return World::parse(&text, name).map_err(|error| anyhow!("the world `{name}` has faults\n{error}"));
    }
    match suggest(name, World::builtin_names()) {
        Some(meant) => bail!("no world is called `{name}`; did you mean `{meant}`?"),
        None => {
            let names: Vec<&str> = World::builtin_names().collect();
            bail!("no world is called `{name}`; there are {}, and files that end in .toml", names.join(", "))
        }
    }
}
