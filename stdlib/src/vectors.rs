//! Vectors: elements by their position.

use crate::arguments::{
    NativeResult, changing, elements, list, natural, pure, room_for, truth, value, vector, vector_items,
};
use rpl_runtime::state::heap::vector_elements;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Native};

fn vector_of(call: &mut Call<'_, '_>) -> NativeResult {
    vector(call, call.arguments.to_vec())
}

fn make_vector(call: &mut Call<'_, '_>) -> NativeResult {
    let length = natural(call, 0)?;
    room_for(call, length.saturating_mul(size_of::<Value>()).saturating_add(vector_elements(0)))?;
    vector(call, vec![call.argument(1); length])
}

/// Both have an instruction where they are called by name.
fn element(call: &mut Call<'_, '_>) -> NativeResult {
    let (of, position) = (call.argument(0), call.argument(1));
    match call.machine.heap.element(&of, &position) {
        Some(&element) => value(element),
        None => Err(call.machine.no_element("vref", of, position)),
    }
}

fn set_element(call: &mut Call<'_, '_>) -> NativeResult {
    let (of, position, new) = (call.argument(0), call.argument(1), call.argument(2));
    assign_element(call, "(setf vref)", of, position, new)
}

/// Assigns an element of a vector, for the form that the error names.
pub(crate) fn assign_element(
    call: &mut Call<'_, '_>,
    form: &str,
    of: Value,
    position: Value,
    new: Value,
) -> NativeResult {
    match call.machine.heap.element_mut(&of, &position) {
        Some(element) => *element = new,
        None => return Err(call.machine.no_element(form, of, position)),
    }
    value(new)
}

fn from_list(call: &mut Call<'_, '_>) -> NativeResult {
    let items = elements(call, 0)?;
    vector(call, items)
}

fn to_list(call: &mut Call<'_, '_>) -> NativeResult {
    let items = vector_items(call, 0)?;
    list(call, &items)
}

/// A list as a vector if the first argument is a vector, else as it is: what functions over lists and vectors make.
fn like(call: &mut Call<'_, '_>) -> NativeResult {
    match call.argument(0) {
        Value::Vector(_) => {
            let items = elements(call, 1)?;
            vector(call, items)
        }
        _ => value(call.argument(1)),
    }
}

/// Vectors.
pub(super) const NATIVES: &[Native] = &[
    pure("vector", "&rest values", "A vector of the values.", vector_of),
    pure("make-vector", "length &optional value", "A vector of LENGTH elements, each the value.", make_vector),
    pure("vref", "vector position", "The element of a vector at a position counted from 0.", element),
    changing("%set-vref", "vector position value", "Sets the element of a vector at a position.", set_element),
    pure("vectorp", "value", "Whether the value is a vector.", |call| {
        truth(matches!(call.argument(0), Value::Vector(_)))
    }),
    pure("list->vector", "list", "A vector of the elements of a list.", from_list),
    pure("vector->list", "vector", "A list of the elements of a vector.", to_list),
    pure("%like", "value list", "The list, or a vector of its elements if the value is a vector.", like),
];
