//! Maps as grids of cells, the distances to what is occupied in them, and the rays through them.
//!
//! A grid lies in the frame it was made in: `map`, or `odom` if the robot has drawn it itself. Points
//! that are looked up in it are of that frame, `in_frame`.

mod distance_field;
mod distance_transform;
mod flood;
mod grid;
mod ray;
mod sweep;

pub use distance_field::DistanceField;
pub use distance_transform::squared_distances_cells;
pub(crate) use flood::flood;
pub use grid::{Cell, OccupancyGrid};
pub use sweep::{SweepMap, SweepPoints};
