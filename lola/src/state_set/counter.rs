//! Counting, to compare with.

use super::chain::Chain;
use crate::feature::Percept;

/// Whether the nth percept that concerns the instruction, counted from 1, is the goal to a follower that counts
/// and stops at the right kind.
pub(super) fn is_goal(chain: &Chain, counted: u64, percept: &Percept) -> bool {
    counted >= chain.length as u64 && percept.seen == chain.goal
}
