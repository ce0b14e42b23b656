//! The order of integers and floats as numbers, without rounding either of them.

use std::cmp::Ordering;

/// Every integer up to this size is a float.
const EXACT: u64 = 1 << f64::MANTISSA_DIGITS;

/// How an integer stands to a float; none for NaN.
///
/// An order by rounded values would not be transitive: 2^53 + 1 is rounded to 2^53, and 2^53 is less.
#[inline]
pub fn order(integer: i64, float: f64) -> Option<Ordering> {
    if integer.unsigned_abs() <= EXACT {
        return (integer as f64).partial_cmp(&float);
    }
    match float {
        nan if nan.is_nan() => None,
        above if above >= -(i64::MIN as f64) => Some(Ordering::Less),
        below if below < i64::MIN as f64 => Some(Ordering::Greater),
        // What is cut off matters to no integer of this size.
        within => Some(integer.cmp(&(within as i64))),
    }
}
