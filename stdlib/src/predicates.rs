//! What a value is, and whether two are the same.

use crate::arguments::{NativeResult, pure, truth};
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Native};

fn is(call: &Call<'_, '_>, test: fn(Value) -> bool) -> NativeResult {
    truth(test(call.argument(0)))
}

fn same(call: &mut Call<'_, '_>) -> NativeResult {
    truth(call.argument(0) == call.argument(1))
}

fn equal(call: &mut Call<'_, '_>) -> NativeResult {
    let (are_equal, pairs) = call.machine.heap.compared(call.argument(0), call.argument(1));
    call.burn(pairs);
    truth(are_equal)
}

/// Predicates.
pub(super) const NATIVES: &[Native] = &[
    pure("eq", "a b", "Whether both are the same object, symbol or number.", same),
    pure("eql", "a b", "Whether both are the same object, symbol or number.", same),
    pure("equal", "a b", "Whether both have the same structure; an integer is never equal to a float.", equal),
    pure("not", "value", "Whether the value is nil.", |call| is(call, |value| !value.is_true())),
    pure("null", "value", "Whether the value is the empty list.", |call| is(call, |value| !value.is_true())),
    pure("consp", "value", "Whether the value is a list that is not empty.", |call| {
        is(call, |value| matches!(value, Value::Cons(_)))
    }),
    pure("listp", "value", "Whether the value is a list.", |call| {
        is(call, |value| matches!(value, Value::Cons(_) | Value::Nil))
    }),
    pure("atom", "value", "Whether the value is not a pair.", |call| {
        is(call, |value| !matches!(value, Value::Cons(_)))
    }),
    pure("symbolp", "value", "Whether the value is a symbol; nil, t and keywords are.", |call| {
        is(call, |value| matches!(value, Value::Symbol(_) | Value::Keyword(_) | Value::Nil | Value::True))
    }),
    pure("keywordp", "value", "Whether the value is a keyword.", |call| {
        is(call, |value| matches!(value, Value::Keyword(_)))
    }),
    pure("numberp", "value", "Whether the value is a number.", |call| {
        is(call, |value| matches!(value, Value::Int(_) | Value::Float(_)))
    }),
    pure("integerp", "value", "Whether the value is an integer.", |call| {
        is(call, |value| matches!(value, Value::Int(_)))
    }),
    pure("floatp", "value", "Whether the value is a float.", |call| is(call, |value| matches!(value, Value::Float(_)))),
    pure("stringp", "value", "Whether the value is a string.", |call| is(call, |value| matches!(value, Value::Str(_)))),
    pure("functionp", "value", "Whether the value is a function or plan.", |call| {
        is(call, |value| matches!(value, Value::Function(_) | Value::Closure(_) | Value::Native(_)))
    }),
    pure("fluentp", "value", "Whether the value is a fluent.", |call| {
        is(call, |value| matches!(value, Value::Fluent(_)))
    }),
    pure("taskp", "value", "Whether the value is a task.", |call| is(call, |value| matches!(value, Value::Task(_)))),
    pure("failurep", "value", "Whether the value is a failure.", |call| {
        is(call, |value| matches!(value, Value::Failure(_)))
    }),
    pure("tablep", "value", "Whether the value is a hash table.", |call| {
        is(call, |value| matches!(value, Value::Table(_)))
    }),
];
