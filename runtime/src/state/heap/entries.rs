//! Entries of the heap's tables, and the keys that they are found by.

use super::key::{Key, KeyPart, KeyParts, MAX_KEY_PARTS, atom_hash, compound_hash, float_bits, kept_atom_hash, object};
use super::store::Heap;
use super::table::{Entry, entry_bytes, table_entry};
use crate::state::value::Value;
use std::borrow::Cow;

/// Whether a value is found by its parts: a list or vector.
#[inline]
fn has_parts(value: &Value) -> bool {
    matches!(value, Value::Cons(_) | Value::Vector(_))
}

impl Heap {
    /// The key a value is found by; none if it has more than [`MAX_KEY_PARTS`].
    pub fn key(&self, value: Value) -> Option<Key> {
        if !has_parts(&value) {
            return Some(Key { value, hash: atom_hash(&self.strings, &value), parts: None });
        }
        let parts = self.key_parts(value)?;
        Some(Key { value, hash: compound_hash(&parts), parts: Some(parts) })
    }

    fn key_parts(&self, whole: Value) -> Option<KeyParts> {
        let (mut parts, mut waiting, mut count) = (Vec::new(), vec![whole], 0);
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
        Some(parts.into())
    }

    pub(super) fn key_part(&self, value: Value) -> KeyPart {
        match value {
            Value::Int(value) => KeyPart::Int(value),
            Value::Float(value) => KeyPart::Float(float_bits(value)),
            Value::Symbol(symbol) => KeyPart::Symbol(symbol),
            Value::Keyword(symbol) => KeyPart::Keyword(symbol),
            Value::Str(index) => KeyPart::Str(self.strings[index].text.clone()),
            Value::Cons(_) => KeyPart::Pair,
            Value::Vector(index) => KeyPart::Vector(self.vectors[index].elements().len() as u32),
            other => object(other),
        }
    }

    /// The value of a key without parts; none if it is another, or that is no table.
    #[inline]
    pub(crate) fn atom_entry(&mut self, table: &Value, of: &Value) -> Option<Option<&Value>> {
        let (&Value::Table(table), false) = (table, has_parts(of)) else { return None };
        let hash = kept_atom_hash(&mut self.strings, of);
        Some(self.tables[table].atom(&self.strings, of, hash))
    }

    /// Sets the value of a key without parts; tells whether it is one, and that a table which may be changed.
    #[inline]
    pub(crate) fn set_atom_entry(&mut self, table: &Value, of: &Value, value: &Value) -> bool {
        let (&Value::Table(table), false) = (table, has_parts(of)) else { return false };
        if self.tables[table].is_frozen() {
            return false;
        }
        if let Some(entry) = self.tables[table].last_mut(of) {
            entry.value.set(value);
            return true;
        }
        let hash = kept_atom_hash(&mut self.strings, of);
        if self.tables[table].set_atom(&self.strings, of, hash, value) {
            self.allocated += entry_bytes(None);
        }
        true
    }

    /// The value of a key in a table.
    pub fn table_value(&self, table: u32, key: &Key) -> Option<Value> {
        self.tables[table].get(&self.strings, key)
    }

    /// Puts an entry into a hash table.
    pub fn enter(&mut self, table: u32, key: Key, value: Value) {
        let bytes = table_entry(&key);
        if self.tables[table].insert(&self.strings, key, value) {
            self.allocated += bytes;
        }
    }

    /// Removes the entry of a key; tells whether there was one.
    pub fn remove_entry(&mut self, table: u32, key: &Key) -> bool {
        self.tables[table].remove(&self.strings, key)
    }

    /// What the order of an entry follows from.
    fn order_of<'t>(&self, entry: &'t Entry) -> Cow<'t, [KeyPart]> {
        match &entry.parts {
            Some(parts) => Cow::Borrowed(parts),
            None => Cow::Owned(vec![self.key_part(entry.key)]),
        }
    }

    /// The entries of a hash table in the order of their keys. O(n log n).
    pub fn entries_in_order(&self, table: u32) -> Vec<(Value, Value)> {
        let mut entries: Vec<_> =
            self.tables[table].entries().iter().map(|entry| (self.order_of(entry), (entry.key, entry.value))).collect();
        entries.sort_unstable_by(|(left, _), (right, _)| left.cmp(right));
        entries.into_iter().map(|(_, entry)| entry).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// A key of one of four kinds, made anew each time.
    fn key_of(heap: &mut Heap, number: i64) -> Value {
        match number % 4 {
            0 => Value::Int(number),
            1 => Value::Float(number as f64),
            2 => heap.string(&format!("text {number}")),
            _ => heap.list(&[Value::Int(number), Value::True]),
        }
    }

    fn small_key(heap: &Heap, of: Value) -> Key {
        heap.key(of).expect("it has few parts")
    }

    #[test]
    fn a_table_does_what_an_ordered_map_does() {
        let mut heap = Heap::new();
        let Value::Table(table) = heap.table() else { unreachable!("a table was made") };
        let mut model = BTreeMap::new();
        for turn in 0..20_000_i64 {
            let number = turn * 7919 % 1009;
            let of = key_of(&mut heap, number);
            let key = small_key(&heap, of);
            if turn % 3 == 2 {
                assert_eq!(heap.remove_entry(table, &key), model.remove(&number).is_some(), "{number}");
            } else {
                heap.enter(table, key, Value::Int(turn));
                model.insert(number, turn);
            }
            let asked = (turn * 31) % 1009;
            let of = key_of(&mut heap, asked);
            let found = heap.table_value(table, &small_key(&heap, of));
            assert_eq!(found, model.get(&asked).map(|&value| Value::Int(value)), "{asked}");
        }
        assert_eq!(heap.tables[table].len(), model.len());
        assert!(heap.tables[table].entries().iter().all(|entry| entry.is_whole(&heap.strings)));
    }

    #[test]
    fn what_was_found_last_is_no_longer_there_once_it_is_removed() {
        let mut heap = Heap::new();
        let made = heap.table();
        let Value::Table(table) = made else { unreachable!("a table was made") };
        let (text, number) = (heap.string("key"), Value::Int(7));
        for of in [text, number] {
            assert!(heap.set_atom_entry(&made, &of, &Value::Nil));
        }
        for (of, other) in [(text, number), (number, text)] {
            assert_eq!(heap.atom_entry(&made, &of), Some(Some(&Value::Nil)));
            let key = small_key(&heap, of);
            assert!(heap.remove_entry(table, &key));
            // The other one stands in its place.
            assert!(heap.set_atom_entry(&made, &of, &Value::True));
            assert_eq!(heap.atom_entry(&made, &other).flatten(), Some(&Value::Nil));
            assert_eq!(heap.atom_entry(&made, &of).flatten(), Some(&Value::True));
            assert!(heap.set_atom_entry(&made, &of, &Value::Nil));
            assert_eq!(heap.tables[table].len(), 2);
        }
    }

    #[test]
    fn a_table_that_was_read_finds_its_entries() {
        let mut heap = Heap::new();
        let Value::Table(table) = heap.table() else { unreachable!("a table was made") };
        for number in 0..100 {
            let of = key_of(&mut heap, number);
            heap.enter(table, small_key(&heap, of), Value::Int(number));
        }
        let bytes = postcard::to_allocvec(&heap).expect("a heap can be written");
        let mut read: Heap = postcard::from_bytes(&bytes).expect("what was written can be read");
        assert_eq!(read, heap);
        for number in 0..100 {
            let of = key_of(&mut read, number);
            assert_eq!(read.table_value(table, &small_key(&read, of)), Some(Value::Int(number)));
        }
    }

    #[test]
    fn an_entry_with_the_hash_of_another_key_is_not_whole() {
        let heap = Heap::new();
        let key = small_key(&heap, Value::Int(1));
        let entry = |of| Entry { hash: key.hash, key: of, value: Value::Nil, parts: None };
        assert!(entry(Value::Int(1)).is_whole(&heap.strings));
        assert!(!entry(Value::Int(2)).is_whole(&heap.strings));
        assert!(!entry(Value::Cons(0)).is_whole(&heap.strings));
    }

    #[test]
    fn keys_are_the_same_if_they_are_equal() {
        let mut heap = Heap::new();
        let Value::Table(table) = heap.table() else { unreachable!("a table was made") };
        let (text, same_text) = (heap.string("1"), heap.string("1"));
        let different = [Value::Int(1), Value::Float(1.0), text, Value::Nil, Value::True, Value::Float(f64::NAN)];
        for (at, &of) in different.iter().enumerate() {
            heap.enter(table, small_key(&heap, of), Value::Int(at as i64));
        }
        assert_eq!(heap.tables[table].len(), different.len());
        let found = |of| heap.table_value(table, &small_key(&heap, of));
        assert_eq!(found(same_text), Some(Value::Int(2)));
        assert_eq!(found(Value::Float(-f64::NAN)), Some(Value::Int(5)));
        assert_eq!(found(Value::Float(0.0)), None);
        heap.enter(table, small_key(&heap, Value::Float(-0.0)), Value::True);
        assert_eq!(heap.table_value(table, &small_key(&heap, Value::Float(0.0))), Some(Value::True));
    }
}
