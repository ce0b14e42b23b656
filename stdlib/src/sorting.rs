//! Sorting by an order that is known here, without a call for each comparison: pieces, which the
//! prelude has merged, so that control comes back between them.

use crate::arguments::{NativeResult, elements, list, natural, pure, room_for, value};
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Native};
use std::cmp::Ordering;
use std::sync::Arc;

/// Keys of one kind, so that their order is total: an integer and a float are compared as floats,
/// which is no order for large integers.
enum Keys {
    Ints(Vec<i64>),
    Floats(Vec<f64>),
    Strings(Vec<Arc<str>>),
}

impl Keys {
    fn of(call: &Call<'_, '_>, items: &[Value], strings: bool) -> Option<Self> {
        if strings {
            return all(items, |item| match item {
                Value::Str(index) => Some(call.machine.heap.strings[index].text.clone()),
                _ => None,
            })
            .map(Keys::Strings);
        }
        let ints = all(items, |item| if let Value::Int(int) = item { Some(int) } else { None });
        ints.map(Keys::Ints).or_else(|| {
            all(items, |item| match item {
                Value::Float(float) if !float.is_nan() => Some(float),
                _ => None,
            })
            .map(Keys::Floats)
        })
    }

    fn compare(&self, left: usize, right: usize) -> Ordering {
        match self {
            Keys::Ints(keys) => keys[left].cmp(&keys[right]),
            // No key is a NaN.
            Keys::Floats(keys) => keys[left].partial_cmp(&keys[right]).unwrap_or(Ordering::Equal),
            Keys::Strings(keys) => keys[left].cmp(&keys[right]),
        }
    }
}

/// What all items are, if they all are.
fn all<T>(items: &[Value], kind: impl Fn(Value) -> Option<T>) -> Option<Vec<T>> {
    items.iter().map(|&item| kind(item)).collect()
}

/// The order of a predicate, if it is `<`, `>`, `string<` or `string>`.
#[derive(Clone, Copy)]
struct Order {
    strings: bool,
    descending: bool,
}

impl Order {
    fn of(call: &Call<'_, '_>, predicate: Value) -> Option<Self> {
        let Value::Native(number) = predicate else { return None };
        let (strings, descending) = match call.around.natives[usize::from(number)].name {
            "<" => (false, false),
            ">" => (false, true),
            "string<" => (true, false),
            "string>" => (true, true),
            _ => return None,
        };
        Some(Self { strings, descending })
    }

    /// How two keys stand to each other in this order.
    fn compare(self, keys: &Keys, left: usize, right: usize) -> Ordering {
        if self.descending { keys.compare(right, left) } else { keys.compare(left, right) }
    }
}

/// The keys of some elements: they themselves, or the first halves of the pairs.
fn keys_of(call: &Call<'_, '_>, items: &[Value], by_pairs: bool, order: Order) -> Option<Keys> {
    let key = |&item: &Value| match item {
        Value::Cons(index) if by_pairs => call.machine.heap.pair(index).0,
        other => other,
    };
    Keys::of(call, &items.iter().map(key).collect::<Vec<Value>>(), order.strings)
}

/// Bytes that sorting `elements` elements takes for a while: they, their keys, and their order.
fn room_to_sort(call: &Call<'_, '_>, elements: usize) -> Result<(), Raise> {
    room_for(call, elements * 6 * size_of::<Value>())
}

/// The first elements in order, up to a number, if the order is known and their keys are all of one kind; else `t`.
fn sorted(call: &mut Call<'_, '_>) -> NativeResult {
    let Some(order) = Order::of(call, call.argument(0)) else { return value(Value::True) };
    let count = natural(call, 2)?;
    let items: Vec<Value> = call.machine.heap.spine(call.argument(1)).take(count).map(|(_, item)| item).collect();
    room_to_sort(call, items.len())?;
    let by_pairs = call.argument(3).is_true();
    let Some(keys) = keys_of(call, &items, by_pairs, order) else { return value(Value::True) };
    let mut places: Vec<usize> = (0..items.len()).collect();
    places.sort_by(|&left, &right| order.compare(&keys, left, right));
    call.burn(items.len() * items.len().max(1).ilog2() as usize);
    let items: Vec<Value> = places.into_iter().map(|at| items[at]).collect();
    list(call, &items)
}

/// One list in order of two that are, those of the left first among equals; `t` if one of them is
/// `t` or their keys are not all of one kind.
fn merged(call: &mut Call<'_, '_>) -> NativeResult {
    let Some(order) = Order::of(call, call.argument(0)) else { return value(Value::True) };
    if [1, 2].iter().any(|&at| call.argument(at) == Value::True) {
        return value(Value::True);
    }
    let (mut items, right) = (elements(call, 1)?, elements(call, 2)?);
    let middle = items.len();
    items.extend(right);
    room_to_sort(call, items.len())?;
    let by_pairs = call.argument(3).is_true();
    let Some(keys) = keys_of(call, &items, by_pairs, order) else { return value(Value::True) };
    let (mut left, mut right) = (0, middle);
    let mut in_order = Vec::with_capacity(items.len());
    while left < middle || right < items.len() {
        let takes_left = right == items.len() || left < middle && order.compare(&keys, right, left) != Ordering::Less;
        let next = if takes_left { &mut left } else { &mut right };
        in_order.push(items[*next]);
        *next += 1;
    }
    list(call, &in_order)
}

/// Sorting.
pub(super) const NATIVES: &[Native] = &[
    pure(
        "%sorted",
        "less elements count by-pairs",
        "The first so many elements in a known order of numbers or strings, or t if the order is not known.",
        sorted,
    ),
    pure("%merged", "less value rest by-pairs", "Two lists in such an order as one, or t.", merged),
];
