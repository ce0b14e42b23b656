//! Pairs: their first halves in one table, and in another, four bytes each, what follows.
//!
//! Nearly always that is a pair or nil. Where it is neither, as in `(1 . 2)`, it lies in a slab of its own, which the
//! pair alone refers to. A list that is made at once lies in a row where there is room for it, and its pairs know how
//! many follow in the row; so a slot of a record is found without a walk.

use crate::state::slab::{Marks, NONE, Slab, give_back};
use crate::state::value::Value;
use serde::{Deserialize, Serialize};

/// What follows a pair: below [`OTHER`] the number of a pair, else one of those below.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Tail(u32);

/// From here on, the number of what is neither a pair nor nil in its slab.
const OTHER: u32 = 1 << 31;

/// The end of a list.
const END: Tail = Tail(3 << 30);

/// Nothing: the place is free, and the first half tells the next free one.
const FREE: Tail = Tail(END.0 + 1);

/// The next place; added to this, how many pairs lie in a row behind this one.
const ROW: u32 = u32::MAX - LONGEST_ROW as u32;

/// The most pairs that lie in a row: the row in front of a pair has to be counted anew when something else comes to
/// follow that.
const LONGEST_ROW: usize = 256;

impl Tail {
    fn row(behind: usize) -> Self {
        Self(ROW + behind as u32)
    }

    #[inline]
    fn is_row(self) -> bool {
        self.0 >= ROW
    }

    /// The number of what is neither a pair nor nil, if that follows.
    #[inline]
    fn other(self) -> Option<u32> {
        (OTHER..END.0).contains(&self.0).then(|| self.0 - OTHER)
    }
}

/// Bytes of a pair.
pub const PAIR: usize = size_of::<Value>() + size_of::<Tail>();

/// Bytes of what follows a pair and is neither a pair nor nil.
const OTHER_TAIL: usize = size_of::<Option<Value>>();

/// All pairs of a heap, by number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pairs {
    /// First halves; of a free place the number of the next one as if it were a pair, nil at the last.
    cars: Vec<Value>,
    /// As many.
    tails: Vec<Tail>,
    others: Slab<Value>,
    /// The free place that is used next; [`NONE`] if there is none.
    free: u32,
    /// Those that never change, as far as there are any.
    frozen: Marks,
}

impl Default for Pairs {
    fn default() -> Self {
        Self { cars: Vec::new(), tails: Vec::new(), others: Slab::default(), free: NONE, frozen: Marks::default() }
    }
}

impl Pairs {
    /// How many places there are, free ones included.
    pub fn places(&self) -> usize {
        self.cars.len()
    }

    /// The first half of a pair.
    #[inline]
    pub fn car(&self, pair: u32) -> &Value {
        &self.cars[pair as usize]
    }

    /// The same to be assigned.
    #[inline]
    pub fn car_mut(&mut self, pair: u32) -> &mut Value {
        &mut self.cars[pair as usize]
    }

    /// The pair that follows a pair, where it is told by its number.
    #[inline]
    pub fn next(&self, pair: u32) -> Option<u32> {
        let Tail(next) = self.tails[pair as usize];
        (next < OTHER).then_some(next)
    }

    /// Whether a pair never changes.
    #[inline]
    pub fn is_frozen(&self, pair: u32) -> bool {
        self.frozen.has(pair)
    }

    /// From now on a pair never changes; tells whether it could until now.
    pub(super) fn freeze(&mut self, pair: u32) -> bool {
        self.frozen.grow(pair);
        self.frozen.set(pair)
    }

    /// What follows a pair.
    #[inline]
    pub fn cdr(&self, pair: u32) -> Value {
        match self.tails[pair as usize] {
            Tail(next) if next < OTHER => Value::Cons(next),
            tail if tail.is_row() => Value::Cons(pair + 1),
            END => Value::Nil,
            tail => tail.other().map_or(Value::Nil, |other| self.others[other]),
        }
    }

    /// The pair `count` places behind another in its list, if there are as many. One look if they lie in a row.
    #[inline]
    pub(super) fn behind(&self, pair: u32, count: usize) -> Option<u32> {
        self.in_row(pair, count).or_else(|| self.walk(pair, count))
    }

    /// The same, if they lie in a row.
    #[inline]
    pub(super) fn in_row(&self, pair: u32, count: usize) -> Option<u32> {
        (self.tails[pair as usize].0 as usize >= ROW as usize + count).then(|| pair + count as u32)
    }

    #[inline(never)]
    fn walk(&self, pair: u32, count: usize) -> Option<u32> {
        let mut at = pair;
        for _ in 0..count {
            let Value::Cons(next) = self.cdr(at) else { return None };
            at = next;
        }
        Some(at)
    }

    /// All pairs, as their halves.
    pub fn iter(&self) -> impl Iterator<Item = (Value, Value)> {
        let used = self.tails.iter().enumerate().filter(|&(_, &tail)| tail != FREE);
        used.map(|(pair, _)| (self.cars[pair], self.cdr(pair as u32)))
    }

    /// A new pair, and how many bytes it takes.
    #[inline]
    pub(super) fn cons(&mut self, car: Value, cdr: Value) -> (u32, usize) {
        match cdr {
            Value::Cons(next) => (self.place(car, Tail(next)), PAIR),
            Value::Nil => (self.place(car, END), PAIR),
            other => self.cons_other(car, other),
        }
    }

    /// A new last pair behind the last one.
    #[inline(always)]
    pub(super) fn extend(&mut self, end: u32, car: &Value) -> u32 {
        let pair = self.place(car.copied(), END);
        match &mut self.tails[end as usize] {
            last if *last == END => *last = Tail(pair),
            _ => self.replace_tail(end, pair),
        }
        pair
    }

    /// Lets a pair follow another one, which is not the last.
    #[cold]
    #[inline(never)]
    fn replace_tail(&mut self, pair: u32, next: u32) {
        self.set_cdr(pair, Value::Cons(next));
    }

    #[inline(never)]
    fn cons_other(&mut self, car: Value, cdr: Value) -> (u32, usize) {
        let (tail, bytes) = self.tail(cdr);
        (self.place(car, tail), PAIR + bytes)
    }

    /// How a value stands in the table of what follows, and how many bytes it takes beside.
    fn tail(&mut self, value: Value) -> (Tail, usize) {
        match value {
            Value::Cons(next) => (Tail(next), 0),
            Value::Nil => (END, 0),
            other => (Tail(OTHER + self.others.insert(other)), OTHER_TAIL),
        }
    }

    #[inline(always)]
    fn place(&mut self, car: Value, tail: Tail) -> u32 {
        let pair = self.free;
        if pair == NONE {
            self.cars.push(car);
            self.tails.push(tail);
            return self.cars.len() as u32 - 1;
        }
        self.free = next_free(&self.cars[pair as usize]);
        self.cars[pair as usize] = car;
        self.tails[pair as usize] = tail;
        pair
    }

    /// A new list that ends in `tail`, in rows where there is room for them; and how many bytes it takes.
    pub(super) fn list(&mut self, items: &[Value], tail: Value) -> (Value, usize) {
        let mut bytes = 0;
        let list = items.rchunks(LONGEST_ROW).fold(tail, |tail, items| {
            let (part, more) = self.row(items, tail);
            bytes += more;
            part
        });
        (list, bytes)
    }

    fn row(&mut self, items: &[Value], end: Value) -> (Value, usize) {
        if !self.has_row(items.len()) {
            return items.iter().rev().fold((end, 0), |(tail, bytes), &item| {
                let (pair, more) = self.cons(item, tail);
                (Value::Cons(pair), bytes + more)
            });
        }
        let (end, beside) = self.tail(end);
        let first = if self.free == NONE { self.cars.len() as u32 } else { self.free };
        for (at, &item) in items.iter().enumerate() {
            let behind = items.len() - 1 - at;
            self.place(item, if behind == 0 { end } else { Tail::row(behind) });
        }
        (Value::Cons(first), items.len() * PAIR + beside)
    }

    /// Whether the places that are used next lie in a row.
    fn has_row(&self, length: usize) -> bool {
        let free = self.free as usize;
        self.free == NONE
            || self.cars.get(free..free + length).is_some_and(|row| {
                let links = row.iter().take(length - 1).enumerate();
                links.into_iter().all(|(at, link)| next_free(link) as usize == free + at + 1)
            })
    }

    /// Lets something else follow a pair; gives how many bytes that takes beside.
    #[inline]
    pub(super) fn set_cdr(&mut self, pair: u32, cdr: Value) -> usize {
        let before = self.tails[pair as usize];
        if before != END && before.0 >= OTHER {
            self.forget_tail(pair, before);
        }
        let (tail, bytes) = self.tail(cdr);
        self.tails[pair as usize] = tail;
        bytes
    }

    /// Frees what follows, where that lies apart; ends the row here, where it goes on.
    fn forget_tail(&mut self, pair: u32, tail: Tail) {
        if let Some(other) = tail.other() {
            self.others.remove(other);
        }
        if !tail.is_row() {
            return;
        }
        let row = self.tails[..pair as usize].iter_mut().rev().zip(1..);
        for (earlier, behind) in row.take_while(|(earlier, behind)| **earlier == Tail(tail.0.saturating_add(*behind))) {
            *earlier = Tail::row(behind as usize);
        }
    }

    /// Frees what is not marked. The free places are used again from the first on, so that those at the end can be given
    /// back, unless they are no more than `slack` bytes.
    pub(super) fn sweep(&mut self, marks: &Marks, slack: usize) {
        let used = marks.last().map_or(0, |last| last as usize + 1);
        for tail in &self.tails[used..] {
            tail.other().map(|other| self.others.remove(other));
        }
        self.cars.truncate(used);
        self.tails.truncate(used);
        self.frozen.keep_those_of(marks);
        give_back(&mut self.cars, slack);
        give_back(&mut self.tails, slack);
        self.free = NONE;
        for first in (0..used).step_by(64).rev() {
            if !marks.are_all_set(first) {
                self.sweep_places(marks, first..used.min(first + 64));
            }
        }
        self.others.shrink(slack);
    }

    fn sweep_places(&mut self, marks: &Marks, places: std::ops::Range<usize>) {
        let first = places.start;
        let halves = self.cars[places.clone()].iter_mut().zip(&mut self.tails[places]);
        for (offset, (car, tail)) in halves.enumerate().rev() {
            let place = (first + offset) as u32;
            if !marks.is_set(place) {
                tail.other().map(|other| self.others.remove(other));
                *tail = FREE;
                *car = if self.free == NONE { Value::Nil } else { Value::Cons(self.free) };
                self.free = place;
            }
        }
    }

    /// Bytes of the tables.
    pub(super) fn bytes(&self) -> usize {
        self.cars.len() * PAIR + self.others.slots() * OTHER_TAIL + self.frozen.bytes()
    }

    /// Whether the places that are free are those without a pair, each once, what lies apart belongs to one pair each, and
    /// rows are as long as their pairs say.
    pub(crate) fn is_whole(&self) -> bool {
        let places = self.places();
        let are_followed = |(place, &tail): (usize, &Tail)| match tail {
            Tail(next) if next < OTHER => (next as usize) < places,
            tail if tail.is_row() => {
                let next = self.tails.get(place + 1);
                match tail.0 - ROW {
                    0 => false,
                    1 => next.is_some_and(|&next| next != FREE),
                    behind => next == Some(&Tail(ROW + behind - 1)),
                }
            }
            tail => tail == END || tail == FREE || tail.other().is_some(),
        };
        places < OTHER as usize
            && self.tails.len() == places
            && self.tails.iter().enumerate().all(are_followed)
            && self.are_others_whole()
            && self.is_free_list_whole()
            && self.frozen.last().is_none_or(|last| (last as usize) < places)
    }

    fn are_others_whole(&self) -> bool {
        let mut seen = Marks::new(self.others.slots());
        let mut others = self.tails.iter().filter_map(|tail| tail.other());
        let count = others.clone().count();
        let each_once = others.all(|other| self.others.get(other).is_some() && seen.set(other));
        each_once && self.others.is_whole() && self.others.iter().count() == count
    }

    fn is_free_list_whole(&self) -> bool {
        let count = self.tails.iter().filter(|&&tail| tail == FREE).count();
        let mut seen = Marks::new(self.places());
        let mut at = self.free;
        for _ in 0..count {
            if self.tails.get(at as usize) != Some(&FREE) || !seen.set(at) {
                return false;
            }
            at = match self.cars[at as usize] {
                Value::Cons(next) => next,
                Value::Nil => NONE,
                _ => return false,
            };
        }
        at == NONE
    }
}

/// The place that the first half of a free one names.
#[inline]
fn next_free(car: &Value) -> u32 {
    match car {
        &Value::Cons(next) => next,
        _ => NONE,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ints(count: i64) -> Vec<Value> {
        (0..count).map(Value::Int).collect()
    }

    fn items(pairs: &Pairs, list: Value) -> Vec<Value> {
        let (mut items, mut at) = (Vec::new(), list);
        while let Value::Cons(pair) = at {
            items.push(*pairs.car(pair));
            at = pairs.cdr(pair);
        }
        items
    }

    fn number(list: Value) -> u32 {
        let Value::Cons(pair) = list else { unreachable!("it is a list") };
        pair
    }

    /// Frees all but some pairs.
    fn keep(pairs: &mut Pairs, kept: impl IntoIterator<Item = u32>) {
        let mut marks = Marks::new(pairs.places());
        for pair in kept {
            marks.set(pair);
        }
        pairs.sweep(&marks, 0);
        assert!(pairs.is_whole());
    }

    #[test]
    fn a_list_of_any_length_is_what_it_was_made_of() {
        let mut pairs = Pairs::default();
        for length in [1, 2, 3, 255, 256, 257, 600] {
            let (list, bytes) = pairs.list(&ints(length), Value::True);
            assert_eq!(items(&pairs, list), ints(length));
            assert_eq!(bytes, length as usize * PAIR + OTHER_TAIL);
            assert!(pairs.is_whole());
            for place in [0, 1, 254, 255, 256, 599, 600] {
                let found = pairs.behind(number(list), place).map(|pair| *pairs.car(pair));
                assert_eq!(found, (place < length as usize).then_some(Value::Int(place as i64)), "{place} of {length}");
            }
        }
    }

    #[test]
    fn wherever_a_row_is_cut_the_list_goes_on_there_and_no_place_is_found_behind_the_cut() {
        for cut in 0..6 {
            for second in 0..6 {
                let mut pairs = Pairs::default();
                let first = number(pairs.list(&ints(6), Value::Nil).0);
                pairs.set_cdr(first + cut, Value::Nil);
                let other = pairs.cons(Value::True, Value::Nil).0;
                pairs.set_cdr(first + second, Value::Cons(other));
                assert!(pairs.is_whole(), "{cut} {second}");
                let end = cut.min(second);
                let mut expected = ints(i64::from(end) + 1);
                expected.extend((second <= cut).then_some(Value::True));
                assert_eq!(items(&pairs, Value::Cons(first)), expected, "{cut} {second}");
                let found = pairs.behind(first, end as usize + 1);
                assert_eq!(found, (second <= cut).then_some(other), "{cut} {second}");
            }
        }
    }

    #[test]
    fn what_is_no_pair_behind_a_pair_goes_with_it() {
        let mut pairs = Pairs::default();
        let dotted: Vec<u32> = ints(100).into_iter().map(|item| pairs.cons(Value::True, item).0).collect();
        pairs.set_cdr(dotted[0], Value::Int(7));
        pairs.set_cdr(dotted[1], Value::Nil);
        assert!(pairs.is_whole());
        assert_eq!((pairs.cdr(dotted[0]), pairs.cdr(dotted[1])), (Value::Int(7), Value::Nil));
        assert_eq!(pairs.others.iter().count(), 99);
        keep(&mut pairs, [dotted[0], dotted[1], dotted[50]]);
        assert_eq!(pairs.others.iter().count(), 2);
        assert_eq!(pairs.cdr(dotted[50]), Value::Int(50));
    }

    #[test]
    fn free_places_are_used_before_new_ones_and_in_rows_where_they_lie_so() {
        let mut pairs = Pairs::default();
        for item in ints(20) {
            pairs.cons(item, Value::Nil);
        }
        keep(&mut pairs, [0, 1, 2, 8, 19]);
        let (row, _) = pairs.list(&ints(5), Value::Nil);
        assert_eq!((row, pairs.behind(number(row), 4)), (Value::Cons(3), Some(7)));
        let (taken_singly, _) = pairs.list(&ints(11), Value::Nil);
        assert_eq!(items(&pairs, taken_singly), ints(11));
        assert!(pairs.is_whole());
        assert_eq!(pairs.places(), 21);
    }
}
