//! Forms beside the one that a session runs: each is a task of its own under the main task, and goes
//! first when it is handed in.

use crate::robot::Outside;
use crate::run::library::Rejected;
use crate::run::session::{Answer, Submitted};
use crate::run::stepping::Stop;
use crate::run::system::{System, Turn};
use crate::state::machine::Machine;
use crate::state::registers::Registers;
use crate::state::task::{ScopeKind, Task};
use crate::state::value::{TaskRef, Value};
use crate::step::native::Surroundings;
use rpl_lang::code::GlobalKind;
use rpl_lang::compile::Loader;
use rpl_lang::symbol::Symbol;

/// What the tasks are called.
const NAME: &str = "typed";

/// Forms that were handed in beside the one that runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Beside {
    /// Counts them.
    pub number: u32,
    /// The task that runs them.
    pub task: TaskRef,
    /// The call whose variables they see, and the variables as they were.
    seen: Option<(Stop, Vec<(Symbol, Value)>)>,
}

/// How such forms ended.
#[derive(Clone, Debug, PartialEq)]
pub struct BesideAnswer {
    /// Which.
    pub number: u32,
    /// How.
    pub answer: Answer,
    /// The variables they saw, as they left them.
    variables: Vec<Value>,
}

impl BesideAnswer {
    /// The path of the task.
    pub fn path(&self) -> String {
        match self.number {
            1 => format!("main/{NAME}"),
            number => format!("main/{NAME}.{number}"),
        }
    }
}

impl<O: Outside> System<O> {
    /// Compiles a text into the running program and makes a task of its forms, which sees the
    /// variables of the call that stands at `stop`. The task has not run yet:
    /// [`System::step_beside`].
    ///
    /// # Errors
    /// The findings in the text; then nothing changes.
    pub fn submit_beside(
        &mut self,
        name: &str,
        text: &str,
        stop: Option<&Stop>,
        loader: &mut dyn Loader,
    ) -> Result<(Submitted, Beside), Rejected> {
        let seen = stop.and_then(|stop| Some((stop.clone(), self.variables_at(stop)?)));
        let variables = seen.as_ref().map_or(&[][..], |(_, variables)| variables);
        let names: Vec<&str> = variables.iter().map(|&(name, _)| self.machine.symbols.name(name)).collect();
        let names = names.join(" ");
        // Definitions stand at the top level, so only an expression can be put into a function. On
        // lines of its own it keeps its columns.
        let function = format!("(lambda ({names}) (list (progn\n{text}\n) {names}))");
        let mut values: Vec<Value> = variables.iter().map(|&(_, value)| value).collect();
        let (form, arguments, submitted) = match self.extend(name, &function, loader) {
            Ok((code, submitted)) => {
                let function = self.with_machine(|machine, around| machine.evaluate_code(around, code, &[]));
                let arguments = self.machine.heap.list(&values);
                (function.unwrap_or(Value::Nil), arguments, submitted)
            }
            Err(_) => {
                let (code, submitted) = self.extend(name, text, loader)?;
                values.clear();
                (Value::Function(code), Value::True, submitted)
            }
        };
        let seen = seen.filter(|_| !values.is_empty());
        let (number, task) = self.start_beside(form, arguments);
        Ok((submitted, Beside { number, task, seen }))
    }

    fn start_beside(&mut self, form: Value, arguments: Value) -> (u32, TaskRef) {
        let global = self.session_global("%beside").map(|global| &self.program.globals[global].kind);
        let (Some(&GlobalKind::Function(code)), Some(Value::Int(count))) = (global, self.session_variable("%typed"))
        else {
            unreachable!("the text of the session defines both")
        };
        let number = (count + 1) as u32;
        self.set_session_variable("%typed", Value::Int(count + 1));
        let keep = self.session_variable("%keep").unwrap_or_default();
        let registers = [Value::Int(count + 1), form, arguments, keep];
        let task = self.with_machine(|machine, around| machine.start_beside(around, code, number, &registers));
        (number, task)
    }

    /// Runs the task until it waits, ends or something more important is ready, at most for a slice;
    /// false if it has ended or waits. What has ended at once has assigned the variables of the call it sees.
    pub fn step_beside(&mut self, beside: &Beside) -> bool {
        let task = self.machine.tasks.find_alive(beside.task).filter(|&task| self.machine.is_queued(task));
        let Some(task) = task else { return false };
        let ran = self.with_machine(|machine, around| machine.run_ahead(around, task));
        self.answer_asked(ran) != Turn::Idle
    }

    /// How those ended that have ended since the last call, in order.
    pub fn take_beside_answers(&mut self) -> Vec<BesideAnswer> {
        let mut answers = Vec::new();
        let mut rest = self.session_variable("%answers").unwrap_or_default();
        self.set_session_variable("%answers", Value::Nil);
        while let Value::Cons(pair) = rest {
            let (entry, next) = self.machine.heap.pair(pair);
            answers.extend(self.beside_answer(entry));
            rest = next;
        }
        answers.reverse();
        answers
    }

    fn beside_answer(&self, entry: Value) -> Option<BesideAnswer> {
        let items = self.machine.heap.elements(entry).ok()?;
        let &[Value::Int(number), outcome] = items.as_slice() else { return None };
        let (answer, variables) = match outcome {
            failure @ Value::Failure(_) => (Answer::Failed(failure), Vec::new()),
            outcome => {
                let values = self.machine.heap.elements(outcome).ok()?;
                let (&value, variables) = values.split_first()?;
                (Answer::Succeeded(value), variables.to_vec())
            }
        };
        Some(BesideAnswer { number: number as u32, answer, variables })
    }

    /// Gives the variables of the call that the forms saw the values they left, while the call
    /// stands where it stood. Names of those that have changed.
    pub fn assign_seen(&mut self, beside: &Beside, answer: &BesideAnswer) -> Vec<Symbol> {
        let Some((stop, before)) = &beside.seen else { return Vec::new() };
        let Some(task) = self.machine.tasks.find_alive(stop.task) else { return Vec::new() };
        if self.machine.tasks[task].frame != stop.frame {
            return Vec::new();
        }
        let changed = before.iter().zip(&answer.variables).filter(|((_, before), after)| before != *after);
        let changed: Vec<(Symbol, Value)> = changed.map(|(&(name, _), &value)| (name, value)).collect();
        for &(name, value) in &changed {
            self.machine.assign_variable(&self.program, task, name, value);
        }
        changed.into_iter().map(|(name, _)| name).collect()
    }

    fn variables_at(&self, stop: &Stop) -> Option<Vec<(Symbol, Value)>> {
        let task = self.machine.tasks.find_alive(stop.task)?;
        let (_, variables) = self.machine.variables(&self.program, task).into_iter().next()?;
        Some(variables)
    }
}

impl Machine {
    fn start_beside(&mut self, around: &mut Surroundings<'_>, code: u32, number: u32, registers: &[Value]) -> TaskRef {
        let name = self.symbols.intern(NAME);
        let mut task = Task::new(code, Registers::default(), name, 0);
        task.occurrence = number;
        let index = self.tasks.insert(task);
        self.tasks.set_registers(index, registers);
        self.adopt(self.main, 0, index);
        if let Some(ScopeKind::Call(call)) = self.tasks[self.main].scopes.first_mut().map(|scope| &mut scope.kind) {
            call.spawned += 1;
        }
        self.start_task(around, index);
        self.tasks.reference(index)
    }
}
