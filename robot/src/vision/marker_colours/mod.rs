//! What markers look like to a camera. The histograms are measured and not computed: a camera cuts off what
//! is brighter than white, so that a fluorescent sheet has not the colour it was painted with.

mod measured;

use super::histogram::Histogram;
use crate::world::MarkerColour;
use measured::MEASURED;

impl Histogram {
    /// Of the paper that markers and landmarks are of. It was measured in places with all kinds of light, by a
    /// camera like that of the robots here.
    pub fn of_marker(colour: MarkerColour) -> Self {
        let mut colours = Self::default();
        let measured = MARKERS.iter().zip(MEASURED).filter(|(known, _)| **known == colour);
        for (bin, share) in measured.flat_map(|(_, bins)| bins) {
            colours.counts[*bin] = f64::from(*share);
        }
        colours
    }
}

/// The colours in the order in which they were measured.
const MARKERS: [MarkerColour; 4] = MarkerColour::ALL;
