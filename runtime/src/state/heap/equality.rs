//! Equality by content, of circular data as well.

use super::store::Heap;
use crate::state::value::Value;
use std::collections::BTreeMap;

/// With more pairs and vectors compared than this, or than there are, parts are taken to be shared.
const MAX_PLAIN_STEPS: usize = 1_000_000;

/// What is compared by its parts.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Whole {
    Pair(u32),
    Vector(u32),
}

/// Wholes that are equal unless a difference is found elsewhere: each is compared with one of its
/// like only, so that shared parts are looked at once and circles come to an end.
#[derive(Default)]
struct Alike {
    /// From a whole towards the one that stands for its like.
    towards: BTreeMap<Whole, Whole>,
}

impl Alike {
    fn leader(&mut self, whole: Whole) -> Whole {
        let mut at = whole;
        while let Some(&next) = self.towards.get(&at) {
            // Each one on the way is led past the next one.
            if let Some(&beyond) = self.towards.get(&next) {
                self.towards.insert(at, beyond);
            }
            at = next;
        }
        at
    }

    /// Takes two wholes for equal; tells whether that is new.
    fn unite(&mut self, left: Whole, right: Whole) -> bool {
        let (left, right) = (self.leader(left), self.leader(right));
        if left != right {
            self.towards.insert(left, right);
        }
        left != right
    }
}

/// What is left to compare.
enum ToCompare {
    Values(Value, Value),
    /// Two vectors of one length, from a position on.
    Elements(u32, u32, usize),
}

impl Heap {
    /// Structural equality: same type and same content.
    #[inline]
    pub fn equal(&self, left: Value, right: Value) -> bool {
        self.compared(left, right).0
    }

    /// Structural equality, and how many pairs and elements were looked at to know it.
    #[inline(always)]
    pub fn compared(&self, left: Value, right: Value) -> (bool, usize) {
        match (left, right) {
            (Value::Cons(_), Value::Cons(_)) | (Value::Vector(_), Value::Vector(_)) => {
                self.compared_by_content(left, right)
            }
            (left, right) => (self.are_equal_atoms(left, right), 0),
        }
    }

    /// The same for values one of which has no parts.
    #[inline(always)]
    fn are_equal_atoms(&self, left: Value, right: Value) -> bool {
        match (left, right) {
            (Value::Str(a), Value::Str(b)) => a == b || self.strings[a] == self.strings[b],
            (Value::Float(a), Value::Float(b)) => a == b || a.is_nan() && b.is_nan(),
            (left, right) => left == right,
        }
    }

    fn compared_by_content(&self, left: Value, right: Value) -> (bool, usize) {
        let mut waiting = vec![ToCompare::Values(left, right)];
        let mut steps = 0usize;
        let plain = (self.pairs.places() + self.vectors.slots()).min(MAX_PLAIN_STEPS);
        let mut wholes = 0;
        let mut alike = Alike::default();
        let mut is_new = |left, right| {
            wholes += 1;
            wholes <= plain || alike.unite(left, right)
        };
        while let Some(next) = waiting.pop() {
            let (left, right) = match next {
                ToCompare::Values(left, right) => (left, right),
                ToCompare::Elements(a, b, at) => {
                    let elements = (self.vectors[a].elements().get(at), self.vectors[b].elements().get(at));
                    let (Some(&left), Some(&right)) = elements else { continue };
                    steps += 1;
                    waiting.push(ToCompare::Elements(a, b, at + 1));
                    (left, right)
                }
            };
            match (left, right) {
                (Value::Cons(a), Value::Cons(b)) if a != b => {
                    steps += 1;
                    if !is_new(Whole::Pair(a), Whole::Pair(b)) {
                        continue;
                    }
                    let (a, b) = (self.pair(a), self.pair(b));
                    waiting.push(ToCompare::Values(a.1, b.1));
                    waiting.push(ToCompare::Values(a.0, b.0));
                }
                (Value::Vector(a), Value::Vector(b)) if a != b => {
                    if self.vectors[a].elements().len() != self.vectors[b].elements().len() {
                        return (false, steps);
                    }
                    if is_new(Whole::Vector(a), Whole::Vector(b)) {
                        waiting.push(ToCompare::Elements(a, b, 0));
                    }
                }
                (left, right) => {
                    if !self.are_equal_atoms(left, right) {
                        return (false, steps);
                    }
                }
            }
        }
        (true, steps)
    }
}
