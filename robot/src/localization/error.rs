//! Why there is no model.

use super::kernel::MAX_BEAMS;

/// Why no model can be built.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ModelError {
    /// The angle step does not divide the circle, or is 0.
    #[error("an angle step of {0}° does not divide 360°")]
    AngleStep(u32),
    /// The cells are not a positive length, or smaller than those of the map.
    #[error("belief cells must be at least as large as the map's, {0} m")]
    CellSize(String),
    /// A scan without beams, or with more than a sum of byte costs holds.
    #[error("a scan has 1 to {MAX_BEAMS} beams, found {0}")]
    Beams(usize),
    /// Nothing to localize with.
    #[error("at least one range sensor is needed")]
    NoSensor,
    /// The robot fits nowhere.
    #[error("the map has no free cell the robot could stand in")]
    NoFreeCell,
    /// A parameter that describes nothing there is.
    #[error("the parameter `{name}` must be from {least} to {most}, found {found}")]
    Parameter {
        /// Its name, as in a file of parameters.
        name: &'static str,
        /// The least it may be.
        least: String,
        /// The most it may be.
        most: String,
        /// What it is.
        found: String,
    },
}
