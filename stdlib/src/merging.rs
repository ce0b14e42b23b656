//! Sorting by any predicate: what stands before and behind the instruction that merges, and asks the predicate.

use crate::arguments::{NativeResult, elements, list, pure, room_for, vector, vector_items};
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::heap::{sort_state, sort_state_bytes};
use rpl_runtime::step::native::{Call, Effect, Native, NativeCode};

/// The state of a sort that has not compared anything.
fn begin(call: &mut Call<'_, '_>) -> NativeResult {
    let items = elements(call, 0)?;
    room_for(call, sort_state_bytes(items.len()))?;
    vector(call, sort_state(&items, call.argument(1)))
}

/// The elements in the order in which a sort has left them; their second halves where they are pairs.
fn in_order(call: &mut Call<'_, '_>) -> NativeResult {
    let state = vector_items(call, 0)?;
    let items = call.machine.heap.sorted(&state).ok_or_else(no_sort)?;
    list(call, &items)
}

fn no_sort() -> Raise {
    Raise::type_error("this is not the state of a sort")
}

/// Sorting by any predicate.
pub(super) const NATIVES: &[Native] = &[
    pure(
        "%sort-begin",
        "elements by-pairs",
        "The state of a sort; by the first halves of pairs if the second is true.",
        begin,
    ),
    Native {
        name: "%sort-merge",
        parameters: "vector function",
        doc: "Puts the elements in order. Has an instruction, and is nothing but its name.",
        effect: Effect::Calls,
        code: NativeCode::Plain(|_| Err(no_sort())),
    },
    pure("%sort-end", "vector", "The elements in order.", in_order),
];
