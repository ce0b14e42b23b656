//! How much all expansions of one text may make together.
//!
//! A macro that uses itself twice doubles what it makes with each turn: two lines of a text can ask for
//! more than any machine has.

/// Parts that the expansions of a text may make, however short it is; and as many more for each part
/// that stands in it.
const PARTS_OF_A_TEXT: usize = 1_000_000;
const PARTS_FOR_A_PART: usize = 16;

/// What the expansions of a text may still make, and how deep they are.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Expansion {
    /// Expansions whose result is being resolved.
    pub(super) in_a_row: u32,
    /// Parts that were made.
    pub(super) made: usize,
    /// Parts that may be made.
    pub(super) most: usize,
    /// Whether more were asked for.
    pub(super) lacks_room: bool,
    /// Whether too much was asked for, parts, steps or depth: that was told, and nothing more is expanded.
    pub(super) is_over: bool,
}

impl Expansion {
    /// What a text may make.
    pub(super) fn of_text() -> Self {
        Self::of_datum(PARTS_OF_A_TEXT)
    }

    /// What a datum may make: this many parts.
    pub(super) fn of_datum(parts: usize) -> Self {
        Self { most: parts, ..Self::default() }
    }

    /// This many parts were read.
    pub(super) fn has_read(&mut self, parts: usize) {
        self.most += parts * PARTS_FOR_A_PART;
    }

    /// This many parts were read that had been read before. Whether they may be.
    pub(super) fn has_read_again(&mut self, parts: usize) -> bool {
        self.made += parts;
        self.made <= self.most
    }
}
