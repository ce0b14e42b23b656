//! Keys of hash tables, compared by content.

use crate::state::block::{block, entry};
use crate::state::heap::Heap;
use crate::state::value::Value;
use rpl_lang::symbol::Symbol;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;
use std::sync::Arc;

/// A part of a key.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
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
    /// Any other object, by identity.
    Object(u8, u32, u32),
}

/// A key of a hash table, compared by content: two keys are the same if they are `equal`. A list is
/// its parts, each pair before its halves: comparing or dropping one costs no Rust stack.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Key {
    /// No list.
    Atom(KeyPart),
    /// A list.
    List(Box<[KeyPart]>),
}

impl Key {
    /// Its parts, outermost first.
    pub fn parts(&self) -> &[KeyPart] {
        match self {
            Key::Atom(part) => std::slice::from_ref(part),
            Key::List(parts) => parts,
        }
    }
}

impl PartialEq for Key {
    fn eq(&self, other: &Self) -> bool {
        self.parts() == other.parts()
    }
}

impl Eq for Key {}

impl PartialOrd for Key {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Key {
    fn cmp(&self, other: &Self) -> Ordering {
        self.parts().cmp(other.parts())
    }
}

/// Pairs a key may have. A list that shares its parts can be far larger than the memory it takes.
pub const MAX_KEY_PAIRS: usize = 100_000;

/// Bytes of an entry of a hash table.
pub fn table_entry(key: &Key) -> usize {
    let parts = match key {
        Key::Atom(_) => 0,
        Key::List(parts) => block(std::mem::size_of_val::<[KeyPart]>(parts)),
    };
    entry::<(Key, (Value, Value))>() + parts
}

impl Heap {
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
