//! The loops over the cells of one tile. Every sum has one fixed order, and every operation is one
//! that rounds alike whatever the width of the registers: the loops are written in
//! [`lanes`](super::lanes), and [`simd`](super::simd) compiles them for wider ones.

use super::grid::{BLOCK, TILE, TILE_EDGE};
use super::lanes::{Float, LANES, Lanes};

/// Blocks of a tile.
const TILE_BLOCKS: usize = TILE / BLOCK;

/// Beams whose costs are looked up together.
pub(super) const TOGETHER: usize = 4;

/// Beams of a scan, at most: every sum of byte costs over one scan fits into 16 bits.
pub const MAX_BEAMS: usize = u16::MAX as usize / u8::MAX as usize;

/// Costs of the beams of a scan for some blocks of a tile.
pub(super) type CostSums = [[u16; BLOCK]; TILE_BLOCKS];

/// One reading against one tile of a plane: the bins expected there, and what each costs.
#[derive(Clone, Copy)]
pub(super) struct Beam<'a> {
    /// A tile of expected bins, of each cell the smaller of two.
    pub expected: [&'a [u8; TILE]; 2],
    /// Costs by expected bin.
    pub costs: &'a [u8; 256],
}

/// Costs of a beam that says nothing.
const SILENT: [u8; 256] = [0; 256];

impl<'a> Beam<'a> {
    /// Writes beams as they are looked up, with silent ones behind the last.
    pub(super) fn put_together(beams: impl IntoIterator<Item = Self>, together: &mut Vec<[Self; TOGETHER]>) {
        let mut beams = beams.into_iter();
        together.clear();
        while let Some(first) = beams.next() {
            let silent = Self { expected: first.expected, costs: &SILENT };
            together.push(std::array::from_fn(|at| if at == 0 { first } else { beams.next().unwrap_or(silent) }));
        }
    }
}

/// A tile of a plane, and a scan to weigh it by.
pub(super) struct TilePart<'a> {
    /// The cells.
    pub cells: &'a mut [f32; TILE],
    /// 1 where the robot can stand, else 0.
    pub admissible: &'a [f32; TILE],
    /// Factor and floor by which the cells are to be read.
    pub terms: [f32; 2],
    /// The scan.
    pub beams: &'a [[Beam<'a>; TOGETHER]],
    /// Binary logarithm of the weight a unit of cost amounts to.
    pub log2_per_cost: f32,
    /// Weight of cells below the threshold, and of empty blocks.
    pub average: f32,
    /// θ.
    pub threshold: f32,
    /// Cells that are weighed next, to be fetched meanwhile.
    pub next: Option<&'a [f32; TILE]>,
}

/// Sum and maximum of some cells.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Extent {
    /// The sum.
    pub mass: f64,
    /// The largest cell.
    pub peak: f32,
}

/// Sum and maximum of cells as they are visited, lane by lane.
struct Visited<L> {
    sums: L,
    peaks: L,
}

impl<L: Lanes> Visited<L> {
    #[inline(always)]
    fn none() -> Self {
        Self { sums: L::all(0.0), peaks: L::all(0.0) }
    }

    #[inline(always)]
    fn add(&mut self, cells: L) {
        self.sums = self.sums.plus(cells);
        self.peaks = cells.larger(self.peaks);
    }

    #[inline(always)]
    fn extent(&self) -> Extent {
        Extent { mass: self.sums.to_array().into_iter().map(f64::from).sum(), peak: self.peaks.largest() }
    }
}

/// Sum and maximum of a tile.
pub(super) fn extent(cells: &[f32; TILE]) -> Extent {
    let mut visited = Visited::<[f32; LANES]>::none();
    cells.as_chunks().0.iter().for_each(|chunk| visited.add(*chunk));
    visited.extent()
}

/// Smallest value at which an admissible cell is read. No product of such a value, [`LIFT`], a weight
/// and the share of a blur is a denormal number, which would cost a factor of five in time.
const FLOOR: f32 = 1e-20;

/// Weighed cells are stored this many times as large, 2⁶⁴, until the next normalization; so the range
/// of floats is used on both sides of 1.
pub(super) const LIFT: f32 = 18_446_744_073_709_551_616.0;

/// Binary logarithm of the smallest weight of a scan, 8e-31: no scan speaks against a pose by more
/// than 69 nats.
const LEAST_LOG2: f32 = -100.0;

/// 2^x for 0 ≥ x ≥ [`LEAST_LOG2`], below that the weight there; relative error 2e-7.
///
/// A polynomial of the fraction, minimal in the largest relative error, and the whole part added to
/// the exponent; multiplications and additions only, so that all widths round alike.
#[inline(always)]
pub(super) fn exp2<F: Float>(x: F) -> F {
    exp2_within(x.larger(F::all(LEAST_LOG2)))
}

/// The same where x is no less.
#[inline(always)]
fn exp2_within<F: Float>(x: F) -> F {
    // Added to a float, it leaves the whole part in the lowest bits.
    let whole = F::all(12_582_912.0);
    let shifted = x.plus(whole);
    let fraction = x.minus(shifted.minus(whole));
    let mut series = F::all(1.326_472_7e-3);
    for coefficient in [9.671_513e-3, 5.550_733_7e-2, 2.402_224_2e-1, std::f32::consts::LN_2, 1.0] {
        series = series.times(fraction).plus(F::all(coefficient));
    }
    series.to_power(shifted)
}

/// Natural logarithm of a normal float, to 1e-6 and rounding; finite for 0.
#[inline(always)]
fn ln(x: f32) -> f32 {
    const SQRT_HALF_BITS: i32 = 0x3f35_04f3;
    let bits = x.to_bits() as i32;
    let exponent = (bits - SQRT_HALF_BITS) >> 23;
    let t = f32::from_bits((bits - (exponent << 23)) as u32) - 1.0;
    let series = 1.221_098_2e-1 * t - 1.878_273e-1;
    let series = series * t + 2.045_475_5e-1;
    let series = series * t - 2.489_679_3e-1;
    let series = series * t + 3.331_603e-1;
    let series = series * t - 5.000_14e-1;
    let series = series * t + 1.000_001;
    exponent as f32 * std::f32::consts::LN_2 + series * t
}

/// −Σ p ln p over the admissible cells of a tile whose cells are to be read by these terms.
#[inline(always)]
pub(super) fn entropy(cells: &[f32; TILE], admissible: &[f32; TILE], [factor, floor]: [f32; 2]) -> f64 {
    let mut sums = [0f32; LANES];
    for (cells, admissible) in cells.as_chunks::<LANES>().0.iter().zip(admissible.as_chunks::<LANES>().0) {
        for lane in 0..LANES {
            let value = (cells[lane] * factor + floor) * admissible[lane];
            sums[lane] -= value * ln(value);
        }
    }
    sums.iter().map(|&lane| f64::from(lane)).sum()
}

/// Cells a turn of the portable loop looks up.
const UNROLLED: usize = 4;

/// Bin by bin.
fn smaller([one, other]: [&[u8; BLOCK]; 2]) -> [u8; BLOCK] {
    std::array::from_fn(|lane| one[lane].min(other[lane]))
}

/// Sums the costs of a scan for the blocks of a tile that are `loud`, in that order.
pub(super) fn cost_sums(sums: &mut CostSums, beams: &[[Beam; TOGETHER]], loud: &[usize]) {
    for four in beams {
        let [a, b, c, d] = four.map(|beam| beam.costs);
        let expected = four.map(|beam| beam.expected.map(|bins| bins.as_chunks::<BLOCK>().0));
        for (sums, &block) in sums.iter_mut().zip(loud) {
            let [at_a, at_b, at_c, at_d] = expected.map(|of_two| smaller(of_two.map(|blocks| &blocks[block])));
            for first in (0..BLOCK).step_by(UNROLLED) {
                for lane in first..first + UNROLLED {
                    sums[lane] += u16::from(a[usize::from(at_a[lane])])
                        + u16::from(b[usize::from(at_b[lane])])
                        + u16::from(c[usize::from(at_c[lane])])
                        + u16::from(d[usize::from(at_d[lane])]);
                }
            }
        }
    }
}

/// Multiplies a part by the weights of a scan (Eq. (2) without the normalizer); cells below the
/// threshold, also those that share a block with others, and empty blocks are multiplied by the
/// average weight (Eq. (3)): a mirror pose must not gain on its twin because it lies beside the
/// track. The cells are read by the part's terms, which bring in the last normalization; cells that
/// are not admissible become 0. What is stored and returned is [`LIFT`] times as large.
///
/// # Deviation
/// A weight is at least 2⁻¹⁰⁰ and an admissible cell is read as at least [`FLOOR`], so that no
/// number becomes denormal.
#[inline(always)]
pub(super) fn weigh<L: Lanes>(
    part: TilePart,
    cost_sums: impl Fn(&mut CostSums, &[[Beam; TOGETHER]], &[usize]),
) -> Extent {
    let [factor, floor] = part.terms;
    let lifted = [L::all(factor * LIFT), L::all(floor * LIFT)];
    let average = L::all(part.average);
    let cells = part.cells.as_chunks_mut::<BLOCK>().0;
    let admissible = part.admissible.as_chunks::<BLOCK>().0;
    let mut visited = Visited::none();
    let (mut loud, mut count) = ([0; TILE_BLOCKS], 0);
    let next = part.next.map_or(&[][..], |next| next.as_chunks::<BLOCK>().0);
    let (zero, nothing) = (L::all(0.0), L::all(-1.0));
    let (terms, threshold) = ([L::all(factor), L::all(floor)], L::all(part.threshold));
    for (block, (cells, admissible)) in cells.iter_mut().zip(admissible).enumerate() {
        next.get(block).into_iter().for_each(L::fetch);
        let mut peaks = zero;
        for chunk in cells.as_chunks().0 {
            peaks = L::load(chunk).larger(peaks);
        }
        let highest = peaks.times(terms[0]).plus(terms[1]);
        if !part.beams.is_empty() && zero.if_less(peaks, highest, nothing).reaches(threshold) {
            loud[count] = block;
            count += 1;
            continue;
        }
        for (cells, admissible) in cells.as_chunks_mut().0.iter_mut().zip(admissible.as_chunks().0) {
            let weighed = read(cells, lifted).times(average).times(L::load(admissible));
            *cells = weighed.to_array();
            visited.add(weighed);
        }
    }
    if count == 0 {
        // Of most tiles nothing is left to do, and to clear the sums takes as long as that.
        return visited.extent();
    }
    let loud = &loud[..count];
    let mut sums = [[0; BLOCK]; TILE_BLOCKS];
    cost_sums(&mut sums, part.beams, loud);
    let least_log2 = part.log2_per_cost * (part.beams.len() * TOGETHER * usize::from(u8::MAX)) as f32;
    let loud = Loud {
        blocks: loud,
        sums: &sums,
        log2_per_cost: L::all(part.log2_per_cost),
        lifted,
        average,
        threshold: L::all(part.threshold * LIFT),
    };
    if part.threshold <= 0.0 && floor >= FLOOR && least_log2 >= LEAST_LOG2 {
        loud.weigh::<false>(cells, admissible, &mut visited);
    } else {
        loud.weigh::<true>(cells, admissible, &mut visited);
    }
    visited.extent()
}

/// The blocks of a tile whose cells are weighed by the scan.
struct Loud<'a, L> {
    blocks: &'a [usize],
    /// What the scan costs in each of them.
    sums: &'a CostSums,
    log2_per_cost: L,
    lifted: [L; 2],
    average: L,
    threshold: L,
}

impl<L: Lanes> Loud<'_, L> {
    /// Weighs them. Where none of the bounds can be met, as in a belief of which nothing sleeps, nothing is `BOUNDED`: the
    /// same comes out, and an operation in seven is saved.
    #[inline(always)]
    fn weigh<const BOUNDED: bool>(
        &self,
        cells: &mut [[f32; BLOCK]],
        admissible: &[[f32; BLOCK]],
        visited: &mut Visited<L>,
    ) {
        for (sums, &block) in self.sums.iter().zip(self.blocks) {
            let chunks = cells[block].as_chunks_mut().0.iter_mut().zip(admissible[block].as_chunks().0);
            for ((cells, admissible), sums) in chunks.zip(sums.as_chunks().0) {
                let log2 = L::load_whole(sums).times(self.log2_per_cost);
                let weighed = if BOUNDED {
                    let value = read(cells, self.lifted);
                    value.times(value.if_less(self.threshold, self.average, exp2(log2)))
                } else {
                    L::load(cells).times(self.lifted[0]).plus(self.lifted[1]).times(exp2_within(log2))
                };
                let weighed = weighed.times(L::load(admissible));
                *cells = weighed.to_array();
                visited.add(weighed);
            }
        }
    }
}

/// Edge of a tile and one cell around it.
pub(super) const WIDER: usize = TILE_EDGE + 2;

/// The cells of a tile and those around it, `[row][column]`.
pub(super) type Wider = [[f32; WIDER]; WIDER];

/// Writes the tile in the middle, spread by `[g, 1 − 2g, g]` along x and then along y.
#[inline(always)]
pub(super) fn spread(wider: &Wider, [spread_x, spread_y]: [f32; 2], cells: &mut [f32; TILE]) {
    let along_x = |row: &[f32; WIDER]| -> [f32; TILE_EDGE] {
        std::array::from_fn(|at| (1.0 - 2.0 * spread_x) * row[at + 1] + spread_x * (row[at] + row[at + 2]))
    };
    let [mut below, mut middle] = [0, 1].map(|row| along_x(&wider[row]));
    for (cells, row) in cells.as_chunks_mut::<TILE_EDGE>().0.iter_mut().zip(&wider[2..]) {
        let above = along_x(row);
        for (at, cell) in cells.iter_mut().enumerate() {
            *cell = (1.0 - 2.0 * spread_y) * middle[at] + spread_y * below[at] + spread_y * above[at];
        }
        (below, middle) = (middle, above);
    }
}

/// 1 − 2g of the first cells and g of each of the others.
#[inline(always)]
pub(super) fn blend([own, before, after]: [&[f32; TILE]; 3], spread: f32, cells: &mut [f32; TILE]) {
    let keep = 1.0 - 2.0 * spread;
    for (cell, ((own, before), after)) in cells.iter_mut().zip(own.iter().zip(before).zip(after)) {
        *cell = keep * own + spread * before + spread * after;
    }
}

/// Cells read by lifted terms.
#[inline(always)]
fn read<L: Lanes>(cells: &[f32; LANES], [factor, floor]: [L; 2]) -> L {
    L::load(cells).times(factor).plus(floor).larger(L::all(FLOOR * LIFT))
}

/// `cell · factor + floor` where admissible, else 0.
pub(super) fn apply_terms(cells: &mut [f32; TILE], admissible: &[f32; TILE], [factor, floor]: [f32; 2]) {
    for (cell, admissible) in cells.iter_mut().zip(admissible) {
        *cell = (*cell * factor + floor).larger(FLOOR) * admissible;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponential_and_logarithm_are_as_exact_as_they_say() {
        for step in 0..=100_000 {
            let x = -100.0 * step as f32 / 100_000.0;
            let exact = libm::exp2(f64::from(x));
            assert!((f64::from(exp2(x)) / exact - 1.0).abs() < 3e-7, "{x}");
            let p = exp2(x);
            assert!((f64::from(ln(p)) - libm::log(f64::from(p))).abs() < 2e-6 - 1e-7 * libm::log(exact), "{p}");
        }
        assert_eq!(exp2(-1e9), exp2(LEAST_LOG2));
        assert_eq!(0.0 * ln(0.0), 0.0);
    }
}
