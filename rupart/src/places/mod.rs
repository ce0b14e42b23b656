//! The known places of a building: which of them see each other, which regions they have influence on, and
//! shortest ways over them.

mod adjacency;
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
