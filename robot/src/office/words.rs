//! What plans are told in words: names of travel modes, that there is no map, and signals of sensors that
//! this crate does not know.

use super::model::OfficeModel;
use crate::sensors::Signal;
use crate::world::TravelMode;
use rpl_runtime::robot::reading::{Reading, ReadingList, TooNested};
use rpl_runtime::state::failure::Raise;

/// What needs a map fails, and says what to do instead.
pub(super) fn no_map(what: &str) -> Raise {
    Raise::new("localization-failure", format!("the robot has no map: {what}; run the plan without `--map none`"))
}

/// What needs a belief fails, and says what to do instead: the robot has no map, or goes by its odometry.
pub(super) fn no_belief(model: &OfficeModel, what: &str) -> Raise {
    if model.map.is_none() {
        return no_map(what);
    }
    let message = format!(
        "the robot goes by its odometry and the landmarks it comes to: {what}; it localizes by landmarks while it \
         drives under `(with-policy (localize-by-landmarks) ...)`"
    );
    Raise::new("localization-failure", message)
}

/// The name plans use for a travel mode.
pub(super) fn mode_name(mode: TravelMode) -> &'static str {
    match mode {
        TravelMode::Hallway => "hallway",
        TravelMode::Office => "office",
        TravelMode::Doorway => "doorway",
    }
}

/// What a signal says to plans; its texts are names.
///
/// # Errors
/// It is nested too deep.
pub fn signal_reading(signal: &Signal) -> Result<Reading, TooNested> {
    Ok(match signal {
        Signal::Truth(truth) => Reading::Truth(*truth),
        Signal::Number(number) => Reading::Float(*number),
        Signal::Text(name) => Reading::Symbol(name.clone()),
        Signal::List(items) => {
            Reading::List(ReadingList::new(items.iter().map(signal_reading).collect::<Result<_, _>>()?)?)
        }
    })
}
