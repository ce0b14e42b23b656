//! Valves: pre-emptible semaphores that guard effectors.
//!
//! # The rule
//!
//! A valve has places, an ordinary one a single place. A place is a stack. A *hold* says that a task has taken it; a
//! *mark* above holds says that the valve was taken away there, and names the root of the subtree that has been
//! suspended for it.
//! The topmost hold is the *holder's*, as long as no mark lies above it.
//!
//! - **Taking.** Whoever is the holder or below it takes the valve at once: it *borrows* it, and its
//!   hold goes on top. So borrowing nests, and one borrows at a time. A valve nobody holds is free.
//! - **Waiting.** Everybody else waits in line, by priority, then by the order of asking. A suspended
//!   task keeps its place and is passed over.
//! - **Pre-empting.** Who has a higher priority than the holder takes the valve away. If a task that
//!   holds it is above both of them, that is done from *inside*: what is suspended is the branch
//!   below the nearest common ancestor that contains the holder. Otherwise it is done from *outside*:
//!   what is suspended is the whole subtree of the *owner*, the outermost task above the holder that
//!   holds the valve. A mark with that root goes on top, and the requester's hold above it. As long as
//!   a clean-up runs anywhere in that subtree, or the subtree is a part of a clean-up to which the
//!   requester does not belong, the requester is passed over, nothing is suspended, and the clean-up
//!   runs at its priority.
//! - **Giving back.** With its hold gone from the top, the valve goes to the first in line who can
//!   have it. If a mark has come to the top, the interrupted one is asked as well, with the priority
//!   of the hold below: only a higher priority goes first, and suspends what is not suspended yet.
//!   Otherwise the mark goes away and its root is resumed; if nobody below that root holds the valve
//!   any more, a clean-up there that waits for it comes before its equals.
//! - **Dying.** The holds of a dead task, and the marks of which it is the root, are taken out
//!   wherever they are. What lies below keeps its place: the valve goes back to the next living hold.
//!   A mark whose interrupted hold is gone stays as long as its root lives, which is suspended until
//!   the valve comes back to it.
//! - **Hooks.** Between the mark and the requester's hold, and before the mark goes away, the hooks
//!   of the subtree run in a task that holds the valve meanwhile; nothing else is served. Scopes in
//!   a subtree that is interrupted already have had their turn.
//! - **Places.** A task belongs to the place of the nearest task from itself upwards that has a link anywhere in the
//!   valve, and all above holds for it there. Who belongs to none can have any: a free one, where no owner is left that
//!   could use it, or else that whose holder is least important. An interrupted owner can have any free place too: then
//!   the links of its subtree go there, in their order, and come under its own rule again. A place about to be lent
//!   while hooks run counts for the first of those who belong to none, so that nobody takes two.
//! - **One decision is one.** What a construct ends, it ends before any valve goes on to somebody.
//!
//! # Cost
//!
//! A request, a release and a death cost the logarithm of the number of waiters, times the depth of
//! the task in the tree. To find the first who can have a valve looks at the first in line and at the
//! first of those below the holder; only while somebody waits for a clean-up to end are there more:
//! the first in each line, and those of the lines of lenders above the holder who could pre-empt it. The cost grows in
//! proportion to the places of a valve, which therefore has few.

mod boost;
mod hooks;
mod links;
mod places;
mod request;
mod serving;
mod way;
