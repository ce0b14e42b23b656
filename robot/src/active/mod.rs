//! Active localization (Beetz et al. §2.2; Fox, Burgard, Thrun §4): drive to where the pose can
//! be told.
//!
//! The belief is summarised by its local maxima. An action is a target point relative to the robot,
//! x forward and y left. [`choose`] weighs the entropy expected there against the way; the state
//! machine [`ActiveLocalization`] wanders until there are few maxima, chooses, follows, and chooses
//! again until the robot knows where it is. It commands no wheels: it says what it wants.
//!
//! Read in this order: `parameters`, `action` (the grid of actions), `occupancy` (Eq. 7), `cost`
//! (Eq. 8), `entropy` (Eq. 6), `choice` (Eq. 9), `exact` (the oracle), `controller`; and `sensing`
//! (where to look, Fox, Burgard, Thrun Eq. 13).

mod action;
mod choice;
mod controller;
mod cost;
mod entropy;
mod exact;
mod occupancy;
mod parameters;
mod sensing;
#[cfg(test)]
mod tests;

pub use action::ActionGrid;
pub use choice::{ActionField, Choice, choose, consider};
pub use controller::{ActiveLocalization, Intent};
pub use exact::{ExactChoice, choose_exactly};
pub use parameters::{ActiveParameters, Exploration};
pub use sensing::{Direction, SensingChoice, SensingModel};
