//! What plans are told in words: names of travel modes, and that there is no map.

use crate::world::TravelMode;
use rpl_runtime::state::failure::Raise;

/// What needs a map fails, and says what to do instead.
pub(super) fn no_map(what: &str) -> Raise {
    Raise::new("localization-failure", format!("the robot has no map: {what}; run the plan without `--map none`"))
}

/// The name plans use for a travel mode.
pub(super) fn mode_name(mode: TravelMode) -> &'static str {
    match mode {
        TravelMode::Hallway => "hallway",
        TravelMode::Office => "office",
        TravelMode::Doorway => "doorway",
    }
}
