//! What a closure has captured: few values stand in the closure itself.

use crate::state::block::block;
use crate::state::value::Value;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::ops::{Deref, DerefMut};

/// The most values that need no block of their own.
const FEW: usize = 2;

/// The values of a closure, as a slice.
#[derive(Clone, Debug)]
pub struct Captured(Place);

#[derive(Clone, Debug)]
enum Place {
    /// The number of values, and the values; nil behind them.
    Inside(u8, [Value; FEW]),
    Outside(Box<[Value]>),
}

impl Captured {
    /// Bytes beside the closure.
    pub(crate) fn bytes(&self) -> usize {
        match &self.0 {
            Place::Inside(..) => 0,
            Place::Outside(values) => block(std::mem::size_of_val::<[Value]>(values)),
        }
    }
}

impl Deref for Captured {
    type Target = [Value];

    #[inline]
    fn deref(&self) -> &[Value] {
        match &self.0 {
            Place::Inside(count, values) => &values[..usize::from(*count).min(FEW)],
            Place::Outside(values) => values,
        }
    }
}

impl DerefMut for Captured {
    fn deref_mut(&mut self) -> &mut [Value] {
        match &mut self.0 {
            Place::Inside(count, values) => &mut values[..usize::from(*count).min(FEW)],
            Place::Outside(values) => values,
        }
    }
}

impl FromIterator<Value> for Captured {
    #[inline]
    fn from_iter<I: IntoIterator<Item = Value>>(values: I) -> Self {
        let mut values = values.into_iter();
        let mut inside = [Value::Nil; FEW];
        for (count, place) in inside.iter_mut().enumerate() {
            match values.next() {
                Some(value) => *place = value,
                None => return Self(Place::Inside(count as u8, inside)),
            }
        }
        Self(match values.next() {
            None => Place::Inside(FEW as u8, inside),
            Some(next) => Place::Outside(inside.into_iter().chain([next]).chain(values).collect()),
        })
    }
}

impl PartialEq for Captured {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl Serialize for Captured {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (**self).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Captured {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Vec::<Value>::deserialize(deserializer).map(|values| values.into_iter().collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_number_of_values_is_kept_in_order() {
        for count in 0..6 {
            let values: Vec<Value> = (0..count).map(Value::Int).collect();
            let captured: Captured = values.iter().copied().collect();
            assert_eq!(*captured, *values);
            assert_eq!(captured, captured.clone());
            assert_eq!(captured.bytes() == 0, values.len() <= FEW);
        }
    }
}
