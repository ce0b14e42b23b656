//! What the prelude is built on: steps of list functions that would be slow, or checks that would
//! be clumsy, in RPL. Their names begin with `%`; plans do not call them.

use crate::arguments::{
    NativeResult, changing, elements, list, natural, pure, room_for_pairs, text, truth, value, vector_items,
};
use crate::symbols::named;
use rpl_lang::code::GlobalKind;
use rpl_lang::diagnostic::NOT_OF_THE_FORM;
use rpl_lang::kind::Kind;
use rpl_lang::symbol::{Qualifier, base_name};
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Effect, Native, NativeCode};

/// Turns a list round in place. The prelude does so only with lists nobody else has seen.
fn reverse_in_place(call: &mut Call<'_, '_>) -> NativeResult {
    let (mut turned, mut passed) = (Value::Nil, 0);
    let mut at = call.argument(0);
    while let Value::Cons(index) = at {
        let heap = &mut call.machine.heap;
        let next = heap.pairs.cdr(index);
        heap.set_cdr(index, turned);
        (at, turned) = (next, at);
        passed += 1;
    }
    call.burn_walk(passed);
    value(turned)
}

/// A new last pair; has an instruction. Only for lists nobody else has seen.
fn extend(call: &mut Call<'_, '_>) -> NativeResult {
    value(Value::Cons(call.machine.heap.extend(&call.argument(0), &call.argument(1))))
}

/// What has an instruction only.
fn no_call(_: &mut Call<'_, '_>) -> NativeResult {
    Err(Raise::type_error("this is no function, but a loop"))
}

/// The first elements of all lists, then the second ones, up to the end of the shortest.
fn transpose(call: &mut Call<'_, '_>) -> NativeResult {
    let mut columns = Vec::new();
    let mut count = 0;
    for column in elements(call, 0)? {
        let heap = &call.machine.heap;
        let vector = match column {
            Value::Vector(vector) => Some(heap.vectors[vector].elements()),
            _ => None,
        };
        count += vector.map_or_else(|| heap.length(column).unwrap_or(0), <[Value]>::len);
        room_for_pairs(call, 2 * count)?;
        match vector.map_or_else(|| heap.elements(column), |items| Ok(items.to_vec())) {
            Ok(items) => columns.push(items),
            Err(_) => {
                return Err(call.machine.wrong_type(
                    "each argument behind the function",
                    Kind::Elements.noun(),
                    column,
                ));
            }
        }
    }
    call.burn(count);
    let length = columns.iter().map(Vec::len).min().unwrap_or(0);
    let rows: Vec<Value> = (0..length)
        .map(|row| {
            let row: Vec<Value> = columns.iter().map(|column| column[row]).collect();
            call.machine.heap.list(&row)
        })
        .collect();
    list(call, &rows)
}

/// The list in the first argument, or the elements of the vector; the others name the function and the position for
/// the error.
fn checked_elements(call: &mut Call<'_, '_>) -> NativeResult {
    match call.argument(0) {
        Value::Nil | Value::Cons(_) => value(call.argument(0)),
        Value::Vector(_) => {
            let items = vector_items(call, 0)?;
            list(call, &items)
        }
        other => {
            let what = format!("argument {} of `{}`", call.integer(2)?, call.name(1)?);
            Err(call.machine.wrong_type(&what, Kind::Elements.noun(), other))
        }
    }
}

/// The elements of the vector in the first argument, and any other value as it is.
fn listed(call: &mut Call<'_, '_>) -> NativeResult {
    match call.argument(0) {
        Value::Vector(_) => {
            let items = vector_items(call, 0)?;
            list(call, &items)
        }
        other => value(other),
    }
}

/// The function in the first argument.
fn checked_function(call: &mut Call<'_, '_>) -> NativeResult {
    match call.argument(0) {
        Value::Function(_) | Value::Closure(_) | Value::Native(_) => value(call.argument(0)),
        other => {
            let what = format!("argument {} of `{}`", call.integer(2)?, call.name(1)?);
            Err(call.machine.wrong_type(&what, Kind::Function.noun(), other))
        }
    }
}

/// A symbol without its qualifier; anything else as it is.
fn unqualified(call: &mut Call<'_, '_>) -> NativeResult {
    let Value::Symbol(written) = call.argument(0) else { return value(call.argument(0)) };
    let base = match Qualifier::split(call.machine.symbols.name(written)) {
        Some((_, base)) => base.to_string(),
        None => return value(Value::Symbol(written)),
    };
    value(Value::Symbol(named(call, |symbols| symbols.intern(&base))))
}

/// Whether a symbol is, where macros are expanded, the name of a function and of no macro.
fn names_function(call: &mut Call<'_, '_>) -> NativeResult {
    let Value::Symbol(written) = call.argument(0) else { return truth(false) };
    let symbols = &call.machine.symbols;
    let text = base_name(symbols.name(written));
    let name = symbols.find(text).unwrap_or(written);
    let program = call.around.program;
    let is_macro = program.macros.contains_key(&name);
    let is_global = program
        .names
        .get(&name)
        .is_some_and(|&global| matches!(program.globals[global as usize].kind, GlobalKind::Function(_)));
    let is_native = || call.around.natives.iter().any(|native| native.name == text);
    truth(!is_macro && (is_global || is_native()))
}

/// The list in the first argument, if it fits a parameter list with these numbers of elements and, behind a position,
/// those keywords.
fn fitted(call: &mut Call<'_, '_>) -> NativeResult {
    let list = call.argument(0);
    let (least, most, positional) = (natural(call, 2)?, natural(call, 3)?, natural(call, 4)?);
    let parameters = call.machine.brief(call.around.program, call.argument(1));
    let Ok(length) = call.machine.heap.length(list) else {
        return Err(call.machine.wrong_type(&format!("what `{parameters}` takes apart"), Kind::List.noun(), list));
    };
    call.burn_walk(length);
    if length < least || length > most {
        let elements = |count: usize| if count == 1 { "1 element".to_string() } else { format!("{count} elements") };
        let takes = match most {
            _ if most == least => elements(least),
            _ if most == i64::MAX as usize => format!("at least {}", elements(least)),
            _ => format!("{least} to {}", elements(most)),
        };
        let found = call.machine.brief(call.around.program, list);
        let message = format!("`{parameters}` takes {takes}, and the list has {length}: {found}");
        return Err(Raise::new("arity-error", message));
    }
    let keys = call.machine.heap.elements(call.argument(5)).unwrap_or_default();
    if !keys.is_empty() && length > positional {
        let rest = call.machine.heap.first_elements(list, length).split_off(positional);
        for pair in rest.chunks(2) {
            let key = call.machine.brief(call.around.program, pair[0]);
            if !keys.contains(&pair[0]) {
                let known: Vec<String> = keys.iter().map(|&key| call.machine.brief(call.around.program, key)).collect();
                let message = format!("`{parameters}` takes the keywords {}, not `{key}`", known.join(" "));
                return Err(Raise::new("arity-error", message));
            }
            if pair.len() == 1 {
                return Err(Raise::new(
                    "arity-error",
                    format!("`{key}` has no value in what `{parameters}` takes apart"),
                ));
            }
        }
    }
    value(list)
}

/// What follows a keyword among those behind a position of a list, the last one if there are several; else nil.
fn behind_key(call: &mut Call<'_, '_>) -> NativeResult {
    let (key, mut found) = (call.argument(2), Value::Nil);
    let pairs: Vec<(u32, Value)> = call.machine.heap.spine(call.argument(0)).skip(natural(call, 1)?).collect();
    call.burn_walk(pairs.len());
    for keyed in pairs.chunks_exact(2).filter(|keyed| keyed[0].1 == key) {
        found = Value::Cons(keyed[1].0);
    }
    value(found)
}

/// A value in the message of a failure, cut where it is long.
fn brief(call: &mut Call<'_, '_>) -> NativeResult {
    let brief = call.machine.brief(call.around.program, call.argument(0));
    text(call, &brief)
}

/// The record in the first argument, if it is of the kind in the second.
fn checked_record(call: &mut Call<'_, '_>) -> NativeResult {
    call.machine.check_record(call.around.program, call.argument(0), call.argument(1))?;
    value(call.argument(0))
}

/// Slots that are read have an instruction where the kind and a place below 256 are written out.
fn slot(call: &mut Call<'_, '_>) -> NativeResult {
    let (record, kind, place) = (call.argument(0), call.argument(1), natural(call, 2)?);
    match call.machine.heap.slot(&record, &kind, place) {
        Some(pair) => value(call.machine.heap.pair(pair).0),
        None => call.machine.check_record(call.around.program, record, kind).and(value(Value::Nil)),
    }
}

/// So have slots that are assigned.
fn assign_slot(call: &mut Call<'_, '_>) -> NativeResult {
    let (record, kind, place) = (call.argument(0), call.argument(1), natural(call, 2)?);
    let Some(pair) = call.machine.heap.slot(&record, &kind, place) else {
        return Err(call.machine.no_slot_to_set(call.around.program, record, kind, place));
    };
    if call.machine.heap.pairs.is_frozen(pair) {
        return Err(call.machine.frozen(record));
    }
    *call.machine.heap.pairs.car_mut(pair) = call.argument(3);
    value(call.argument(3))
}

/// What a macro raises when its form is not of the right shape.
fn malformed(call: &mut Call<'_, '_>) -> NativeResult {
    Err(Raise::type_error(format!("{NOT_OF_THE_FORM}{}", call.text(0)?)))
}

/// Support of the prelude.
pub(super) const NATIVES: &[Native] = &[
    pure("%nreverse", "list", "The pairs of a new list in the opposite order.", reverse_in_place),
    pure("%extend", "list value", "A new pair behind the last pair of a new list.", extend),
    Native {
        name: "%each",
        parameters: "function list value form &optional item",
        doc: "Calls the function with each element; in the form, evaluated each time, variables stand for its value and the item. Has an instruction, and is nothing but its name.",
        effect: Effect::Calls,
        code: NativeCode::Plain(no_call),
    },
    pure("%transpose", "columns", "Rows of columns.", transpose),
    pure(
        "%elements",
        "value name position",
        "The value if it is a list, the elements of a vector, else an error.",
        checked_elements,
    ),
    pure("%listed", "value", "The elements of a vector as a list, any other value as it is.", listed),
    pure("%checked-function", "value name position", "The value if it is a function, else an error.", checked_function),
    pure("%unqualified", "value", "A symbol without its qualifier.", unqualified),
    pure("%names-function", "name", "Whether a symbol is the name of a function.", names_function),
    pure("%fitted", "value form integer integer integer values", "The list, if it fits a parameter list.", fitted),
    pure(
        "%behind-key",
        "list position key",
        "What follows a keyword in a list, behind a position; else nil.",
        behind_key,
    ),
    pure("%brief", "value", "The value as it could be read, cut where it is long.", brief),
    pure("%checked-record", "value kind", "The value if it is a record of the kind, else an error.", checked_record),
    pure("%slot", "value kind position", "The slot at a place of a record of the kind.", slot),
    changing(
        "%assign-slot",
        "value kind position value",
        "Sets the slot at a place of a record of the kind.",
        assign_slot,
    ),
    pure("%malformed", "form", "The error of a macro whose form is malformed.", malformed),
];
