//! The office robot behind the seam of the runtime: thin bindings of simulator, localization,
//! active localization, navigation and gripper to behaviours, fluents and functions of plans.
//!
//! One step of 50 ms: the commands of the modules go to the host, and a percept comes back; simulated,
//! the scenario runs before the robot moves and senses. Then the modules work in the order of their list
//! (`behaviours`): position tracking takes the percept in, the active behaviours decide. What they found
//! goes out as one assignment of all fluents.
//!
//! Read `behaviours` first, then `controller`, then `robot`.

mod behaviours;
mod board;
mod controller;
mod cost;
mod host;
mod model;
mod names;
mod natives;
mod plan_text;
mod report;
mod robot;
mod save;
mod scenario;
mod words;

pub use behaviours::active_localization::NAME as ACTIVE_LOCALIZATION;
pub use behaviours::position::Position;
pub use behaviours::{Modules, tables};
pub use board::Board;
pub use controller::Controller;
pub use cost::Cost;
pub use host::{Host, SimulatedHost};
pub use model::{MapModel, OfficeModel, OfficeSettings};
pub use names::{PLANS, reserved_names, robot_names, scenario_names};
pub use natives::natives;
pub use report::{Report, ReportKind};
pub use robot::OfficeRobot;
pub use scenario::{Oracle, oracle_natives, oracle_tables};
