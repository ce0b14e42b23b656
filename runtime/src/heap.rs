//! The heap: pairs, strings, cells, closures and hash tables in slabs of their own.

use crate::failure::Failure;
use crate::memory::{MIN_THRESHOLD, block, table_entry};
use crate::slab::{Marks, Slab, give_back, is_free_list};
use crate::value::Value;
use rpl_lang::symbol::Symbol;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A function with the values it captured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Closure {
    /// Its code.
    pub code: u32,
    /// Copied behind the parameters at each call.
    pub captured: Box<[Value]>,
}

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

/// A hash table: entries in the order of their keys, so that walking it is deterministic.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// Key and value as the plan gave them.
    pub entries: BTreeMap<Key, (Value, Value)>,
}

/// All heap objects of a system.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Heap {
    /// Pairs; a free one has [`Value::Unbound`] as its first half.
    pub pairs: Vec<(Value, Value)>,
    free_pairs: Vec<u32>,
    /// Strings.
    pub strings: Slab<Arc<str>>,
    /// Cells.
    pub cells: Slab<Value>,
    /// Closures.
    pub closures: Slab<Closure>,
    /// Hash tables.
    pub tables: Slab<Table>,
    /// Failures.
    pub failures: Slab<Failure>,
    /// Bytes that were made since the last collection, here and elsewhere in the machine.
    pub allocated: usize,
    /// The same for the time before.
    pub allocated_before: u64,
    /// A collection is due when `allocated` passes this.
    pub threshold: usize,
    /// Bytes that were found alive by the last collection, in the whole machine.
    pub live: usize,
    /// Bytes of the texts of strings.
    pub text_bytes: usize,
}

/// Pairs a key may have. A list that shares its parts can be far larger than the memory it takes.
pub const MAX_KEY_PAIRS: usize = 100_000;

/// With more pairs compared than this, or than there are, parts are taken to be shared.
const MAX_PLAIN_STEPS: usize = 1_000_000;

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

    #[inline]
    fn next(&mut self) -> Option<(u32, Value)> {
        let Value::Cons(pair) = self.at else { return None };
        if pair == self.anchor {
            return None;
        }
        if self.since_anchor == self.stride {
            (self.anchor, self.since_anchor, self.stride) = (pair, 0, self.stride * 2);
        }
        let (car, cdr) = self.heap.pair(pair);
        self.at = cdr;
        self.since_anchor += 1;
        self.passed += 1;
        Some((pair, car))
    }
}

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
    /// An empty heap.
    pub fn new() -> Self {
        Self { threshold: MIN_THRESHOLD, ..Self::default() }
    }

    /// A new pair.
    pub fn cons(&mut self, car: Value, cdr: Value) -> Value {
        self.allocated += PAIR;
        match self.free_pairs.pop() {
            Some(index) => {
                self.pairs[index as usize] = (car, cdr);
                Value::Cons(index)
            }
            None => {
                self.pairs.push((car, cdr));
                Value::Cons(self.pairs.len() as u32 - 1)
            }
        }
    }

    /// A new string.
    pub fn string(&mut self, text: &str) -> Value {
        let bytes = text_block(text);
        self.allocated += STRING + bytes;
        self.text_bytes += bytes;
        Value::Str(self.strings.insert(text.into()))
    }

    /// A new cell.
    pub fn cell(&mut self, value: Value) -> Value {
        self.allocated += CELL;
        Value::Cell(self.cells.insert(value))
    }

    /// A new closure.
    pub fn closure(&mut self, code: u32, captured: Box<[Value]>) -> Value {
        self.allocated += CLOSURE + block(captured.len() * size_of::<Value>());
        Value::Closure(self.closures.insert(Closure { code, captured }))
    }

    /// A new hash table. Its entries are counted where they are made.
    pub fn table(&mut self) -> Value {
        self.allocated += TABLE;
        Value::Table(self.tables.insert(Table::default()))
    }

    /// A new failure.
    pub(crate) fn failure(&mut self, failure: Failure) -> Value {
        self.allocated += FAILURE + crate::memory::failure(&failure);
        Value::Failure(self.failures.insert(failure))
    }

    /// Puts an entry into a hash table.
    pub fn enter(&mut self, table: u32, key: Key, entry: (Value, Value)) {
        self.allocated += table_entry(&key);
        self.tables[table].entries.insert(key, entry);
    }

    /// A new list.
    pub fn list(&mut self, items: &[Value]) -> Value {
        self.list_with_tail(items, Value::Nil)
    }

    /// A new list that ends in `tail`.
    pub fn list_with_tail(&mut self, items: &[Value], tail: Value) -> Value {
        items.iter().rev().fold(tail, |tail, &item| self.cons(item, tail))
    }

    /// The halves of a pair.
    pub fn pair(&self, index: u32) -> (Value, Value) {
        self.pairs[index as usize]
    }

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
        let length = self.length(list)?;
        let mut items = Vec::with_capacity(length);
        items.extend(self.spine(list).map(|(_, item)| item));
        Ok(items)
    }

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

    /// Whether each table knows which of its places are free.
    pub(crate) fn is_whole(&self) -> bool {
        let pairs = is_free_list(&self.free_pairs, self.pairs.len(), |index| self.pairs[index].0 == Value::Unbound);
        let slabs = [self.strings.is_whole(), self.cells.is_whole(), self.closures.is_whole()];
        let counts = [self.allocated, self.live, self.text_bytes].iter().all(|&count| count <= usize::MAX / 8);
        pairs && slabs == [true; 3] && self.tables.is_whole() && self.failures.is_whole() && counts
    }

    /// Whether a collection is due.
    pub fn is_full(&self) -> bool {
        self.allocated >= self.threshold
    }

    /// Frees what is not marked. A table keeps so many bytes of free room.
    pub fn sweep(&mut self, marks: &HeapMarks, slack: usize) {
        self.sweep_pairs(&marks.pairs, slack);
        let mut freed = 0;
        self.strings.sweep(&marks.strings, slack, |text| freed += text_block(&text));
        self.text_bytes = self.text_bytes.saturating_sub(freed);
        self.cells.sweep(&marks.cells, slack, drop);
        self.closures.sweep(&marks.closures, slack, drop);
        self.tables.sweep(&marks.tables, slack, drop);
        self.failures.sweep(&marks.failures, slack, drop);
    }

    /// The free pairs are used again from the first on, so that those at the end can be given back.
    fn sweep_pairs(&mut self, marks: &Marks, slack: usize) {
        let used = marks.last().map_or(0, |last| last as usize + 1);
        self.pairs.truncate(used);
        give_back(&mut self.pairs, slack);
        self.free_pairs.clear();
        for (group, pairs) in self.pairs.chunks_mut(64).enumerate().rev() {
            let first = group * 64;
            if marks.are_all_set(first) {
                continue;
            }
            for (offset, pair) in pairs.iter_mut().enumerate().rev() {
                let index = (first + offset) as u32;
                if !marks.is_set(index) {
                    *pair = (Value::Unbound, Value::Nil);
                    self.free_pairs.push(index);
                }
            }
        }
        give_back(&mut self.free_pairs, slack);
    }

    /// Bytes ever made.
    pub fn made_bytes(&self) -> u64 {
        self.allocated_before + self.allocated as u64
    }

    /// Bytes of all tables, free places included, and of texts.
    pub(crate) fn bytes(&self) -> usize {
        self.pairs.len() * PAIR
            + self.free_pairs.len() * size_of::<u32>()
            + self.strings.slots() * STRING
            + self.text_bytes
            + self.cells.slots() * CELL
            + self.closures.slots() * CLOSURE
            + self.tables.slots() * TABLE
            + self.failures.slots() * FAILURE
    }
}

/// Bytes of a pair.
pub const PAIR: usize = size_of::<(Value, Value)>();
/// Bytes of a string, its text not counted.
const STRING: usize = size_of::<Option<Arc<str>>>();
/// Bytes of a cell.
const CELL: usize = size_of::<Option<Value>>();
/// Bytes of a closure, what it captured not counted.
const CLOSURE: usize = size_of::<Option<Closure>>();
/// Bytes of a hash table, its entries not counted.
const TABLE: usize = size_of::<Option<Table>>();

/// Bytes of a failure, what it holds not counted.
const FAILURE: usize = size_of::<Option<Failure>>();

/// Bytes of a text and the two counters in front of it.
fn text_block(text: &str) -> usize {
    block(text.len() + 2 * size_of::<usize>())
}

/// Marks of one collection, and the objects still to be looked into.
#[derive(Debug)]
pub struct HeapMarks {
    /// One bit a pair.
    pub pairs: Marks,
    /// One bit a string.
    pub strings: Marks,
    /// One bit a cell.
    pub cells: Marks,
    /// One bit a closure.
    pub closures: Marks,
    /// One bit a table.
    pub tables: Marks,
    /// One bit a failure.
    pub failures: Marks,
}

impl HeapMarks {
    /// Nothing marked.
    pub fn new(heap: &Heap) -> Self {
        Self {
            pairs: Marks::new(heap.pairs.len()),
            strings: Marks::new(heap.strings.slots()),
            cells: Marks::new(heap.cells.slots()),
            closures: Marks::new(heap.closures.slots()),
            tables: Marks::new(heap.tables.slots()),
            failures: Marks::new(heap.failures.slots()),
        }
    }
}
