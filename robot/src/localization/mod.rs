//! Position probability grids (Beetz et al. §2.1; Fox, Burgard, Thrun §3): where the robot is, as
//! a probability for every cell of (x, y, heading).
//!
//! A [`LocalizationModel`] is built once from a map: which cells can be stood in, the expected
//! distance for every cell and direction, and the sensor model as byte tables. A [`Localization`]
//! is the state: the belief, and the odometry at its last update. It never reads a clock and never
//! moves the robot.
//!
//! Read in this order: `scan_parameters`, `parameters`, `grid`, `ground`, `sensor`, `expected`, `scan`, `model` (what
//! never changes), then `tile`, `plane`, `motion`, `belief`, `advance`, `sleep`, `resampling`,
//! `odometry_faults`, `weigh`, `summary`, `evidence` and `scan_match` (the belief), `landmark` (what was seen),
//! `calibration`, `watcher`, `contest`, `review`, `map_fit` and `beliefs` (fine and coarse), `gating` (which readings are left out), `filter` (the state others use), `reading` (a
//! belief read beam by beam), and `once` (one scan against the whole map).

mod advance;
mod belief;
mod beliefs;
mod calibration;
mod contest;
mod error;
mod evidence;
mod expected;
mod filter;
mod gating;
mod grid;
mod ground;
mod kernel;
mod landmark;
mod lanes;
mod map_fit;
mod model;
mod motion;
mod odometry_faults;
pub mod once;
mod parameters;
mod plane;
mod reading;
mod resampling;
mod review;
mod saved_tiles;
mod scan;
mod scan_match;
mod scan_parameters;
mod sensor;
mod simd;
mod sleep;
mod slip;
mod summary;
#[cfg(test)]
mod tests;
mod tile;
mod watcher;
mod weigh;

pub use belief::Belief;
pub use calibration::Calibration;
pub use error::ModelError;
pub use filter::{Estimate, Localization};
pub use grid::{Bearings, BeliefGrid, State};
pub use kernel::MAX_BEAMS;
pub use landmark::{LandmarkNoise, LandmarkSighting};
pub use model::LocalizationModel;
pub use parameters::{LocalizationParameters, OdometryError, OdometryFaults, Spread, Watch};
pub use plane::Plane;
pub use reading::{Offness, ReadingModel, StateShare};
pub use scan::ScanModel;
pub use scan_parameters::{BeamParameters, ErrorCorrelation, Gating, ScanParameters, ShortReadings};
pub(crate) use sensor::{BINS, components};
pub use sensor::{NO_ECHO, SensorModel};
pub use simd::Instructions;
pub use summary::Maximum;
