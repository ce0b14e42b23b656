//! Hash tables: keys are compared as by `equal`, and plans see entries in the order of their keys.

use crate::arguments::{NativeResult, changing, elements, integer, list, pure, room_for, truth, value};
use crate::elements::no_pair;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::heap::{Key, PAIR, table_entry};
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Native};

/// The table in an argument.
fn table(call: &Call<'_, '_>, at: usize) -> Result<u32, Raise> {
    match call.argument(at) {
        Value::Table(table) => Ok(table),
        _ => Err(call.wrong_type(at)),
    }
}

/// The key in the first argument, and the table in another.
fn key_and_table(call: &mut Call<'_, '_>, at: usize) -> Result<(Key, u32), Raise> {
    let table = table(call, at)?;
    Ok((call.machine.key_of(call.argument(0))?, table))
}

/// Common Lisp's `:test` is taken and means nothing: every table compares by `equal`.
fn make_hash_table(call: &mut Call<'_, '_>) -> NativeResult {
    if let Some(&option) = call.arguments.first() {
        let is_test = matches!(option, Value::Keyword(name) if call.machine.symbols.name(name) == "test");
        if !is_test || call.arguments.len() != 2 {
            return Err(Raise::new(
                "arity-error",
                "`make-hash-table` takes no arguments but `:test`, which changes nothing",
            ));
        }
    }
    value(call.machine.heap.table())
}

fn from_alist(call: &mut Call<'_, '_>) -> NativeResult {
    let items = elements(call, 0)?;
    let (mut entries, mut bytes) = (Vec::with_capacity(items.len()), 0);
    for item in items {
        let Value::Cons(index) = item else {
            return Err(no_pair(call, 0, item));
        };
        let (of, content) = call.machine.heap.pair(index);
        let key = call.machine.key_of(of)?;
        bytes += 2 * table_entry(&key);
        room_for(call, bytes)?;
        entries.push((key, content));
    }
    let made = call.machine.heap.table();
    if let Value::Table(table) = made {
        // The first entry of a key counts, as for `assoc`.
        for (key, content) in entries.into_iter().rev() {
            call.machine.heap.enter(table, key, content);
        }
    }
    value(made)
}

fn gethash(call: &mut Call<'_, '_>) -> NativeResult {
    let (key, table) = key_and_table(call, 1)?;
    let found = call.machine.heap.table_value(table, &key);
    value(found.unwrap_or(call.argument(2)))
}

/// The value is the last argument; a default before it, as in `(incf (gethash k h 0))`, is passed
/// over.
fn set_gethash(call: &mut Call<'_, '_>) -> NativeResult {
    let (key, table) = key_and_table(call, 1)?;
    let content = call.arguments.last().copied().unwrap_or_default();
    changeable(call, table)?;
    room_for(call, table_entry(&key))?;
    call.machine.heap.enter(table, key, content);
    value(content)
}

/// Refuses to change a table that is frozen.
fn changeable(call: &Call<'_, '_>, table: u32) -> Result<(), Raise> {
    match call.machine.heap.tables[table].is_frozen() {
        true => Err(call.machine.frozen(Value::Table(table))),
        false => Ok(()),
    }
}

fn contains(call: &mut Call<'_, '_>) -> NativeResult {
    let (key, table) = key_and_table(call, 1)?;
    truth(call.machine.heap.table_value(table, &key).is_some())
}

fn remhash(call: &mut Call<'_, '_>) -> NativeResult {
    let (key, table) = key_and_table(call, 1)?;
    changeable(call, table)?;
    truth(call.machine.heap.remove_entry(table, &key))
}

fn clrhash(call: &mut Call<'_, '_>) -> NativeResult {
    let table = table(call, 0)?;
    changeable(call, table)?;
    call.burn(call.machine.heap.tables[table].len());
    call.machine.heap.tables[table].clear();
    value(call.argument(0))
}

fn count_entries(call: &mut Call<'_, '_>) -> NativeResult {
    let table = table(call, 0)?;
    integer(call.machine.heap.tables[table].len() as i64)
}

fn entries(call: &Call<'_, '_>) -> Result<Vec<(Value, Value)>, Raise> {
    let table = table(call, 0)?;
    let count = call.machine.heap.tables[table].len();
    room_for(call, count * (4 * size_of::<(Value, Value)>() + 2 * PAIR))?;
    Ok(call.machine.heap.entries_in_order(table))
}

fn keys(call: &mut Call<'_, '_>) -> NativeResult {
    let keys: Vec<Value> = entries(call)?.into_iter().map(|(key, _)| key).collect();
    list(call, &keys)
}

fn values(call: &mut Call<'_, '_>) -> NativeResult {
    let values: Vec<Value> = entries(call)?.into_iter().map(|(_, content)| content).collect();
    list(call, &values)
}

fn to_alist(call: &mut Call<'_, '_>) -> NativeResult {
    let pairs: Vec<Value> =
        entries(call)?.into_iter().map(|(key, content)| call.machine.heap.cons(key, content)).collect();
    list(call, &pairs)
}

/// Hash tables.
pub(super) const NATIVES: &[Native] = &[
    pure(
        "make-hash-table",
        "&key test",
        "A new, empty hash table; its keys are compared as by `equal`.",
        make_hash_table,
    ),
    pure("gethash", "key table &optional default", "The value of a key in a hash table, or the default.", gethash),
    changing("%set-gethash", "key table value &optional value-after-default", "Sets the value of a key.", set_gethash),
    pure("hash-table-contains-p", "key table", "Whether the hash table has an entry for the key.", contains),
    changing("remhash", "key table", "Removes the entry of a key; tells whether there was one.", remhash),
    changing("clrhash", "table", "Removes all entries.", clrhash),
    pure("hash-table-count", "table", "How many entries the hash table has.", count_entries),
    pure("hash-table-keys", "table", "The keys of the hash table, in a fixed order.", keys),
    pure("hash-table-values", "table", "The values of the hash table, in the order of their keys.", values),
    pure("hash-table->alist", "table", "The entries of the hash table as an association list.", to_alist),
    pure("alist->hash-table", "alist", "A hash table with the entries of an association list.", from_alist),
];
