//! Localization on a complete topological map: what state-set progression was made for (Nourbakhsh, Powers
//! and Birchfield 1995; Gutierrez-Osuna and Luo, "State-Set Progression"). The start is unknown; a state is a
//! node and the direction in which the robot passed it, and what is perceived on both sides is one percept.
//!
//! Read in this order: `map`, `localization`, `plan`, and `trial`, which drives a robot along a map to see how
//! soon it knows where it is.

mod both_sides;
mod localization;
mod map;
mod plan;
mod trial;

pub use both_sides::{BothSides, OPPOSITE_M, both_sides};
pub use localization::TopologicalLocalization;
pub use map::{Direction, MapFault, Node, State, TopologicalMap, Turn};
pub use plan::{Action, next_action};
pub use trial::{Step, drive};
