//! Markers: sheets on the floor, and the colours of sheets.

use crate::geometry::Point;
use serde::{Deserialize, Serialize};

/// A sheet of a bright colour that lies flat on the floor, for cameras: a square along the axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Marker {
    /// Its middle.
    pub at: Point,
    /// Its colour.
    pub colour: MarkerColour,
    /// Length of its sides.
    pub size_m: f64,
}

/// The fluorescent colours that markers and landmarks come in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum MarkerColour {
    /// Pink.
    Pink,
    /// Orange.
    Orange,
    /// Green.
    Green,
    /// Blue.
    Blue,
}

impl MarkerColour {
    /// All of them.
    pub const ALL: [MarkerColour; 4] = [Self::Pink, Self::Orange, Self::Green, Self::Blue];

    /// As world files and people call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pink => "pink",
            Self::Orange => "orange",
            Self::Green => "green",
            Self::Blue => "blue",
        }
    }
}
