//! Registers of tasks that do not run: one store for all, so that a task costs no allocation of its
//! own and a fork copies them in one piece.
//!
//! A block has the smallest of the sizes 1, 2, 3, 4, 6, 8, 12, 16, 24 … that fits. Free blocks of
//! one size are linked through their first value.

use crate::state::slab::Marks;
use crate::state::value::Value;
use serde::{Deserialize, Serialize};

/// The registers of one task in a [`RegisterStore`]. Those behind the last that is not nil are not
/// kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Registers {
    start: u32,
    count: u32,
}

impl Registers {
    /// How many values are kept.
    pub(crate) fn values(self) -> usize {
        self.count as usize
    }
}

/// All registers of all tasks that do not run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RegisterStore {
    values: Vec<Value>,
    /// The first free block of each size; [`Value::Nil`] if there is none.
    free: Vec<Value>,
}

/// Number and size of the class of blocks for `count` values, which are more than none.
fn class(count: usize) -> (usize, usize) {
    if count <= 2 {
        return (count - 1, count);
    }
    let power = (count - 1).ilog2() as usize;
    let between = 3 << (power - 1);
    if count <= between { (2 * power, between) } else { (2 * power + 1, 2 << power) }
}

/// More classes than there are sizes below 2³².
const MAX_CLASSES: usize = 64;

/// The size of the blocks of a class.
fn size(class: usize) -> usize {
    match class {
        0 | 1 => class + 1,
        _ if class.is_multiple_of(2) => 3 << (class / 2 - 1),
        _ => 4 << (class / 2 - 1),
    }
}

impl RegisterStore {
    /// The values of a task's registers.
    pub fn get(&self, registers: Registers) -> &[Value] {
        &self.values[registers.start as usize..registers.start as usize + registers.count as usize]
    }

    /// A block for these values, whose number is known.
    pub fn make(&mut self, count: usize, values: impl Iterator<Item = Value>) -> Registers {
        let registers = self.fitted(Registers::default(), count);
        let start = registers.start as usize;
        for (register, value) in self.values[start..start + count].iter_mut().zip(values) {
            *register = value;
        }
        registers
    }

    /// Keeps these values as a task's registers from now on.
    pub fn set(&mut self, registers: Registers, values: &[Value]) -> Registers {
        let mut count = values.len();
        while count > 0 && matches!(values[count - 1], Value::Nil) {
            count -= 1;
        }
        let registers = self.fitted(registers, count);
        let start = registers.start as usize;
        for (kept, &value) in self.values[start..start + count].iter_mut().zip(values) {
            *kept = value;
        }
        registers
    }

    /// Gives a block back.
    #[inline]
    pub fn free(&mut self, registers: Registers) {
        if registers.count > 0 {
            self.link(registers);
        }
    }

    fn link(&mut self, registers: Registers) {
        let (start, count) = (registers.start, registers.count as usize);
        let (class, size) = class(count);
        if self.free.len() <= class {
            self.free.resize(class + 1, Value::Nil);
        }
        let block = &mut self.values[start as usize..start as usize + size];
        // The first becomes the link.
        block[1..].fill(Value::Nil);
        block[0] = std::mem::replace(&mut self.free[class], Value::Int(i64::from(start)));
    }

    /// Whether the blocks in use and the free ones lie apart, and all within the store.
    pub(crate) fn is_whole(&self, mut used: impl Iterator<Item = Registers>) -> bool {
        let mut seen = Marks::new(self.values.len());
        let mut claim = |start: usize, size: usize| {
            start + size <= self.values.len() && (start..start + size).all(|at| seen.set(at as u32))
        };
        let all_apart = used.all(|registers| match (registers.start as usize, registers.count as usize) {
            (start, 0) => start <= self.values.len(),
            (start, count) => claim(start, class(count).1),
        });
        all_apart
            && self.free.len() <= MAX_CLASSES
            && self.free.iter().enumerate().all(|(class, &first)| {
                let mut at = first;
                while let Value::Int(start) = at {
                    let Ok(start) = u32::try_from(start) else { return false };
                    if !claim(start as usize, size(class)) {
                        return false;
                    }
                    at = self.values[start as usize];
                }
                at == Value::Nil
            })
    }

    /// A block for `count` values: the same one if it fits.
    #[inline]
    fn fitted(&mut self, registers: Registers, count: usize) -> Registers {
        let kept = registers.count as usize;
        if count == kept || (count > 0 && kept > 0 && class(count) == class(kept)) {
            return Registers { start: registers.start, count: count as u32 };
        }
        self.moved(registers, count)
    }

    fn moved(&mut self, registers: Registers, count: usize) -> Registers {
        self.free(registers);
        if count == 0 {
            return Registers::default();
        }
        let (class, size) = class(count);
        let start = match self.free.get(class) {
            Some(&Value::Int(start)) => {
                self.free[class] = self.values[start as usize];
                start as u32
            }
            _ => {
                let start = self.values.len();
                self.values.resize(start + size, Value::Nil);
                start as u32
            }
        };
        Registers { start, count: count as u32 }
    }

    /// Whether the store is large, and most of it is free when `used` values are used.
    pub(crate) fn is_sparse(&self, used: usize) -> bool {
        self.values.len() > 1 << 16 && used * 3 < self.values.len()
    }

    /// Bytes of all blocks, free ones included.
    pub fn bytes(&self) -> usize {
        self.values.len() * size_of::<Value>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_class_has_the_smallest_size_that_fits() {
        let mut before = 0;
        for count in 1..2_000 {
            let (number, size) = class(count);
            assert!(size >= count && size * 2 <= count * 3 + 1, "{count} values in a block of {size}");
            assert!(number >= before, "classes are in the order of their sizes");
            before = number;
        }
    }

    #[test]
    fn what_was_set_is_found_and_freed_blocks_are_used_again() {
        let mut store = RegisterStore::default();
        let values: Vec<Value> = (1..40).map(Value::Int).collect();
        let mut all: Vec<Registers> = values.iter().map(|_| Registers::default()).collect();
        for round in 0..50 {
            for (at, registers) in all.iter_mut().enumerate() {
                let length = (at * 7 + round * 3) % values.len();
                *registers = store.set(*registers, &values[..length]);
            }
            for (at, registers) in all.iter().enumerate() {
                let length = (at * 7 + round * 3) % values.len();
                assert_eq!(store.get(*registers), &values[..length]);
            }
        }
        let most = store.bytes();
        for registers in all {
            store.free(registers);
        }
        for count in (0..values.len()).map(|at| (at * 7 + 49 * 3) % values.len()) {
            assert_eq!(store.set(Registers::default(), &values[..count]).count, count as u32);
        }
        let trimmed = store.set(Registers::default(), &[Value::True, Value::Nil, Value::Nil]);
        assert_eq!(store.get(trimmed), [Value::True]);
        store.free(trimmed);
        assert!(store.bytes() <= most + 16, "free blocks are used again");
    }
}
