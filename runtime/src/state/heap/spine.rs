//! Lists walked through, circles included.

use super::store::Heap;
use crate::state::value::Value;

/// The pairs of a list from the front; ends also where the list has been once round a circle.
pub struct Spine<'h> {
    heap: &'h Heap,
    at: Value,
    passed: usize,
    /// A pair that was passed, to be met again if the list is a circle; further on each time, so
    /// that it comes to lie in the circle (Brent).
    anchor: u32,
    /// Pairs from the anchor to here, and how many before the next anchor.
    since_anchor: usize,
    stride: usize,
}

impl Spine<'_> {
    /// What follows the pairs passed so far: a pair only if the list is a circle, or is not walked to
    /// its end.
    pub fn rest(&self) -> Value {
        self.at
    }

    /// How many pairs were passed.
    pub fn passed(&self) -> usize {
        self.passed
    }

    /// How many pairs the circle has that ended the walk; none if it was none.
    pub fn circle(&self) -> Option<usize> {
        (self.at == Value::Cons(self.anchor)).then_some(self.since_anchor)
    }
}

impl Iterator for Spine<'_> {
    /// The pair itself and its first half.
    type Item = (u32, Value);

    #[inline(always)]
    fn next(&mut self) -> Option<(u32, Value)> {
        let Value::Cons(pair) = self.at else { return None };
        if pair == self.anchor {
            return None;
        }
        if self.since_anchor == self.stride {
            (self.anchor, self.since_anchor, self.stride) = (pair, 0, self.stride * 2);
        }
        self.at = self.heap.pairs.cdr(pair);
        self.since_anchor += 1;
        self.passed += 1;
        Some((pair, *self.heap.pairs.car(pair)))
    }
}

impl Heap {
    /// The pairs of a list from the front.
    pub fn spine(&self, list: Value) -> Spine<'_> {
        Spine { heap: self, at: list, passed: 0, anchor: u32::MAX, since_anchor: 0, stride: 1 }
    }

    /// The length of a proper list.
    ///
    /// # Errors
    /// The value found where a list was expected: the argument itself, or an improper tail.
    pub fn length(&self, list: Value) -> Result<usize, Value> {
        let mut spine = self.spine(list);
        let length = spine.by_ref().count();
        match spine.rest() {
            Value::Nil => Ok(length),
            Value::Cons(_) => Err(list),
            tail => Err(tail),
        }
    }

    /// The elements of a proper list.
    ///
    /// # Errors
    /// The value found where a list was expected: the argument itself, or an improper tail.
    pub fn elements(&self, list: Value) -> Result<Vec<Value>, Value> {
        Ok(self.first_elements(list, self.length(list)?))
    }

    /// The first `count` elements of a list; all, if it has fewer and is no circle.
    pub fn first_elements(&self, list: Value, count: usize) -> Vec<Value> {
        let mut items = Vec::with_capacity(count);
        let mut at = list;
        while let Value::Cons(pair) = at
            && items.len() < count
        {
            items.push(*self.pairs.car(pair));
            at = self.pairs.cdr(pair);
        }
        items
    }
}
