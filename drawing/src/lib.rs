//! Drawings as SVG and PNG, in one palette: maps with what a robot did in them, scales of colour, charts' parts.
//!
//! Read in this order: `palette`; `frame` (from the map to the page); `sheet` (title, map, scale, legend on one page); `floor_plan` (what stands where);
//! `ink` (cells as one outline, lines with fewer points); `labels` (names that do not cover each other); `shades` (numbers as
//! darkness); `marks` (robots, targets, points); `figure` (all of it together); `raster` (PNG).

mod field;
mod figure;
mod floor_plan;
mod frame;
mod ink;
mod labels;
mod legend;
mod marks;
pub mod palette;
pub mod raster;
pub mod shades;
mod sheet;
pub mod writing;

pub use field::Field;
pub use figure::{Dots, Figure};
pub use floor_plan::FloorPlan;
pub use marks::{Mark, MarkKind, TrackKind};
