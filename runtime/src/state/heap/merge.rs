//! A merge sort that stands still at each comparison. Its state is a vector of the plan's heap, so that a run can be
//! stopped, forked or saved between two calls of the predicate.

use super::store::Heap;
use super::vector::vector_elements;
use crate::state::value::Value;

/// What stands in the state before the elements: whether the predicate was asked, whether elements are pairs that are
/// compared by their first halves, and the merge under way. Behind the elements is room for the left half of a merge.
const HEADER: usize = 10;

/// Where the merge under way begins in the state.
const MERGE: usize = 2;

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
        let (mut at, mut around) = (self, None);
        while at.length > part.length.max(1) {
            around = Some(at);
            let (left, right) = at.halves();
            at = if part.start < right.start { left } else { right };
        }
        let around = around.filter(|_| at == part)?;
        let right = around.halves().1;
        Some(if part.start < right.start && right.length > 1 { right.first() } else { around })
    }
}

/// A merge: the left half has been put aside, and elements of both halves follow one another from the start on. All are
/// places in the state.
#[derive(Clone, Copy)]
struct Merge {
    /// The next element of the left half, and where that ends.
    left: usize,
    left_end: usize,
    /// The next element of the right half, and where that ends.
    right: usize,
    right_end: usize,
    /// Where the next one goes.
    to: usize,
    part: Part,
    /// How many elements are sorted altogether.
    elements: usize,
}

impl Merge {
    fn read(state: &[Value]) -> Option<Self> {
        let number = |at: usize| match state.get(MERGE + at) {
            Some(&Value::Int(number)) => usize::try_from(number).ok(),
            _ => None,
        };
        let merge = Self {
            left: number(0)?,
            left_end: number(1)?,
            right: number(2)?,
            right_end: number(3)?,
            to: number(4)?,
            part: Part { start: number(5)?, length: number(6)? },
            elements: number(7)?,
        };
        merge.is_whole(state.len()).then_some(merge)
    }

    fn is_whole(self, length: usize) -> bool {
        let is_part = self.elements <= length
            && state_length(self.elements) == length
            && self.part.start.checked_add(self.part.length).is_some_and(|end| end <= self.elements);
        let first = is_part.then(|| Self::at(self.part, self.elements));
        first.is_some_and(|first| {
            (self.left_end, self.right_end) == (first.left_end, first.right_end)
                && (first.left..=first.left_end).contains(&self.left)
                && (first.right..=first.right_end).contains(&self.right)
                && self.to == first.to + (self.left - first.left) + (self.right - first.right)
        })
    }

    fn write(self, state: &mut [Value]) {
        let numbers = [
            self.left,
            self.left_end,
            self.right,
            self.right_end,
            self.to,
            self.part.start,
            self.part.length,
            self.elements,
        ];
        for (place, number) in state[MERGE..].iter_mut().zip(numbers) {
            *place = Value::Int(number as i64);
        }
    }

    /// The merge of a part, with nothing taken yet.
    fn at(part: Part, elements: usize) -> Self {
        let (left, right) = part.halves();
        let aside = HEADER + elements;
        let right_start = HEADER + right.start;
        Self {
            left: aside,
            left_end: aside + left.length,
            right: right_start,
            right_end: right_start + right.length,
            to: HEADER + left.start,
            part,
            elements,
        }
    }

    /// Puts the left half of a part aside.
    fn begin(part: Part, elements: usize, state: &mut [Value]) -> Self {
        let merge = Self::at(part, elements);
        state.copy_within(merge.to..merge.to + part.halves().0.length, merge.left);
        merge
    }

    /// Whether elements of both halves are left.
    fn is_open(self) -> bool {
        self.left < self.left_end && self.right < self.right_end
    }

    /// Puts the next element of one half in its place.
    fn take(&mut self, is_right: bool, state: &mut [Value]) {
        let next = if is_right { &mut self.right } else { &mut self.left };
        state[self.to] = state[*next];
        *next += 1;
        self.to += 1;
    }

    /// Puts what is left of the left half behind the rest; what is left of the right one is in its place.
    fn end(self, state: &mut [Value]) {
        state.copy_within(self.left..self.left_end, self.to);
    }
}

fn state_length(elements: usize) -> usize {
    HEADER + elements + elements / 2
}

/// How a sort goes on.
pub enum SortStep {
    /// The predicate is to be asked of these two.
    Ask(Value, Value),
    /// All is in order.
    Done,
}

/// Bytes of the state of a sort.
pub fn sort_state_bytes(elements: usize) -> usize {
    vector_elements(state_length(elements))
}

/// The state of a sort that has not compared anything.
pub fn sort_state(items: &[Value], by_pairs: Value) -> Vec<Value> {
    let count = items.len();
    let mut state = Vec::with_capacity(state_length(count));
    state.extend([Value::Nil, by_pairs]);
    state.resize(HEADER, Value::Nil);
    state.extend(items);
    state.resize(state_length(count), Value::Nil);
    let whole = Part { start: 0, length: count };
    let merge = if count > 1 { Merge::begin(whole.first(), count, &mut state) } else { Merge::at(whole, count) };
    merge.write(&mut state);
    state
}

impl Heap {
    /// Goes on with a sort within a merge: state, predicate, and what that said, which makes room for the next two to be
    /// compared. Does nothing, and tells so, where a merge begins or ends.
    #[inline]
    pub(crate) fn merge_on(&mut self, registers: &mut [Value]) -> bool {
        let [Value::Vector(state), _, first, second, ..] = registers else { return false };
        let state = self.vectors[*state].elements_mut();
        let [
            Value::True,
            by_pairs,
            Value::Int(left),
            Value::Int(left_end),
            Value::Int(right),
            Value::Int(right_end),
            Value::Int(to),
            ..,
        ] = &*state
        else {
            return false;
        };
        let (by_pairs, takes_right) = (by_pairs.is_true(), !matches!(first, Value::Nil));
        let (left, right, to, left_end, right_end) = (*left, *right, *to, *left_end, *right_end);
        let (from, next_left, next_right) =
            if takes_right { (right, left, right.wrapping_add(1)) } else { (left, left.wrapping_add(1), right) };
        let length = state.len();
        let is_within = |place: i64| (place as usize) < length;
        if next_left >= left_end
            || next_right >= right_end
            || ![from, to, next_left, next_right].into_iter().all(is_within)
        {
            return false;
        }
        state[to as usize] = state[from as usize];
        (state[MERGE], state[MERGE + 2], state[MERGE + 4]) =
            (Value::Int(next_left), Value::Int(next_right), Value::Int(to + 1));
        (*first, *second) = (state[next_right as usize], state[next_left as usize]);
        if by_pairs {
            (*first, *second) = (self.first_half(*first), self.first_half(*second));
        }
        true
    }

    /// Goes on with a sort up to its next comparison, and tells how many elements were moved on the way; none if this is not
    /// the state of one. The second argument is what the predicate said of the two that were to be compared.
    pub(crate) fn sort_on(&mut self, state: Value, takes_right: Value) -> Option<(SortStep, usize)> {
        let Value::Vector(state) = state else { return None };
        let state = self.vectors[state].elements_mut();
        let mut merge = Merge::read(state)?;
        if state[0].is_true() && merge.is_open() {
            merge.take(takes_right.is_true(), state);
        }
        let whole = Part { start: 0, length: merge.elements };
        let mut moved = 0;
        while !merge.is_open() {
            merge.end(state);
            moved += merge.part.length;
            let Some(next) = whole.after(merge.part) else { return Some((SortStep::Done, moved)) };
            merge = Merge::begin(next, merge.elements, state);
        }
        merge.write(state);
        state[0] = Value::True;
        let (by_pairs, first, second) = (state[1].is_true(), state[merge.right], state[merge.left]);
        Some((
            match by_pairs {
                true => SortStep::Ask(self.first_half(first), self.first_half(second)),
                false => SortStep::Ask(first, second),
            },
            moved,
        ))
    }

    fn first_half(&self, item: Value) -> Value {
        match item {
            Value::Cons(pair) => *self.pairs.car(pair),
            other => other,
        }
    }

    /// The elements in the order in which a sort has left them; their second halves where they are pairs. None if this is
    /// not the state of one.
    pub fn sorted(&self, state: &[Value]) -> Option<Vec<Value>> {
        let merge = Merge::read(state)?;
        let by_pairs = state[1].is_true();
        let value = |&item: &Value| match item {
            Value::Cons(pair) if by_pairs => self.pair(pair).1,
            other => other,
        };
        Some(state[HEADER..HEADER + merge.elements].iter().map(value).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The parts that are merged, halves before wholes.
    fn merged(part: Part, order: &mut Vec<(usize, usize)>) {
        if part.length > 1 {
            let (left, right) = part.halves();
            merged(left, order);
            merged(right, order);
            order.push((part.start, part.length));
        }
    }

    #[test]
    fn halves_are_merged_before_what_they_are_halves_of() {
        for length in 2..200 {
            let whole = Part { start: 0, length };
            let mut expected = Vec::new();
            merged(whole, &mut expected);
            let parts = std::iter::successors(Some(whole.first()), |&part| whole.after(part));
            assert!(parts.map(|part| (part.start, part.length)).eq(expected), "{length} elements");
        }
    }

    #[test]
    fn nothing_follows_what_is_no_part() {
        let whole = Part { start: 0, length: 10 };
        for (start, length) in [(1, 5), (0, 4), (3, 3), (5, 9)] {
            assert!(whole.after(Part { start, length }).is_none(), "{length} from {start} on");
        }
    }
}
