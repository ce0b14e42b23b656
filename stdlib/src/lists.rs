//! Building lists and taking them apart.

use crate::arguments::{
    NativeResult, count, elements, given, index_error, list, natural, proper_end, pure, room_for_pairs, value,
};
use crate::numbers::{Number, number, overflow};
use rpl_lang::kind::Kind;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Native};

/// The half of a list that one letter of `cadr` names; nil of nil.
pub(crate) fn half(call: &Call<'_, '_>, list: Value, letter: u8) -> Result<Value, Raise> {
    match list {
        Value::Nil => Ok(Value::Nil),
        Value::Cons(index) => {
            let (car, cdr) = call.machine.heap.pair(index);
            Ok(if letter == b'a' { car } else { cdr })
        }
        other => Err(call.machine.wrong_type(&format!("a part of {}", call.which(0)), Kind::List.noun(), other)),
    }
}

/// Follows halves from the first argument, in the order of evaluation: `da` is `cadr`.
pub(crate) fn follow(call: &Call<'_, '_>, letters: &[u8]) -> Result<Value, Raise> {
    letters.iter().try_fold(call.argument(0), |at, &letter| half(call, at, letter))
}

fn path(call: &Call<'_, '_>, letters: &[u8]) -> NativeResult {
    value(follow(call, letters)?)
}

fn cons(call: &mut Call<'_, '_>) -> NativeResult {
    value(call.machine.heap.cons(call.arguments[0], call.arguments[1]))
}

fn list_of(call: &mut Call<'_, '_>) -> NativeResult {
    value(call.machine.heap.list(call.arguments))
}

fn list_with_tail(call: &mut Call<'_, '_>) -> NativeResult {
    let (tail, items) = call.arguments.split_last().map_or((Value::Nil, [].as_slice()), |(&tail, items)| (tail, items));
    value(call.machine.heap.list_with_tail(items, tail))
}

fn make_list(call: &mut Call<'_, '_>) -> NativeResult {
    let length = natural(call, 0)?;
    room_for_pairs(call, length)?;
    list(call, &vec![call.argument(1); length])
}

/// The pairs of all lists but the last are new.
fn append(call: &mut Call<'_, '_>) -> NativeResult {
    let Some(last) = count(call).checked_sub(1) else { return value(Value::Nil) };
    let mut items = Vec::new();
    for at in 0..last {
        items.extend(elements(call, at)?);
        room_for_pairs(call, items.len())?;
    }
    value(call.machine.heap.list_with_tail(&items, call.arguments[last]))
}

/// The pairs from a position on, or the tail that ends the list before it.
fn tail_from(call: &mut Call<'_, '_>, from: Value, position: usize) -> Value {
    let heap = &call.machine.heap;
    let mut spine = heap.spine(from);
    let passed = spine.by_ref().take(position).count();
    let mut at = spine.rest();
    // Once round a circle, further rounds lead nowhere else.
    if let Some(circle) = spine.circle() {
        for _ in 0..(position - passed) % circle {
            let Value::Cons(pair) = at else { break };
            at = heap.pair(pair).1;
        }
    }
    call.burn_walk(passed);
    at
}

fn nth(call: &mut Call<'_, '_>) -> NativeResult {
    let position = natural(call, 0)?;
    nth_of(call, 1, position)
}

/// The element of a list at a position counted from zero, nil behind its end.
fn nth_of(call: &mut Call<'_, '_>, at: usize, position: usize) -> NativeResult {
    match tail_from(call, call.argument(at), position) {
        Value::Nil => value(Value::Nil),
        Value::Cons(index) => value(call.machine.heap.pair(index).0),
        _ => Err(call.wrong_type(at)),
    }
}

fn nthcdr(call: &mut Call<'_, '_>) -> NativeResult {
    let position = natural(call, 0)?;
    match call.argument(1) {
        Value::Nil | Value::Cons(_) => value(tail_from(call, call.argument(1), position)),
        _ => Err(call.wrong_type(1)),
    }
}

fn element_number(call: &mut Call<'_, '_>, position: usize) -> NativeResult {
    nth_of(call, 0, position)
}

/// How many elements the last pairs of a list, or what is left without them, begin behind.
fn split_before_last(call: &mut Call<'_, '_>) -> Result<usize, Raise> {
    let last = if count(call) > 1 { natural(call, 1)? } else { 1 };
    let mut spine = call.machine.heap.spine(call.argument(0));
    let length = spine.by_ref().count();
    let end = spine.rest();
    call.burn_walk(length);
    proper_end(call, 0, end)?;
    Ok(length.saturating_sub(last))
}

fn last(call: &mut Call<'_, '_>) -> NativeResult {
    let position = split_before_last(call)?;
    value(tail_from(call, call.argument(0), position))
}

fn butlast(call: &mut Call<'_, '_>) -> NativeResult {
    let length = split_before_last(call)?;
    room_for_pairs(call, length)?;
    let items: Vec<Value> = call.machine.heap.spine(call.argument(0)).take(length).map(|(_, item)| item).collect();
    list(call, &items)
}

fn copy_list(call: &mut Call<'_, '_>) -> NativeResult {
    let items = elements(call, 0)?;
    list(call, &items)
}

fn acons(call: &mut Call<'_, '_>) -> NativeResult {
    if !matches!(call.argument(2), Value::Nil | Value::Cons(_)) {
        return Err(call.wrong_type(2));
    }
    let entry = call.machine.heap.cons(call.arguments[0], call.arguments[1]);
    value(call.machine.heap.cons(entry, call.arguments[2]))
}

/// Start, end and step of a range.
fn bounds(call: &Call<'_, '_>) -> Result<(Number, Number, Number), Raise> {
    let step = if count(call) > 2 { number(call, 2)? } else { Number::Int(1) };
    if step.as_f64() == 0.0 {
        return Err(index_error("the step of a range must not be 0".into()));
    }
    Ok(match count(call) {
        1 => (Number::Int(0), number(call, 0)?, step),
        _ => (number(call, 0)?, number(call, 1)?, step),
    })
}

fn range(call: &mut Call<'_, '_>) -> NativeResult {
    let (start, end, step) = bounds(call)?;
    let length = match (start, end, step) {
        (Number::Int(start), Number::Int(end), Number::Int(step)) => {
            let distance = (i128::from(end) - i128::from(start)) * i128::from(step.signum());
            let stride = i128::from(step.unsigned_abs());
            usize::try_from((distance + stride - 1) / stride).unwrap_or(0)
        }
        (start, end, step) => ((end.as_f64() - start.as_f64()) / step.as_f64()).ceil() as usize,
    };
    progression(call, length, start, step)
}

fn iota(call: &mut Call<'_, '_>) -> NativeResult {
    let length = natural(call, 0)?;
    let start = if count(call) > 1 { number(call, 1)? } else { Number::Int(0) };
    let step = if count(call) > 2 { number(call, 2)? } else { Number::Int(1) };
    progression(call, length, start, step)
}

/// Each element from the first one, so that rounding errors do not add up.
fn progression(call: &mut Call<'_, '_>, length: usize, start: Number, step: Number) -> NativeResult {
    room_for_pairs(call, length)?;
    let items: Option<Vec<Value>> = (0..length as i64)
        .map(|turn| match (start, step) {
            (Number::Int(start), Number::Int(step)) => {
                step.checked_mul(turn).and_then(|way| start.checked_add(way)).map(Value::Int)
            }
            (start, step) => Some(Value::Float(start.as_f64() + turn as f64 * step.as_f64())),
        })
        .collect();
    let items = items.ok_or_else(|| overflow("the last element"))?;
    list(call, &items)
}

/// All atoms but nil, from left to right. The work is bounded by the room for the result and by
/// the number of pairs that can be visited on the way to it.
fn flatten(call: &mut Call<'_, '_>) -> NativeResult {
    let mut items = Vec::new();
    let mut waiting = vec![call.argument(0)];
    let mut visited = 0usize;
    while let Some(at) = waiting.pop() {
        match at {
            Value::Nil => {}
            Value::Cons(index) => {
                visited += 1;
                if visited.is_multiple_of(4096) {
                    room_for_pairs(call, visited)?;
                }
                let (car, cdr) = call.machine.heap.pair(index);
                waiting.push(cdr);
                waiting.push(car);
            }
            atom => items.push(atom),
        }
    }
    call.burn(visited);
    list(call, &items)
}

/// The value behind a name in a list of names and values in turn.
fn getf(call: &mut Call<'_, '_>) -> NativeResult {
    let items = elements(call, 0)?;
    let wanted = call.argument(1);
    let found = items.chunks(2).find(|entry| entry[0] == wanted);
    value(match found {
        Some(&[_, found]) => found,
        _ => given(call, 2).unwrap_or_default(),
    })
}

/// Building lists and taking them apart.
pub(super) const NATIVES: &[Native] = &[
    pure("cons", "value rest", "A list of a first element and a rest.", cons),
    pure("car", "list", "The first element; nil of the empty list.", |call| path(call, b"a")),
    pure("cdr", "list", "The list without its first element; nil of the empty list.", |call| path(call, b"d")),
    pure("caar", "list", "The car of the car.", |call| path(call, b"aa")),
    pure("cadr", "list", "The car of the cdr: the second element.", |call| path(call, b"da")),
    pure("cdar", "list", "The cdr of the car.", |call| path(call, b"ad")),
    pure("cddr", "list", "The cdr of the cdr: the list without its first two elements.", |call| path(call, b"dd")),
    pure("caddr", "list", "The car of the cddr: the third element.", |call| path(call, b"dda")),
    pure("cdddr", "list", "The cdr of the cddr: the list without its first three elements.", |call| path(call, b"ddd")),
    pure("cadddr", "list", "The car of the cdddr: the fourth element.", |call| path(call, b"ddda")),
    pure("first", "list", "The first element; nil of the empty list.", |call| path(call, b"a")),
    pure("second", "list", "The second element, or nil.", |call| element_number(call, 1)),
    pure("third", "list", "The third element, or nil.", |call| element_number(call, 2)),
    pure("fourth", "list", "The fourth element, or nil.", |call| element_number(call, 3)),
    pure("fifth", "list", "The fifth element, or nil.", |call| element_number(call, 4)),
    pure("rest", "list", "The list without its first element; nil of the empty list.", |call| path(call, b"d")),
    pure("nth", "position list", "The element at a position counted from 0; nil beyond the end.", nth),
    pure("nthcdr", "count list", "The list without its first COUNT elements.", nthcdr),
    pure("last", "list &optional count", "The last pair of a list, or its last COUNT pairs.", last),
    pure(
        "butlast",
        "list &optional count",
        "A copy of the list without its last element, or its last COUNT elements.",
        butlast,
    ),
    pure("list", "&rest values", "A list of the values.", list_of),
    pure("list*", "value &rest values", "A list of the values that ends in the last one.", list_with_tail),
    pure("make-list", "length &optional value", "A list of LENGTH elements, each the value.", make_list),
    pure("append", "&rest lists", "One list of the elements of all lists; it ends in the last one itself.", append),
    pure("copy-list", "list", "A new list of the same elements.", copy_list),
    pure("acons", "key value alist", "The association list with one more entry in front.", acons),
    pure(
        "range",
        "from-or-to &optional to step",
        "The numbers from a start, or 0, up to an end that is not among them.",
        range,
    ),
    pure("iota", "count &optional from step", "So many numbers from a start, or 0.", iota),
    pure("flatten", "tree", "The atoms of nested lists in one list, without nil.", flatten),
    pure("getf", "plist key &optional default", "The value that follows the key in a list of keys and values.", getf),
];
