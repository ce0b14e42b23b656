//! Finding a room by instructions (Gutierrez-Osuna and Luo, *LOLA*): what is perceived of hallways, whether
//! openings are counted right, and whether the robot arrives.
//!
//! Read in this order: `setting` (what differs from row to row), `course` (drives along single hallways) with
//! `features` and `openings`, `delivery` (whole routes), `topological` (the complete map), `markers` (what the
//! camera finds), `figures`.

mod course;
mod delivery;
mod features;
mod figures;
mod markers;
mod openings;
mod setting;
mod topological;

pub use delivery::{OfficeDelivery, row_names as delivery_rows};
pub use features::{HallwayFeatures, row_names as feature_rows};
pub use markers::{MarkerDetections, row_names as marker_rows};
pub use openings::{CountOpenings, row_names as counting_rows};
pub use topological::{TopologicalDrives, row_names as map_rows};
