//! Recorded drives: laser scans with odometry, and how well the filter finds the robot in them.
//!
//! A [`Recording`] is read from the text of a CARMEN log. [`BeamChoice`] picks the beams that the
//! filter is given, [`Window`] cuts the drive into trials, [`localize`] makes one, and
//! [`fit_sensor`] and [`fit_odometry`] estimate the parameters of the models from a recording.
//!
//! Read in this order: `drive`, `dead_reckoning`, `carmen`, `beams`, `window`, `trial`, `fit`.

mod beams;
mod carmen;
mod dead_reckoning;
mod drive;
mod fit;
#[cfg(test)]
mod tests;
mod trial;
mod window;

pub use beams::{BeamChoice, BeamError};
pub use carmen::LaserMount;
pub use drive::{FirstReading, LogError, Recording, Scan, ScanGeometry};
pub use fit::{FitError, fit_odometry, fit_sensor};
pub use trial::{PoseError, RIGHT_M, RIGHT_RAD, SURE, Trial, TrialStart, localize};
pub use window::{Window, WindowError};
