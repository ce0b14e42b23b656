//! Rust stack for what recurses over forms, which nest deeper than the stack of a thread is.

/// Stack that is left for what `inside` calls before it comes here again.
const RED_ZONE_BYTES: usize = 128 * 1024;

/// What is taken when less is left.
const SEGMENT_BYTES: usize = 2 * 1024 * 1024;

/// Runs one level of a recursion, on new stack if little is left.
pub(crate) fn deep<T>(inside: impl FnOnce() -> T) -> T {
    stacker::maybe_grow(RED_ZONE_BYTES, SEGMENT_BYTES, inside)
}
