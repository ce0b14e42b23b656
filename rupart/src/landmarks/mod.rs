//! Localization by landmarks (Fox and Anderson-Sprecher, Localization): coloured sheets on walls at known places,
//! found by a camera.
//!
//! Read in this order: `track` (where the camera is turned, and what it finds), `recognition` (which landmark that
//! is), `wall_ahead` (how far off a wall is and how it lies, by sonars), `localizing` (what the states Loc1 and
//! Loc2 do, and the position that comes of it).

mod localizing;
mod recognition;
mod track;
mod wall_ahead;

pub use localizing::{LandmarkFix, Localizing, LocalizingEnd, LocalizingTarget};
pub use recognition::{Recognized, recognize};
pub use track::{LandmarkEye, SeenSheet, Track};
pub use wall_ahead::{WallAhead, wall_ahead};
