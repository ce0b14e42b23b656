//! Memory: collections, and the room that is left.
//!
//! Everything that a run makes adds its bytes to a counter (`room`), and a collection measures what is alive (`gc`). A
//! collection that is due is made before the run waits for its next event. A function that would make much asks for
//! room first, and is called again when there is some.

pub(crate) mod gc;
pub mod room;
