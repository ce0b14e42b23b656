//! The loops of [`kernel`] compiled for the registers this machine has, with [`Lanes`](super::lanes::Lanes)
//! that are these registers. All give the same bits.

#![allow(unsafe_code, reason = "code for instructions that are found at run time can only be called so")]

use super::grid::TILE;
use super::kernel::{self, Extent, TilePart, Wider};
use super::lanes::LANES;

#[cfg(target_arch = "x86_64")]
mod x86_64;

/// Instructions to compute with. A value exists only for those the machine has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instructions(Set);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Set {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Instructions {
    /// What every machine has.
    pub const PORTABLE: Self = Self(Set::Portable);

    /// All that this machine has, the fastest last.
    pub fn available() -> Vec<Self> {
        let mut available = vec![Self::PORTABLE];
        #[cfg(target_arch = "x86_64")]
        {
            if std::arch::is_x86_feature_detected!("avx2") {
                available.push(Self(Set::Avx2));
            }
            if x86_64::has_avx512() {
                available.push(Self(Set::Avx512));
            }
        }
        available
    }

    /// The fastest of this machine.
    pub fn fastest() -> Self {
        Self::available().pop().unwrap_or(Self::PORTABLE)
    }

    /// What they are called.
    pub fn name(self) -> &'static str {
        match self.0 {
            Set::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => "AVX2",
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => "AVX-512 VBMI",
        }
    }

    /// [`kernel::weigh`].
    pub(super) fn weigh(self, part: TilePart) -> Extent {
        match self.0 {
            Set::Portable => kernel::weigh::<[f32; LANES]>(part, kernel::cost_sums),
            // SAFETY: the value exists, so the machine has the instructions.
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => unsafe { x86_64::weigh_avx2(part) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => unsafe { x86_64::weigh_avx512(part) },
        }
    }

    /// [`kernel::spread`].
    pub(super) fn spread(self, wider: &Wider, spread: [f32; 2], cells: &mut [f32; TILE]) {
        match self.0 {
            Set::Portable => kernel::spread(wider, spread, cells),
            // SAFETY: the value exists, so the machine has the instructions.
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => unsafe { x86_64::spread_avx2(wider, spread, cells) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => unsafe { x86_64::spread_avx512(wider, spread, cells) },
        }
    }

    /// [`kernel::blend`].
    pub(super) fn blend(self, planes: [&[f32; TILE]; 3], spread: f32, cells: &mut [f32; TILE]) {
        match self.0 {
            Set::Portable => kernel::blend(planes, spread, cells),
            // SAFETY: the value exists, so the machine has the instructions.
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => unsafe { x86_64::blend_avx2(planes, spread, cells) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => unsafe { x86_64::blend_avx512(planes, spread, cells) },
        }
    }

    /// [`kernel::entropy`].
    pub(super) fn entropy(self, cells: &[f32; TILE], admissible: &[f32; TILE], terms: [f32; 2]) -> f64 {
        match self.0 {
            Set::Portable => kernel::entropy(cells, admissible, terms),
            // SAFETY: the value exists, so the machine has the instructions.
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => unsafe { x86_64::entropy_avx2(cells, admissible, terms) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => unsafe { x86_64::entropy_avx512(cells, admissible, terms) },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::kernel::{Beam, LIFT, TOGETHER};
    use super::*;

    const THRESHOLD: f32 = 1e-6;
    const AVERAGE: f32 = 0.01;
    const TERMS: [f32; 2] = [0.5, 1e-8];

    fn value(cell: f32) -> f32 {
        cell * TERMS[0] + TERMS[1]
    }

    fn weighed(instructions: Instructions, cells: &[f32; TILE], log2_per_cost: f32, threshold: f32) -> [f32; TILE] {
        // Here the one and there the other is the smaller.
        let bin = |cell: usize| (cell * 31 % 256) as u8;
        let [one, other]: [[u8; TILE]; 2] =
            [0, 1].map(|odd| std::array::from_fn(|cell| if cell % 2 == odd { bin(cell) } else { u8::MAX }));
        let costs: [u8; 256] = std::array::from_fn(|bin| (bin % 7) as u8);
        let beams = [[Beam { expected: [&one, &other], costs: &costs }; TOGETHER]; 2];
        let mut cells = *cells;
        instructions.weigh(TilePart {
            admissible: &[1.0; TILE],
            cells: &mut cells,
            terms: TERMS,
            beams: &beams,
            log2_per_cost,
            average: AVERAGE,
            threshold,
            next: None,
        });
        cells
    }

    #[test]
    fn a_cell_below_the_threshold_takes_the_average_weight_wherever_it_lies() {
        for instructions in Instructions::available() {
            // Blocks wholly below the threshold, wholly above it, and mixed in different ways.
            for period in [1, 2, 3, 5, 64, 100, TILE + 1] {
                let cells = std::array::from_fn(|cell| if cell % period == 0 { 1e-3 } else { 1e-7 });
                for (cell, (&before, after)) in
                    cells.iter().zip(weighed(instructions, &cells, -0.1, THRESHOLD)).enumerate()
                {
                    let weight = f64::from(after) / f64::from(LIFT) / f64::from(value(before));
                    let own = libm::exp2(-0.1 * 8.0 * (cell * 31 % 256 % 7) as f64);
                    let due = if value(before) < THRESHOLD { f64::from(AVERAGE) } else { own };
                    let name = instructions.name();
                    assert!((weight / due - 1.0).abs() < 1e-6, "{name}, every {period}th, {cell}: {weight} for {due}");
                }
            }
        }
    }

    /// Cells of many magnitudes, among them some that are 0.
    fn cells(seed: u32) -> [f32; TILE] {
        let mut state = seed;
        std::array::from_fn(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            if state >> 29 == 0 { 0.0 } else { (state >> 8) as f32 * kernel::exp2(-((state % 97) as f32)) }
        })
    }

    fn bits(cells: &[f32; TILE]) -> [u32; TILE] {
        cells.map(f32::to_bits)
    }

    #[test]
    fn bounds_that_no_cell_meets_change_no_bit() {
        // As small as a threshold can be, and none: with it all bounds are looked at.
        let thresholds = [f32::from_bits(1), 0.0];
        let due = bits(&weighed(Instructions::PORTABLE, &cells(3), -0.02, thresholds[0]));
        for instructions in Instructions::available() {
            for threshold in thresholds {
                let found = bits(&weighed(instructions, &cells(3), -0.02, threshold));
                assert!(found == due, "{} {threshold}", instructions.name());
            }
        }
    }

    #[test]
    fn tiles_are_spread_and_blended_with_the_same_bits_by_all_instructions() {
        let mut values = [cells(1), cells(2)].into_iter().flatten();
        let wider: Wider = std::array::from_fn(|_| std::array::from_fn(|_| values.next().unwrap_or(1.0)));
        let planes = [cells(4), cells(5), cells(6)];
        let made = |instructions: Instructions| {
            let mut made = [[0.0; TILE]; 2];
            instructions.spread(&wider, [0.1, 0.23], &mut made[0]);
            instructions.blend([&planes[0], &planes[1], &planes[2]], 0.17, &mut made[1]);
            made.map(|cells| bits(&cells))
        };
        for instructions in Instructions::available() {
            assert!(made(instructions) == made(Instructions::PORTABLE), "{}", instructions.name());
        }
    }
}
