//! Strings. Positions and lengths count characters, not bytes.

use crate::arguments::{
    NativeResult, count, drafted, elements, list, natural, pure, room_for_text, show, text, truth, value,
};
use crate::elements::{characters, part};
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Native};
use std::cmp::Ordering;

/// A pattern that must not be empty.
fn pattern(call: &Call<'_, '_>, at: usize) -> Result<std::sync::Arc<str>, Raise> {
    let pattern = call.text(at)?;
    if pattern.is_empty() {
        return Err(Raise::type_error(format!("{} must not be an empty string", call.which(at))));
    }
    Ok(pattern)
}

fn string_append(call: &mut Call<'_, '_>) -> NativeResult {
    let mut length = 0;
    for at in 0..count(call) {
        length += call.str(at)?.len();
    }
    room_for_text(call, length)?;
    let mut joined = call.draft();
    joined.reserve(length);
    for at in 0..count(call) {
        joined.push_str(call.str(at)?);
    }
    drafted(call, joined)
}

/// Adds a value as `print` shows it, if there is room for the whole.
fn push_shown(call: &mut Call<'_, '_>, joined: &mut String, value: Value) -> Result<(), Raise> {
    let before = joined.len();
    if let Value::Str(index) = value {
        let string = &call.machine.heap.strings[index];
        room_for_text(call, before + string.len())?;
        joined.push_str(string);
    } else {
        call.machine.show_into(call.around.program, value, joined);
        room_for_text(call, joined.len())?;
    }
    call.burn_text(joined.len() - before);
    Ok(())
}

/// The arguments as `print` shows them, one after the other.
fn concat(call: &mut Call<'_, '_>) -> NativeResult {
    let mut joined = call.draft();
    for &argument in call.arguments {
        push_shown(call, &mut joined, argument)?;
    }
    drafted(call, joined)
}

/// Whether an order holds between all neighbours; symbols count as their names.
fn chain(call: &mut Call<'_, '_>, holds: fn(Ordering) -> bool) -> NativeResult {
    let names: Vec<String> = (0..count(call)).map(|at| call.name(at)).collect::<Result<_, _>>()?;
    call.burn_text(names.iter().map(String::len).sum());
    truth(names.windows(2).all(|pair| holds(pair[0].cmp(&pair[1]))))
}

fn substring(call: &mut Call<'_, '_>) -> NativeResult {
    let string = call.text(0)?;
    call.burn_text(string.len());
    let (start, end) = part(call, string.chars().count())?;
    text(call, characters(&string, start, end))
}

fn search(call: &mut Call<'_, '_>) -> NativeResult {
    let (wanted, string) = (call.text(0)?, call.text(1)?);
    call.burn_text(wanted.len() + string.len());
    let start = if count(call) > 2 { natural(call, 2)? } else { 0 };
    let Some(from) = string.char_indices().map(|(byte, _)| byte).chain([string.len()]).nth(start) else {
        return value(Value::Nil);
    };
    value(match string[from..].find(&*wanted) {
        Some(byte) => Value::Int((start + string[from..from + byte].chars().count()) as i64),
        None => Value::Nil,
    })
}

fn starts(call: &mut Call<'_, '_>) -> NativeResult {
    truth(call.text(1)?.starts_with(&*call.text(0)?))
}

fn ends(call: &mut Call<'_, '_>) -> NativeResult {
    truth(call.text(1)?.ends_with(&*call.text(0)?))
}

/// Without a separator the words between spaces, which are never empty.
fn split(call: &mut Call<'_, '_>) -> NativeResult {
    let string = call.text(0)?;
    call.burn_text(string.len());
    if count(call) == 1 {
        return list_of_strings(call, string.split_whitespace());
    }
    let separator = pattern(call, 1)?;
    let mut characters = separator.chars();
    match (characters.next(), characters.next()) {
        // One character is found without looking at the others.
        (Some(character), None) => list_of_strings(call, string.split(character)),
        _ => list_of_strings(call, string.split(&*separator)),
    }
}

/// What a string in a list takes beside its text, halved.
const BYTES_A_STRING: usize = 64;

fn list_of_strings<'s>(call: &mut Call<'_, '_>, parts: impl Iterator<Item = &'s str> + Clone) -> NativeResult {
    let (count, bytes) = parts.clone().fold((0, 0), |(count, bytes), part| (count + 1, bytes + part.len()));
    room_for_text(call, bytes + count * BYTES_A_STRING)?;
    let parts: Vec<Value> = parts.map(|part| call.machine.heap.string(part)).collect();
    list(call, &parts)
}

fn join(call: &mut Call<'_, '_>) -> NativeResult {
    let separator = if count(call) > 1 { call.text(1)?.to_string() } else { String::new() };
    let mut joined = String::new();
    for (position, item) in elements(call, 0)?.into_iter().enumerate() {
        if position > 0 {
            joined.push_str(&separator);
        }
        push_shown(call, &mut joined, item)?;
    }
    text(call, &joined)
}

/// `(string-trim STRING)` or, as in Common Lisp, `(string-trim CHARACTERS STRING)`.
fn trim(call: &mut Call<'_, '_>) -> NativeResult {
    if count(call) == 1 {
        let string = call.text(0)?;
        return text(call, string.trim());
    }
    let (unwanted, string) = (call.text(0)?, call.text(1)?);
    text(call, string.trim_matches(|character| unwanted.contains(character)))
}

fn replace(call: &mut Call<'_, '_>) -> NativeResult {
    let (string, old, new) = (call.text(0)?, pattern(call, 1)?, call.text(2)?);
    call.burn_text(string.len());
    room_for_text(call, string.matches(&*old).count().saturating_mul(new.len()).saturating_add(string.len()))?;
    text(call, &string.replace(&*old, &new))
}

fn repeat(call: &mut Call<'_, '_>) -> NativeResult {
    let (string, times) = (call.text(0)?, natural(call, 1)?);
    room_for_text(call, string.len().saturating_mul(times))?;
    // An empty string can be asked for any number of times.
    text(call, &string.repeat(if string.is_empty() { 0 } else { times }))
}

fn upcase(call: &mut Call<'_, '_>) -> NativeResult {
    let string = call.text(0)?.to_uppercase();
    text(call, &string)
}

fn downcase(call: &mut Call<'_, '_>) -> NativeResult {
    let string = call.text(0)?.to_lowercase();
    text(call, &string)
}

fn to_characters(call: &mut Call<'_, '_>) -> NativeResult {
    let string = call.text(0)?;
    let ends = string.char_indices().map(|(start, character)| &string[start..start + character.len_utf8()]);
    list_of_strings(call, ends)
}

fn to_string(call: &mut Call<'_, '_>) -> NativeResult {
    if let Value::Str(_) = call.argument(0) {
        return value(call.argument(0));
    }
    let shown = match call.argument(0) {
        Value::Symbol(name) | Value::Keyword(name) => call.machine.symbols.name(name).to_string(),
        other => show(call, other),
    };
    text(call, &shown)
}

fn write_to_string(call: &mut Call<'_, '_>) -> NativeResult {
    let written = call.machine.write(call.around.program, call.argument(0));
    text(call, &written)
}

/// Strings.
pub(super) const NATIVES: &[Native] = &[
    pure("string-append", "&rest strings", "The strings one after the other.", string_append),
    pure("concat", "&rest values", "The values, as they are printed, one after the other in a string.", concat),
    pure("string", "value", "The value as a string: the name of a symbol or keyword, else what is printed.", to_string),
    pure("write-to-string", "value", "The value as it could be read again.", write_to_string),
    pure("string=", "name &rest names", "Whether all strings, or names of symbols, are the same.", |call| {
        chain(call, Ordering::is_eq)
    }),
    pure("string<", "name &rest names", "Whether each string comes before the next.", |call| {
        chain(call, Ordering::is_lt)
    }),
    pure("string>", "name &rest names", "Whether each string comes after the next.", |call| {
        chain(call, Ordering::is_gt)
    }),
    pure("string<=", "name &rest names", "Whether no string comes after the next.", |call| {
        chain(call, Ordering::is_le)
    }),
    pure("string>=", "name &rest names", "Whether no string comes before the next.", |call| {
        chain(call, Ordering::is_ge)
    }),
    pure("string-upcase", "string", "The string in capitals.", upcase),
    pure("string-downcase", "string", "The string in lower case.", downcase),
    pure(
        "substring",
        "string start &optional end",
        "The characters from a position up to another that is not in it.",
        substring,
    ),
    pure(
        "string-search",
        "pattern string &optional start",
        "The position where the pattern first occurs in the string, or nil.",
        search,
    ),
    pure("string-prefix-p", "prefix string", "Whether the string begins with the prefix.", starts),
    pure("string-suffix-p", "suffix string", "Whether the string ends with the suffix.", ends),
    pure(
        "string-split",
        "string &optional separator",
        "The parts of the string between separators, or the words between spaces.",
        split,
    ),
    pure(
        "string-join",
        "list &optional separator",
        "The elements, as they are printed, with a separator between them.",
        join,
    ),
    pure(
        "string-trim",
        "characters-or-string &optional string",
        "The string without spaces, or such characters, at its ends.",
        trim,
    ),
    pure(
        "string-replace",
        "string pattern replacement",
        "The string with a new part in place of each old one.",
        replace,
    ),
    pure("string-repeat", "string times", "The string repeated TIMES times.", repeat),
    pure("string->list", "string", "The characters of the string, each a string.", to_characters),
];
