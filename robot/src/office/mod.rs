//! The office robot behind the seam of the runtime: thin bindings of simulator, localization,
//! active localization, navigation and gripper to behaviours, fluents and functions of plans.
//!
//! One step of 50 ms: the scenario runs, the simulated robot moves and senses, position tracking
//! takes the percept in, then the active behaviours work in the order of their table. What they
//! found goes out as one assignment of all fluents.

mod behaviours;
mod board;
mod cost;
mod host;
mod natives;
mod plan_text;
mod save;
mod scenario;

pub use behaviours::{BEHAVIOURS, FLUENTS, VALVES};
pub use board::Board;
pub use cost::Cost;
pub use host::SimulatedHost;
pub use natives::natives;
pub use scenario::{Oracle, SCENARIO_NAMES, oracle_natives};

use crate::active::{ActiveParameters, Choice};
use crate::geometry::Pose;
use crate::localization::{Estimate, Localization, LocalizationModel, LocalizationParameters, ModelError, Spread};
use crate::navigation::{Concern, DriveLimits, NavigationModel, TopologicalModel};
use crate::simulator::{Contacts, OracleError, Percept, SimulatorModel, SimulatorSettings};
use crate::world::World;
use rpl_runtime::behaviour::{BehaviourSpec, FluentSpec, Outbox, Outside, Stop};
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use std::any::Any;
use std::sync::Arc;

/// The robot's own plan library.
pub const PLANS: &str = include_str!("plans.rpl");

/// Names that exist only with a robot: a plan without one gets "add `--world dept`".
pub const ROBOT_NAMES: &[&str] = &[
    "navigation",
    "active-localization",
    "position-tracking",
    "gripper",
    "look-around",
    "wheels",
    "arm",
    "x*",
    "y*",
    "o*",
    "pos-certainty*",
    "navigation-active?*",
    "nr-of-nav-goals*",
    "travel-mode*",
    "region*",
    "speed*",
    "bumped?*",
    "holding*",
    "battery*",
    "messages*",
    "place",
    "place-pose",
    "at-destination?",
    "generate-navigation-plan",
    "plan-remove-all-goals",
    "set-travel-mode",
    "doubt-position",
    "read-message",
    "region-of",
    "distance-to",
    "odometry-pose",
    "odometry-in-map",
    "belief-maxima",
    "go-to",
    "go-to-point",
    "pick-up",
    "pick-up-again",
    "is-spot-at?",
    "fetch",
    "put-down",
    "look-until-sure",
    "bring",
    "deliver",
    "relocalize-when-necessary",
];

/// Edge of a cell of the map the expected distances are cast in.
const SENSOR_MAP_CELL_M: f64 = 0.05;

/// What can be set about the robot and its world.
#[derive(Clone, Debug, PartialEq)]
pub struct OfficeSettings {
    /// The simulated robot.
    pub simulator: SimulatorSettings,
    /// The filter.
    pub localization: LocalizationParameters,
    /// Active localization.
    pub active: ActiveParameters,
    /// Whether the robot is told where it starts.
    pub start_known: bool,
    /// Whether the robot has a map of the world. Without one it goes by its odometry and by what its
    /// sensors have seen.
    pub map_known: bool,
}

impl Default for OfficeSettings {
    fn default() -> Self {
        Self {
            simulator: SimulatorSettings::default(),
            localization: LocalizationParameters::default(),
            active: ActiveParameters::default(),
            start_known: true,
            map_known: true,
        }
    }
}

/// Everything about a world that does not change; built once, shared by all runs.
#[derive(Debug)]
pub struct OfficeModel {
    /// The world.
    pub world: Arc<World>,
    /// The simulator.
    pub simulator: Arc<SimulatorModel>,
    /// What the robot knows of the world, if it has a map.
    pub map: Option<MapModel>,
    /// What the robot can do.
    pub limits: DriveLimits,
    /// What can be set.
    pub settings: OfficeSettings,
}

/// The robot's map of the world, as each of its uses needs it.
#[derive(Debug)]
pub struct MapModel {
    /// The filter's tables.
    pub localization: LocalizationModel,
    /// The planner's map.
    pub navigation: NavigationModel,
    /// Rooms, doors and regions.
    pub topology: TopologicalModel,
}

impl MapModel {
    fn new(world: &Arc<World>, limits: DriveLimits, settings: &OfficeSettings) -> Result<Self, ModelError> {
        let sensor_map =
            if settings.localization.centred { World::map_centred } else { World::map }(world, SENSOR_MAP_CELL_M);
        let localization = LocalizationModel::new(&sensor_map, settings.localization.clone())?;
        let navigation = NavigationModel::new(world, limits);
        let topology = TopologicalModel::new(world, &navigation.planner);
        Ok(Self { localization, navigation, topology })
    }
}

impl OfficeModel {
    /// Builds all models of a world.
    ///
    /// # Errors
    /// If the filter's grid cannot be built for this world.
    pub fn new(world: World, settings: OfficeSettings) -> Result<Self, ModelError> {
        let world = Arc::new(world);
        let step_s = settings.simulator.step_us as f64 / 1e6;
        let limits = DriveLimits {
            step_s,
            robot_radius_m: settings.simulator.robot_radius_m,
            sonar_max_range_m: settings.simulator.sonar_max_range_m,
            ..DriveLimits::default()
        };
        let map = settings.map_known.then(|| MapModel::new(&world, limits, &settings)).transpose()?;
        Ok(Self {
            simulator: Arc::new(SimulatorModel::new(world.clone(), settings.simulator.clone())),
            map,
            limits,
            settings,
            world,
        })
    }
}

impl OfficeModel {
    /// What of a world is probably not meant as it stands, looked over without building all models.
    pub fn survey(world: &Arc<World>, settings: &OfficeSettings) -> Vec<Concern> {
        let navigation = NavigationModel::new(world, DriveLimits::default());
        let topology = TopologicalModel::new(world, &navigation.planner);
        topology.survey(&navigation.planner, settings.simulator.gripper_reach_m)
    }
}

/// The robot in its world: what the runtime steps.
#[derive(Clone)]
pub struct OfficeRobot {
    /// What does not change.
    pub model: Arc<OfficeModel>,
    /// The simulated robot and its scenario.
    pub host: SimulatedHost,
    /// What the behaviours share.
    pub board: Board,
}

impl OfficeRobot {
    /// A robot at the start of its world.
    pub fn new(model: Arc<OfficeModel>, host: SimulatedHost, seed: u64) -> Self {
        let board = Board::new(&model, seed);
        Self { model, host, board }
    }

    /// The same robot at the beginning of a run, put down elsewhere and told so.
    ///
    /// # Errors
    /// Something stands there.
    pub fn starting_at(mut self, start_in_map: Pose) -> Result<Self, OracleError> {
        self.host.model.clone().teleport(&mut self.host.state, start_in_map)?;
        self.board.localization = self
            .model
            .map
            .as_ref()
            .map(|map| Localization::start_at(&map.localization, start_in_map, Spread::default()));
        Ok(self)
    }

    /// Where the robot really is.
    pub fn true_pose_in_map(&self) -> Pose {
        self.host.state.true_pose()
    }

    /// Where it believes itself to be, and how certain it is. Without a map: where its odometry says it is,
    /// in `odom`.
    pub fn estimate(&self) -> Estimate {
        self.board.estimate(&self.model)
    }

    /// Where it believes itself to be, also without a map: then by its odometry from the start of the world.
    pub fn estimated_pose_in_map(&self) -> Pose {
        let Estimate { pose_in_map, .. } = self.estimate();
        if self.model.map.is_some() { pose_in_map } else { self.model.world.start_in_map.compose(pose_in_map) }
    }

    /// Contacts so far.
    pub fn contacts(&self) -> Contacts {
        self.host.state.contacts()
    }

    /// Metres driven so far.
    pub fn distance_driven_m(&self) -> f64 {
        self.host.state.distance_driven_m()
    }

    /// Probability of each cell of (x, y), `[row][column]` on the filter's grid; none without a map.
    pub fn belief_xy(&self) -> Option<Vec<f64>> {
        let (map, localization) = (self.model.map.as_ref()?, self.board.localization.as_ref()?);
        Some(localization.belief_xy(&map.localization))
    }

    /// The last choice of active localization.
    pub fn last_choice(&self) -> Option<&Choice> {
        self.board.active.as_ref().and_then(|active| active.last_choice())
    }

    /// Whether active localization is at work.
    pub fn is_localizing(&self) -> bool {
        self.board.is_localizing()
    }

    /// Bytes of belief and plans of the way that an earlier state does not share.
    pub fn bytes_apart(&self, earlier: &Self) -> usize {
        let (now, earlier) = (&self.board, &earlier.board);
        let belief = match (&now.localization, &earlier.localization) {
            (Some(now), Some(earlier)) => now.bytes_apart(earlier),
            (Some(_) | None, _) => 0,
        };
        belief + now.navigation.bytes_apart(&earlier.navigation) + now.mapless.bytes_apart(&earlier.mapless)
    }

    /// The percept of the last step.
    pub fn percept(&self) -> Option<&Percept> {
        self.board.percept.as_ref()
    }
}

impl Outside for OfficeRobot {
    fn behaviours(&self) -> &'static [BehaviourSpec] {
        BEHAVIOURS
    }

    fn fluents(&self) -> &'static [FluentSpec] {
        FLUENTS
    }

    fn valves(&self) -> &'static [&'static str] {
        VALVES
    }

    fn start(
        &mut self,
        machine: &Machine,
        behaviour: u16,
        arguments: &[(rpl_lang::symbol::Symbol, Value)],
        outbox: &mut Outbox,
    ) -> Result<(), Raise> {
        self.board.start(&self.model, machine, behaviour, arguments, outbox)
    }

    fn stop(&mut self, behaviour: u16, how: Stop, outbox: &mut Outbox) {
        self.board.stop(behaviour, how, outbox);
    }

    fn period_us(&self) -> Option<u64> {
        Some(self.model.settings.simulator.step_us)
    }

    fn step(&mut self, outbox: &mut Outbox) {
        let commands = self.board.take_commands();
        let percept = self.host.step(&commands, outbox);
        self.board.step(&self.model, percept, outbox);
    }

    fn as_any(&mut self) -> &mut dyn Any {
        self
    }
}
