//! Elements of lists, vectors and strings: how many, where, all but some, in another order.

use crate::arguments::{
    NativeResult, Sequence, count, elements, index_error, integer, list, natural, proper_end, pure, sequence, text,
    value, vector,
};
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::heap::Heap;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Native};

fn length(call: &mut Call<'_, '_>) -> NativeResult {
    if let Value::Str(_) = call.argument(0) {
        let string = call.text(0)?;
        call.burn_text(string.len());
        return integer(string.chars().count() as i64);
    }
    if let Value::Vector(index) = call.argument(0) {
        return integer(call.machine.heap.vectors[index].elements().len() as i64);
    }
    let mut spine = call.machine.heap.spine(call.argument(0));
    let length = spine.by_ref().count();
    let end = spine.rest();
    call.burn_walk(length);
    proper_end(call, 0, end)?;
    integer(length as i64)
}

fn reverse(call: &mut Call<'_, '_>) -> NativeResult {
    match sequence(call, 0)? {
        Sequence::List(mut items) => {
            items.reverse();
            list(call, &items)
        }
        Sequence::Vector(mut items) => {
            items.reverse();
            vector(call, items)
        }
        Sequence::Text(string) => {
            let reversed: String = string.chars().rev().collect();
            text(call, &reversed)
        }
    }
}

/// Start and end of a part, both within the length.
pub(crate) fn part(call: &Call<'_, '_>, length: usize) -> Result<(usize, usize), Raise> {
    let start = natural(call, 1)?;
    let end = if count(call) > 2 && call.argument(2).is_true() { natural(call, 2)? } else { length };
    if start > end {
        return Err(index_error(format!("a part cannot begin at {start} and end at {end}")));
    }
    if end > length {
        return Err(index_error(format!("a part cannot reach up to {end}: the length is {length}")));
    }
    Ok((start, end))
}

/// The characters from one position to another.
pub(crate) fn characters(string: &str, start: usize, end: usize) -> &str {
    if string.is_ascii() {
        return &string[start..end];
    }
    let byte = |position: usize| string.char_indices().nth(position).map_or(string.len(), |(byte, _)| byte);
    &string[byte(start)..byte(end)]
}

fn subsequence(call: &mut Call<'_, '_>) -> NativeResult {
    match sequence(call, 0)? {
        Sequence::List(items) => {
            let (start, end) = part(call, items.len())?;
            list(call, &items[start..end])
        }
        Sequence::Vector(items) => {
            let (start, end) = part(call, items.len())?;
            vector(call, items[start..end].to_vec())
        }
        Sequence::Text(string) => {
            let (start, end) = part(call, string.chars().count())?;
            text(call, characters(&string, start, end))
        }
    }
}

fn elt(call: &mut Call<'_, '_>) -> NativeResult {
    if let Value::Vector(_) = call.argument(0) {
        let (of, position) = (call.argument(0), call.argument(1));
        let element = call.machine.heap.element(&of, &position).copied();
        return element.map_or_else(|| Err(call.machine.no_element("elt", of, position)), value);
    }
    let position = natural(call, 1)?;
    let outside = |length: usize| index_error(format!("there is no element {position}: the length is {length}"));
    match sequence(call, 0)? {
        Sequence::List(items) | Sequence::Vector(items) => {
            value(*items.get(position).ok_or_else(|| outside(items.len()))?)
        }
        Sequence::Text(string) => {
            call.burn_text(string.len());
            let length = string.chars().count();
            if position >= length {
                return Err(outside(length));
            }
            text(call, characters(&string, position, position + 1))
        }
    }
}

/// The first pair of the list in an argument whose first half is wanted, with its position. What
/// tells that also tells how many steps it took, or gives back an element that is no entry.
fn find(
    call: &mut Call<'_, '_>,
    at: usize,
    mut is_wanted: impl FnMut(&Heap, Value) -> Result<(bool, usize), Value>,
) -> Result<Option<(usize, u32)>, Raise> {
    let heap = &call.machine.heap;
    let mut spine = heap.spine(call.argument(at));
    let (mut found, mut steps) = (None, 0);
    while let Some((pair, item)) = spine.next() {
        let (is_found, looked_at) = is_wanted(heap, item).map_err(|other| no_pair(call, at, other))?;
        steps += looked_at;
        if is_found {
            found = Some((spine.passed() - 1, pair));
            break;
        }
    }
    let (passed, end) = (spine.passed(), spine.rest());
    call.burn_walk(passed);
    call.burn(steps);
    if found.is_none() {
        proper_end(call, at, end)?;
    }
    Ok(found)
}

/// The pair whose first half is `equal` to a value, with its position.
pub(crate) fn find_equal(call: &mut Call<'_, '_>, wanted: Value, at: usize) -> Result<Option<(usize, u32)>, Raise> {
    find(call, at, |heap, item| Ok(heap.compared(item, wanted)))
}

fn member(call: &mut Call<'_, '_>) -> NativeResult {
    let found = find_equal(call, call.argument(0), 1)?;
    value(found.map_or(Value::Nil, |(_, pair)| Value::Cons(pair)))
}

fn position(call: &mut Call<'_, '_>) -> NativeResult {
    let found = find_equal(call, call.argument(0), 1)?;
    value(found.map_or(Value::Nil, |(position, _)| Value::Int(position as i64)))
}

/// The error for an element of an association list that is no entry.
pub(crate) fn no_pair(call: &Call<'_, '_>, at: usize, found: Value) -> Raise {
    let found = call.machine.described(found);
    Raise::type_error(format!("{} must be a list of pairs, and one of its elements is {found}", call.which(at)))
}

/// The entry of an association list whose half (0 key, 1 value) is `equal` to the first argument.
fn entry(call: &mut Call<'_, '_>, by_value: bool) -> Result<Option<(Value, Value, Value)>, Raise> {
    let wanted = call.argument(0);
    let found = find(call, 1, |heap, item| match item {
        Value::Nil => Ok((false, 0)),
        Value::Cons(entry) => {
            let half = if by_value { heap.pairs.cdr(entry) } else { *heap.pairs.car(entry) };
            Ok(heap.compared(half, wanted))
        }
        other => Err(other),
    })?;
    Ok(found.and_then(|(_, pair)| {
        let item = call.machine.heap.pair(pair).0;
        let Value::Cons(entry) = item else { return None };
        let (key, content) = call.machine.heap.pair(entry);
        Some((item, key, content))
    }))
}

fn assoc(call: &mut Call<'_, '_>, by_value: bool) -> NativeResult {
    value(entry(call, by_value)?.map_or(Value::Nil, |(item, _, _)| item))
}

fn assoc_value(call: &mut Call<'_, '_>) -> NativeResult {
    value(entry(call, false)?.map_or(call.argument(2), |(_, _, content)| content))
}

/// One half of every entry of an association list.
fn halves(call: &mut Call<'_, '_>, values: bool) -> NativeResult {
    let mut found = Vec::new();
    for item in elements(call, 0)? {
        match item {
            Value::Nil => {}
            Value::Cons(index) => {
                let (key, content) = call.machine.heap.pair(index);
                found.push(if values { content } else { key });
            }
            other => {
                return Err(no_pair(call, 0, other));
            }
        }
    }
    list(call, &found)
}

fn remove(call: &mut Call<'_, '_>) -> NativeResult {
    let unwanted = call.argument(0);
    let mut items = elements(call, 1)?;
    let mut steps = 0;
    items.retain(|&item| {
        let (is_unwanted, looked_at) = call.machine.heap.compared(item, unwanted);
        steps += looked_at;
        !is_unwanted
    });
    call.burn(steps);
    list(call, &items)
}

fn substitute(call: &mut Call<'_, '_>) -> NativeResult {
    let (new, old) = (call.argument(0), call.argument(1));
    let mut items = elements(call, 2)?;
    let mut steps = 0;
    for item in &mut items {
        let (is_old, looked_at) = call.machine.heap.compared(*item, old);
        steps += looked_at;
        if is_old {
            *item = new;
        }
    }
    call.burn(steps);
    list(call, &items)
}

/// Elements of lists, vectors and strings.
pub(super) const NATIVES: &[Native] = &[
    pure("length", "sequence", "How many elements or characters there are.", length),
    pure("reverse", "sequence", "A new list, vector or string in the opposite order.", reverse),
    pure(
        "subseq",
        "sequence start &optional end",
        "A copy of the part from a position up to another that is not in it.",
        subsequence,
    ),
    pure("elt", "sequence position", "The element, or string of one character, at a position counted from 0.", elt),
    pure("member", "value list", "The list from the first element that is equal to the value, or nil.", member),
    pure("position", "value list", "The position of the first element that is equal to the value, or nil.", position),
    pure("assoc", "key alist", "The first entry of an association list whose key is equal, or nil.", |call| {
        assoc(call, false)
    }),
    pure("rassoc", "value alist", "The first entry of an association list whose value is equal, or nil.", |call| {
        assoc(call, true)
    }),
    pure(
        "assoc-value",
        "key alist &optional default",
        "The value that belongs to the key in an association list, or the default.",
        assoc_value,
    ),
    pure("alist-keys", "alist", "The keys of an association list.", |call| halves(call, false)),
    pure("alist-values", "alist", "The values of an association list.", |call| halves(call, true)),
    pure("remove", "value list", "A copy of the list without the elements that are equal to the value.", remove),
    pure(
        "substitute",
        "value former list",
        "A copy of the list with a new element in place of each that is equal to the old one.",
        substitute,
    ),
];
