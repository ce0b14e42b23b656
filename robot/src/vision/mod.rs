//! Vision: where things of a known colour lie on the floor or hang on walls, by histogram back-projection.
//!
//! Read in this order: `histogram` (colours, whatever the light), `back_projection` (where in an image they
//! are), `floor_marks` (where on the floor), `wall_marks` (where on walls), `pan_control` (where the camera is
//! turned).

mod back_projection;
mod floor_marks;
mod histogram;
mod marker_colours;
mod pan_control;
mod wall_marks;

pub use back_projection::{Blob, blobs};
pub use floor_marks::{FloorMark, FloorSighting, floor_sightings};
pub use histogram::{BINS, Histogram, bin};
pub use pan_control::PanControl;
pub use wall_marks::{WallMark, wall_sightings};
