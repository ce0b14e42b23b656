//! Sorting by any predicate: a merge sort that stands still at each comparison. Its state is a vector of the plan's heap, so
//! that a run can be stopped, forked or saved between two calls of the predicate.

use crate::arguments::{NativeResult, elements, list, pure, room_for, truth, vector, vector_items};
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::heap::vector_elements;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Native};

/// What stands in the state before the elements: a pair of the two to be compared, which the prelude reads; whether
/// there are any; whether elements are compared by their first halves; and the merge under way. Behind the elements is
/// room for the left half of a merge.
const HEADER: usize = 8;

/// The pair of what the predicate is asked of.
const QUESTION: usize = 0;

/// Whether the predicate has been asked.
const IS_ASKED: usize = 1;

/// Whether elements are pairs that are compared by their first halves.
const BY_PAIRS: usize = 2;

/// Where the merge under way begins in the state.
const MERGE: usize = 3;

/// A part of the elements that is put in order.
#[derive(Clone, Copy, PartialEq)]
struct Part {
    start: usize,
    length: usize,
}

impl Part {
    /// Its two halves, which are put in order before it.
    fn halves(self) -> (Part, Part) {
        let half = self.length / 2;
        (Part { length: half, ..self }, Part { start: self.start + half, length: self.length - half })
    }

    /// The first part within it that is merged: the left halves come first.
    fn first(self) -> Part {
        let (left, right) = self.halves();
        match (left.length, right.length) {
            (2.., _) => left.first(),
            (_, 2..) => right.first(),
            _ => self,
        }
    }

    /// What is merged after a part within it; none after itself. O(log n).
    fn after(self, part: Part) -> Option<Part> {
        let mut around = self;
        while around != part {
            let (left, right) = around.halves();
            match (left == part, right == part) {
                (true, _) if right.length > 1 => return Some(right.first()),
                (true, _) | (_, true) => return Some(around),
                _ if left.length.max(right.length) < 2 => return None,
                _ => around = if part.start < right.start { left } else { right },
            }
        }
        None
    }
}

/// A merge: the left half has been put aside, and elements of both halves follow one another from the start on.
#[derive(Clone, Copy)]
struct Merge {
    /// How many elements are sorted altogether.
    elements: usize,
    part: Part,
    /// How many elements of the left half are in place.
    taken_left: usize,
    /// How many of the right one.
    taken_right: usize,
}

impl Merge {
    fn read(state: &[Value]) -> Option<Self> {
        let number = |at: usize| match state.get(MERGE + at) {
            Some(&Value::Int(number)) => usize::try_from(number).ok(),
            _ => None,
        };
        let (part, taken_left, taken_right) = (Part { start: number(0)?, length: number(1)? }, number(2)?, number(3)?);
        let (left, right) = part.halves();
        let elements = number(4)?;
        let is_whole = state.len() == HEADER + elements + elements / 2
            && part.start.checked_add(part.length).is_some_and(|end| end <= elements)
            && taken_left <= left.length
            && taken_right <= right.length;
        is_whole.then_some(Self { elements, part, taken_left, taken_right })
    }

    fn write(self, state: &mut [Value]) {
        let numbers = [self.part.start, self.part.length, self.taken_left, self.taken_right, self.elements];
        for (place, number) in state[MERGE..].iter_mut().zip(numbers) {
            *place = Value::Int(number as i64);
        }
    }

    /// Puts the left half of a part aside.
    fn begin(part: Part, elements: usize, state: &mut [Value]) -> Self {
        let (left, _) = part.halves();
        let from = HEADER + left.start;
        state.copy_within(from..from + left.length, HEADER + elements);
        Self { elements, part, taken_left: 0, taken_right: 0 }
    }

    /// The next elements of the left and of the right half; none when one of them is used up.
    fn heads(self, state: &[Value]) -> Option<(Value, Value)> {
        let (left, right) = self.part.halves();
        if self.taken_left == left.length || self.taken_right == right.length {
            return None;
        }
        Some((state[HEADER + self.elements + self.taken_left], state[HEADER + right.start + self.taken_right]))
    }

    /// Puts the next element of one half in its place.
    fn take(&mut self, is_right: bool, state: &mut [Value]) {
        let Some((left, right)) = self.heads(state) else { return };
        let to = HEADER + self.part.start + self.taken_left + self.taken_right;
        if is_right {
            (state[to], self.taken_right) = (right, self.taken_right + 1);
        } else {
            (state[to], self.taken_left) = (left, self.taken_left + 1);
        }
    }

    /// Puts what is left of the left half behind the rest; what is left of the right one is in its place.
    fn end(self, state: &mut [Value]) {
        let (left, _) = self.part.halves();
        let aside = HEADER + self.elements;
        let to = HEADER + self.part.start + self.taken_left + self.taken_right;
        state.copy_within(aside + self.taken_left..aside + left.length, to);
    }
}

/// The state of a sort that has not compared anything.
fn begin(call: &mut Call<'_, '_>) -> NativeResult {
    let items = elements(call, 0)?;
    let count = items.len();
    let length = HEADER + count + count / 2;
    room_for(call, vector_elements(length))?;
    let mut state = Vec::with_capacity(length);
    let question = call.machine.heap.cons(Value::Nil, Value::Nil);
    state.extend([question, Value::Nil, call.argument(1)]);
    state.extend([0, 0, 0, 0, count as i64].map(Value::Int));
    state.extend(items);
    state.resize(length, Value::Nil);
    if count > 1 {
        Merge::begin(Part { start: 0, length: count }.first(), count, &mut state).write(&mut state);
    }
    vector(call, state)
}

/// Goes on with a sort up to its next comparison; tells whether there is one. The second argument is what the predicate
/// said of the two that were to be compared.
fn step(call: &mut Call<'_, '_>) -> NativeResult {
    let Value::Vector(index) = call.argument(0) else { return Err(call.wrong_type(0)) };
    let takes_right = call.argument(1).is_true();
    let heap = &mut call.machine.heap;
    let state = heap.vectors[index].elements_mut();
    let Some(mut merge) = Merge::read(state) else { return Err(no_sort()) };
    if state[IS_ASKED].is_true() {
        merge.take(takes_right, state);
    }
    let whole = Part { start: 0, length: merge.elements };
    let mut moved = 0;
    let heads = loop {
        if let Some(heads) = merge.heads(state) {
            break heads;
        }
        merge.end(state);
        moved += merge.part.length;
        let Some(next) = whole.after(merge.part) else {
            call.burn_walk(moved);
            return truth(false);
        };
        merge = Merge::begin(next, merge.elements, state);
    };
    merge.write(state);
    let by_pairs = state[BY_PAIRS].is_true();
    let key = |item: Value| match item {
        Value::Cons(pair) if by_pairs => heap.pairs[pair as usize].0,
        other => other,
    };
    let asked = (key(heads.1), key(heads.0));
    state[IS_ASKED] = Value::True;
    if let Value::Cons(question) = state[QUESTION] {
        heap.pairs[question as usize] = asked;
    }
    call.burn_walk(moved);
    truth(true)
}

/// The elements in the order in which a sort has left them; their second halves where they are pairs.
fn in_order(call: &mut Call<'_, '_>) -> NativeResult {
    let state = vector_items(call, 0)?;
    let Some(merge) = Merge::read(&state) else { return Err(no_sort()) };
    let by_pairs = state[BY_PAIRS].is_true();
    let value = |&item: &Value| match item {
        Value::Cons(pair) if by_pairs => call.machine.heap.pair(pair).1,
        other => other,
    };
    let items: Vec<Value> = state[HEADER..HEADER + merge.elements].iter().map(value).collect();
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
    pure(
        "%sort-step",
        "vector value",
        "Goes on with a sort up to its next comparison; tells whether there is one.",
        step,
    ),
    pure("%sort-end", "vector", "The elements in order.", in_order),
];
