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

    /// The same, if the record lies in a row, as nearly all do. No call, for the loop.
    #[inline]
    pub fn slot_in_row(&self, record: &Value, kind: &Value, place: usize) -> Option<u32> {
        let &Value::Cons(pair) = record else { return None };
        if self.is_record(record, kind) { self.pairs.in_row(pair, place) } else { None }
    }

    /// Does what a function does that reads or assigns a slot: its arguments stand in the first registers, and its value
    /// goes to the first. Does nothing, and tells so, where [`Self::slot`] finds none.
    #[inline(never)]
    pub fn access_slot(&mut self, slot: &SlotAccess, constants: &[Value], registers: &mut [Value]) -> bool {
        let [first, behind @ ..] = registers else { return false };
        let Some(pair) = self.slot(first, &constants[slot.kind as usize], slot.place.into()) else { return false };
        let place = self.pairs.car_mut(pair);
        if let (true, Some(assigned)) = (slot.assigns, behind.first()) {
            place.set(assigned);
        }
        first.set(place);
        true
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
