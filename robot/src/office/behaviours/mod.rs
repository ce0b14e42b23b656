//! The modules of the office robot: the list, and what follows from it.

pub(super) mod active_localization;
pub(super) mod body;
pub(super) mod gripper;
pub(super) mod look_around;
pub(super) mod move_by_odometry;
pub(super) mod navigation;
mod places;
pub(super) mod position_tracking;

use self::active_localization::Localizing;
use self::body::Body;
use self::gripper::Gripping;
use self::look_around::LookingAround;
use self::move_by_odometry::MovingByOdometry;
use self::navigation::Navigating;
use self::places::Places;
use self::position_tracking::PositionTracking;
use super::composition::Composition;
use rpl_runtime::robot::RobotTables;
use rpl_runtime::step::native::Native;
use std::sync::{Arc, LazyLock};

crate::modules! {
    /// The states of the office robot's modules.
    #[derive(Debug, PartialEq)]
    pub struct OfficeModules {
        position_tracking: PositionTracking,
        body: Body,
        active_localization: Localizing,
        navigation: Navigating,
        gripper: Gripping,
        look_around: LookingAround,
        move_by_odometry: MovingByOdometry,
        places: Places,
    }
}

/// What the office robot's modules offer together.
pub fn office_modules() -> &'static Arc<Composition<OfficeModules>> {
    static MODULES: LazyLock<Arc<Composition<OfficeModules>>> =
        LazyLock::new(|| match Composition::new(Default::default()) {
            Ok(modules) => modules,
            Err(taken) => unreachable!("{taken}"),
        });
    &MODULES
}

/// What plans see of the office robot.
pub fn tables() -> &'static RobotTables {
    &office_modules().tables
}

/// Functions of the office robot.
pub fn natives() -> Vec<Native> {
    office_modules().functions.clone()
}
