//! What markers look like to a camera. The histograms are measured and not computed: a camera cuts off what
//! is brighter than white, so that a fluorescent sheet has not the colour it was painted with.

mod measured;

use super::floor_marks::FloorMark;
use super::histogram::Histogram;
use crate::world::MarkerColour;
use measured::MEASURED;

impl FloorMark {
    /// A marker of a colour and size. Its histogram was measured in places with all kinds of light, by a
    /// camera like that of the robots here.
    pub fn marker(colour: MarkerColour, size_m: f64) -> Self {
        let mut colours = Histogram::default();
        let measured = MARKERS.iter().zip(MEASURED).filter(|(known, _)| **known == colour);
        for (bin, share) in measured.flat_map(|(_, bins)| bins) {
            colours.counts[*bin] = f64::from(*share);
        }
        Self { colours, size_m }
    }
}

/// The colours in the order in which they were measured.
const MARKERS: [MarkerColour; 4] = MarkerColour::ALL;
