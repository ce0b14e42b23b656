//! The known places of a building: which of them see each other, what lies between those that do not, which
//! regions they have influence on, and shortest ways over them.

mod adjacency;
mod key_positions;
mod known_places;
mod lower_bound;
mod place;
mod shortest;
mod sight;
#[cfg(test)]
pub(crate) mod tests;

pub use known_places::{NoPlaces, Places};
pub use lower_bound::LowerBounds;
pub use place::{KnownPlace, PlaceId, Stretch};
pub use shortest::{Way, shortest_way};
