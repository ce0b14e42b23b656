//! The grid: gaps with rooms and the hallways between them, along one axis.

use super::interval::{Interval, Millimetres};
use rpl_random::Stream;

/// Along one axis, gap and hallway in turn, beginning and ending with a gap. All borders are the middles of
/// walls.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bands {
    /// The gaps; between each two is a hallway.
    pub gaps_mm: Vec<Interval>,
}

/// Between the edge of the world and the outer wall.
const MARGIN_MM: Millimetres = 300;

/// The outermost rooms are so deep.
const OUTER_MM: Interval = (3600, 4800);

/// Between two hallways.
const INNER_MM: Interval = (8500, 15_000);

/// Clear width of a hallway (lola.md, part 10).
pub const HALLWAY_MM: Interval = (2000, 2500);

/// Whole centimetres between two lengths, both included.
pub fn centimetres(stream: &mut Stream, (least_mm, most_mm): Interval) -> Millimetres {
    let steps = usize::try_from((most_mm - least_mm) / 10).unwrap_or(0);
    least_mm + 10 * stream.index(steps + 1) as Millimetres
}

impl Bands {
    /// With a number of hallways.
    pub fn draw(stream: &mut Stream, hallways: usize, walls_mm: Millimetres) -> Self {
        let mut gaps_mm = Vec::with_capacity(hallways + 1);
        let mut from_mm = MARGIN_MM;
        for gap in 0..=hallways {
            let is_outer = gap == 0 || gap == hallways;
            let to_mm = from_mm + centimetres(stream, if is_outer { OUTER_MM } else { INNER_MM });
            gaps_mm.push((from_mm, to_mm));
            from_mm = to_mm + centimetres(stream, HALLWAY_MM) + walls_mm;
        }
        Self { gaps_mm }
    }

    /// All bands in their order, gaps at even places and hallways at odd ones.
    pub fn band_mm(&self, index: usize) -> Interval {
        let gap = self.gaps_mm[index / 2];
        if index.is_multiple_of(2) { gap } else { (gap.1, self.gaps_mm[index / 2 + 1].0) }
    }

    /// How many bands there are.
    pub fn count(&self) -> usize {
        2 * self.gaps_mm.len() - 1
    }

    /// The middles of the outermost walls.
    pub fn reach_mm(&self) -> Interval {
        (self.band_mm(0).0, self.band_mm(self.count() - 1).1)
    }

    /// How long the world is.
    pub fn size_mm(&self) -> Millimetres {
        self.reach_mm().1 + MARGIN_MM
    }
}
