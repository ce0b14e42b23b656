//! Sets that are mostly small: a sorted list, and a tree once there are many.

use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// More elements than this are kept in a tree.
const MAX_FEW: usize = 32;

/// A set in the order of its elements. Going through a small one costs what a list does; adding and
/// removing cost the logarithm of its size.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(from = "Vec<T>", into = "Vec<T>", bound(deserialize = "T: Ord + Copy + Deserialize<'de>"))]
#[serde(bound(serialize = "T: Ord + Copy + Serialize"))]
pub struct SmallSet<T: Ord + Copy> {
    /// Sorted; empty if there is a tree.
    few: Vec<T>,
    many: BTreeSet<T>,
}

impl<T: Ord + Copy> Default for SmallSet<T> {
    fn default() -> Self {
        Self { few: Vec::new(), many: BTreeSet::new() }
    }
}

impl<T: Ord + Copy> SmallSet<T> {
    /// How many elements there are.
    pub fn len(&self) -> usize {
        self.few.len() + self.many.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether an element is in it.
    pub fn contains(&self, element: &T) -> bool {
        self.few.binary_search(element).is_ok() || self.many.contains(element)
    }

    /// Adds an element, if it is not there.
    pub fn insert(&mut self, element: T) {
        if !self.many.is_empty() {
            self.many.insert(element);
        } else if let Err(at) = self.few.binary_search(&element) {
            self.few.insert(at, element);
            if self.few.len() > MAX_FEW {
                self.many = std::mem::take(&mut self.few).into_iter().collect();
            }
        }
    }

    /// Takes an element out, if it is there.
    pub fn remove(&mut self, element: &T) {
        match self.few.binary_search(element) {
            Ok(at) => drop(self.few.remove(at)),
            Err(_) => drop(self.many.remove(element)),
        }
    }

    /// Keeps only some elements.
    pub fn retain(&mut self, mut keeps: impl FnMut(&T) -> bool) {
        self.few.retain(&mut keeps);
        self.many.retain(keeps);
    }

    /// Shows each element, in order.
    #[inline]
    pub fn for_each(&self, mut act: impl FnMut(T)) {
        self.few.iter().for_each(|&element| act(element));
        if !self.many.is_empty() {
            self.many.iter().for_each(|&element| act(element));
        }
    }

    /// The elements in order. Slower than [`SmallSet::for_each`].
    pub fn iter(&self) -> impl Iterator<Item = &T> {
        self.few.iter().chain(&self.many)
    }
}

impl<T: Ord + Copy> PartialEq for SmallSet<T> {
    fn eq(&self, other: &Self) -> bool {
        self.len() == other.len() && self.iter().eq(other.iter())
    }
}

impl<T: Ord + Copy> From<Vec<T>> for SmallSet<T> {
    fn from(elements: Vec<T>) -> Self {
        let mut set = Self::default();
        elements.into_iter().for_each(|element| set.insert(element));
        set
    }
}

impl<T: Ord + Copy> From<SmallSet<T>> for Vec<T> {
    fn from(set: SmallSet<T>) -> Self {
        set.iter().copied().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_same_set_whether_few_or_many() {
        let mut set = SmallSet::default();
        let mut expected = BTreeSet::new();
        let turns =
            (0..200u32).map(|turn| (turn * 37 % 101, true)).chain((0..101).map(|turn| (turn * 53 % 101, false)));
        for (element, is_added) in turns {
            if is_added {
                set.insert(element);
                expected.insert(element);
            } else {
                set.remove(&element);
                expected.remove(&element);
            }
            assert!(set.iter().eq(&expected) && set.len() == expected.len());
            assert_eq!(set, SmallSet::from(Vec::from(set.clone())));
            assert_eq!(set.contains(&element), is_added);
        }
        assert!(set.is_empty());
    }
}
