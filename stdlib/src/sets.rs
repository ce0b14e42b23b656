//! Lists as sets: `equal` elements count as one, the order of the first list is kept.

use crate::arguments::{NativeResult, elements, list, pure, room_for, truth, value};
use crate::elements::find_equal;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::heap::{Heap, Key, MAX_KEY_PARTS, Table, table_entry};
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Native};

/// Values met so far, up to `equal`.
#[derive(Default)]
struct SeenKeys {
    keys: Table,
    /// Values that are too large for a key.
    large: Vec<Value>,
    /// What was looked at, in steps.
    steps: usize,
    /// What the keys take.
    bytes: usize,
}

impl SeenKeys {
    fn of(call: &Call<'_, '_>, items: &[Value]) -> Result<Self, Raise> {
        let mut seen = SeenKeys::default();
        for &item in items {
            seen.insert(call, item)?;
        }
        Ok(seen)
    }

    /// Whether the value is new.
    fn insert(&mut self, call: &Call<'_, '_>, item: Value) -> Result<bool, Raise> {
        let heap = &call.machine.heap;
        let Some(key) = self.key(heap, item) else {
            let is_new = !self.contains_large(heap, item);
            self.large.extend(is_new.then_some(item));
            return Ok(is_new);
        };
        self.bytes += table_entry(&key);
        room_for(call, self.bytes)?;
        Ok(self.keys.insert(&heap.strings, key, Value::Nil))
    }

    fn contains(&mut self, heap: &Heap, item: Value) -> bool {
        match self.key(heap, item) {
            Some(key) => self.keys.get(&heap.strings, &key).is_some(),
            None => self.contains_large(heap, item),
        }
    }

    fn key(&mut self, heap: &Heap, item: Value) -> Option<Key> {
        let key = heap.key(item);
        self.steps += key.as_ref().map_or(MAX_KEY_PARTS, Key::part_count);
        key
    }

    fn contains_large(&mut self, heap: &Heap, item: Value) -> bool {
        self.large.iter().any(|&known| {
            let (is_equal, steps) = heap.compared(known, item);
            self.steps += steps;
            is_equal
        })
    }
}

/// The elements that are new, each once.
fn distinct(call: &mut Call<'_, '_>, items: Vec<Value>) -> NativeResult {
    let (mut seen, mut distinct) = (SeenKeys::default(), Vec::new());
    for item in items {
        if seen.insert(call, item)? {
            distinct.push(item);
        }
    }
    call.burn(seen.steps);
    list(call, &distinct)
}

fn remove_duplicates(call: &mut Call<'_, '_>) -> NativeResult {
    let items = elements(call, 0)?;
    distinct(call, items)
}

fn union(call: &mut Call<'_, '_>) -> NativeResult {
    let mut items = elements(call, 0)?;
    items.extend(elements(call, 1)?);
    distinct(call, items)
}

/// The elements of the first list that are, or are not, in the second.
fn select(call: &mut Call<'_, '_>, common: bool) -> NativeResult {
    let mut items = elements(call, 0)?;
    let others = elements(call, 1)?;
    let mut others = SeenKeys::of(call, &others)?;
    items.retain(|&item| others.contains(&call.machine.heap, item) == common);
    call.burn(others.steps);
    list(call, &items)
}

fn is_subset(call: &mut Call<'_, '_>) -> NativeResult {
    let items = elements(call, 0)?;
    let others = elements(call, 1)?;
    let mut others = SeenKeys::of(call, &others)?;
    let is_subset = items.iter().all(|&item| others.contains(&call.machine.heap, item));
    call.burn(others.steps);
    truth(is_subset)
}

fn adjoin(call: &mut Call<'_, '_>) -> NativeResult {
    let (item, set) = (call.argument(0), call.argument(1));
    let known = find_equal(call, item, 1)?.is_some();
    value(if known { set } else { call.machine.heap.cons(item, set) })
}

/// Lists as sets.
pub(super) const NATIVES: &[Native] = &[
    pure(
        "remove-duplicates",
        "list",
        "A copy of the list with the first of all equal elements only.",
        remove_duplicates,
    ),
    pure("union", "list other", "The elements of both lists, each once.", union),
    pure("intersection", "list other", "The elements of the list that are in the other too.", |call| {
        select(call, true)
    }),
    pure("set-difference", "list other", "The elements of the list that are not in the other.", |call| {
        select(call, false)
    }),
    pure("subsetp", "list other", "Whether all elements of the list are in the other.", is_subset),
    pure("adjoin", "value list", "The list, with the value in front unless it is in it.", adjoin),
];
