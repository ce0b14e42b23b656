//! The loops with the registers of AVX2 and of AVX-512 VBMI.

use super::super::grid::{BLOCK, TILE};
use super::super::kernel::{self, Beam, CostSums, Extent, TOGETHER, TilePart, Wider};
use super::super::lanes::{Float, LANES, Lanes};
use std::arch::is_x86_feature_detected;
use std::arch::x86_64::*;

pub(super) fn has_avx512() -> bool {
    is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("avx512vbmi")
}

#[target_feature(enable = "avx2")]
pub(super) fn weigh_avx2(part: TilePart) -> Extent {
    kernel::weigh::<[__m256; 2]>(part, |sums, beams, loud| cost_sums_avx2(sums, beams, loud))
}

#[target_feature(enable = "avx512f,avx512bw,avx512vbmi")]
pub(super) fn weigh_avx512(part: TilePart) -> Extent {
    kernel::weigh::<__m512>(part, |sums, beams, loud| cost_sums_avx512(sums, beams, loud))
}

#[target_feature(enable = "avx2")]
pub(super) fn entropy_avx2(cells: &[f32; TILE], admissible: &[f32; TILE], terms: [f32; 2]) -> f64 {
    kernel::entropy(cells, admissible, terms)
}

#[target_feature(enable = "avx512f,avx512bw,avx512vbmi")]
pub(super) fn entropy_avx512(cells: &[f32; TILE], admissible: &[f32; TILE], terms: [f32; 2]) -> f64 {
    kernel::entropy(cells, admissible, terms)
}

#[target_feature(enable = "avx2")]
pub(super) fn spread_avx2(wider: &Wider, spread: [f32; 2], cells: &mut [f32; TILE]) {
    kernel::spread(wider, spread, cells);
}

#[target_feature(enable = "avx512f,avx512bw,avx512vbmi")]
pub(super) fn spread_avx512(wider: &Wider, spread: [f32; 2], cells: &mut [f32; TILE]) {
    kernel::spread(wider, spread, cells);
}

#[target_feature(enable = "avx2")]
pub(super) fn blend_avx2(planes: [&[f32; TILE]; 3], spread: f32, cells: &mut [f32; TILE]) {
    kernel::blend(planes, spread, cells);
}

#[target_feature(enable = "avx512f,avx512bw,avx512vbmi")]
pub(super) fn blend_avx512(planes: [&[f32; TILE]; 3], spread: f32, cells: &mut [f32; TILE]) {
    kernel::blend(planes, spread, cells);
}

/// 32 values of a table of 256 at once: sixteen shuffles, each in a sixteenth of the table by
/// the low half of the index, and a tree of choices by the bits of the high half.
#[target_feature(enable = "avx2")]
#[inline]
fn look_up_avx2(table: &[__m256i; 16], index: __m256i) -> __m256i {
    // A set highest bit makes a shuffle give 0, so only the low half is left.
    let low = _mm256_and_si256(index, _mm256_set1_epi8(0x0f));
    let sixteenth = |part: usize| _mm256_shuffle_epi8(table[part], low);
    // Bit 4, 5, 6 and 7 as the highest of each byte, by which the blends choose.
    let (bit4, bit5) = (_mm256_slli_epi16::<3>(index), _mm256_slli_epi16::<2>(index));
    let bit6 = _mm256_slli_epi16::<1>(index);
    let two = |part: usize| _mm256_blendv_epi8(sixteenth(part), sixteenth(part + 1), bit4);
    let four = |part: usize| _mm256_blendv_epi8(two(part), two(part + 2), bit5);
    let eight = |part: usize| _mm256_blendv_epi8(four(part), four(part + 4), bit6);
    _mm256_blendv_epi8(eight(0), eight(8), index)
}

#[target_feature(enable = "avx2")]
#[inline]
fn load_256(bytes: &[u8; 32]) -> __m256i {
    // SAFETY: 32 bytes are there, and the load needs no alignment.
    unsafe { _mm256_loadu_si256(bytes.as_ptr().cast()) }
}

#[target_feature(enable = "avx2")]
#[inline]
fn load_sums(sums: &[u16; 16]) -> __m256i {
    // SAFETY: 32 bytes are there, and the load needs no alignment.
    unsafe { _mm256_loadu_si256(sums.as_ptr().cast()) }
}

#[target_feature(enable = "avx2")]
#[inline]
fn store_sums(sums: &mut [u16; 16], value: __m256i) {
    // SAFETY: 32 bytes are there, and the store needs no alignment.
    unsafe { _mm256_storeu_si256(sums.as_mut_ptr().cast(), value) }
}

/// A table with each sixteenth in both halves of a register.
#[target_feature(enable = "avx2")]
#[inline]
fn spread_table(costs: &[u8; 256]) -> [__m256i; 16] {
    let mut table = [_mm256_setzero_si256(); 16];
    for (register, sixteenth) in table.iter_mut().zip(costs.as_chunks::<16>().0) {
        let mut twice = [0; 32];
        twice[..16].copy_from_slice(sixteenth);
        twice[16..].copy_from_slice(sixteenth);
        *register = load_256(&twice);
    }
    table
}

#[target_feature(enable = "avx2")]
fn cost_sums_avx2(sums: &mut CostSums, beams: &[[Beam; TOGETHER]], loud: &[usize]) {
    let once = _mm256_set1_epi8(1);
    for two in beams.as_flattened().as_chunks::<2>().0 {
        let tables = two.map(|beam| spread_table(beam.costs));
        let expected = two.map(|beam| beam.expected.map(|bins| bins.as_chunks::<BLOCK>().0));
        for (sums, &block) in sums.iter_mut().zip(loud) {
            for (half, sums) in sums.as_chunks_mut::<32>().0.iter_mut().enumerate() {
                let at = |beam: usize| {
                    let [one, other] = expected[beam].map(|blocks| load_256(&blocks[block].as_chunks::<32>().0[half]));
                    _mm256_min_epu8(one, other)
                };
                let a = look_up_avx2(&tables[0], at(0));
                let b = look_up_avx2(&tables[1], at(1));
                // Bytes 0..8 and 16..24 of the registers are in `low`, the others in `high`.
                let low = _mm256_maddubs_epi16(_mm256_unpacklo_epi8(a, b), once);
                let high = _mm256_maddubs_epi16(_mm256_unpackhi_epi8(a, b), once);
                let first = _mm256_permute2x128_si256::<0x20>(low, high);
                let second = _mm256_permute2x128_si256::<0x31>(low, high);
                let [head, tail] = sums.as_chunks_mut::<16>().0 else { continue };
                store_sums(head, _mm256_add_epi16(load_sums(head), first));
                store_sums(tail, _mm256_add_epi16(load_sums(tail), second));
            }
        }
    }
}

// The operations of lanes are inlined into the functions above, which ask for the instructions,
// and nothing else names these types.

impl Float for __m512 {
    #[inline(always)]
    fn all(value: f32) -> Self {
        // SAFETY: used where AVX-512 was found only.
        unsafe { _mm512_set1_ps(value) }
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        // SAFETY: as above.
        unsafe { _mm512_add_ps(self, other) }
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        // SAFETY: as above.
        unsafe { _mm512_sub_ps(self, other) }
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        // SAFETY: as above.
        unsafe { _mm512_mul_ps(self, other) }
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        // SAFETY: as above.
        unsafe { _mm512_max_ps(self, other) }
    }

    #[inline(always)]
    fn if_less(self, bound: Self, less: Self, not_less: Self) -> Self {
        // SAFETY: as above.
        unsafe { _mm512_mask_blend_ps(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(self, bound), not_less, less) }
    }

    #[inline(always)]
    fn to_power(self, power: Self) -> Self {
        // SAFETY: as above.
        unsafe {
            let power = _mm512_slli_epi32::<23>(_mm512_castps_si512(power));
            _mm512_castsi512_ps(_mm512_add_epi32(_mm512_castps_si512(self), power))
        }
    }
}

impl Lanes for __m512 {
    #[inline(always)]
    fn load(cells: &[f32; LANES]) -> Self {
        // SAFETY: as above; 64 bytes are there, and the load needs no alignment.
        unsafe { _mm512_loadu_ps(cells.as_ptr()) }
    }

    #[inline(always)]
    fn load_whole(numbers: &[u16; LANES]) -> Self {
        // SAFETY: as above; 32 bytes are there.
        unsafe { _mm512_cvtepi32_ps(_mm512_cvtepu16_epi32(_mm256_loadu_si256(numbers.as_ptr().cast()))) }
    }

    #[inline(always)]
    fn largest(self) -> f32 {
        // SAFETY: as above.
        unsafe { _mm512_reduce_max_ps(self) }
    }

    #[inline(always)]
    fn reaches(self, bound: Self) -> bool {
        // SAFETY: as above.
        unsafe { _mm512_cmp_ps_mask::<_CMP_GE_OQ>(self, bound) != 0 }
    }

    #[inline(always)]
    fn to_array(self) -> [f32; LANES] {
        let mut cells = [0.0; LANES];
        // SAFETY: as above; 64 bytes are there.
        unsafe { _mm512_storeu_ps(cells.as_mut_ptr(), self) };
        cells
    }

    #[inline(always)]
    fn fetch(cells: &[f32; BLOCK]) {
        for line in cells.as_chunks::<LANES>().0 {
            // SAFETY: the memory is there.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(line.as_ptr().cast()) };
        }
    }
}

impl Float for [__m256; 2] {
    #[inline(always)]
    fn all(value: f32) -> Self {
        // SAFETY: used where AVX2 was found only.
        unsafe { [_mm256_set1_ps(value); 2] }
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        // SAFETY: as above.
        unsafe { [_mm256_add_ps(self[0], other[0]), _mm256_add_ps(self[1], other[1])] }
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        // SAFETY: as above.
        unsafe { [_mm256_sub_ps(self[0], other[0]), _mm256_sub_ps(self[1], other[1])] }
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        // SAFETY: as above.
        unsafe { [_mm256_mul_ps(self[0], other[0]), _mm256_mul_ps(self[1], other[1])] }
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        // SAFETY: as above.
        unsafe { [_mm256_max_ps(self[0], other[0]), _mm256_max_ps(self[1], other[1])] }
    }

    #[inline(always)]
    fn if_less(self, bound: Self, less: Self, not_less: Self) -> Self {
        let mut chosen = not_less;
        for half in 0..2 {
            // SAFETY: as above.
            unsafe {
                let is_less = _mm256_cmp_ps::<_CMP_LT_OQ>(self[half], bound[half]);
                chosen[half] = _mm256_blendv_ps(not_less[half], less[half], is_less);
            }
        }
        chosen
    }

    #[inline(always)]
    fn to_power(self, power: Self) -> Self {
        let mut scaled = self;
        for half in 0..2 {
            // SAFETY: as above.
            unsafe {
                let power = _mm256_slli_epi32::<23>(_mm256_castps_si256(power[half]));
                scaled[half] = _mm256_castsi256_ps(_mm256_add_epi32(_mm256_castps_si256(self[half]), power));
            }
        }
        scaled
    }
}

impl Lanes for [__m256; 2] {
    #[inline(always)]
    fn load(cells: &[f32; LANES]) -> Self {
        let (head, tail) = cells.split_at(8);
        // SAFETY: as above; 32 bytes are in each, and the load needs no alignment.
        unsafe { [_mm256_loadu_ps(head.as_ptr()), _mm256_loadu_ps(tail.as_ptr())] }
    }

    #[inline(always)]
    fn load_whole(numbers: &[u16; LANES]) -> Self {
        let (head, tail) = numbers.split_at(8);
        // SAFETY: as above; 16 bytes are in each.
        unsafe {
            let halves = [_mm_loadu_si128(head.as_ptr().cast()), _mm_loadu_si128(tail.as_ptr().cast())];
            let [head, tail] = [_mm256_cvtepu16_epi32(halves[0]), _mm256_cvtepu16_epi32(halves[1])];
            [_mm256_cvtepi32_ps(head), _mm256_cvtepi32_ps(tail)]
        }
    }

    #[inline(always)]
    fn largest(self) -> f32 {
        // SAFETY: as above.
        unsafe {
            let eight = _mm256_max_ps(self[0], self[1]);
            let four = _mm_max_ps(_mm256_castps256_ps128(eight), _mm256_extractf128_ps::<1>(eight));
            let two = _mm_max_ps(four, _mm_movehl_ps(four, four));
            _mm_cvtss_f32(_mm_max_ss(two, _mm_shuffle_ps::<1>(two, two)))
        }
    }

    #[inline(always)]
    fn reaches(self, bound: Self) -> bool {
        // SAFETY: as above.
        unsafe {
            let head = _mm256_cmp_ps::<_CMP_GE_OQ>(self[0], bound[0]);
            let tail = _mm256_cmp_ps::<_CMP_GE_OQ>(self[1], bound[1]);
            _mm256_movemask_ps(_mm256_or_ps(head, tail)) != 0
        }
    }

    #[inline(always)]
    fn fetch(cells: &[f32; BLOCK]) {
        for line in cells.as_chunks::<LANES>().0 {
            // SAFETY: the memory is there.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(line.as_ptr().cast()) };
        }
    }

    #[inline(always)]
    fn to_array(self) -> [f32; LANES] {
        let mut cells = [0.0; LANES];
        let (head, tail) = cells.split_at_mut(8);
        // SAFETY: as above; 32 bytes are in each.
        unsafe {
            _mm256_storeu_ps(head.as_mut_ptr(), self[0]);
            _mm256_storeu_ps(tail.as_mut_ptr(), self[1]);
        }
        cells
    }
}

#[target_feature(enable = "avx512f")]
#[inline]
fn load_512(bytes: &[u8; 64]) -> __m512i {
    // SAFETY: 64 bytes are there, and the load needs no alignment.
    unsafe { _mm512_loadu_si512(bytes.as_ptr().cast()) }
}

#[target_feature(enable = "avx512f")]
#[inline]
fn load_halves(sums: &[u16; BLOCK]) -> [__m512i; 2] {
    let [low, high] = sums.as_chunks::<32>().0 else { return [_mm512_setzero_si512(); 2] };
    // SAFETY: each is 64 bytes, and the load needs no alignment.
    unsafe { [_mm512_loadu_si512(low.as_ptr().cast()), _mm512_loadu_si512(high.as_ptr().cast())] }
}

#[target_feature(enable = "avx512f")]
#[inline]
fn store_halves(sums: &mut [u16; BLOCK], values: [__m512i; 2]) {
    let [low, high] = sums.as_chunks_mut::<32>().0 else { return };
    // SAFETY: each is 64 bytes, and the store needs no alignment.
    unsafe {
        _mm512_storeu_si512(low.as_mut_ptr().cast(), values[0]);
        _mm512_storeu_si512(high.as_mut_ptr().cast(), values[1]);
    }
}

/// 64 values of a table of 256 at once: one look-up in either half of the table by the low seven
/// bits of the index, and a choice by the highest.
#[target_feature(enable = "avx512f,avx512bw,avx512vbmi")]
#[inline]
fn look_up_avx512(table: &[__m512i; 4], index: __m512i) -> __m512i {
    let low = _mm512_permutex2var_epi8(table[0], index, table[1]);
    let high = _mm512_permutex2var_epi8(table[2], index, table[3]);
    _mm512_mask_blend_epi8(_mm512_movepi8_mask(index), low, high)
}

#[target_feature(enable = "avx512f,avx512bw,avx512vbmi")]
fn cost_sums_avx512(sums: &mut CostSums, beams: &[[Beam; TOGETHER]], loud: &[usize]) {
    let once = _mm512_set1_epi8(1);
    for four in beams {
        let table = |beam: &Beam| -> [__m512i; 4] {
            let quarters = beam.costs.as_chunks::<64>().0;
            [load_512(&quarters[0]), load_512(&quarters[1]), load_512(&quarters[2]), load_512(&quarters[3])]
        };
        let expected = [four[0].expected, four[1].expected, four[2].expected, four[3].expected];
        let [a, b, c, d] = [table(&four[0]), table(&four[1]), table(&four[2]), table(&four[3])];
        for (sums, &block) in sums.iter_mut().zip(loud) {
            let at = |beam: usize| {
                let [one, other] = expected[beam].map(|bins| load_512(&bins.as_chunks().0[block]));
                _mm512_min_epu8(one, other)
            };
            let a = look_up_avx512(&a, at(0));
            let b = look_up_avx512(&b, at(1));
            let c = look_up_avx512(&c, at(2));
            let d = look_up_avx512(&d, at(3));
            // Two bytes side by side, each times one, and their sum in 16 bits.
            let low = |a, b| _mm512_maddubs_epi16(_mm512_unpacklo_epi8(a, b), once);
            let high = |a, b| _mm512_maddubs_epi16(_mm512_unpackhi_epi8(a, b), once);
            let [before_low, before_high] = load_halves(sums);
            let sum_low = _mm512_add_epi16(before_low, _mm512_add_epi16(low(a, b), low(c, d)));
            let sum_high = _mm512_add_epi16(before_high, _mm512_add_epi16(high(a, b), high(c, d)));
            store_halves(sums, [sum_low, sum_high]);
        }
    }
    // `low` holds bytes 0..8 of each quarter of a register, `high` bytes 8..16.
    let first = _mm512_set_epi64(11, 10, 3, 2, 9, 8, 1, 0);
    let second = _mm512_set_epi64(15, 14, 7, 6, 13, 12, 5, 4);
    for sums in sums.iter_mut().take(loud.len()) {
        let [low, high] = load_halves(sums);
        let ordered = [_mm512_permutex2var_epi64(low, first, high), _mm512_permutex2var_epi64(low, second, high)];
        store_halves(sums, ordered);
    }
}
