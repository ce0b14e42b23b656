//! The bytes of a saved run, as the values that they hold.

use serde::Deserialize;

/// A value, and the bytes behind it.
pub(super) fn taken<'b, T: Deserialize<'b>>(bytes: &'b [u8]) -> Result<(T, &'b [u8]), String> {
    postcard::take_from_bytes(bytes).map_err(|error| format!("its state is damaged: {error}"))
}

/// The last value in the bytes.
pub(super) fn read<'b, T: Deserialize<'b>>(bytes: &'b [u8]) -> Result<T, String> {
    taken(bytes).map(|(value, _)| value)
}
