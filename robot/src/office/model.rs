//! What is built from a world once and shared by all runs in it.

use crate::active::ActiveParameters;
use crate::avoidance::DriveLimits;
use crate::description::RobotDescription;
use crate::foresight::ways::{Routes, WayMap};
use crate::localization::once::ScanLocator;
use crate::localization::{LocalizationModel, LocalizationParameters, ModelError, ScanParameters};
use crate::navigation::NavigationModel;
use crate::occupancy::OccupancyGrid;
use crate::planning::{Concern, TopologicalModel};
use crate::sensors::{RangeSensor, RangeSensors};
use crate::simulator::{SimulatorModel, SimulatorSettings};
use crate::world::{SeenBy, World};
use serde::{Deserialize, Serialize};
use std::sync::{Arc, OnceLock};

/// Edge of a cell of the map the expected distances are cast in.
pub(super) const SENSOR_MAP_CELL_M: f64 = 0.05;

/// What a robot with a map knows its position by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum PositionBy {
    /// Its range sensors, and the landmarks that it looks for.
    Grid,
    /// Its range sensors alone.
    GridWithoutLandmarks,
    /// Its odometry, set right at landmarks (Fox and Anderson-Sprecher, Localization).
    Landmarks,
}

/// What can be set about the robot and its world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OfficeSettings {
    /// The robot.
    pub robot: Arc<RobotDescription>,
    /// What it knows its position by.
    pub position_by: PositionBy,
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
    /// Those of the papers' robot.
    fn default() -> Self {
        Self::of(RobotDescription::papers())
    }
}

impl OfficeSettings {
    /// Whether the robot has a belief about where it is.
    pub fn has_belief(&self) -> bool {
        self.map_known && self.position_by != PositionBy::Landmarks
    }

    /// What is usual for a robot.
    pub fn of(robot: Arc<RobotDescription>) -> Self {
        Self {
            position_by: PositionBy::Grid,
            localization: LocalizationParameters::of(&robot),
            robot,
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
    /// How its range sensors look.
    pub sensors: RangeSensors,
    /// What can be set.
    pub settings: OfficeSettings,
    /// The same without the truth, once it was asked for.
    known: OnceLock<Arc<Self>>,
}

/// The robot's map of the world, as each of its uses needs it. A copy shares all of it.
#[derive(Clone, Debug)]
pub struct MapModel {
    /// The filter's tables.
    pub localization: Arc<LocalizationModel>,
    /// The planner's map.
    pub navigation: Arc<NavigationModel>,
    /// Rooms, doors and regions.
    pub topology: Arc<TopologicalModel>,
    /// The ways between its places, for foresight.
    pub routes: Arc<Routes>,
    /// What single scans are compared with, once it was asked for; none if the robot fits nowhere.
    locator: Arc<OnceLock<Option<ScanLocator>>>,
}

impl MapModel {
    /// What ways are searched in for foresight.
    pub fn ways<'a>(&'a self, world: &'a World) -> WayMap<'a> {
        WayMap { world, planner: &self.navigation.planner, topology: &self.topology, routes: &self.routes }
    }

    /// What scans of the first sensor are compared with, made when it is first asked for.
    pub fn locator(&self, world: &World) -> Option<&ScanLocator> {
        let parameters = &self.localization.parameters;
        let made = || {
            let sensor = parameters.sensors.first()?;
            let sees = |seen_by| is_seen(seen_by, sensor.source);
            let map = world.map_centred_seen(SENSOR_MAP_CELL_M, sees);
            ScanLocator::new(&map, &sensor.beam, parameters.clearance_m).ok()
        };
        self.locator.get_or_init(made).as_ref()
    }

    fn new(world: &Arc<World>, limits: DriveLimits, settings: &OfficeSettings) -> Result<Self, ModelError> {
        let mut parameters = settings.localization.clone();
        parameters.sensors = telling(&parameters.sensors, world);
        let map_of = |seen: &dyn Fn(SeenBy) -> bool| match parameters.centred {
            true => world.map_centred_seen(SENSOR_MAP_CELL_M, seen),
            false => world.map_seen(SENSOR_MAP_CELL_M, seen),
        };
        let sensor_map = map_of(&|_| true);
        let own_map = |sensor: &ScanParameters| {
            let sees = |seen_by| is_seen(seen_by, sensor.source);
            let sees_all = world.objects.iter().all(|object| sees(object.seen_by));
            (!sees_all).then(|| map_of(&sees))
        };
        let seen: Vec<Option<OccupancyGrid>> = parameters.sensors.iter().map(own_map).collect();
        let seen: Vec<&OccupancyGrid> = seen.iter().map(|seen| seen.as_ref().unwrap_or(&sensor_map)).collect();
        let localization = LocalizationModel::seeing(&sensor_map, &seen, parameters)?;
        let navigation = NavigationModel::new(world, limits);
        let topology = TopologicalModel::new(world, &navigation.planner);
        Ok(Self {
            localization: Arc::new(localization),
            navigation: Arc::new(navigation),
            topology: Arc::new(topology),
            routes: Arc::new(Routes::new(world)),
            locator: Arc::default(),
        })
    }
}

/// The sensors that localization reads in a world: the first, which tells most, and any other that sees
/// something on the map which those before it do not. Beside a laser sonars tell nothing else, and cost
/// as much.
fn telling(sensors: &[ScanParameters], world: &World) -> Vec<ScanParameters> {
    let mut kept: Vec<ScanParameters> = Vec::new();
    for sensor in sensors {
        let is_unseen = |seen_by: SeenBy| kept.iter().all(|other| !is_seen(seen_by, other.source));
        let tells = |seen_by| is_seen(seen_by, sensor.source) && is_unseen(seen_by);
        if kept.is_empty() || world.objects.iter().any(|object| object.mapped && tells(object.seen_by)) {
            kept.push(sensor.clone());
        }
    }
    kept
}

fn is_seen(seen_by: SeenBy, sensor: RangeSensor) -> bool {
    match sensor {
        RangeSensor::Sonar => seen_by.sonar,
        RangeSensor::Laser => seen_by.laser,
    }
}

impl OfficeModel {
    /// Builds all models of a world.
    ///
    /// # Errors
    /// If the filter's grid cannot be built for this world.
    pub fn new(world: World, settings: OfficeSettings) -> Result<Self, ModelError> {
        let world = Arc::new(world);
        let limits = DriveLimits::of(&settings.robot);
        let map = settings.map_known.then(|| MapModel::new(&world, limits, &settings)).transpose()?;
        Ok(Self {
            simulator: Arc::new(SimulatorModel::new(world.clone(), SimulatorSettings::of(settings.robot.clone()))),
            sensors: settings.robot.range_sensors(),
            map,
            limits,
            settings,
            world,
            known: OnceLock::new(),
        })
    }

    /// The same as far as the robot knows it: its world is the one that the map shows ([`World::known`]), and so is
    /// the simulator's. Foresight is made of it, so that nothing projected can come from the truth. It is built
    /// when it is first asked for; the tables of the map are shared. Its robot makes long steps and does not stray
    /// ([`RobotDescription::foreseen`]).
    pub fn known(&self) -> Arc<Self> {
        let known = || {
            let world = Arc::new(self.world.known());
            let robot = Arc::new(self.settings.robot.foreseen());
            let limits = DriveLimits::of(&robot);
            let map = self.map.clone().map(|map| {
                let navigation = Arc::new(map.navigation.with_limits(limits));
                MapModel { navigation, ..map }
            });
            let simulated = SimulatorSettings { robot: robot.clone(), ..self.simulator.settings.clone() };
            Arc::new(Self {
                simulator: Arc::new(SimulatorModel::new(world.clone(), simulated)),
                map,
                limits,
                sensors: self.sensors.clone(),
                settings: OfficeSettings { robot, ..self.settings.clone() },
                known: OnceLock::new(),
                world,
            })
        };
        self.known.get_or_init(known).clone()
    }

    /// The same robot with the same map in a world that has changed since it was mapped, simulated as another robot of
    /// the same body and sensors, such as one whose wheels slip: it knows nothing of either.
    #[must_use]
    pub fn simulated_as(self, real: World, robot: Arc<RobotDescription>) -> Self {
        let settings = SimulatorSettings { robot, ..self.simulator.settings.clone() };
        Self { simulator: Arc::new(SimulatorModel::new(Arc::new(real), settings)), ..self }
    }

    /// What of a world is probably not meant as it stands, looked over without building all models.
    pub fn survey(world: &Arc<World>, settings: &OfficeSettings) -> Vec<Concern> {
        let navigation = NavigationModel::new(world, DriveLimits::of(&settings.robot));
        let topology = TopologicalModel::new(world, &navigation.planner);
        let reach_m = settings.robot.gripper.map(|gripper| gripper.reach_m);
        topology.survey(&navigation.planner, reach_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sonars_are_read_beside_a_laser_where_they_alone_see_something() {
        let robot = RobotDescription::builtin("b21-laser").expect("built in");
        let read = |world: &str| -> Vec<RangeSensor> {
            let world = World::builtin(world).expect("built in");
            telling(&ScanParameters::of(&robot), &world).iter().map(|sensor| sensor.source).collect()
        };
        assert_eq!(read("dept"), [RangeSensor::Laser]);
        assert_eq!(read("sensing"), [RangeSensor::Laser, RangeSensor::Sonar]);
    }
}
