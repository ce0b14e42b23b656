//! Sorting by an order that is known here, without a call for each comparison.

use crate::arguments::{Answer, elements, list, pure, room_for, value};
use rpl_runtime::native::{Call, Native};
use rpl_runtime::value::Value;
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
                Value::Str(index) => Some(call.machine.heap.strings[index].clone()),
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

/// The elements in order if the predicate is `<`, `>`, `string<` or `string>` and the elements, or
/// the first halves of the pairs, are all of one kind; else `t`.
fn sorted(call: &mut Call<'_, '_>) -> Answer {
    let Value::Native(number) = call.argument(0) else { return value(Value::True) };
    let (strings, descending) = match call.around.natives[usize::from(number)].name {
        "<" => (false, false),
        ">" => (false, true),
        "string<" => (true, false),
        "string>" => (true, true),
        _ => return value(Value::True),
    };
    let items = elements(call, 1)?;
    room_for(call, items.len() * 6 * size_of::<Value>())?;
    let by_pairs = call.argument(2).is_true();
    let keys: Vec<Value> = items
        .iter()
        .map(|&item| match item {
            Value::Cons(index) if by_pairs => call.machine.heap.pair(index).0,
            other => other,
        })
        .collect();
    let Some(keys) = Keys::of(call, &keys, strings) else { return value(Value::True) };
    let mut order: Vec<usize> = (0..items.len()).collect();
    order.sort_by(|&left, &right| if descending { keys.compare(right, left) } else { keys.compare(left, right) });
    call.burn(items.len() * items.len().max(1).ilog2() as usize);
    let items: Vec<Value> = order.into_iter().map(|at| items[at]).collect();
    list(call, &items)
}

/// Sorting.
pub const NATIVES: &[Native] = &[pure(
    "%sorted",
    "less elements by-pairs",
    "The elements in a known order of numbers or strings, or t if the order is not known.",
    sorted,
)];
