//! Reading the arguments of a native, with errors that say what was found, and room for results.

use rpl_runtime::failure::Raise;
use rpl_runtime::native::{Call, Effect, Native, NativeCode, Reply};
use rpl_runtime::value::Value;
use std::sync::Arc;

/// What every native of the library answers.
pub(crate) type Answer = Result<Reply, Raise>;

/// A native without effect.
pub(crate) const fn pure(name: &'static str, parameters: &'static str, doc: &'static str, code: NativeCode) -> Native {
    Native { name, parameters, doc, effect: Effect::None, code }
}

/// A native that changes an object a plan can see: no network may call it.
pub(crate) const fn changing(
    name: &'static str,
    parameters: &'static str,
    doc: &'static str,
    code: NativeCode,
) -> Native {
    Native { name, parameters, doc, effect: Effect::Acts, code }
}

/// Answers with a value.
pub(crate) fn value(value: Value) -> Answer {
    Ok(Reply::Value(value))
}

/// Answers with `t` or `nil`.
pub(crate) fn truth(condition: bool) -> Answer {
    value(Value::truth(condition))
}

/// Answers with an integer.
pub(crate) fn integer(number: i64) -> Answer {
    value(Value::Int(number))
}

/// Answers with a new string.
pub(crate) fn text(call: &mut Call<'_, '_>, text: &str) -> Answer {
    room_for(call, text.len())?;
    burn_text(call, text.len());
    value(call.machine.heap.string(text))
}

/// Answers with a new list.
pub(crate) fn list(call: &mut Call<'_, '_>, items: &[Value]) -> Answer {
    room_for_pairs(call, items.len())?;
    call.burn(items.len());
    value(call.machine.heap.list(items))
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
    let items: Vec<Value> = spine.by_ref().map(|(_, item)| item).collect();
    let end = spine.rest();
    call.burn(items.len());
    proper_end(call, at, end)?;
    Ok(items)
}

/// A list, or the text of a string.
pub(crate) enum Sequence {
    List(Vec<Value>),
    Text(Arc<str>),
}

/// The argument at a position as a list or string.
pub(crate) fn sequence(call: &mut Call<'_, '_>, at: usize) -> Result<Sequence, Raise> {
    match call.argument(at) {
        Value::Str(_) => call.text(at).map(Sequence::Text),
        Value::Nil | Value::Cons(_) => elements(call, at).map(Sequence::List),
        _ => Err(call.wrong_type(at)),
    }
}

/// An error if so many more bytes would pass the limit on memory: one call can ask for more than a
/// collection between two calls could notice.
pub(crate) fn room_for(call: &Call<'_, '_>, bytes: usize) -> Result<(), Raise> {
    let limit = call.machine.limits.bytes;
    if bytes > limit || call.machine.heap.used_bytes().saturating_add(bytes) > limit.saturating_mul(2) {
        let megabytes = limit >> 20;
        return Err(Raise::new(
            "out-of-memory",
            format!("the result would pass the limit of {megabytes} MiB; build less of it at a time"),
        ));
    }
    Ok(())
}

/// The same for a list of so many elements.
pub(crate) fn room_for_pairs(call: &Call<'_, '_>, pairs: usize) -> Result<(), Raise> {
    room_for(call, pairs.saturating_mul(size_of::<(Value, Value)>()))
}

/// A value as `print` shows it.
pub(crate) fn show(call: &mut Call<'_, '_>, value: Value) -> String {
    let text = call.machine.show(call.around.program, value);
    burn_text(call, text.len());
    text
}

/// So much text is made, or looked through, in the time of one turn of a loop.
const CHARACTERS_A_STEP: usize = 8;

/// So many pairs are passed in the time of one turn of a loop.
const PAIRS_A_STEP: usize = 4;

/// Takes the steps of a walk that passed so many pairs.
pub(crate) fn burn_walk(call: &mut Call<'_, '_>, pairs: usize) {
    call.burn(pairs / PAIRS_A_STEP);
}

/// Takes the steps of looking through so many bytes of text.
pub(crate) fn burn_text(call: &mut Call<'_, '_>, bytes: usize) {
    call.burn(bytes / CHARACTERS_A_STEP);
}
