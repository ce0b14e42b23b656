//! Values, objects of the heap, fluents and watches.

use super::{Object, Writer};
use crate::state::fluent::Origin;
use crate::state::value::Value;

impl Writer<'_> {
    pub(super) fn value(&mut self, value: Value) {
        let (tag, object) = match value {
            Value::Nil => return self.byte(0),
            Value::True => return self.byte(1),
            Value::Int(value) => {
                self.byte(2);
                return self.number(value as u64);
            }
            Value::Float(value) => {
                self.byte(3);
                return self.bytes.extend_from_slice(&value.to_bits().to_le_bytes());
            }
            Value::Symbol(symbol) => {
                self.byte(4);
                return self.plain(&symbol);
            }
            Value::Keyword(symbol) => {
                self.byte(5);
                return self.plain(&symbol);
            }
            Value::Function(code) => {
                self.byte(7);
                return self.number(u64::from(code));
            }
            Value::Native(native) => {
                self.byte(8);
                return self.number(u64::from(native));
            }
            Value::Valve(valve) => {
                self.byte(9);
                return self.number(u64::from(valve));
            }
            Value::Behaviour(behaviour) => {
                self.byte(10);
                return self.number(u64::from(behaviour));
            }
            Value::Unbound => return self.byte(11),
            // `eq` tells two equal strings apart.
            Value::Str(string) => (6, Object::Str(string)),
            Value::Cons(pair) => (12, Object::Pair(pair)),
            Value::Cell(cell) => (13, Object::Cell(cell)),
            Value::Closure(closure) => (14, Object::Closure(closure)),
            Value::Table(table) => (15, Object::Table(table)),
            Value::Vector(vector) => (16, Object::Vector(vector)),
            Value::Failure(failure) => (17, Object::Failure(failure)),
            Value::Fluent(fluent) => (18, Object::Fluent(fluent)),
            Value::Task(task) => (19, Object::Task(task.index, task.generation)),
        };
        self.byte(tag);
        self.object(object);
    }

    pub(super) fn heap_parts(&mut self, object: Object) {
        let heap = &self.machine.heap;
        match object {
            Object::Str(string) => {
                let text = heap.strings[string].text.clone();
                self.text(&text);
            }
            Object::Pair(pair) => {
                let (car, cdr) = heap.pair(pair);
                self.value(car);
                self.value(cdr);
            }
            Object::Cell(cell) => self.value(heap.cells[cell]),
            Object::Closure(closure) => {
                let closure = &heap.closures[closure];
                self.number(u64::from(closure.code));
                self.values(&closure.captured);
            }
            Object::Vector(vector) => {
                let vector = &heap.vectors[vector];
                self.byte(u8::from(vector.is_frozen()));
                self.values(vector.elements());
            }
            Object::Table(table) => self.table(table),
            Object::Failure(failure) => {
                let failure = &heap.failures[failure];
                self.plain(&(failure.class, &failure.message, failure.is_runaway));
                self.number(failure.slots.len() as u64);
                for &(name, value) in &failure.slots {
                    self.plain(&name);
                    self.value(value);
                }
                self.values(&failure.parts);
                self.values(&failure.while_cleaning_up);
            }
            Object::Fluent(_) | Object::Task(..) | Object::Block(_) => {}
        }
    }

    /// Entries stand in the order of their keys, as plans see them. Keys that have no order stand in that of coming.
    fn table(&mut self, table: u32) {
        let heap = &self.machine.heap;
        let table = &heap.tables[table];
        let mut entries: Vec<(Option<Vec<u8>>, Value, Value)> =
            table.entries().iter().map(|entry| (self.atom_bytes(entry.key), entry.key, entry.value)).collect();
        entries.sort_by(|a, b| a.0.cmp(&b.0));
        self.byte(u8::from(table.is_frozen()));
        self.number(entries.len() as u64);
        for (_, key, value) in entries {
            self.value(key);
            self.value(value);
        }
    }

    /// What an atom that names no object is, by which it can be put in an order.
    fn atom_bytes(&self, key: Value) -> Option<Vec<u8>> {
        let bytes = match key {
            Value::Int(value) => value.to_le_bytes().to_vec(),
            Value::Float(value) => value.to_bits().to_le_bytes().to_vec(),
            Value::Symbol(symbol) | Value::Keyword(symbol) => self.machine.symbols.name(symbol).as_bytes().to_vec(),
            Value::Str(string) => self.machine.heap.strings[string].text.as_bytes().to_vec(),
            _ => return None,
        };
        Some(bytes)
    }

    pub(super) fn optional_fluent(&mut self, fluent: Option<u32>) {
        self.byte(u8::from(fluent.is_some()));
        if let Some(fluent) = fluent {
            self.object(Object::Fluent(fluent));
        }
    }

    /// Who waits for it stands with the tasks, who reads it with the networks.
    pub(super) fn fluent_parts(&mut self, fluent: u32) {
        let Some(fluent) = self.machine.fluents.get(fluent) else { return self.byte(0xfe) };
        self.value(fluent.value);
        match &fluent.origin {
            Origin::Plan => self.byte(0),
            Origin::System => self.byte(1),
            Origin::Network { code, captured } => {
                self.byte(2);
                self.number(u64::from(*code));
                self.values(captured);
            }
            Origin::Pulsed => self.byte(3),
            Origin::Changed => self.byte(4),
            Origin::Count => self.byte(5),
        }
        self.number(fluent.inputs.len() as u64);
        fluent.inputs.iter().for_each(|&input| self.object(Object::Fluent(input)));
        self.byte(u8::from(fluent.failure.is_some()));
        if let Some(failure) = fluent.failure {
            self.value(failure);
        }
    }

    pub(super) fn watch(&mut self, watch: u32) {
        let Some(watch) = self.machine.watches.get(watch) else { return self.byte(0xfe) };
        self.object(Object::Fluent(watch.fluent));
        self.number(u64::from(watch.events));
        self.plain(&(watch.was_true, watch.missed, watch.owned, watch.waits));
    }
}
