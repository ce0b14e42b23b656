//! Keys of hash tables, compared by content.

use super::text::{Text, text_hash};
use crate::state::block::block;
use crate::state::slab::Slab;
use crate::state::value::Value;
use foldhash::fast::FixedState;
use rpl_lang::symbol::Symbol;
use serde::{Deserialize, Serialize};
use std::hash::BuildHasher;
use std::sync::Arc;

/// A part of a key.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum KeyPart {
    /// `nil`
    Nil,
    /// `t`
    True,
    /// An integer.
    Int(i64),
    /// A float, by its bits.
    Float(u64),
    /// A symbol.
    Symbol(Symbol),
    /// A keyword.
    Keyword(Symbol),
    /// A string.
    Str(Arc<str>),
    /// A pair: the parts of its halves follow.
    Pair,
    /// A vector of this many elements, whose parts follow.
    Vector(u32),
    /// Any other object, by identity.
    Object(u8, u32, u32),
}

/// What a list or vector consists of when it becomes a key, each part whole before what it is made of: comparing or
/// dropping one costs no Rust stack. The list may change later, and its key does not.
pub type KeyParts = Box<[KeyPart]>;

/// A value as the key of a hash table, compared by content: two keys are the same if they are `equal`.
#[derive(Clone, Debug)]
pub struct Key {
    pub(super) value: Value,
    pub(super) hash: u64,
    /// Of a list or vector only: what has no parts is its value.
    pub(super) parts: Option<KeyParts>,
}

impl Key {
    /// Of how many parts it is.
    pub fn part_count(&self) -> usize {
        self.parts.as_ref().map_or(1, |parts| parts.len())
    }
}

/// Pairs and elements of vectors a key may have. What shares its parts can be far larger than the memory it takes.
pub const MAX_KEY_PARTS: usize = 100_000;

/// Bytes of the parts of a key.
pub(super) fn key_parts(parts: Option<&[KeyPart]>) -> usize {
    parts.map_or(0, |parts| block(std::mem::size_of_val::<[KeyPart]>(parts)))
}

/// The bits of a float as a key: `equal` takes both zeros for the same, and all that is not a number.
pub(super) fn float_bits(value: f64) -> u64 {
    match value {
        0.0 => 0,
        value if value.is_nan() => f64::NAN.to_bits(),
        value => value.to_bits(),
    }
}

/// Odd, with its bits spread evenly: 2⁶⁴ divided by the golden ratio (Knuth, The Art of Computer Programming 3, 6.4).
const SPREAD: u64 = 0x9E37_79B9_7F4A_7C15;

/// A hash of a number: both halves of a product, so that every bit of the number reaches every bit of the hash.
#[inline]
fn spread(number: u64, kind: u64) -> u64 {
    let product = u128::from(number ^ kind) * u128::from(SPREAD);
    (product >> 64) as u64 ^ product as u64
}

/// The bits of an integer that tell neighbours apart.
const NEAR_BITS: u32 = 6;

/// The hash of an integer. Keys are often neighbours, and are then made and asked for in turn; in a table, which looks where
/// the low bits of a hash say, and compares the highest seven before anything else, they lie side by side as well. Where
/// such a block of neighbours begins is spread, and that twice: blocks at equal distances are to meet by chance only.
#[inline]
fn int_hash(value: i64) -> u64 {
    let near = value as u64 % (1 << NEAR_BITS);
    let block = spread(value as u64 >> NEAR_BITS, SPREAD.rotate_left(1));
    spread(block, SPREAD.rotate_left(5)).wrapping_add(near << 57 | near)
}

/// The hash of a value that has no parts.
pub(super) fn atom_hash(strings: &Slab<Text>, value: &Value) -> u64 {
    match *value {
        Value::Str(text) => text_hash(&strings[text]),
        _ => hash_without_text(value),
    }
}

/// The same; that of a text is kept with it.
#[inline]
pub(super) fn kept_atom_hash(strings: &mut Slab<Text>, value: &Value) -> u64 {
    match *value {
        Value::Str(text) => strings[text].hash(),
        _ => hash_without_text(value),
    }
}

#[inline]
fn hash_without_text(value: &Value) -> u64 {
    match *value {
        Value::Int(value) => int_hash(value),
        _ => other_hash(value),
    }
}

fn other_hash(value: &Value) -> u64 {
    match *value {
        Value::Symbol(symbol) => spread(u64::from(symbol.0), SPREAD.rotate_left(2)),
        Value::Keyword(symbol) => spread(u64::from(symbol.0), SPREAD.rotate_left(3)),
        Value::Float(value) => spread(float_bits(value), SPREAD.rotate_left(4)),
        other => FixedState::default().hash_one(object(other)),
    }
}

/// The hash of a list or vector.
pub(super) fn compound_hash(parts: &[KeyPart]) -> u64 {
    FixedState::default().hash_one(parts)
}

/// Whether two values without parts are `equal`.
#[inline]
pub(super) fn are_equal_atoms(strings: &Slab<Text>, left: &Value, right: &Value) -> bool {
    match (left, right) {
        (Value::Int(left), Value::Int(right)) => left == right,
        (&Value::Str(left), &Value::Str(right)) => left == right || *strings[left] == *strings[right],
        (&Value::Float(left), &Value::Float(right)) => float_bits(left) == float_bits(right),
        (left, right) => left == right,
    }
}

/// A value that is compared by identity.
pub(super) fn object(value: Value) -> KeyPart {
    match value {
        Value::True => KeyPart::True,
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
        _ => KeyPart::Nil,
    }
}

#[cfg(test)]
mod tests {
    use super::int_hash;
    use std::collections::BTreeSet;

    /// How many groups of 16 places are looked at on average until a key finds its own, in a table that is as full as it gets.
    fn looks(keys: &[i64]) -> f64 {
        let groups = (keys.len() * 8 / 7 / 16).next_power_of_two();
        let mut used = vec![0; groups];
        let looks_for = |key: &i64| {
            let (mut group, mut looks) = (int_hash(*key) as usize / 16 % groups, 1);
            while used[group] == 16 {
                group = (group + looks) % groups;
                looks += 1;
            }
            used[group] += 1;
            looks
        };
        keys.iter().map(looks_for).sum::<usize>() as f64 / keys.len() as f64
    }

    #[test]
    fn integers_in_whatever_order_do_not_meet_at_one_place() {
        // Seven eighths of a power of two: the table is full.
        let count = 7 << 13;
        let steps = (0..44).flat_map(|power| [1_i64, 3, 7].map(|odd| odd << power));
        for step in steps {
            let keys: Vec<i64> = (0..count).map(|at| at * step).collect();
            assert!(looks(&keys) < 6.0, "{} looks for multiples of {step}", looks(&keys));
        }
        for (width, row) in
            [(256, 256), (100, 1000), (16, 1 << 16), (240, 1 << 32), (64, 1 << 40), (5, 1 << 20), (240, 1000)]
        {
            let keys: Vec<i64> = (0..count).map(|at| at / width * row + at % width - count / 2).collect();
            assert!(looks(&keys) < 6.0, "{} looks for rows of {width} at distances of {row}", looks(&keys));
        }
    }

    #[test]
    fn neighbours_are_told_apart_before_they_are_looked_at() {
        for first in [-16, 0, 16, 1 << 40] {
            let highest: BTreeSet<u64> = (first..first + 16).map(|key| int_hash(key) >> 57).collect();
            assert_eq!(highest.len(), 16, "from {first} on");
        }
    }
}
