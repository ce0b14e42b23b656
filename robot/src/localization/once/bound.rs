//! How badly a scan must fit anywhere in a block: a bound for all headings at once.

use super::scale::RangeScale;

/// Headings, and directions, of the search: every 2°.
pub(super) const HEADINGS: usize = 180;

/// The same, up to whole registers.
pub(super) const LANES: usize = 192;

/// The costs of a scan at all headings.
pub(super) type Costs = [u16; LANES];

/// Costs are counted in eighths of a nat: a reading that nothing explains.
const UNEXPLAINED: u8 = 24;

/// One that is shorter than what is expected: somebody stands there.
const SHORT: u8 = 12;

/// An echo that did not come.
const MISSED: u8 = 16;

/// The beams that are summed up in a byte.
const SUMMED: usize = u8::MAX as usize / UNEXPLAINED as usize;

/// The beams of a scan that are searched with, at the most.
pub(super) const MOST_BEAMS: usize = 6 * SUMMED;

/// The shortest and the longest distance that is expected from a block in each direction, over all of its places and
/// to either side of the direction.
pub(super) struct Expected<'a> {
    pub shortest: &'a [u8; HEADINGS],
    pub longest: &'a [u8; HEADINGS],
}

/// A reading as the search compares it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SearchBeam {
    /// Its direction from straight ahead.
    pub direction: usize,
    /// Up to this an expected distance is not longer ...
    longer_from: u8,
    /// ... and from this on not shorter.
    shorter_to: u8,
    unexplained: u8,
}

impl SearchBeam {
    pub(super) fn new(direction: usize, range_m: f64, scale: &RangeScale) -> Self {
        let (step, tolerance) = (scale.step(range_m), libm::ceil(scale.steps) as u8);
        let unexplained = if step == scale.no_echo { MISSED } else { UNEXPLAINED };
        Self {
            direction,
            longer_from: step.saturating_add(tolerance),
            shorter_to: step.saturating_sub(tolerance),
            unexplained,
        }
    }

    /// The least cost while what is expected lies between these: it grows by two with every step beyond the tolerance.
    #[inline(always)]
    pub(super) fn cost(self, shortest: u8, longest: u8) -> u8 {
        let too_long = shortest.saturating_sub(self.longer_from);
        let too_short = self.shorter_to.saturating_sub(longest);
        too_long.saturating_add(too_long).min(SHORT) + too_short.saturating_add(too_short).min(self.unexplained)
    }
}

/// A lower bound of what the scan costs at each heading anywhere in a block; none where it is above the limit at all of
/// them. The beams are to be mixed, so that a few of them tell. Cost: a nanosecond for twenty beams and headings.
pub(super) fn costs(expected: &Expected<'_>, beams: &[SearchBeam], limit: u16) -> Option<Costs> {
    let around = |of: &[u8; HEADINGS]| {
        let mut twice = [0u8; HEADINGS + LANES];
        twice[..HEADINGS].copy_from_slice(of);
        twice[HEADINGS..2 * HEADINGS].copy_from_slice(of);
        twice[2 * HEADINGS..].copy_from_slice(&of[..LANES - HEADINGS]);
        twice
    };
    let (shortest, longest) = (around(expected.shortest), around(expected.longest));
    let mut costs = [0u16; LANES];
    for beams in beams.chunks(SUMMED) {
        let mut sums = [0u8; LANES];
        for beam in beams {
            let (shortest, longest) = (&shortest[beam.direction..][..LANES], &longest[beam.direction..][..LANES]);
            for ((sum, &shortest), &longest) in sums.iter_mut().zip(shortest).zip(longest) {
                *sum += beam.cost(shortest, longest);
            }
        }
        let mut least = u16::MAX;
        for (cost, sum) in costs.iter_mut().zip(sums) {
            *cost += u16::from(sum);
            least = least.min(*cost);
        }
        if least > limit {
            return None;
        }
    }
    Some(costs)
}
