//! Lengths and stretches in an arena.

/// Lengths in an arena, in whole millimetres.
pub type Millimetres = i64;

/// From and to.
pub(crate) type Interval = (Millimetres, Millimetres);
