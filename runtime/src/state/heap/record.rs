//! Records: lists that begin with the symbol of their kind.

use super::store::Heap;
use crate::state::value::Value;
use rpl_lang::code::SlotAccess;
use rpl_lang::symbol::Symbol;

impl Heap {
    /// The pair that holds the slot at a place of a record, counted behind the kind from 1; none if the value is
    /// no record of the kind, or shorter.
    #[inline]
    pub fn slot(&self, record: &Value, kind: &Value, place: usize) -> Option<u32> {
        let &Value::Symbol(kind) = kind else { return None };
        self.behind_kind(record, kind, place)
    }

    #[inline]
    fn behind_kind(&self, record: &Value, kind: Symbol, place: usize) -> Option<u32> {
        self.pairs.behind(self.record(record, kind)?, place)
    }

    /// The same, if the record lies in a row, as nearly all do. No call, for the loop.
    #[inline]
    pub fn slot_in_row(&self, record: &Value, slot: &SlotAccess) -> Option<u32> {
        self.pairs.in_row(self.record(record, slot.kind)?, slot.place.into())
    }

    /// The first pair of a value that is a record of a kind.
    #[inline]
    fn record(&self, value: &Value, kind: Symbol) -> Option<u32> {
        let &Value::Cons(pair) = value else { return None };
        matches!(self.pairs.car(pair), Value::Symbol(name) if *name == kind).then_some(pair)
    }

    /// Does what a function does that reads or assigns a slot: its arguments stand in the first registers, and its value
    /// goes to the first. Does nothing, and tells so, where [`Self::slot`] finds none.
    #[inline(never)]
    pub fn access_slot(&mut self, slot: &SlotAccess, registers: &mut [Value]) -> bool {
        let [first, behind @ ..] = registers else { return false };
        let Some(pair) = self.behind_kind(first, slot.kind, slot.place.into()) else { return false };
        if slot.assigns && self.pairs.is_frozen(pair) {
            return false;
        }
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
        matches!(kind, &Value::Symbol(kind) if self.record(value, kind).is_some())
    }
}
