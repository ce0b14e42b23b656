//! Going on in another process: what lies outside the run was started anew, and the world has not waited.

use crate::robot::{Outbox, Outside};
use crate::run::system::System;
use crate::state::machine::Machine;
use crate::state::registers::Registers;
use crate::state::task::{ScopeKind, Task};
use crate::state::value::Value;
use crate::step::native::Surroundings;
use rpl_lang::code::Program;
use rpl_lang::symbol::Symbol;

/// What the task is called that runs what `def-resume` has defined.
const NAME: &str = "resume";

/// What it runs.
const RUNNER: &str = "%run-hooks";

impl<O: Outside> System<O> {
    /// The process of the run had ended, and another one goes on with it, while all tasks are blocked. Behaviours
    /// that nobody goes on with are interrupted, and what plans have defined for that is ready to run before
    /// all else. A run whose world is a part of it goes on as if nothing had been. Whether something was outside.
    pub fn renew_outside(&mut self) -> bool {
        let mut outbox = Outbox::default();
        if !self.outside.renew(&mut outbox) {
            return false;
        }
        let answers = std::mem::take(&mut outbox.answers);
        let interrupted = std::mem::take(&mut outbox.interrupted);
        self.with_machine(|machine, around| {
            machine.apply_outbox(around, outbox);
            for behaviour in interrupted {
                machine.take_goals(around, behaviour, "what it was moving was started anew");
            }
            machine.take_answers(answers);
            machine.start_resumptions(around);
        });
        true
    }
}

impl Machine {
    /// A task below the main task, more important than all others, for what runs first.
    fn start_resumptions(&mut self, around: &mut Surroundings<'_>) {
        let (program, main) = (around.program, self.main);
        let hooks: Vec<Value> =
            program.resumptions.iter().filter_map(|&name| self.function_named(program, name)).collect();
        let runner = self.symbols.find(RUNNER).and_then(|name| self.function_named(program, name));
        // What the main task leaves behind is cleaned up, whatever has become of the world.
        let is_over = self.tasks[main].state().is_dead() || self.tasks[main].is_leaving();
        let (Some(Value::Function(code)), false, false) = (runner, hooks.is_empty(), is_over) else { return };
        let list = self.heap.list(&hooks);
        let name = self.symbols.intern(NAME);
        let mut task = Task::new(code, Registers::default(), name, self.priorities.appended(0, 0, i64::MAX));
        task.priority_depth = 1;
        task.occurrence = self.count_use(main, name);
        let index = self.tasks.insert(task);
        self.tasks.set_registers(index, &[list]);
        self.adopt(main, 0, index);
        if let Some(ScopeKind::Call(call)) = self.tasks[main].scopes.first_mut().map(|scope| &mut scope.kind) {
            call.spawned += 1;
        }
        self.start_task(around, index);
    }

    fn function_named(&self, program: &Program, name: Symbol) -> Option<Value> {
        let &global = program.names.get(&name)?;
        self.globals.get(global as usize).copied().filter(|value| matches!(value, Value::Function(_)))
    }
}
