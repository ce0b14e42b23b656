//! Routes: adapted from cases literally as the paper prints it, or guided by what adapting will cost; checked,
//! repaired and learned; which of them a memory can do without; and the way round what blocks one that is driven.

mod adapted;
mod competence;
mod detour;
mod guided;
mod learning;
mod literal;
mod problem;
#[cfg(test)]
mod tests;
mod travel_times;
mod underway;

pub use adapted::Adapted;
pub use competence::{Competence, competences, reachability};
pub use detour::{Blockage, BlockedAt, Detour};
pub use guided::{CaseUse, Guidance, adapt_guided, best_use};
pub use learning::{learn_route, learn_times, learn_to_make};
pub use literal::adapt_literally;
pub use problem::RouteProblem;
pub use travel_times::TravelTimes;
pub use underway::Underway;
