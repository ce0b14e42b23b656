//! Values that never change: those of fluents.
//!
//! Who waits for a fluent is told by its assignment. A list that is changed in place while a fluent has it would change
//! the fluent with nobody being told, so what a fluent has had once is frozen, with all its parts, as long as it lives.

use super::store::Heap;
use crate::state::value::Value;

impl Heap {
    /// Freezes a value with all its parts. Cost: what of it is not frozen yet; gives how much that was.
    pub(crate) fn freeze(&mut self, value: Value) -> u64 {
        let (mut waiting, mut looked_at) = (vec![value], 0);
        while let Some(mut value) = waiting.pop() {
            while let Value::Cons(pair) = value {
                looked_at += 1;
                if !self.pairs.freeze(pair) {
                    break;
                }
                let car = *self.pairs.car(pair);
                if is_changeable(car) {
                    waiting.push(car);
                }
                value = self.pairs.cdr(pair);
            }
            match value {
                Value::Vector(vector) if self.vectors[vector].freeze() => {
                    let elements = self.vectors[vector].elements();
                    looked_at += elements.len() as u64;
                    waiting.extend(elements.iter().copied().filter(|&element| is_changeable(element)));
                }
                Value::Table(table) if self.tables[table].freeze() => {
                    let entries = self.tables[table].entries().iter();
                    let parts = entries.flat_map(|entry| [entry.key, entry.value]).filter(|&part| is_changeable(part));
                    waiting.extend(parts);
                    looked_at += self.tables[table].len() as u64;
                }
                _ => {}
            }
        }
        looked_at
    }

    /// Whether a value is frozen; what cannot be changed at all is not.
    pub fn is_frozen(&self, value: Value) -> bool {
        match value {
            Value::Cons(pair) => self.pairs.is_frozen(pair),
            Value::Vector(vector) => self.vectors[vector].is_frozen(),
            Value::Table(table) => self.tables[table].is_frozen(),
            _ => false,
        }
    }
}

fn is_changeable(value: Value) -> bool {
    matches!(value, Value::Cons(_) | Value::Vector(_) | Value::Table(_))
}
