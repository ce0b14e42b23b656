//! Slots by number, used again when free.

use serde::{Deserialize, Serialize};

/// A table of values by number. Free slots are used again, the last freed first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slab<T> {
    slots: Vec<Option<T>>,
    free: Vec<u32>,
}

impl<T> Default for Slab<T> {
    fn default() -> Self {
        Self { slots: Vec::new(), free: Vec::new() }
    }
}

impl<T> Slab<T> {
    /// Adds a value.
    pub fn insert(&mut self, value: T) -> u32 {
        match self.free.pop() {
            Some(index) => {
                self.slots[index as usize] = Some(value);
                index
            }
            None => {
                self.slots.push(Some(value));
                self.slots.len() as u32 - 1
            }
        }
    }

    /// Frees a slot.
    pub fn remove(&mut self, index: u32) -> Option<T> {
        let value = self.slots.get_mut(index as usize)?.take();
        if value.is_some() {
            self.free.push(index);
        }
        value
    }

    /// Frees a slot, if it is used; what was in it is not moved.
    pub fn clear(&mut self, index: u32) {
        if let Some(slot @ Some(_)) = self.slots.get_mut(index as usize) {
            *slot = None;
            self.free.push(index);
        }
    }

    /// The value in a slot, if it is used.
    pub fn get(&self, index: u32) -> Option<&T> {
        self.slots.get(index as usize)?.as_ref()
    }

    /// The value in a slot, if it is used.
    pub fn get_mut(&mut self, index: u32) -> Option<&mut T> {
        self.slots.get_mut(index as usize)?.as_mut()
    }

    /// All used slots in the order of their numbers.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &T)> {
        self.slots.iter().enumerate().filter_map(|(index, slot)| Some((index as u32, slot.as_ref()?)))
    }

    /// All values in the order of their slots.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut T> {
        self.slots.iter_mut().flatten()
    }

    /// How many slots there are, free ones included.
    pub fn slots(&self) -> usize {
        self.slots.len()
    }

    /// Whether the free slots are those without a value, each once.
    pub(crate) fn is_whole(&self) -> bool {
        is_free_list(&self.free, self.slots.len(), |index| self.slots[index].is_none())
    }

    /// Frees every slot whose mark is not set. More free room than `slack` bytes may be given back.
    pub fn sweep(&mut self, marks: &Marks, slack: usize, mut freed: impl FnMut(T)) {
        for (index, slot) in self.slots.iter_mut().enumerate() {
            if !marks.is_set(index as u32)
                && let Some(value) = slot.take()
            {
                freed(value);
            }
        }
        self.order(slack);
    }

    /// Gives the free slots at the end back; the others are used again from the first on.
    pub fn shrink(&mut self, slack: usize) {
        if !self.free.is_empty() {
            return self.order(slack);
        }
        give_back(&mut self.slots, slack);
        give_back(&mut self.free, slack);
    }

    /// The same, whatever is known of free slots.
    fn order(&mut self, slack: usize) {
        let used = self.slots.iter().rposition(Option::is_some).map_or(0, |last| last + 1);
        self.slots.truncate(used);
        give_back(&mut self.slots, slack);
        self.free.clear();
        let free = self.slots.iter().enumerate().rev().filter(|(_, slot)| slot.is_none());
        self.free.extend(free.map(|(index, _)| index as u32));
        give_back(&mut self.free, slack);
    }
}

/// Gives back what a table has room for beyond its length, if that is more than `slack` bytes.
pub(crate) fn give_back<T>(table: &mut Vec<T>, slack: usize) {
    let unused = (table.capacity() - table.len()) * size_of::<T>();
    if unused > slack && table.capacity() > 2 * table.len() {
        table.shrink_to_fit();
    }
}

impl<T> std::ops::Index<u32> for Slab<T> {
    type Output = T;

    #[inline]
    fn index(&self, index: u32) -> &T {
        match &self.slots[index as usize] {
            Some(value) => value,
            None => panic!("slot {index} is free: a handle has outlived its object"),
        }
    }
}

impl<T> std::ops::IndexMut<u32> for Slab<T> {
    #[inline]
    fn index_mut(&mut self, index: u32) -> &mut T {
        match &mut self.slots[index as usize] {
            Some(value) => value,
            None => panic!("slot {index} is free: a handle has outlived its object"),
        }
    }
}

/// Whether a list names each free one of `slots` slots once.
fn is_free_list(free: &[u32], slots: usize, is_free: impl Fn(usize) -> bool) -> bool {
    let mut seen = Marks::new(slots);
    let all_free = free.iter().all(|&index| (index as usize) < slots && is_free(index as usize) && seen.set(index));
    all_free && (0..slots).filter(|&index| is_free(index)).count() == free.len()
}

/// One bit for each slot of a slab.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Marks(Vec<u64>);

impl Marks {
    /// No bit set.
    pub fn new(slots: usize) -> Self {
        Self(vec![0; slots.div_ceil(64)])
    }

    /// Sets a bit; tells whether it was clear.
    pub fn set(&mut self, index: u32) -> bool {
        let (word, bit) = (index as usize / 64, 1 << (index % 64));
        let fresh = self.0[word] & bit == 0;
        self.0[word] |= bit;
        fresh
    }

    /// Whether all of the 64 bits from this one on are set; it is a multiple of 64.
    pub fn are_all_set(&self, index: usize) -> bool {
        self.0[index / 64] == u64::MAX
    }

    /// The last bit that is set.
    pub fn last(&self) -> Option<u32> {
        let word = self.0.iter().rposition(|&word| word != 0)?;
        Some(word as u32 * 64 + 63 - self.0[word].leading_zeros())
    }

    /// Whether the bit is there and set.
    #[inline]
    pub fn has(&self, index: u32) -> bool {
        self.0.get(index as usize / 64).is_some_and(|word| word & (1 << (index % 64)) != 0)
    }

    /// Makes room for a bit.
    pub fn grow(&mut self, index: u32) {
        let words = index as usize / 64 + 1;
        if self.0.len() < words {
            self.0.resize(words, 0);
        }
    }

    /// Clears what is not set in the other, which has room for all that is set here, and gives room back at the end.
    pub fn keep_those_of(&mut self, others: &Marks) {
        self.0.iter_mut().zip(&others.0).for_each(|(word, other)| *word &= other);
        self.0.truncate(self.0.iter().rposition(|&word| word != 0).map_or(0, |last| last + 1));
    }

    /// Bytes it takes.
    pub fn bytes(&self) -> usize {
        self.0.len() * size_of::<u64>()
    }

    /// Whether the bit is set.
    pub fn is_set(&self, index: u32) -> bool {
        self.0[index as usize / 64] & (1 << (index % 64)) != 0
    }
}

/// No task, no fluent.
pub const NONE: u32 = u32::MAX;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slots_that_were_cleared_are_used_again_and_given_back() {
        let mut slab = Slab::default();
        (0..100).for_each(|number| assert_eq!(slab.insert(number), number));
        (0..100).filter(|number| number % 3 == 0 || *number > 80).for_each(|number| slab.clear(number));
        slab.clear(0);
        slab.clear(1_000);
        assert!(slab.is_whole(), "a slot is free once");
        slab.shrink(0);
        assert_eq!((slab.slots(), slab.insert(7)), (81, 0), "the first free slot is used first");
        assert!(slab.is_whole() && slab.get(3).is_none() && slab.get(80) == Some(&80));
        let mut marks = Marks::new(slab.slots());
        marks.set(80);
        slab.sweep(&marks, 0, drop);
        assert!(slab.is_whole() && slab.iter().map(|(_, &number)| number).eq([80]));
    }
}
