//! Where a robot follows hallways, and how: what differs from row to row.

use anyhow::Result;
use rpl_lang::compile::NoFiles;
use rpl_lola::LolaSettings;
use rpl_lola::arena::ArenaSettings;
use rpl_lola::state_set::{Inference, Matrix, Method};
use rpl_mission::libraries::robot_library;
use rpl_mission::modules::{SiteModules, modules_with};
use rpl_mission::site::Site;
use rpl_robot::description::RobotDescription;
use rpl_robot::office::{Composition, OfficeModel, OfficeSettings};
use rpl_robot::world::World;
use rpl_runtime::run::library::{Library, Loaded};
use rpl_shell::sites;
use std::sync::Arc;

/// Where a robot follows hallways, and how.
#[derive(Clone, Copy)]
pub struct Setting {
    /// What its row is called.
    pub name: &'static str,
    /// What stands in the arenas.
    pub arena: ArenaSettings,
    /// Another robot than the one that is asked for.
    pub robot: Option<&'static str>,
    /// Whether sensors and odometry make no errors.
    pub is_exact: bool,
    /// How the robot differs from the usual one.
    pub lola: fn(&mut LolaSettings),
}

/// Nobody and nothing in the hallways, and a robot without a camera, or one that finds no markers.
pub const CALM: Setting =
    Setting { name: "sonar alone", arena: ArenaSettings::CALM, robot: None, is_exact: false, lola: |_| () };

/// The same with markers and a camera.
pub const MARKED: Setting = Setting { name: "with markers", arena: ArenaSettings::MARKED, ..CALM };

/// Walls in which closed doors stand 3 cm deep.
pub const THIN: Setting =
    Setting { name: "thin walls", arena: ArenaSettings { walls_mm: 100, ..ArenaSettings::CALM }, ..CALM };

/// Walls in which they stand 13 cm deep.
pub const THICK: Setting =
    Setting { name: "thick walls", arena: ArenaSettings { walls_mm: 300, ..ArenaSettings::CALM }, ..CALM };

/// Six people, and boxes.
pub const CROWDED: Setting = Setting { name: "crowded", arena: ArenaSettings::CROWDED, ..CALM };

/// Both.
pub const CROWDED_MARKED: Setting =
    Setting { name: "crowded, with markers", arena: ArenaSettings { markers: true, ..ArenaSettings::CROWDED }, ..CALM };

/// Sensors and wheels that make no errors.
pub const EXACT: Setting = Setting { name: "exact sensors", is_exact: true, ..CALM };

/// The direction of a hallway is what was guessed when it was entered.
pub const UNREGISTERED: Setting =
    Setting { name: "without registration", lola: |settings| settings.registers = false, ..CALM };

/// LOLA's own robot: 16 sonars, whose cones overlap.
pub const NOMAD: Setting = Setting { name: "nomad-200", robot: Some("nomad-200"), ..CALM };

/// Openings are counted by a rule.
pub fn by(method: Method) -> Inference {
    Inference { method, ..Inference::of_robot(false) }
}

/// Openings are counted by DERVISH's matrix.
pub fn by_dervish() -> Inference {
    Inference { matrix: Matrix::DERVISH, ..Inference::of_robot(false) }
}

/// What all runs of a setting share; the world is another one for each seed.
pub struct Ground {
    robot: Arc<RobotDescription>,
    library: Arc<Library>,
    modules: Arc<Composition<SiteModules>>,
}

impl Ground {
    /// For the setting's robot, or this one; it gets a camera if there are markers to see.
    ///
    /// # Errors
    /// The library of plans does not compile.
    pub fn new(setting: &Setting, robot: &Arc<RobotDescription>) -> Result<Self> {
        let mut lola = LolaSettings::default();
        (setting.lola)(&mut lola);
        let modules = modules_with(lola)?;
        let library = robot_library(&modules, Vec::new())?;
        let own = setting.robot.and_then(RobotDescription::builtin);
        let mut robot = RobotDescription::clone(own.as_ref().unwrap_or(robot));
        robot.camera = if setting.arena.markers { robot.camera.or_else(usual_camera) } else { None };
        let robot = Arc::new(if setting.is_exact { robot.without_errors() } else { robot });
        Ok(Self { robot, library, modules })
    }

    /// A world without a map, and a plan that is to run there.
    ///
    /// # Errors
    /// The robot cannot be simulated there, or the plan's text is wrong.
    pub fn site(&self, world: World, plan: &str) -> Result<(Site, Loaded)> {
        let settings = OfficeSettings { map_known: false, ..OfficeSettings::of(self.robot.clone()) };
        let model = Arc::new(OfficeModel::new(world, settings)?);
        let site = Site::of(self.library.clone(), model, self.modules.clone());
        let loaded = sites::load_text(&site, "experiment.rpl", plan, &mut NoFiles, false)?;
        Ok((site, loaded))
    }
}

/// A camera for a robot that has none of its own.
pub fn usual_camera() -> Option<rpl_robot::description::Camera> {
    RobotDescription::builtin("b21-camera").and_then(|robot| robot.camera)
}
