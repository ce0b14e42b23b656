//! Floats computed with one at a time or many at once: what `kernel` writes its loops in. Every
//! operation rounds in each lane as it does on a single float, whatever registers it runs in.

use super::grid::BLOCK;

/// Floats visited at once: a whole number of the widest registers.
pub(super) const LANES: usize = 16;

/// One float, or several side by side.
pub(super) trait Float: Copy {
    /// The same in every lane.
    fn all(value: f32) -> Self;

    /// `self + other`.
    fn plus(self, other: Self) -> Self;

    /// `self − other`.
    fn minus(self, other: Self) -> Self;

    /// `self · other`.
    fn times(self, other: Self) -> Self;

    /// `self` where it exceeds `other`, else `other`: one instruction, other than `f32::max`, which
    /// looks after NaN.
    fn larger(self, other: Self) -> Self;

    /// `less` where `self` is less than `bound`, else `not_less`.
    fn if_less(self, bound: Self, less: Self, not_less: Self) -> Self;

    /// `self · 2^n`, where n stands in the lowest bits of `power`.
    fn to_power(self, power: Self) -> Self;
}

/// [`LANES`] floats side by side.
pub(super) trait Lanes: Float {
    /// From memory.
    fn load(cells: &[f32; LANES]) -> Self;

    /// Whole numbers from memory.
    fn load_whole(numbers: &[u16; LANES]) -> Self;

    /// The largest; none may be NaN.
    fn largest(self) -> f32;

    /// Whether any is at least its bound.
    fn reaches(self, bound: Self) -> bool;

    /// Lane by lane.
    fn to_array(self) -> [f32; LANES];

    /// Has cells brought near that are to be loaded soon, where there is an instruction for it.
    fn fetch(cells: &[f32; BLOCK]);
}

impl Float for f32 {
    #[inline(always)]
    fn all(value: f32) -> Self {
        value
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self + other
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self - other
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        self * other
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        if self > other { self } else { other }
    }

    #[inline(always)]
    fn if_less(self, bound: Self, less: Self, not_less: Self) -> Self {
        if self < bound { less } else { not_less }
    }

    #[inline(always)]
    fn to_power(self, power: Self) -> Self {
        f32::from_bits(self.to_bits().wrapping_add(power.to_bits() << 23))
    }
}

/// What every machine has.
impl Float for [f32; LANES] {
    #[inline(always)]
    fn all(value: f32) -> Self {
        [value; LANES]
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        std::array::from_fn(|lane| self[lane].plus(other[lane]))
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        std::array::from_fn(|lane| self[lane].minus(other[lane]))
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        std::array::from_fn(|lane| self[lane].times(other[lane]))
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        std::array::from_fn(|lane| self[lane].larger(other[lane]))
    }

    #[inline(always)]
    fn if_less(self, bound: Self, less: Self, not_less: Self) -> Self {
        std::array::from_fn(|lane| self[lane].if_less(bound[lane], less[lane], not_less[lane]))
    }

    #[inline(always)]
    fn to_power(self, power: Self) -> Self {
        std::array::from_fn(|lane| self[lane].to_power(power[lane]))
    }
}

impl Lanes for [f32; LANES] {
    #[inline(always)]
    fn load(cells: &[f32; LANES]) -> Self {
        *cells
    }

    #[inline(always)]
    fn load_whole(numbers: &[u16; LANES]) -> Self {
        numbers.map(f32::from)
    }

    #[inline(always)]
    fn largest(self) -> f32 {
        self.into_iter().fold(f32::NEG_INFINITY, f32::larger)
    }

    #[inline(always)]
    fn reaches(self, bound: Self) -> bool {
        (0..LANES).fold(false, |any, lane| any | (self[lane] >= bound[lane]))
    }

    #[inline(always)]
    fn to_array(self) -> [f32; LANES] {
        self
    }

    #[inline(always)]
    fn fetch(_: &[f32; BLOCK]) {}
}
