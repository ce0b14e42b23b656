//! Vectors: elements by their position, shared by the copies of a run until one of them writes.

use crate::state::block::block;
use crate::state::value::Value;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::sync::Arc;

/// The elements of a vector.
#[derive(Debug)]
pub struct Vector(Elements);

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
        Self(Elements::Own(elements))
    }

    /// The elements.
    #[inline]
    pub fn elements(&self) -> &[Value] {
        match &self.0 {
            Elements::Own(elements) => elements,
            Elements::Shared(elements) => elements,
        }
    }

    /// The elements, to be written. Copies them if another copy of the run has them too.
    #[inline]
    pub fn elements_mut(&mut self) -> &mut [Value] {
        if let Elements::Shared(_) = self.0 {
            self.take_over();
        }
        match &mut self.0 {
            Elements::Own(elements) => elements,
            Elements::Shared(_) => &mut [],
        }
    }

    #[cold]
    fn take_over(&mut self) {
        if let Elements::Shared(elements) = &mut self.0 {
            let elements = Arc::unwrap_or_clone(std::mem::take(elements));
            self.0 = Elements::Own(elements);
        }
    }

    /// Lets the next copies of this vector have the same elements. O(1).
    pub fn share(&mut self) {
        if let Elements::Own(elements) = &mut self.0 {
            self.0 = Elements::Shared(Arc::new(std::mem::take(elements)));
        }
    }
}

impl Clone for Vector {
    fn clone(&self) -> Self {
        Self(match &self.0 {
            Elements::Own(elements) => Elements::Own(elements.clone()),
            Elements::Shared(elements) => Elements::Shared(elements.clone()),
        })
    }
}

impl PartialEq for Vector {
    fn eq(&self, other: &Self) -> bool {
        self.elements() == other.elements()
    }
}

impl Serialize for Vector {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.elements().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Vector {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Vec::deserialize(deserializer).map(Self::new)
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
