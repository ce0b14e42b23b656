//! The names of the rules.

/// The rules, in the order of their documentation.
pub const RULES: &[&str] = &[
    "unused-binding",
    "duplicate-definition",
    "redefines-library",
    "unreachable-code",
    "unreachable-clause",
    "unused-value",
    "endless-loop",
    "policy-never-waits",
    "network-effect",
    "condition-never-changes",
    "fluent-as-value",
    "wrong-kind",
    "unknown-parameter",
    "unknown-place",
    "unknown-slot",
    "unknown-state",
    "wrong-call",
    "wrong-format",
    "valve-order",
    "needs-valve",
    "suspends-itself",
    "never-enough",
];
