//! Equality by content, of circular data as well, and the keys it makes.

use super::key::{Key, KeyPart, MAX_KEY_PARTS};
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
    #[inline]
    pub fn compared(&self, left: Value, right: Value) -> (bool, usize) {
        match (left, right) {
            (Value::Str(_), Value::Str(_))
            | (Value::Float(_), Value::Float(_))
            | (Value::Cons(_), Value::Cons(_))
            | (Value::Vector(_), Value::Vector(_)) => self.compared_by_content(left, right),
            (left, right) => (left == right, 0),
        }
    }

    fn compared_by_content(&self, left: Value, right: Value) -> (bool, usize) {
        let mut waiting = vec![ToCompare::Values(left, right)];
        let mut steps = 0usize;
        let plain = (self.pairs.len() + self.vectors.slots()).min(MAX_PLAIN_STEPS);
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
                (Value::Str(a), Value::Str(b)) => {
                    if self.strings[a] != self.strings[b] {
                        return (false, steps);
                    }
                }
                (Value::Float(a), Value::Float(b)) => {
                    if a != b && !(a.is_nan() && b.is_nan()) {
                        return (false, steps);
                    }
                }
                (left, right) => {
                    if left != right {
                        return (false, steps);
                    }
                }
            }
        }
        (true, steps)
    }

    /// The key a value is found by; none if it has more than [`MAX_KEY_PARTS`].
    pub fn key(&self, value: Value) -> Option<Key> {
        if !matches!(value, Value::Cons(_) | Value::Vector(_)) {
            return Some(Key::Atom(self.key_part(value)));
        }
        let (mut parts, mut waiting, mut count) = (Vec::new(), vec![value], 0);
        while let Some(value) = waiting.pop() {
            parts.push(self.key_part(value));
            count += match value {
                Value::Cons(_) => 1,
                Value::Vector(vector) => self.vectors[vector].elements().len() + 1,
                _ => 0,
            };
            if count > MAX_KEY_PARTS {
                return None;
            }
            match value {
                Value::Cons(pair) => {
                    let (car, cdr) = self.pair(pair);
                    waiting.extend([cdr, car]);
                }
                Value::Vector(vector) => waiting.extend(self.vectors[vector].elements().iter().rev()),
                _ => {}
            }
        }
        Some(Key::Compound(parts.into()))
    }

    fn key_part(&self, value: Value) -> KeyPart {
        match value {
            Value::Nil | Value::Unbound => KeyPart::Nil,
            Value::True => KeyPart::True,
            Value::Int(value) => KeyPart::Int(value),
            // `equal` takes both zeros for the same, and all that is not a number.
            Value::Float(0.0) => KeyPart::Float(0),
            Value::Float(value) if value.is_nan() => KeyPart::Float(f64::NAN.to_bits()),
            Value::Float(value) => KeyPart::Float(value.to_bits()),
            Value::Symbol(symbol) => KeyPart::Symbol(symbol),
            Value::Keyword(symbol) => KeyPart::Keyword(symbol),
            Value::Str(index) => KeyPart::Str(self.strings[index].clone()),
            Value::Cons(_) => KeyPart::Pair,
            Value::Cell(index) => KeyPart::Object(0, index, 0),
            Value::Function(index) => KeyPart::Object(1, index, 0),
            Value::Closure(index) => KeyPart::Object(2, index, 0),
            Value::Native(index) => KeyPart::Object(3, u32::from(index), 0),
            Value::Fluent(index) => KeyPart::Object(4, index, 0),
            Value::Task(task) => KeyPart::Object(5, task.index, task.generation),
            Value::Valve(index) => KeyPart::Object(6, index, 0),
            Value::Failure(index) => KeyPart::Object(7, index, 0),
            Value::Table(index) => KeyPart::Object(8, index, 0),
            Value::Vector(index) => KeyPart::Vector(self.vectors[index].elements().len() as u32),
            Value::Behaviour(index) => KeyPart::Object(9, u32::from(index), 0),
        }
    }
}
