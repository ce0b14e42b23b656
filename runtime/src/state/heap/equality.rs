//! Equality by content, of circular data as well, and the keys it makes.

use super::key::{Key, KeyPart, MAX_KEY_PAIRS};
use super::store::Heap;
use crate::state::value::Value;
use std::collections::BTreeMap;

/// With more pairs compared than this, or than there are, parts are taken to be shared.
const MAX_PLAIN_STEPS: usize = 1_000_000;

/// Pairs that are equal unless a difference is found elsewhere: each is compared with one of its
/// like only, so that shared parts are looked at once and circles come to an end.
#[derive(Default)]
struct Alike {
    /// From a pair towards the one that stands for its like.
    towards: BTreeMap<u32, u32>,
}

impl Alike {
    fn leader(&mut self, pair: u32) -> u32 {
        let mut at = pair;
        while let Some(&next) = self.towards.get(&at) {
            // Each pair on the way is led past the next one.
            if let Some(&beyond) = self.towards.get(&next) {
                self.towards.insert(at, beyond);
            }
            at = next;
        }
        at
    }

    /// Takes two pairs for equal; tells whether that is new.
    fn unite(&mut self, left: u32, right: u32) -> bool {
        let (left, right) = (self.leader(left), self.leader(right));
        if left != right {
            self.towards.insert(left, right);
        }
        left != right
    }
}

impl Heap {
    /// Structural equality: same type and same content.
    #[inline]
    pub fn equal(&self, left: Value, right: Value) -> bool {
        self.compared(left, right).0
    }

    /// Structural equality, and how many pairs were looked at to know it.
    #[inline]
    pub fn compared(&self, left: Value, right: Value) -> (bool, usize) {
        match (left, right) {
            (Value::Str(_), Value::Str(_)) | (Value::Float(_), Value::Float(_)) | (Value::Cons(_), Value::Cons(_)) => {
                self.compared_by_content(left, right)
            }
            (left, right) => (left == right, 0),
        }
    }

    fn compared_by_content(&self, left: Value, right: Value) -> (bool, usize) {
        let mut waiting = vec![(left, right)];
        let mut steps = 0usize;
        let plain = self.pairs.len().min(MAX_PLAIN_STEPS);
        let mut alike = Alike::default();
        while let Some((left, right)) = waiting.pop() {
            match (left, right) {
                (Value::Cons(a), Value::Cons(b)) if a != b => {
                    steps += 1;
                    if steps > plain && !alike.unite(a, b) {
                        continue;
                    }
                    let (a, b) = (self.pair(a), self.pair(b));
                    waiting.push((a.1, b.1));
                    waiting.push((a.0, b.0));
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

    /// The key a value is found by; none if it has more than [`MAX_KEY_PAIRS`].
    pub fn key(&self, value: Value) -> Option<Key> {
        if !matches!(value, Value::Cons(_)) {
            return Some(Key::Atom(self.key_part(value)));
        }
        let (mut parts, mut waiting, mut pairs) = (Vec::new(), vec![value], 0);
        while let Some(value) = waiting.pop() {
            parts.push(self.key_part(value));
            if let Value::Cons(pair) = value {
                pairs += 1;
                if pairs > MAX_KEY_PAIRS {
                    return None;
                }
                let (car, cdr) = self.pair(pair);
                waiting.extend([cdr, car]);
            }
        }
        Some(Key::List(parts.into()))
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
            Value::Behaviour(index) => KeyPart::Object(9, u32::from(index), 0),
        }
    }
}
