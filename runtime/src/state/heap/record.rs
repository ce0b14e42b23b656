//! Records: lists that begin with the symbol of their kind.

use super::store::Heap;
use crate::state::value::Value;
use rpl_lang::code::SlotAccess;

impl Heap {
    /// The pair that holds the slot at a place of a record, counted behind the kind from 1; none if the value is
    /// no record of the kind, or shorter.
    #[inline]
    pub fn slot(&self, record: &Value, kind: &Value, place: usize) -> Option<u32> {
        let &Value::Cons(mut pair) = record else { return None };
        if !self.is_record(record, kind) {
            return None;
        }
        for _ in 0..place {
            let &Value::Cons(next) = &self.pairs[pair as usize].1 else { return None };
            pair = next;
        }
        Some(pair)
    }

    /// What a function that reads or assigns a slot gives for a record; none where [`Self::slot`] finds none.
    #[inline]
    pub fn access_slot(&mut self, slot: SlotAccess, kind: &Value, record: &Value, assigned: &Value) -> Option<Value> {
        let pair = self.slot(record, kind, slot.place.into())?;
        let place = &mut self.pairs[pair as usize].0;
        if slot.assigns {
            *place = assigned.copied();
        }
        Some(place.copied())
    }

    /// Whether a value is a record of a kind.
    #[inline]
    pub fn is_record(&self, value: &Value, kind: &Value) -> bool {
        match (value, kind) {
            (&Value::Cons(pair), Value::Symbol(kind)) => {
                matches!(&self.pairs[pair as usize].0, Value::Symbol(name) if name == kind)
            }
            _ => false,
        }
    }
}
