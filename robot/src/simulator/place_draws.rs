//! Numbers left to chance that depend on nothing but a place: whoever comes back finds the same.

/// The numbers of a place, or of a thing.
#[derive(Clone, Copy)]
pub(super) struct PlaceDraws(u64);

impl PlaceDraws {
    pub fn new(seed: u64) -> Self {
        Self(mix(seed))
    }

    /// Those of the patch of this size around a coordinate.
    pub fn at(self, value: f64, size: f64) -> Self {
        self.of(libm::floor(value / size) as i64 as u64)
    }

    /// Those of a thing of this number.
    pub fn of(self, number: u64) -> Self {
        Self(mix(self.0 ^ number))
    }

    /// The next number, uniform in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        self.0 = mix(self.0);
        (self.0 >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }
}

/// The finalizer of SplitMix64: every bit of the input changes every bit of the output.
fn mix(value: u64) -> u64 {
    let value = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let value = (value ^ (value >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let value = (value ^ (value >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    value ^ (value >> 31)
}
