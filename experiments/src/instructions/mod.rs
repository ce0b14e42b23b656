//! Finding a room by instructions (Gutierrez-Osuna and Luo, *LOLA*): what is perceived of hallways, whether
//! openings are counted right, and whether the robot arrives.
//!
//! Read in this order: `setting` (what differs from row to row), `course` (drives along single hallways) with
//! `features` and `openings`, `delivery` (whole routes), `topological` (the complete map), `markers` (what the
//! camera finds), `figures`.

mod course;
pub mod delivery;
pub mod features;
mod figures;
pub mod markers;
pub mod openings;
mod setting;
pub mod topological;
