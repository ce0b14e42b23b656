//! Equality by content, of circular data as well.

use crate::state::heap::Heap;
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
}
