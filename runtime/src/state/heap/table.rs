//! Hash tables: entries found by the hash of their keys.

use super::key::{Key, KeyPart, KeyParts, are_equal_atoms, atom_hash, compound_hash, key_parts};
use super::text::Text;
use crate::state::slab::Slab;
use crate::state::value::Value;
use hashbrown::HashTable;
use hashbrown::hash_table::Entry as IndexEntry;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The texts of a heap, by which keys that are strings are told apart.
type Strings = Slab<Text>;

/// An entry of a hash table, with key and value as the plan gave them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    pub(super) hash: u64,
    /// The key.
    pub key: Value,
    /// The value.
    pub value: Value,
    /// What a list or vector was when it became the key. In a box of its own, for the sake of the others.
    #[allow(clippy::redundant_allocation, reason = "half as large in the entry, and few entries have one")]
    pub(super) parts: Option<Box<KeyParts>>,
}

impl Entry {
    /// Whether it is found by a key.
    fn is_of(&self, strings: &Strings, key: &Key) -> bool {
        match (&self.parts, &key.parts) {
            (None, None) => are_equal_atoms(strings, &self.key, &key.value),
            (Some(own), Some(other)) => ***own == **other,
            _ => false,
        }
    }

    /// Whether it is found by an integer.
    #[inline]
    fn is_of_int(&self, key: i64) -> bool {
        matches!(self.key, Value::Int(own) if own == key)
    }

    /// Bytes it takes.
    pub(crate) fn bytes(&self) -> usize {
        entry_bytes(self.parts.as_deref().map(|parts| &**parts))
    }

    /// Whether it can be found where its key says, as can be doubted of one that was read from a file.
    pub(crate) fn is_whole(&self, strings: &Strings) -> bool {
        match (self.key, &self.parts) {
            (Value::Cons(_) | Value::Vector(_), Some(parts)) => compound_hash(parts) == self.hash,
            (Value::Cons(_) | Value::Vector(_), None) | (_, Some(_)) => false,
            (atom, None) => atom_hash(strings, &atom) == self.hash,
        }
    }
}

/// Bytes of an entry of a hash table whose key has no parts, or such.
pub(super) fn entry_bytes(parts: Option<&[KeyPart]>) -> usize {
    // A table has room for up to twice its entries, and as many places and bytes in its index, seven eighths of them used.
    2 * (size_of::<Entry>() + size_of::<u32>() + 2) + key_parts(parts)
}

/// Bytes of an entry of a hash table.
pub fn table_entry(key: &Key) -> usize {
    entry_bytes(key.parts.as_deref())
}

/// A hash table. Its entries stand in the order in which they came, or another that depends on nothing but what was
/// entered and removed; plans see them in the order of their keys.
#[derive(Clone, Debug, Default)]
pub struct Table {
    entries: Vec<Entry>,
    /// Where entries stand, by their hash.
    index: HashTable<u32>,
    /// Where the entry stood that an instruction found last: the next one often assigns what this one has read. Only a
    /// guess, and no part of the state.
    last: u32,
    /// It never changes.
    is_frozen: bool,
}

impl Table {
    /// Whether it never changes.
    #[inline]
    pub fn is_frozen(&self) -> bool {
        self.is_frozen
    }

    /// From now on it never changes; tells whether it could until now.
    pub(super) fn freeze(&mut self) -> bool {
        !std::mem::replace(&mut self.is_frozen, true)
    }

    /// A copy that can be changed.
    #[must_use]
    pub fn thawed(&self) -> Self {
        Self { is_frozen: false, ..self.clone() }
    }

    /// How many entries it has.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether it has none.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Its entries, in no order that means anything.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    fn place(&self, strings: &Strings, key: &Key) -> Option<usize> {
        let is_there = |&place: &u32| self.entries[place as usize].is_of(strings, key);
        self.index.find(key.hash, is_there).map(|&place| place as usize)
    }

    /// The entry that was found last, if it is that of a key: the same integer, or the same string and not only an equal
    /// one.
    #[inline]
    pub(super) fn last_mut(&mut self, of: &Value) -> Option<&mut Entry> {
        let entry = self.entries.get_mut(self.last as usize)?;
        let is_same = match (&entry.key, of) {
            (Value::Int(own), Value::Int(of)) => own == of,
            (Value::Str(own), Value::Str(of)) => own == of,
            _ => false,
        };
        is_same.then_some(entry)
    }

    /// The value of a key without parts.
    #[inline]
    pub(super) fn atom(&mut self, strings: &Strings, of: &Value, hash: u64) -> Option<&Value> {
        let entries = &self.entries;
        // In each of the two the comparison is seen by the compiler.
        let found = match *of {
            Value::Int(of) => self.index.find(hash, |&place| entries[place as usize].is_of_int(of)),
            _ => self.index.find(hash, |&place| are_equal_atoms(strings, &entries[place as usize].key, of)),
        };
        let place = *found?;
        self.last = place;
        Some(&entries[place as usize].value)
    }

    /// Sets the value of a key without parts; tells whether that is a new entry.
    #[inline]
    pub(super) fn set_atom(&mut self, strings: &Strings, of: &Value, hash: u64, value: &Value) -> bool {
        let entries = &self.entries;
        let hash_at = |&place: &u32| entries[place as usize].hash;
        let place = match *of {
            Value::Int(of) => self.index.entry(hash, |&place| entries[place as usize].is_of_int(of), hash_at),
            _ => self.index.entry(hash, |&place| are_equal_atoms(strings, &entries[place as usize].key, of), hash_at),
        };
        match place {
            IndexEntry::Occupied(place) => {
                let entry = &mut self.entries[*place.get() as usize];
                entry.key.set(of);
                entry.value.set(value);
                false
            }
            IndexEntry::Vacant(place) => {
                place.insert(entries.len() as u32);
                self.entries.push(Entry { hash, key: of.copied(), value: value.copied(), parts: None });
                true
            }
        }
    }

    fn add(&mut self, entry: Entry) {
        let (hash, place) = (entry.hash, self.entries.len() as u32);
        self.entries.push(entry);
        self.index.insert_unique(hash, place, |&place| self.entries[place as usize].hash);
    }

    /// The value of a key.
    pub fn get(&self, strings: &Strings, key: &Key) -> Option<Value> {
        self.place(strings, key).map(|place| self.entries[place].value.copied())
    }

    /// Sets the value of a key; tells whether that is a new entry.
    pub fn insert(&mut self, strings: &Strings, key: Key, value: Value) -> bool {
        if let Some(place) = self.place(strings, &key) {
            let entry = &mut self.entries[place];
            (entry.key, entry.value) = (key.value, value);
            return false;
        }
        let Key { value: of, hash, parts } = key;
        self.add(Entry { hash, key: of, value, parts: parts.map(Box::new) });
        true
    }

    /// Removes the entry of a key; tells whether there was one. The last entry takes its place, and room that is no longer
    /// needed is given back.
    pub fn remove(&mut self, strings: &Strings, key: &Key) -> bool {
        let Some(place) = self.place(strings, key) else { return false };
        if let Ok(found) = self.index.find_entry(key.hash, |&at| at as usize == place) {
            found.remove();
        }
        self.entries.swap_remove(place);
        let last = self.entries.len();
        if let Some(moved) = self.entries.get(place)
            && let Some(at) = self.index.find_mut(moved.hash, |&at| at as usize == last)
        {
            *at = place as u32;
        }
        if last < self.entries.capacity() / 4 {
            self.entries.shrink_to(2 * last);
            self.index.shrink_to(2 * last, |&place| self.entries[place as usize].hash);
        }
        true
    }

    /// Removes all entries.
    pub fn clear(&mut self) {
        *self = Self::default();
    }
}

impl PartialEq for Table {
    fn eq(&self, other: &Self) -> bool {
        self.entries == other.entries && self.is_frozen == other.is_frozen
    }
}

impl Serialize for Table {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (self.is_frozen, &self.entries).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Table {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (is_frozen, entries) = <(bool, Vec<Entry>)>::deserialize(deserializer)?;
        let mut index = HashTable::new();
        for (place, entry) in entries.iter().enumerate() {
            index.insert_unique(entry.hash, place as u32, |&place| entries[place as usize].hash);
        }
        Ok(Self { entries, index, last: 0, is_frozen })
    }
}
