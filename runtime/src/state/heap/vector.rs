//! Vectors: elements by their position, shared by the copies of a run until one of them writes.

use crate::state::block::block;
use crate::state::value::Value;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::sync::Arc;

/// The elements of a vector.
#[derive(Debug)]
pub struct Vector {
    elements: Elements,
    /// It never changes.
    is_frozen: bool,
}

/// Whose the elements are.
#[derive(Debug)]
enum Elements {
    /// This run's alone: they can be written at once.
    Own(Vec<Value>),
    /// Perhaps other copies' of this run too.
    Shared(Arc<Vec<Value>>),
}

impl Vector {
    /// A vector of these elements.
    pub fn new(elements: Vec<Value>) -> Self {
        Self { elements: Elements::Own(elements), is_frozen: false }
    }

    /// The elements.
    #[inline]
    pub fn elements(&self) -> &[Value] {
        match &self.elements {
            Elements::Own(elements) => elements,
            Elements::Shared(elements) => elements,
        }
    }

    /// Whether it never changes.
    #[inline]
    pub fn is_frozen(&self) -> bool {
        self.is_frozen
    }

    /// From now on it never changes; tells whether it could until now.
    pub(super) fn freeze(&mut self) -> bool {
        !std::mem::replace(&mut self.is_frozen, true)
    }

    /// The elements, to be written. Copies them if another copy of the run has them too.
    #[inline]
    pub fn elements_mut(&mut self) -> &mut [Value] {
        if let Elements::Shared(_) = self.elements {
            self.take_over();
        }
        match &mut self.elements {
            Elements::Own(elements) => elements,
            Elements::Shared(_) => &mut [],
        }
    }

    #[cold]
    fn take_over(&mut self) {
        if let Elements::Shared(elements) = &mut self.elements {
            let elements = Arc::unwrap_or_clone(std::mem::take(elements));
            self.elements = Elements::Own(elements);
        }
    }

    /// Lets the next copies of this vector have the same elements. O(1).
    pub fn share(&mut self) {
        if let Elements::Own(elements) = &mut self.elements {
            self.elements = Elements::Shared(Arc::new(std::mem::take(elements)));
        }
    }
}

impl Clone for Vector {
    fn clone(&self) -> Self {
        let elements = match &self.elements {
            Elements::Own(elements) => Elements::Own(elements.clone()),
            Elements::Shared(elements) => Elements::Shared(elements.clone()),
        };
        Self { elements, is_frozen: self.is_frozen }
    }
}

impl PartialEq for Vector {
    fn eq(&self, other: &Self) -> bool {
        self.elements() == other.elements() && self.is_frozen == other.is_frozen
    }
}

impl Serialize for Vector {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (self.is_frozen, self.elements()).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Vector {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (is_frozen, elements) = Deserialize::deserialize(deserializer)?;
        Ok(Self { elements: Elements::Own(elements), is_frozen })
    }
}

/// Bytes of the elements of a vector of a length.
pub fn vector_elements(length: usize) -> usize {
    block(length * size_of::<Value>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_have_the_same_elements_until_one_of_them_writes() {
        let mut vector = Vector::new(vec![Value::Int(1), Value::Int(2)]);
        vector.share();
        let mut copy = vector.clone();
        assert!(std::ptr::eq(vector.elements(), copy.elements()));
        copy.elements_mut()[0] = Value::True;
        assert_eq!(vector.elements(), [Value::Int(1), Value::Int(2)]);
        assert_eq!(copy.elements(), [Value::True, Value::Int(2)]);
        let alone = vector.elements().as_ptr();
        vector.elements_mut()[1] = Value::Nil;
        assert_eq!(vector.elements().as_ptr(), alone);
    }
}
