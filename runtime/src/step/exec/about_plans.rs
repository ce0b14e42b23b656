//! Which function does an instruction that the loop hands over.

use crate::state::failure::Raise;
use crate::state::machine::Machine;
use crate::state::scratch::Cursor;
use crate::step::exec::Proceed;
use crate::step::native::Surroundings;
use rpl_lang::code::Op;

impl Machine {
    /// Does an instruction about plans, tasks or scopes, about a table where its key has parts, or about a slot that is
    /// not there. Apart from the loop, so that it has one place for all of them.
    pub(super) fn plan_instruction(
        &mut self,
        around: &mut Surroundings<'_>,
        place: &mut Cursor,
        op: Op,
    ) -> Result<Proceed, Raise> {
        let program = around.program;
        match op {
            Op::DefFluent(a, global) => self.define_fluent(program, place, a, global),
            Op::EnterPlan => self.enter_plan(program, place),
            Op::LeavePlan(a) => self.leave_plan(around, place, a),
            Op::TagNew(a, name) => self.new_tag(place, a, name),
            Op::Parallel(a, construct) => self.start_parallel(around, place, a, construct),
            Op::ParallelMap(a, list, construct) => self.start_parallel_map(around, place, a, list, construct),
            Op::Spawn(a, construct) => self.spawn(around, place, a, construct),
            Op::PushBlock(a, result, distance) => self.push_block(place, a, result, distance),
            Op::ReturnFrom(a, b) => self.return_from(place, a, b),
            Op::PushHandler(a, clauses, distance) => self.push_handler(place, a, clauses, distance),
            Op::PushCleanup(distance) => self.push_cleanup(place, distance),
            Op::BeginCleanup => self.begin_cleanup(),
            Op::EndCleanup => self.end_cleanup(around),
            Op::PushValve(a, seconds) => self.push_valve(around, place, a, seconds),
            Op::PushOnInterrupt(a) => self.push_on_interrupt(place, a),
            Op::PushOnResume(a) => self.push_on_resume(place, a),
            Op::PushSuspended(a) => self.push_suspended(around, place, a),
            Op::PushFence => self.push_fence(),
            Op::PushWatch(a, missed, owned) => self.push_watch(place, a, missed, owned),
            Op::WatchWait => self.wait_for_event(place),
            Op::WatchDone => self.end_event_service(),
            Op::PopScopes(count) => self.pop_scopes(around, count),
            Op::LeaveScopes(count, distance) => self.leave_scopes(place, count, distance),
            Op::Slot(a, record, _, kind) => self.absent_slot(program, place, a, record, kind),
            Op::SetSlot(record, _, slot, kind) => self.set_absent_slot(program, place, record, slot, kind),
            Op::TableRef(a, key, table, default) => self.table_ref(place, [a, key, table, default]),
            Op::SetTableRef(key, table, value) => self.set_table_ref(place, [key, table, value]),
            Op::Network(a, code) => self.make_network(around, place, a, code),
            other => unreachable!("the loop does {other:?} itself"),
        }
    }
}
