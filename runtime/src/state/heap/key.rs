//! Keys of hash tables, compared by content.

use crate::state::block::block;
use crate::state::value::Value;
use rpl_lang::symbol::Symbol;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;
use std::hash::{Hash, Hasher};
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
    /// A vector of so many elements, whose parts follow.
    Vector(u32),
    /// Any other object, by identity.
    Object(u8, u32, u32),
}

/// A key of a hash table, compared by content: two keys are the same if they are `equal`. A list or vector is
/// its parts, each whole before what it is made of: comparing or dropping one costs no Rust stack.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Key {
    /// What has no parts.
    Atom(KeyPart),
    /// A list or vector.
    Compound(Box<[KeyPart]>),
}

impl Key {
    /// Its parts, outermost first.
    pub fn parts(&self) -> &[KeyPart] {
        match self {
            Key::Atom(part) => std::slice::from_ref(part),
            Key::Compound(parts) => parts,
        }
    }
}

impl PartialEq for Key {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Key::Atom(left), Key::Atom(right)) => left == right,
            (left, right) => left.parts() == right.parts(),
        }
    }
}

impl Hash for Key {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.parts().iter().for_each(|part| part.hash(state));
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

/// Pairs and elements of vectors a key may have. What shares its parts can be far larger than the memory it takes.
pub const MAX_KEY_PARTS: usize = 100_000;

/// Bytes of an entry of a hash table.
pub fn table_entry(key: &Key) -> usize {
    let parts = match key {
        Key::Atom(_) => 0,
        Key::Compound(parts) => block(std::mem::size_of_val::<[KeyPart]>(parts)),
    };
    // With its hash; a table has room for up to twice its entries, and a place and a byte for each in its index.
    2 * (size_of::<(u64, Key, (Value, Value))>() + size_of::<usize>() + 1) + parts
}
