//! Fluents, networks of fluents, and their glitch-free propagation.
//!
//! One propagation: the changed fluents are marked, every network that depends on them is
//! evaluated once in the order of dependency heights, then waiters and watches of what is true
//! now are served. A pulse makes its fluent true for one propagation; when it is over, what read
//! it is brought up to date once more, and that is no event.

mod agenda;
mod assignment;
mod networks;
mod watches;

pub(crate) use assignment::read;
