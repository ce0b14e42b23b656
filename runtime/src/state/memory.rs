//! Bytes that the records of a run take, as [`crate::step::memory::room`] counts them.

use crate::state::block::{block, entry};
use crate::state::failure::Failure;
use crate::state::fluent::{Fluent, Origin, Watch};
use crate::state::task::Then;
use crate::state::task::{Children, Frame, PlanCall, Rare, Scope, ScopeKind, Task};
use crate::state::timers::Timer;
use crate::state::value::{TaskRef, Value};
use crate::state::valve::{Below, Waiter};
use crate::state::valve_line::ValveLine;
use crate::state::valve_place::Link;

/// Collections come at least this many bytes apart, where there is room.
pub const MIN_THRESHOLD: usize = 8 << 20;

/// Bytes of a new task, its registers not counted.
pub(crate) const TASK: usize = size_of::<Option<Task>>() + size_of::<u32>();

/// Bytes of a new fluent with `captured` captured values, and of its slot among the free ones.
pub(crate) fn fluent(captured: usize) -> usize {
    size_of::<Option<Fluent>>() + size_of::<u32>() + block(captured * size_of::<Value>())
}

/// Bytes of an edge from a fluent to a network that reads it, or to a watch.
pub(crate) const EDGE: usize = 2 * size_of::<(u64, u32)>() + size_of::<u32>();

/// Bytes of a watch.
pub(crate) const WATCH: usize = size_of::<Option<Watch>>() + EDGE;

/// Bytes of a task that waits for a valve: its request, and its turns in two lines.
pub(crate) const WAITER: usize =
    entry::<(u32, Waiter)>() + 2 * entry::<(u64, u32)>() + entry::<(u64, Below)>() + size_of::<ValveLine>();

/// Bytes of a hold or a mark of a valve, which the task knows of too.
pub(crate) const LINK: usize = size_of::<Link>() + 2 * size_of::<u32>();

/// Bytes of a timer.
pub(crate) const TIMER: usize = size_of::<Timer>();

/// Bytes of how often names were used: the first ones take a whole node of their map.
pub(crate) fn counters(names: usize) -> usize {
    if names == 0 { 0 } else { COUNTERS + names * entry::<(u32, u32)>() }
}

/// Bytes of the first name that is counted.
pub(crate) const COUNTERS: usize = 112;

/// Bytes of the stack of scopes of a task that has any: boxes, and room for the first ones.
pub(crate) const SCOPE_STACK: usize = 304;

/// Bytes of a scope.
pub(crate) fn scope(kind: &ScopeKind) -> usize {
    let inside = match kind {
        ScopeKind::Call(call) => {
            block(size_of::<PlanCall>())
                + counters(call.counters.len())
                + block(std::mem::size_of_val(call.tags.as_slice()))
        }
        ScopeKind::Children(children) => {
            block(size_of::<Children>())
                + block(std::mem::size_of_val(children.values.as_slice()))
                + block(std::mem::size_of_val(children.failures.as_slice()))
                + block(std::mem::size_of_val(children.order.as_slice()))
                + block(std::mem::size_of_val(children.held.as_slice()))
                + block(children.later.len() * size_of::<TaskRef>())
        }
        ScopeKind::InCleanup(_) => block(size_of::<Then>()),
        ScopeKind::Block { .. }
        | ScopeKind::Handler { .. }
        | ScopeKind::Cleanup { .. }
        | ScopeKind::Valve(_)
        | ScopeKind::OnInterrupt(_)
        | ScopeKind::OnResume(_)
        | ScopeKind::Suspended(_)
        | ScopeKind::Watch(_)
        | ScopeKind::Fence => 0,
    };
    size_of::<Scope>() + size_of::<u32>() + inside
}

/// Bytes of what a failure holds.
pub(crate) fn failure(failure: &Failure) -> usize {
    block(failure.message.len())
        + block(failure.path.len())
        + block(std::mem::size_of_val(failure.slots.as_slice()))
        + block(std::mem::size_of_val(failure.calls.as_slice()))
        + block(std::mem::size_of_val(failure.parts.as_slice()))
        + block(std::mem::size_of_val(failure.while_cleaning_up.as_slice()))
}

/// Bytes of the stack of frames of a task that has any.
const FRAME_STACK: usize = 64;

/// Bytes of a task beside its record and registers.
pub(crate) fn task(task: &Task) -> usize {
    let frames = match task.frames.len() {
        0 => 0,
        count => FRAME_STACK + count * size_of::<Frame>(),
    };
    let scopes: usize = task.scopes.iter().map(|entered| scope(&entered.kind)).sum();
    let scopes = if scopes == 0 { 0 } else { SCOPE_STACK + scopes };
    let rare = task
        .rare
        .as_ref()
        .map_or(0, |rare| block(size_of::<Rare>()) + counters(rare.counters.len()) + counters(rare.finished.len()));
    frames + scopes + rare
}

/// Bytes of a fluent that is alive, beside its record.
pub(crate) fn fluent_parts(fluent: &Fluent) -> usize {
    let captured = match &fluent.origin {
        Origin::Network { captured, .. } => block(std::mem::size_of_val::<[Value]>(captured)),
        Origin::Plan | Origin::System | Origin::Pulsed | Origin::Changed | Origin::Count => 0,
    };
    captured + (fluent.dependents.len() + fluent.watches.len() + fluent.inputs.len()) * EDGE
}
