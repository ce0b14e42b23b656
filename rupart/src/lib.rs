//! One case memory for behaviours and routes (Fox and Anderson-Sprecher 2006, "Robot Navigation Using Integrated
//! Retrieval of Behaviors and Routes").
//!
//! A case holds either parameters of the reactive control or a sequence of places. One retrieval serves both: what kind
//! comes back decides whether the robot changes how it drives or where it goes.
//!
//! Read in this order: `situation` (what a case is indexed by), `route`, `case`, `similarity` and `memory` (what is
//! most similar); `places` (known places and ways over them) and `routes` (adaptation, learning, competence); `maintenance`
//! (what is wrong with cases), `forgetting` (how many are kept), `file`; `landmarks` (localization), `control` (what
//! behaviours are), `beginning` (the first memory); `module`, which binds all to plans; then `trial` (what the memory
//! is worth).

pub mod beginning;
pub mod case;
pub mod control;
pub mod file;
pub mod forgetting;
pub mod landmarks;
pub mod maintenance;
pub mod memory;
mod module;
pub mod places;
pub mod route;
pub mod routes;
pub mod similarity;
pub mod situation;
pub mod trial;

pub use module::{PLANS, Rupart, RupartSettings};
