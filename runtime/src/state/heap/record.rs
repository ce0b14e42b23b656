//! Records: lists that begin with the symbol of their kind.

use super::store::Heap;
use crate::state::value::Value;
use rpl_lang::code::SlotAccess;

impl Heap {
    /// The pair that holds the slot at a place of a record, counted behind the kind from 1; none if the value is
    /// no record of the kind, or shorter.
    #[inline]
    pub fn slot(&self, record: &Value, kind: &Value, place: usize) -> Option<u32> {
        let &Value::Cons(pair) = record else { return None };
        if self.is_record(record, kind) { self.pairs.behind(pair, place) } else { None }
    }

    /// What a function that reads or assigns a slot gives for a record; none where [`Self::slot`] finds none.
    #[inline]
    pub fn access_slot(&mut self, slot: SlotAccess, kind: &Value, record: &Value, assigned: &Value) -> Option<Value> {
        let pair = self.slot(record, kind, slot.place.into())?;
        let place = self.pairs.car_mut(pair);
        if slot.assigns {
            place.set(assigned);
        }
        Some(place.copied())
    }

    /// Whether a value is a record of a kind.
    #[inline]
    pub fn is_record(&self, value: &Value, kind: &Value) -> bool {
        match (value, kind) {
            (&Value::Cons(pair), Value::Symbol(kind)) => {
                matches!(self.pairs.car(pair), Value::Symbol(name) if name == kind)
            }
            _ => false,
        }
    }
}
