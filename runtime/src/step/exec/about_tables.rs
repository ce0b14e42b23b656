//! Entries of hash tables, read and assigned by instructions.

use crate::state::failure::Raise;
use crate::state::heap::{Heap, Key, MAX_KEY_PARTS, table_entry};
use crate::state::machine::Machine;
use crate::state::scratch::Cursor;
use crate::state::value::Value;
use crate::step::exec::{Proceed, REACH};
use crate::step::native::text_steps;
use rpl_lang::code::{NO_REG, Reg};
use rpl_lang::kind::Kind;

/// Reads an entry whose key has no parts; gives the steps it takes. None, and nothing done, where the key has parts or
/// there is no table.
pub(super) fn read_entry(heap: &mut Heap, r: &mut [Value; REACH], [to, key, table, default]: [Reg; 4]) -> Option<u32> {
    let key = &r[usize::from(key)];
    let steps = key_steps(heap, key);
    let found = heap.atom_entry(&r[usize::from(table)], key)?;
    match found {
        Some(value) => r[usize::from(to)].set(value),
        None => r[usize::from(to)] = default_value(r, default),
    }
    Some(steps)
}

/// The same for the assignment of an entry.
pub(super) fn assign_entry(heap: &mut Heap, r: &[Value; REACH], [key, table, value]: [Reg; 3]) -> Option<u32> {
    let key = &r[usize::from(key)];
    let is_done = heap.set_atom_entry(&r[usize::from(table)], key, &r[usize::from(value)]);
    is_done.then(|| key_steps(heap, key))
}

/// A key is hashed and, as a rule, compared with one key.
#[inline]
fn key_steps(heap: &Heap, key: &Value) -> u32 {
    match *key {
        Value::Str(text) => text_steps(2 * heap.strings[text].len()) as u32,
        _ => 0,
    }
}

#[inline]
fn default_value(registers: &[Value], default: Reg) -> Value {
    if default == NO_REG { Value::Nil } else { registers[usize::from(default)].copied() }
}

impl Machine {
    /// A value as a key; takes the steps of looking for it.
    ///
    /// # Errors
    /// A `type-error` if it has too many parts.
    pub fn key_of(&mut self, of: Value) -> Result<Key, Raise> {
        let Some(key) = self.heap.key(of) else {
            return Err(Raise::type_error(format!(
                "this has more than {MAX_KEY_PARTS} parts and is too large to be the key of a hash table"
            )));
        };
        let steps = match of {
            Value::Cons(_) | Value::Vector(_) => u32::try_from(2 * key.part_count()).unwrap_or(u32::MAX),
            atom => key_steps(&self.heap, &atom),
        };
        self.scratch.burned = self.scratch.burned.saturating_add(steps);
        Ok(key)
    }

    /// The same for an instruction, with the table.
    fn key_and_table(&mut self, place: &mut Cursor, form: &str, key: Value, table: Value) -> Result<(Key, u32), Raise> {
        let Value::Table(table) = table else {
            return Err(self.wrong_type(&format!("argument 2 of `{form}`"), Kind::Table.noun(), table));
        };
        let key = self.key_of(key)?;
        place.spend(std::mem::take(&mut self.scratch.burned) as usize);
        Ok((key, table))
    }

    /// [`Op::TableRef`] for any key.
    pub(super) fn table_ref(
        &mut self,
        place: &mut Cursor,
        [to, key, table, default]: [Reg; 4],
    ) -> Result<Proceed, Raise> {
        let base = place.frame.base as usize;
        let [of, table] = [key, table].map(|register| self.scratch.stack[base + usize::from(register)]);
        let (key, table) = self.key_and_table(place, "gethash", of, table)?;
        let found = self.heap.table_value(table, &key);
        let registers = &mut self.scratch.stack[base..];
        registers[usize::from(to)] = found.unwrap_or_else(|| default_value(registers, default));
        Ok(Proceed::On)
    }

    /// [`Op::SetTableRef`] for any key.
    pub(super) fn set_table_ref(
        &mut self,
        place: &mut Cursor,
        [key, table, value]: [Reg; 3],
    ) -> Result<Proceed, Raise> {
        let base = place.frame.base as usize;
        let [of, table, value] = [key, table, value].map(|register| self.scratch.stack[base + usize::from(register)]);
        let (key, table) = self.key_and_table(place, "(setf gethash)", of, table)?;
        if self.heap.tables[table].is_frozen() {
            return Err(self.frozen(Value::Table(table)));
        }
        self.make_room(self.scratch.top, table_entry(&key))?;
        self.heap.enter(table, key, value);
        Ok(Proceed::On)
    }
}
