//! What the allocator takes for what is asked of it.

/// What the allocator takes for a block of `bytes` bytes.
pub(crate) fn block(bytes: usize) -> usize {
    if bytes == 0 { 0 } else { (bytes + 8).next_multiple_of(16).max(32) }
}

/// An entry of a tree of maps: its nodes are little more than half full when they are filled in order.
pub(crate) const fn entry<T>() -> usize {
    2 * size_of::<T>()
}
