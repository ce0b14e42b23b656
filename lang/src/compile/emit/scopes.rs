//! Constructs of tasks, and forms around a body: handlers, clean-ups, valves, hooks.

use super::emitter::Emitter;
use crate::code::{Argument, Child, Construct, NO_REG, Op, Reg};
use crate::compile::ir::{ArgumentIr, ClauseIr, ConstructIr, Ir, ScopeIr, VarId};

impl Emitter<'_, '_> {
    pub(super) fn construct(&mut self, construct: &ConstructIr) -> u32 {
        let argument = construct.argument.as_ref().map(|argument| match argument {
            ArgumentIr::Priority(number) => Argument::Priority(self.kept(number)),
            ArgumentIr::Deadline { seconds, active } => {
                Argument::Deadline { seconds: self.kept(seconds), active: *active }
            }
            ArgumentIr::Quorum { successes, failures } => {
                Argument::Quorum { successes: self.kept(successes), failures: self.kept(failures) }
            }
            ArgumentIr::Most(count) => Argument::Most(self.kept(count)),
        });
        let children = construct
            .children
            .iter()
            .map(|child| Child {
                code: self.inner(&child.body),
                tag: child.tag.and_then(|tag| self.registers.get(&tag).copied()).unwrap_or(NO_REG),
                name: child.name,
            })
            .collect();
        self.constructs.push(Construct {
            quorum: construct.quorum,
            name: construct.name,
            children,
            order: construct.order.clone(),
            argument,
        });
        self.constructs.len() as u32 - 1
    }

    pub(super) fn handler(&mut self, body: &Ir, failure: VarId, clauses: &[ClauseIr], into: Reg) {
        let failure_reg = self.fresh();
        let clause_reg = self.fresh();
        self.place(failure, failure_reg);
        self.handlers.push(clauses.iter().map(|clause| clause.classes.clone()).collect());
        let index = self.handlers.len() as u16 - 1;
        let push = self.push(Op::PushHandler(failure_reg, index, 0));
        self.scopes += 1;
        self.value(body, into, false);
        self.push(Op::PopScopes(1));
        self.scopes -= 1;
        let done = self.push(Op::Jump(0));
        self.land(push);
        self.put_in_cell(failure, failure_reg);
        let mut exits = vec![done];
        for (number, clause) in clauses.iter().enumerate() {
            let next = self.push(Op::JumpUnlessNumEqInt(clause_reg, number as i16, 0));
            self.value(&clause.body, into, false);
            exits.push(self.push(Op::Jump(0)));
            self.land(next);
        }
        for exit in exits {
            self.land(exit);
        }
    }

    pub(super) fn cleanup(&mut self, always: bool, body: &Ir, cleanup: &Ir, into: Reg) {
        // The value waits in a register of its own while the clean-up uses the others.
        let result = self.fresh();
        let push = self.push(Op::PushCleanup(0));
        self.scopes += 1;
        self.value(body, result, false);
        let skip = if always {
            self.push(Op::BeginCleanup);
            None
        } else {
            self.push(Op::PopScopes(1));
            Some(self.push(Op::Jump(0)))
        };
        self.land(push);
        self.temporarily(|emitter| {
            let unused = emitter.fresh();
            emitter.value(cleanup, unused, false);
        });
        self.push(Op::EndCleanup);
        self.scopes -= 1;
        if let Some(skip) = skip {
            self.land(skip);
        }
        self.take(result, into);
    }

    pub(super) fn scope(&mut self, scope: &ScopeIr, body: &Ir, into: Reg) {
        let reg = self.fresh();
        let op = match scope {
            ScopeIr::Valve { valve, seconds } => {
                self.value(valve, reg, false);
                let seconds = match seconds {
                    Some(seconds) => {
                        let register = self.fresh();
                        self.value(seconds, register, false);
                        register
                    }
                    None => NO_REG,
                };
                Op::PushValve(reg, seconds)
            }
            ScopeIr::Suspended(value) => {
                self.value(value, reg, false);
                Op::PushSuspended(reg)
            }
            ScopeIr::Fence => Op::PushFence,
            ScopeIr::OnInterrupt(hook) | ScopeIr::OnResume(hook) => {
                let code = self.inner(hook);
                self.push(Op::Closure(reg, code));
                if matches!(scope, ScopeIr::OnInterrupt(_)) { Op::PushOnInterrupt(reg) } else { Op::PushOnResume(reg) }
            }
        };
        self.push(op);
        self.scopes += 1;
        self.value(body, into, false);
        self.push(Op::PopScopes(1));
        self.scopes -= 1;
    }
}
