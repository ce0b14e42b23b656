//! Low-level motion: how the robot drives where it has no map (Gutierrez-Osuna and Luo, "Low-Level-Motion
//! Routines"). Each routine is a plain value that is stepped with what the sensors say and answers with
//! velocities; all of them keep off what they see.
//!
//! `lane` is where in a hallway there is room, `direction_follow` drives along it and `reverse` back;
//! `doorway` notices the frame of a door that the robot drives through. Seeking a goal is
//! [`MaplessNavigation`](rpl_robot::navigation::MaplessNavigation), following a wall
//! [`LocalDrive`](rpl_robot::navigation::LocalDrive).

mod direction_follow;
mod doorway;
mod lane;
mod reverse;

pub use direction_follow::{DirectionFollow, DirectionInput, DirectionOutput};
pub use doorway::{Doorway, DoorwayDetection};
pub use lane::{Lane, clear_lane};
pub use reverse::{Reverse, ReverseStatus};
