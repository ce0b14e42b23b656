//! Drawings as SVG, PNG and PDF, in one palette: maps with the doings of a robot in them, scales of colour, parts of charts.
//!
//! A drawing is a plan of the floor, tracks, dots and marks, each with its meaning. Colours, legend, scale, the place
//! of names and the image beside it follow from that.
//!
//! Read in this order: `palette`; `frame` (from the map to the page); `writing` (text: its width, its lines); `sheet`
//! (title, map, scale, legend on one page); `floor_plan` (what stands where); `ink` (cells as one outline, lines with
//! fewer points); `labels` (names that do not cover each other); `marks` (robots, targets, lines) and `legend` (their
//! meaning); `shades` (numbers as darkness) and `field` (the same around the robot); `figure` (all of it together);
//! `export` (PNG and PDF).

pub mod export;
mod field;
mod figure;
mod floor_plan;
mod frame;
mod ink;
mod labels;
mod legend;
mod marks;
pub mod palette;
pub mod shades;
mod sheet;
pub mod writing;

pub use field::Field;
pub use figure::{Dots, Figure};
pub use floor_plan::FloorPlan;
pub use marks::{Mark, MarkKind, TrackKind};
