//! The office robot behind the seam of the runtime: thin bindings of simulator, localization, active localization,
//! navigation and gripper to behaviours, fluents and functions of plans.
//!
//! One step: the commands of the modules go to the host, and a percept comes back; simulated, the scenario runs before
//! the robot moves and senses. Then the modules work in the order of their list (`behaviours`): position tracking takes
//! the percept in, the active behaviours decide. Their findings go out as one assignment of all fluents.
//!
//! A robot is a list of modules, made with [`modules!`](crate::modules), and a [`Host`]. Other crates add modules and
//! hosts of their own: the office robot's are written no other way (`examples/camera`). The macro makes of a list of
//! modules one module again. The list gives the order of steps, the tables and the reserved names.
//!
//! A module numbers its behaviours and fluents from 0, and its functions find its state by the type. Modules share
//! little: all read the percept and the position, and only position tracking writes the position. Where a behaviour
//! stands is kept once, by the runtime. An event is a variant of an enum (`report`): it is rendered once, and
//! recognised by the same name.
//!
//! Read `module` first, then `composition` and `behaviours`, then `controller` and `robot`.

mod abstract_world;
mod behaviours;
mod board;
mod composition;
mod controller;
mod cost;
mod foreseen_robot;
mod functions;
mod host;
mod immobility;
mod model;
mod module;
mod names;
mod one_scan;
mod plan_text;
mod position;
mod report;
mod robot;
mod save;
mod saved_bytes;
mod scenario;
mod simulated_robot;
mod words;

pub use crate::geometry::Velocity;
pub use crate::simulator::Commands;
pub use crate::world::TravelMode;
pub use abstract_world::{AbstractSetting, AbstractWorld, Forecast};
pub use behaviours::active_localization::{Localizing, NAME as ACTIVE_LOCALIZATION};
pub use behaviours::navigation::{Navigating, PLANS, RULES};
pub use behaviours::{OfficeModules, natives, office_modules, tables};
pub use board::Board;
pub use composition::{Composition, NameTaken};
pub use controller::Controller;
pub use cost::Cost;
pub use functions::{act, board, look, model};
pub use host::{Host, HostLost, SaveHost, SimulatedHost};
pub use model::{MapModel, OfficeModel, OfficeSettings, PositionBy};
pub use module::{
    Layout, Module, ModuleSpec, Moment, Part, PlanText, Start, Telling, continuous, counter, fluent, fluent_number,
};
pub use names::scenario_names;
pub use position::Position;
pub use report::{Report, ReportKind};
pub use robot::OfficeRobot;
pub use rpl_runtime::robot::StopReason;
pub use rpl_runtime::state::activation::Phase;
pub use rpl_runtime::state::failure::Raise;
pub use scenario::{Oracle, oracle_natives, oracle_tables};
pub use words::signal_reading;
