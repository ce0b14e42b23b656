//! Reading the arguments of a native, with errors that say what was found, and room for results.

use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::heap::{PAIR, vector_elements};
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Effect, Native, NativeCode, NativeFunction, Reply};
use std::sync::Arc;

/// What every native of the library answers.
pub(crate) type NativeResult = Result<Reply, Raise>;

/// A native without effect.
pub(crate) const fn pure(
    name: &'static str,
    parameters: &'static str,
    doc: &'static str,
    code: NativeFunction,
) -> Native {
    Native { name, parameters, doc, effect: Effect::None, code: NativeCode::Plain(code) }
}

/// A native that changes an object a plan can see: no network may call it.
pub(crate) const fn changing(
    name: &'static str,
    parameters: &'static str,
    doc: &'static str,
    code: NativeFunction,
) -> Native {
    Native { name, parameters, doc, effect: Effect::Acts, code: NativeCode::Plain(code) }
}

/// Answers with a value.
pub(crate) fn value(value: Value) -> NativeResult {
    Ok(Reply::Value(value))
}

/// Answers with `t` or `nil`.
pub(crate) fn truth(condition: bool) -> NativeResult {
    value(Value::truth(condition))
}

/// Answers with an integer.
pub(crate) fn integer(number: i64) -> NativeResult {
    value(Value::Int(number))
}

/// Answers with a new string.
pub(crate) fn text(call: &mut Call<'_, '_>, text: &str) -> NativeResult {
    room_for_text(call, text.len())?;
    call.burn_text(text.len());
    value(call.machine.heap.string(text))
}

/// Answers with a new string that was written into [`Call::draft`].
pub(crate) fn drafted(call: &mut Call<'_, '_>, draft: String) -> NativeResult {
    let answer = text(call, &draft);
    call.lay_aside(draft);
    answer
}

/// Answers with a new list.
pub(crate) fn list(call: &mut Call<'_, '_>, items: &[Value]) -> NativeResult {
    room_for_pairs(call, items.len())?;
    call.burn(items.len());
    value(call.machine.heap.list(items))
}

/// Answers with a new vector.
pub(crate) fn vector(call: &mut Call<'_, '_>, items: Vec<Value>) -> NativeResult {
    room_for(call, vector_elements(items.len()))?;
    call.burn(items.len());
    value(call.machine.heap.vector(items))
}

/// An `index-error`.
pub(crate) fn index_error(message: String) -> Raise {
    Raise::new("index-error", message)
}

/// How many arguments were given.
pub(crate) fn count(call: &Call<'_, '_>) -> usize {
    call.arguments.len()
}

/// The argument at a position if it was given and is not `nil`.
pub(crate) fn given(call: &Call<'_, '_>, at: usize) -> Option<Value> {
    Some(call.argument(at)).filter(|value| value.is_true())
}

/// An argument that counts or numbers something.
///
/// # Errors
/// A `type-error` if it is no integer, an `index-error` if it is negative.
pub(crate) fn natural(call: &Call<'_, '_>, at: usize) -> Result<usize, Raise> {
    let number = call.integer(at)?;
    usize::try_from(number)
        .map_err(|_| index_error(format!("{} must not be negative, and it is {number}", call.which(at))))
}

/// An error unless a walk of the list in an argument has ended in nil.
pub(crate) fn proper_end(call: &Call<'_, '_>, at: usize, end: Value) -> Result<(), Raise> {
    if end == Value::Nil { Ok(()) } else { Err(call.wrong_type(at)) }
}

/// The elements of the list in an argument.
///
/// # Errors
/// A `type-error` if it is no proper list.
pub(crate) fn elements(call: &mut Call<'_, '_>, at: usize) -> Result<Vec<Value>, Raise> {
    let mut spine = call.machine.heap.spine(call.argument(at));
    let length = spine.by_ref().count();
    let end = spine.rest();
    call.burn(length);
    proper_end(call, at, end)?;
    room_for(call, length * size_of::<Value>())?;
    Ok(call.machine.heap.first_elements(call.argument(at), length))
}

/// A list, a vector, or the text of a string.
pub(crate) enum Sequence {
    List(Vec<Value>),
    Vector(Vec<Value>),
    Text(Arc<str>),
}

/// The argument at a position as a list, vector or string.
pub(crate) fn sequence(call: &mut Call<'_, '_>, at: usize) -> Result<Sequence, Raise> {
    match call.argument(at) {
        Value::Str(_) => call.text(at).map(Sequence::Text),
        Value::Nil | Value::Cons(_) => elements(call, at).map(Sequence::List),
        Value::Vector(_) => vector_items(call, at).map(Sequence::Vector),
        _ => Err(call.wrong_type(at)),
    }
}

/// A copy of the elements of the vector in an argument.
///
/// # Errors
/// A `type-error` if it is none.
pub(crate) fn vector_items(call: &mut Call<'_, '_>, at: usize) -> Result<Vec<Value>, Raise> {
    let Value::Vector(index) = call.argument(at) else { return Err(call.wrong_type(at)) };
    let length = call.machine.heap.vectors[index].elements().len();
    room_for(call, vector_elements(length))?;
    call.burn_walk(length);
    Ok(call.machine.heap.vectors[index].elements().to_vec())
}

/// Asks for `bytes` more bytes before they are taken: one call can want more than a collection between two calls could
/// notice. Asked for before anything is made or changed: the native may be called again when there is room.
pub(crate) fn room_for(call: &Call<'_, '_>, bytes: usize) -> Result<(), Raise> {
    match call.machine.has_room(bytes) {
        true => Ok(()),
        false => Err(Raise::NoRoom(bytes)),
    }
}

/// The same for a text of `bytes` bytes, which is built and then kept.
pub(crate) fn room_for_text(call: &Call<'_, '_>, bytes: usize) -> Result<(), Raise> {
    room_for(call, bytes.saturating_mul(2))
}

/// The same for a list of `pairs` elements, which are gathered and then linked.
pub(crate) fn room_for_pairs(call: &Call<'_, '_>, pairs: usize) -> Result<(), Raise> {
    room_for(call, pairs.saturating_mul(PAIR + size_of::<Value>()))
}

/// A value as `print` shows it.
pub(crate) fn show(call: &mut Call<'_, '_>, value: Value) -> String {
    let text = call.machine.show(call.around.program, value);
    call.burn_text(text.len());
    text
}
