//! Lists as sets: `equal` elements count as one, the order of the first list is kept.

use crate::arguments::{Answer, elements, list, pure, truth, value};
use rpl_runtime::heap::{Heap, Key};
use rpl_runtime::native::{Call, Native};
use rpl_runtime::value::Value;
use std::collections::BTreeSet;

/// Values met so far, up to `equal`.
#[derive(Default)]
struct Seen {
    keys: BTreeSet<Key>,
    /// Values that nest too deep for a key.
    deep: Vec<Value>,
}

impl Seen {
    fn of(heap: &Heap, items: &[Value]) -> Self {
        let mut seen = Seen::default();
        for &item in items {
            seen.insert(heap, item);
        }
        seen
    }

    /// Whether the value is new.
    fn insert(&mut self, heap: &Heap, item: Value) -> bool {
        match heap.key(item) {
            Some(key) => self.keys.insert(key),
            None if self.contains_deep(heap, item) => false,
            None => {
                self.deep.push(item);
                true
            }
        }
    }

    fn contains(&self, heap: &Heap, item: Value) -> bool {
        match heap.key(item) {
            Some(key) => self.keys.contains(&key),
            None => self.contains_deep(heap, item),
        }
    }

    fn contains_deep(&self, heap: &Heap, item: Value) -> bool {
        self.deep.iter().any(|&known| heap.equal(known, item))
    }
}

fn remove_duplicates(call: &mut Call<'_, '_>) -> Answer {
    let mut items = elements(call, 0)?;
    let mut seen = Seen::default();
    items.retain(|&item| seen.insert(&call.machine.heap, item));
    list(call, &items)
}

fn union(call: &mut Call<'_, '_>) -> Answer {
    let mut items = elements(call, 0)?;
    items.extend(elements(call, 1)?);
    let mut seen = Seen::default();
    items.retain(|&item| seen.insert(&call.machine.heap, item));
    list(call, &items)
}

/// The elements of the first list that are, or are not, in the second.
fn select(call: &mut Call<'_, '_>, common: bool) -> Answer {
    let mut items = elements(call, 0)?;
    let others = elements(call, 1)?;
    let others = Seen::of(&call.machine.heap, &others);
    items.retain(|&item| others.contains(&call.machine.heap, item) == common);
    list(call, &items)
}

fn is_subset(call: &mut Call<'_, '_>) -> Answer {
    let items = elements(call, 0)?;
    let others = elements(call, 1)?;
    let others = Seen::of(&call.machine.heap, &others);
    truth(items.iter().all(|&item| others.contains(&call.machine.heap, item)))
}

fn adjoin(call: &mut Call<'_, '_>) -> Answer {
    let (item, set) = (call.argument(0), call.argument(1));
    let known = elements(call, 1)?.iter().any(|&known| call.machine.heap.equal(known, item));
    value(if known { set } else { call.machine.heap.cons(item, set) })
}

/// Lists as sets.
pub const NATIVES: &[Native] = &[
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
