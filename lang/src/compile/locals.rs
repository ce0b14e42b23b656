//! Local variables: which are bound where the compiler stands, and which were bound around a place that it
//! has left.

use super::ir::VarId;
use crate::symbol::Symbol;
use std::collections::BTreeMap;

/// The local variables that are bound where the compiler stands. Looking one up takes the same time however
/// many there are.
#[derive(Debug, Default)]
pub(super) struct Locals {
    /// The numbers in `made` of those that are bound, the innermost last.
    bound: Vec<u32>,
    by_name: BTreeMap<Symbol, Vec<VarId>>,
    /// All there ever were: the name, and the one around it.
    made: Vec<(Symbol, Option<u32>)>,
}

/// A place between local variables: the innermost one, if there is one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Surrounding(Option<u32>);

impl Surrounding {
    /// Where nothing is bound.
    pub(super) const NOTHING: Self = Self(None);
}

impl Locals {
    /// Binds one more.
    pub(super) fn bind(&mut self, name: Symbol, variable: VarId) {
        let around = self.surrounding().0;
        self.bound.push(self.made.len() as u32);
        self.made.push((name, around));
        self.by_name.entry(name).or_default().push(variable);
    }

    /// How many are bound.
    pub(super) fn count(&self) -> usize {
        self.bound.len()
    }

    /// Leaves `count` bound.
    pub(super) fn leave(&mut self, count: usize) {
        for local in self.bound.drain(count..) {
            if let Some(variables) = self.by_name.get_mut(&self.made[local as usize].0) {
                variables.pop();
            }
        }
    }

    /// The innermost of a name.
    pub(super) fn find(&self, name: Symbol) -> Option<VarId> {
        self.by_name.get(&name)?.last().copied()
    }

    /// Where the compiler stands.
    pub(super) fn surrounding(&self) -> Surrounding {
        Surrounding(self.bound.last().copied())
    }

    /// The names that were bound around a place, the innermost first.
    pub(super) fn around(&self, place: Surrounding) -> impl Iterator<Item = Symbol> {
        let next = |&local: &u32| self.made[local as usize].1;
        std::iter::successors(place.0, next).map(|local| self.made[local as usize].0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_innermost_of_a_name_is_found_and_what_was_around_a_place_is_remembered() {
        let (a, b) = (Symbol(1), Symbol(2));
        let mut locals = Locals::default();
        locals.bind(a, VarId(0));
        let outside = locals.count();
        locals.bind(b, VarId(1));
        locals.bind(a, VarId(2));
        let inside = locals.surrounding();
        assert_eq!(locals.find(a), Some(VarId(2)));
        locals.leave(outside);
        assert_eq!((locals.find(a), locals.find(b)), (Some(VarId(0)), None));
        assert_eq!(locals.around(inside).collect::<Vec<_>>(), [a, b, a]);
        assert_eq!(locals.around(locals.surrounding()).collect::<Vec<_>>(), [a]);
    }
}
