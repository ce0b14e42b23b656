//! Resolved forms to register code. Registers are given out like a stack: parameters, captured
//! values, variables and temporaries in the order of their nesting.

mod arithmetic;
mod branches;
mod calls;
mod emitter;
mod function;
mod natives;
mod scopes;
mod sequence;
mod value_facts;
mod values;

pub(super) use function::emit;
pub(super) use sequence::sequence;
