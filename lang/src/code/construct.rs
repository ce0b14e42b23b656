//! Constructs of concurrent children: one primitive, and the quorum that decides its outcome.

use super::Reg;
use crate::symbol::Symbol;
use serde::{Deserialize, Serialize};

/// How the ends of its children decide the outcome of a construct.
///
/// It succeeds as soon as enough children have succeeded. It fails as soon as enough have failed, or
/// too few are left that could succeed. The children that are left then are evaporated. A child that
/// something else evaporates is neither a success nor a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Quorum {
    /// How many successes are enough.
    pub successes: Successes,
    /// How many failures are enough.
    pub failures: Failures,
    /// What its value is.
    pub values: Values,
}

/// What the value of a construct is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Values {
    /// That of the child that decides, or the last by position of all.
    One,
    /// The list of those of the children that have succeeded, in the order in which they did.
    AsTheyCame,
    /// The list of those of all children, in the order of their positions.
    InOrder,
}

/// How many successes are enough.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Successes {
    /// Those of all children that are not evaporated.
    All,
    /// That of the last child, for which being evaporated counts as well. Those before it are its
    /// policies.
    Last,
    /// This many.
    Count(u32),
}

/// How many failures are enough.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Failures {
    /// Those of all children, together.
    All,
    /// This many.
    Count(u32),
    /// However many, none: a failure is the value of its child.
    Settled,
}

impl Quorum {
    /// `par` and `plan`: all must succeed.
    pub const PAR: Self = Self::new(Successes::All, Failures::Count(1));
    /// `pursue`: the first end decides.
    pub const PURSUE: Self = Self::new(Successes::Count(1), Failures::Count(1));
    /// `try-all`: the first success decides.
    pub const TRY_ALL: Self = Self::new(Successes::Count(1), Failures::All);
    /// `with-policy`, and every construct of one child: its end is the construct's.
    pub const LAST: Self = Self::new(Successes::Last, Failures::Count(1));
    /// `quorum`, before its arguments are known: at least one must succeed.
    pub const ASKED: Self =
        Self { successes: Successes::Count(1), failures: Failures::All, values: Values::AsTheyCame };
    /// `gather`: as `par`, with the values of all.
    pub const GATHER: Self = Self { values: Values::InOrder, ..Self::PAR };
    /// `settle`: all must end, in whatever way.
    pub const SETTLE: Self = Self { failures: Failures::Settled, ..Self::GATHER };

    const fn new(successes: Successes, failures: Failures) -> Self {
        Self { successes, failures, values: Values::One }
    }
}

/// One child of a construct.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Child {
    /// Its code.
    pub code: u32,
    /// The register whose value (or cell) is the tag's task; [`NO_REG`](super::NO_REG) if it has no tag.
    pub tag: Reg,
    /// A tag's or process' name, a symbol; else the child is named after the construct.
    pub name: Option<Symbol>,
}

/// What a construct is told when it starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Argument {
    /// The register of the number that is appended to the priority of its child.
    Priority(Reg),
    /// A deadline.
    Deadline {
        /// The register of the seconds there are.
        seconds: Reg,
        /// Whether only the time counts in which the child is not suspended.
        active: bool,
    },
    /// The registers of the numbers of a quorum, which takes the place of [`Quorum::ASKED`].
    Quorum {
        /// How many successes are enough.
        successes: Reg,
        /// How many failures are enough.
        failures: Reg,
    },
    /// The register of how many children of a map are begun and not ended, at most.
    Most(Reg),
}

/// A construct of concurrent children.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Construct {
    /// How the outcome is decided.
    pub quorum: Quorum,
    /// The construct's name in paths.
    pub name: Symbol,
    /// In the order of position.
    pub children: Vec<Child>,
    /// Of a partial order: the second starts when the first is dead.
    pub order: Vec<(u16, u16)>,
    /// What it is told when it starts.
    pub argument: Option<Argument>,
}

impl Construct {
    /// Whether its first child is a policy.
    pub fn has_policy(&self) -> bool {
        self.quorum.successes == Successes::Last && self.children.len() > 1
    }

    /// Whether its one child stands for it in paths.
    pub fn is_single(&self) -> bool {
        self.quorum.successes == Successes::Last && self.children.len() == 1
    }
}
