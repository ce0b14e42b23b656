//! Recorded drives: laser scans with odometry, and how well the filter finds the robot in them.
//!
//! A [`Recording`] is read from the text of a CARMEN log, or paired from a [`StampedDrive`]: scans, odometry and
//! corrected poses with their own times. [`BeamChoice`] picks the beams that the
//! filter is given, [`Window`] cuts the drive into trials, [`localize`] makes one, and
//! [`fit_sensor`] and [`fit_odometry`] estimate the parameters of the models from a recording.
//!
//! Read in this order: `drive`, `track`, `dead_reckoning`, `carmen`, `rays`, `stamped`, `beams`, `window`, `trial`, `fit`.

mod beams;
mod carmen;
mod dead_reckoning;
mod drive;
mod fit;
mod rays;
mod stamped;
#[cfg(test)]
mod tests;
mod track;
mod trial;
mod window;

pub use beams::{BeamChoice, BeamError};
pub use carmen::LaserMount;
pub use drive::{FirstReading, LogError, Recording, Scan, ScanGeometry};
pub use fit::{FitError, fit_odometry, fit_sensor};
pub use rays::Rays;
pub use stamped::{StampedDrive, StampedScan};
pub use track::Track;
pub use trial::{PoseError, RIGHT_M, RIGHT_RAD, SURE, Trial, TrialStart, localize};
pub use window::{Window, WindowError};
