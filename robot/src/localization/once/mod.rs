//! Where a robot is by one scan: the whole map against it, at once (global localization without motion).
//!
//! A [`ScanLocator`] is built once from a map and a sensor; [`ScanLocator::locate`] answers with all poses that explain
//! a scan, each with its probability. It knows no belief and no odometry.
//!
//! Read in this order: `scale`, `blocks`, `bound` (what the search compares), `likelihood`, `scan` (what a pose is judged
//! by), `locator`, `search`, `answer`.

mod answer;
mod blocks;
mod bound;
mod likelihood;
mod locator;
mod scale;
mod scan;
mod search;
#[cfg(test)]
mod tests;
pub mod trial;

pub use answer::{LikelyPose, Located, MOST_POSES};
pub use locator::ScanLocator;
pub use scan::RangeBeam;
