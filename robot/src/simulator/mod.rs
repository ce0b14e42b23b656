//! The simulated robot: a round body that drives and turns on the spot, with the sonars, the laser, the
//! camera, the bumper, the gripper and the drifting odometry of its description, in a world with doors, objects and
//! people.
//!
//! `SimulatorModel` is everything that never changes (surfaces with their lookup grid, settings);
//! `SimulatorState` is everything that does. `SimulatorModel::step` carries a state one step on;
//! `SimulatorModel` also has the experimenter's hands, see `oracle`.
//!
//! Read `settings` first, then `step`.
//!
//! ```
//! use rpl_robot::simulator::{Commands, SimulatorModel, SimulatorSettings};
//! use rpl_robot::world::World;
//! use std::sync::Arc;
//!
//! let world = World::builtin("test-room").expect("a built-in world");
//! let model = SimulatorModel::new(Arc::new(world), SimulatorSettings::default());
//! let mut state = model.start(7);
//! let ahead = Commands { translation_mps: 0.3, sonars_on: true, ..Commands::default() };
//! for _ in 0..20 {
//!     let percept = model.step(&mut state, &ahead);
//!     assert!(percept.sonar_m.is_some());
//! }
//! assert!(state.distance_driven_m() > 0.1);
//! ```

mod appearance;
mod arc;
mod battery;
mod candidates;
mod commands;
mod company;
mod crowd;
mod echo;
mod eye;
mod fan;
mod gather;
mod gripper;
mod model;
mod motion;
mod odometry;
mod oracle;
mod orca;
mod pan;
mod people;
mod percept;
mod place_draws;
mod sensors;
mod settings;
mod start;
mod state;
mod step;
mod surface;
mod sweep;
#[cfg(test)]
mod tests;
mod walker;

pub use arc::drive_arc;
pub use commands::{CameraCommand, Commands};
pub use echo::Echo;
pub use gripper::{Gripper, GripperCommand, GripperMotion, GripperStatus, ItemPlace, ItemState};
pub use model::SimulatorModel;
pub use oracle::OracleError;
pub use pan::Pan;
pub use percept::{Percept, SensorStreams};
pub use settings::SimulatorSettings;
pub use state::{Contacts, SimulatorState, Streams};
pub use walker::{PERSON_RADIUS_M, Walker};
