//! The battery: driving and waiting use it up, and places that charge fill it again.

use super::model::SimulatorModel;
use super::state::SimulatorState;
use crate::geometry::distance_m;

/// The robot is charged this near to a charging place ...
const CONTACT_M: f64 = 0.6;

/// ... when it is no faster than this.
const STANDING_MPS: f64 = 0.02;

impl SimulatorModel {
    /// What one step takes from the battery, or gives to it.
    pub(super) fn use_battery(&self, state: &mut SimulatorState) {
        let Some(battery) = self.robot().battery else { return };
        let stands = state.translation_mps.abs() <= STANDING_MPS;
        let here = state.robot_in_map.point();
        let at_charger = || {
            let mut chargers = self.world.places.iter().filter(|place| place.charges);
            chargers.any(|place| distance_m(place.pose_in_map.point(), here) <= CONTACT_M)
        };
        let change_per_s = if stands && at_charger() {
            1.0 / battery.charging_s
        } else if stands {
            -1.0 / battery.standing_s
        } else {
            -1.0 / battery.driving_s
        };
        state.battery = (state.battery + change_per_s * self.robot().step_s()).clamp(0.0, 1.0);
    }
}
