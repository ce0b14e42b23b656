//! What `setf` calls: `(setf (ACCESSOR ARG...) VALUE)` is `(%set-ACCESSOR ARG... VALUE)` and gives
//! the value.

use crate::arguments::{NativeResult, changing, index_error, natural, value};
use crate::lists::follow;
use crate::vectors::assign_element;
use rpl_lang::kind::Kind;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Native};

/// Writes one half of the pair that the letters lead to from the first argument.
fn set_half(call: &mut Call<'_, '_>, way: &[u8], letter: u8) -> NativeResult {
    let pair = follow(call, way)?;
    let Value::Cons(index) = pair else {
        return Err(match pair {
            Value::Nil => index_error("the list is too short: there is no element to set".into()),
            other => call.machine.wrong_type(&format!("a part of {}", call.which(0)), Kind::List.noun(), other),
        });
    };
    if call.machine.heap.is_frozen(pair) {
        return Err(call.machine.frozen(pair));
    }
    let new = call.argument(1);
    if letter == b'a' {
        *call.machine.heap.pairs.car_mut(index) = new;
    } else {
        call.machine.heap.set_cdr(index, new);
    }
    value(new)
}

/// Writes the element at a position of the list in an argument.
fn set_element(call: &mut Call<'_, '_>, list: usize, position: usize, new: Value) -> NativeResult {
    let mut spine = call.machine.heap.spine(call.argument(list));
    let found = spine.nth(position);
    let length = spine.passed();
    call.burn_walk(length);
    if let Some((pair, _)) = found {
        if call.machine.heap.pairs.is_frozen(pair) {
            return Err(call.machine.frozen(Value::Cons(pair)));
        }
        *call.machine.heap.pairs.car_mut(pair) = new;
        return value(new);
    }
    Err(match call.argument(list) {
        Value::Nil | Value::Cons(_) => call.machine.no_element_to_set(call.argument(list), position),
        _ => call.wrong_type(list),
    })
}

fn set_nth(call: &mut Call<'_, '_>) -> NativeResult {
    let position = natural(call, 0)?;
    set_element(call, 1, position, call.argument(2))
}

fn set_elt(call: &mut Call<'_, '_>) -> NativeResult {
    if let Value::Str(_) = call.argument(0) {
        return Err(Raise::type_error("a string cannot be changed; build a new one with `string-append`"));
    }
    if let Value::Vector(_) = call.argument(0) {
        let (of, position, new) = (call.argument(0), call.argument(1), call.argument(2));
        return assign_element(call, "(setf elt)", of, position, new);
    }
    let position = natural(call, 1)?;
    set_element(call, 0, position, call.argument(2))
}

/// Setters of list places.
pub(super) const NATIVES: &[Native] = &[
    changing("%set-car", "list value", "Sets the first element.", |call| set_half(call, b"", b'a')),
    changing("%set-cdr", "list value", "Sets what follows the first element.", |call| set_half(call, b"", b'd')),
    changing("%set-caar", "list value", "Sets the car of the car.", |call| set_half(call, b"a", b'a')),
    changing("%set-cadr", "list value", "Sets the second element.", |call| set_half(call, b"d", b'a')),
    changing("%set-cdar", "list value", "Sets the cdr of the car.", |call| set_half(call, b"a", b'd')),
    changing("%set-cddr", "list value", "Sets what follows the second element.", |call| set_half(call, b"d", b'd')),
    changing("%set-caddr", "list value", "Sets the third element.", |call| set_half(call, b"dd", b'a')),
    changing("%set-first", "list value", "Sets the first element.", |call| set_half(call, b"", b'a')),
    changing("%set-second", "list value", "Sets the second element.", |call| set_half(call, b"d", b'a')),
    changing("%set-third", "list value", "Sets the third element.", |call| set_half(call, b"dd", b'a')),
    changing("%set-fourth", "list value", "Sets the fourth element.", |call| set_half(call, b"ddd", b'a')),
    changing("%set-fifth", "list value", "Sets the fifth element.", |call| set_half(call, b"dddd", b'a')),
    changing("%set-rest", "list value", "Sets what follows the first element.", |call| set_half(call, b"", b'd')),
    changing("%set-nth", "position list value", "Sets the element at a position counted from 0.", set_nth),
    changing("%set-elt", "list-or-vector position value", "Sets the element at a position counted from 0.", set_elt),
];
