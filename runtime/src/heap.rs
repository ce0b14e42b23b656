//! The heap: pairs, strings, cells, closures and hash tables in slabs of their own.

use crate::failure::Failure;
use crate::slab::{Marks, Slab, is_free_list};
use crate::value::Value;
use rpl_lang::symbol::Symbol;
use serde::{Deserialize, Serialize};
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

/// A key of a hash table, compared by content: two keys are the same if they are `equal`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Key {
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
    /// A pair.
    Cons(Box<(Key, Key)>),
    /// Any other object, by identity.
    Object(u8, u32, u32),
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
    /// Objects allocated since the last collection, large ones for several.
    pub allocated: usize,
    /// The same up to the last collection.
    pub allocated_before: u64,
    /// A collection is due when `allocated` passes this.
    pub threshold: usize,
    /// Bytes of strings and closures, roughly; what a limit on memory counts.
    pub bytes: usize,
}

/// What one counts for in [`Heap::made_bytes`]: a pair.
const OBJECT_BYTES: u64 = 32;

/// Nesting that `equal`, printing and keys follow before they give up.
pub const MAX_DEPTH: usize = 100_000;

impl Heap {
    /// An empty heap.
    pub fn new() -> Self {
        Self { threshold: MIN_THRESHOLD, ..Self::default() }
    }

    /// A new pair.
    pub fn cons(&mut self, car: Value, cdr: Value) -> Value {
        self.allocated += 1;
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
        self.allocated += 1 + text.len() / 32;
        self.bytes += text.len();
        Value::Str(self.strings.insert(text.into()))
    }

    /// A new cell.
    pub fn cell(&mut self, value: Value) -> Value {
        self.allocated += 1;
        Value::Cell(self.cells.insert(value))
    }

    /// A new closure.
    pub fn closure(&mut self, code: u32, captured: Box<[Value]>) -> Value {
        self.allocated += 1 + captured.len() / 2;
        Value::Closure(self.closures.insert(Closure { code, captured }))
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

    /// The length of a proper list.
    ///
    /// # Errors
    /// The value found where a list was expected: the argument itself, or an improper tail.
    pub fn length(&self, list: Value) -> Result<usize, Value> {
        let (mut at, mut length) = (list, 0);
        while let Value::Cons(index) = at {
            at = self.pair(index).1;
            length += 1;
            // A list longer than there are pairs is a circle.
            if length > self.pairs.len() {
                return Err(list);
            }
        }
        if at.is_true() { Err(at) } else { Ok(length) }
    }

    /// The elements of a proper list.
    ///
    /// # Errors
    /// The value found where a list was expected: the argument itself, or an improper tail.
    pub fn elements(&self, list: Value) -> Result<Vec<Value>, Value> {
        let mut items = Vec::with_capacity(self.length(list)?);
        let mut at = list;
        while let Value::Cons(index) = at {
            let (car, cdr) = self.pair(index);
            items.push(car);
            at = cdr;
        }
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
        while let Some((left, right)) = waiting.pop() {
            match (left, right) {
                (Value::Cons(a), Value::Cons(b)) if a != b => {
                    steps += 1;
                    if steps > self.pairs.len().saturating_mul(4).max(MAX_DEPTH) {
                        return (false, steps);
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

    /// The key a value is found by; none if it nests too deep or is too large. A list that shares
    /// its parts can be far larger than it is deep.
    pub fn key(&self, value: Value) -> Option<Key> {
        self.key_within(value, 1_000, &mut 100_000)
    }

    fn key_within(&self, value: Value, depth: usize, pairs: &mut usize) -> Option<Key> {
        Some(match value {
            Value::Nil | Value::Unbound => Key::Nil,
            Value::True => Key::True,
            Value::Int(value) => Key::Int(value),
            // `equal` takes both zeros for the same, and all that is not a number.
            Value::Float(0.0) => Key::Float(0),
            Value::Float(value) if value.is_nan() => Key::Float(f64::NAN.to_bits()),
            Value::Float(value) => Key::Float(value.to_bits()),
            Value::Symbol(symbol) => Key::Symbol(symbol),
            Value::Keyword(symbol) => Key::Keyword(symbol),
            Value::Str(index) => Key::Str(self.strings[index].clone()),
            Value::Cons(index) => {
                let depth = depth.checked_sub(1)?;
                *pairs = pairs.checked_sub(1)?;
                let (car, cdr) = self.pair(index);
                Key::Cons(Box::new((self.key_within(car, depth, pairs)?, self.key_within(cdr, depth, pairs)?)))
            }
            Value::Cell(index) => Key::Object(0, index, 0),
            Value::Function(index) => Key::Object(1, index, 0),
            Value::Closure(index) => Key::Object(2, index, 0),
            Value::Native(index) => Key::Object(3, u32::from(index), 0),
            Value::Fluent(index) => Key::Object(4, index, 0),
            Value::Task(task) => Key::Object(5, task.index, task.generation),
            Value::Valve(index) => Key::Object(6, index, 0),
            Value::Failure(index) => Key::Object(7, index, 0),
            Value::Table(index) => Key::Object(8, index, 0),
            Value::Behaviour(index) => Key::Object(9, u32::from(index), 0),
        })
    }

    /// Whether each table knows which of its places are free.
    pub(crate) fn is_whole(&self) -> bool {
        let pairs = is_free_list(&self.free_pairs, self.pairs.len(), |index| self.pairs[index].0 == Value::Unbound);
        let slabs = [self.strings.is_whole(), self.cells.is_whole(), self.closures.is_whole()];
        let counts = self.allocated <= usize::MAX / 4 && self.bytes <= usize::MAX / 4;
        pairs && slabs == [true; 3] && self.tables.is_whole() && self.failures.is_whole() && counts
    }

    /// Whether a collection is due.
    pub fn is_full(&self) -> bool {
        self.allocated >= self.threshold
    }

    /// Frees what is not marked and sets the next threshold.
    pub fn sweep(&mut self, marks: &HeapMarks) {
        let mut live = 0;
        for (group, pairs) in self.pairs.chunks_mut(64).enumerate() {
            let first = group * 64;
            if marks.pairs.are_all_set(first) {
                live += pairs.len();
                continue;
            }
            for (index, pair) in (first as u32..).zip(pairs) {
                if marks.pairs.is_set(index) {
                    live += 1;
                } else if !matches!(pair.0, Value::Unbound) {
                    *pair = (Value::Unbound, Value::Nil);
                    self.free_pairs.push(index);
                }
            }
        }
        let mut string_bytes = 0;
        live += self.strings.sweep(&marks.strings, |_, text| string_bytes += text.len());
        self.bytes = self.bytes.saturating_sub(string_bytes);
        live += self.cells.sweep(&marks.cells, |_, _| {});
        live += self.closures.sweep(&marks.closures, |_, _| {});
        live += self.tables.sweep(&marks.tables, |_, _| {});
        live += self.failures.sweep(&marks.failures, |_, _| {});
        self.allocated_before += self.allocated as u64;
        self.allocated = 0;
        self.threshold = live.max(MIN_THRESHOLD);
    }

    /// Bytes ever allocated, roughly.
    pub fn made_bytes(&self) -> u64 {
        (self.allocated_before + self.allocated as u64) * OBJECT_BYTES
    }

    /// Bytes in use, roughly: what the limit on memory compares.
    pub fn used_bytes(&self) -> usize {
        self.bytes
            + (self.pairs.len() - self.free_pairs.len()) * 32
            + self.cells.slots() * 24
            + self.closures.slots() * 32
            + self.tables.slots() * 64
    }
}

/// Collections come at least this many allocations apart.
pub const MIN_THRESHOLD: usize = 1 << 18;

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
