//! The heap as data: objects in slabs of their own, made and swept.

use super::captured::Captured;
use super::pairs::{PAIR, Pairs};
use super::table::{Entry, Table};
use super::text::Text;
use super::vector::{Vector, vector_elements};
use crate::state::block::block;
use crate::state::failure::Failure;
use crate::state::memory::{self, MIN_THRESHOLD};
use crate::state::slab::{Marks, Slab};
use crate::state::value::Value;
use serde::{Deserialize, Serialize};

/// A function with the values it captured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Closure {
    /// Its code.
    pub code: u32,
    /// Copied behind the parameters at each call.
    pub captured: Captured,
}

/// All heap objects of a system.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Heap {
    /// Pairs.
    pub pairs: Pairs,
    /// Strings.
    pub strings: Slab<Text>,
    /// Cells.
    pub cells: Slab<Value>,
    /// Closures.
    pub closures: Slab<Closure>,
    /// Hash tables.
    pub tables: Slab<Table>,
    /// Vectors.
    pub vectors: Slab<Vector>,
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

/// Bytes of a string, its text not counted.
const STRING: usize = size_of::<Option<Text>>();

/// Bytes of a cell.
const CELL: usize = size_of::<Option<Value>>();

/// Bytes of a closure, what it captured beside it not counted.
const CLOSURE: usize = size_of::<Option<Closure>>();

/// Bytes of a hash table, its entries not counted.
const TABLE: usize = size_of::<Option<Table>>();

/// Bytes of a vector, its elements not counted.
const VECTOR: usize = size_of::<Option<Vector>>();

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
    /// One bit a vector.
    pub vectors: Marks,
    /// One bit a failure.
    pub failures: Marks,
}

impl HeapMarks {
    /// Nothing marked.
    pub fn new(heap: &Heap) -> Self {
        Self {
            pairs: Marks::new(heap.pairs.places()),
            strings: Marks::new(heap.strings.slots()),
            cells: Marks::new(heap.cells.slots()),
            closures: Marks::new(heap.closures.slots()),
            tables: Marks::new(heap.tables.slots()),
            vectors: Marks::new(heap.vectors.slots()),
            failures: Marks::new(heap.failures.slots()),
        }
    }
}

impl Heap {
    /// An empty heap.
    pub fn new() -> Self {
        Self { threshold: MIN_THRESHOLD, ..Self::default() }
    }

    /// A new pair.
    #[inline]
    pub fn cons(&mut self, car: Value, cdr: Value) -> Value {
        let (pair, bytes) = self.pairs.cons(car, cdr);
        self.allocated += bytes;
        Value::Cons(pair)
    }

    /// Lets something else follow a pair.
    #[inline]
    pub fn set_cdr(&mut self, pair: u32, cdr: Value) {
        self.allocated += self.pairs.set_cdr(pair, cdr);
    }

    /// A new last pair of a list whose last pair was `end`; its number, because a value would be put together in memory and
    /// read from there.
    #[inline(always)]
    pub fn extend(&mut self, end: &Value, value: &Value) -> u32 {
        self.allocated += PAIR;
        match *end {
            Value::Cons(end) => self.pairs.extend(end, value),
            _ => self.first_pair(value),
        }
    }

    #[cold]
    #[inline(never)]
    fn first_pair(&mut self, value: &Value) -> u32 {
        self.pairs.cons(*value, Value::Nil).0
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
    #[inline(always)]
    pub fn closure(&mut self, code: u32, captured: Captured) -> Value {
        self.allocated += CLOSURE + captured.bytes();
        Value::Closure(self.closures.insert(Closure { code, captured }))
    }

    /// A new hash table. Its entries are counted where they are made.
    pub fn table(&mut self) -> Value {
        self.allocated += TABLE;
        Value::Table(self.tables.insert(Table::default()))
    }

    /// A copy of a hash table that can be changed. Cost: its entries.
    pub(crate) fn thawed_table(&mut self, table: u32) -> u32 {
        let copy = self.tables[table].thawed();
        self.allocated += TABLE + copy.entries().iter().map(Entry::bytes).sum::<usize>();
        self.tables.insert(copy)
    }

    /// The element of a vector at a position. None if one of the two is of another type, or there is no such element.
    #[inline]
    pub fn element(&self, vector: &Value, position: &Value) -> Option<&Value> {
        let (&Value::Vector(vector), &Value::Int(position)) = (vector, position) else { return None };
        self.vectors[vector].elements().get(usize::try_from(position).ok()?)
    }

    /// The same to be assigned, unless the vector is frozen.
    #[inline]
    pub fn element_mut(&mut self, vector: &Value, position: &Value) -> Option<&mut Value> {
        let (&Value::Vector(vector), &Value::Int(position)) = (vector, position) else { return None };
        if self.vectors[vector].is_frozen() {
            return None;
        }
        self.vectors[vector].elements_mut().get_mut(usize::try_from(position).ok()?)
    }

    /// Lets copies of this heap share the elements of vectors with it until one of them writes. Whoever is about to
    /// copy a run it may change calls this first; a copy is the same without it. O(number of vectors).
    pub fn share_vectors(&mut self) {
        self.vectors.iter_mut().for_each(Vector::share);
    }

    /// A new vector.
    pub fn vector(&mut self, elements: Vec<Value>) -> Value {
        self.allocated += VECTOR + vector_elements(elements.len());
        Value::Vector(self.vectors.insert(Vector::new(elements)))
    }

    /// A new failure.
    pub(crate) fn failure(&mut self, failure: Failure) -> Value {
        self.allocated += FAILURE + memory::failure(&failure);
        Value::Failure(self.failures.insert(failure))
    }

    /// A new list.
    pub fn list(&mut self, items: &[Value]) -> Value {
        self.list_with_tail(items, Value::Nil)
    }

    /// A new list that ends in `tail`.
    pub fn list_with_tail(&mut self, items: &[Value], tail: Value) -> Value {
        let (list, bytes) = self.pairs.list(items, tail);
        self.allocated += bytes;
        list
    }

    /// The halves of a pair.
    pub fn pair(&self, index: u32) -> (Value, Value) {
        (*self.pairs.car(index), self.pairs.cdr(index))
    }

    /// Whether each table knows which of its places are free.
    pub(crate) fn is_whole(&self) -> bool {
        let slabs = [self.pairs.is_whole(), self.strings.is_whole(), self.cells.is_whole(), self.closures.is_whole()];
        let counts = [self.allocated, self.live, self.text_bytes].iter().all(|&count| count <= usize::MAX / 8);
        let others = [self.tables.is_whole(), self.vectors.is_whole(), self.failures.is_whole()];
        slabs == [true; 4] && others == [true; 3] && counts
    }

    /// Whether a collection is due.
    pub fn is_full(&self) -> bool {
        self.allocated >= self.threshold
    }

    /// Frees what is not marked. A table keeps `slack` bytes of free room.
    pub fn sweep(&mut self, marks: &HeapMarks, slack: usize) {
        self.pairs.sweep(&marks.pairs, slack);
        let mut freed = 0;
        self.strings.sweep(&marks.strings, slack, |text: Text| freed += text_block(&text));
        self.text_bytes = self.text_bytes.saturating_sub(freed);
        self.cells.sweep(&marks.cells, slack, drop);
        self.closures.sweep(&marks.closures, slack, drop);
        self.tables.sweep(&marks.tables, slack, drop);
        self.vectors.sweep(&marks.vectors, slack, drop);
        self.failures.sweep(&marks.failures, slack, drop);
    }

    /// Bytes ever made.
    pub fn made_bytes(&self) -> u64 {
        self.allocated_before + self.allocated as u64
    }

    /// Bytes of all tables, free places included, and of texts.
    pub(crate) fn bytes(&self) -> usize {
        self.pairs.bytes()
            + self.strings.slots() * STRING
            + self.text_bytes
            + self.cells.slots() * CELL
            + self.closures.slots() * CLOSURE
            + self.tables.slots() * TABLE
            + self.vectors.slots() * VECTOR
            + self.failures.slots() * FAILURE
    }
}
