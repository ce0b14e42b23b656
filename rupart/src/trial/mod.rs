//! What the memory is worth: routes in a building, asked for one after the other, kinds of cases, drives, and days of
//! errands.

mod behaviours;
mod days;
mod drive;
mod kinds;
mod routes;

pub use behaviours::{CourseMoment, Driven, Driver, DrivingGround, Quality, candidates};
pub use days::{Day, DayGround, Errand, ErrandEnding};
pub use drive::Trial;
pub use kinds::{KindGround, KindRetrieved, Phase, Reason, Telling};
pub use routes::{Planner, RouteAsked, RouteStart, RouteTrial, SLOW, run_routes};
