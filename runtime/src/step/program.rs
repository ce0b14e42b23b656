//! What a program brings into a machine: constants, globals, valves, the main task.

use crate::state::fluent::{Fluent, Origin};
use crate::state::machine::Machine;
use crate::state::registers::Registers;
use crate::state::task::{PlanCall, Scope, ScopeKind, Task};
use crate::state::value::Value;
use crate::state::valve::Valve;
use crate::state::valve_place::Place;
use rpl_lang::code::{Atom, Constant, GlobalKind, Part, Program};
use rpl_lang::symbol::Symbol;

impl Machine {
    /// Makes room for what has been added to the program: constants, globals, valves. `objects`
    /// are the run-time objects that new constants name.
    pub fn bring_up_to(&mut self, program: &Program, objects: &[Value]) {
        self.bring_up_constants(program, objects);
        self.bring_up_globals(program, 0..program.globals.len() as u32);
    }

    /// The same for what constants were added.
    pub(crate) fn bring_up_constants(&mut self, program: &Program, objects: &[Value]) {
        for constant in &program.constants[self.constants.len()..] {
            let value = self.constant(constant, objects);
            self.constants.push(value);
        }
    }

    /// The same for these globals, which were defined.
    pub(crate) fn bring_up_globals(&mut self, program: &Program, defined: impl Iterator<Item = u32>) {
        self.globals.resize(program.globals.len(), Value::Unbound);
        for index in defined {
            let (global, known) = (&program.globals[index as usize], self.globals[index as usize]);
            self.globals[index as usize] = match global.kind {
                GlobalKind::Function(code) if code != u32::MAX => Value::Function(code),
                GlobalKind::Valve { places } => match known {
                    Value::Valve(valve) if self.valves[valve as usize].places == places => known,
                    _ => self.make_valve(global.name, places),
                },
                GlobalKind::Behaviour(number) => Value::Behaviour(number),
                _ => match global.initial {
                    Some(constant) if matches!(known, Value::Unbound) => {
                        self.initial(&global.kind, global.name, constant)
                    }
                    _ => known,
                },
            };
        }
    }

    fn make_valve(&mut self, name: Symbol, places: u32) -> Value {
        let (valve, first_place) = (self.valves.len() as u32, self.places.len() as u32);
        self.valves.push(Valve::new(name, first_place, places));
        self.places.resize(self.places.len() + places as usize, Place::new(valve));
        Value::Valve(valve)
    }

    /// What a variable or a fluent of the library is when a run begins.
    fn initial(&mut self, kind: &GlobalKind, name: Symbol, constant: u32) -> Value {
        let value = self.constants[constant as usize];
        match kind {
            GlobalKind::Fluent => Value::Fluent(self.fluents.insert(Fluent::new(Some(name), value, Origin::Plan))),
            _ => value,
        }
    }

    /// The same for constants whose places were used before.
    pub(crate) fn renew_constants(&mut self, program: &Program, constants: &[u32], objects: &[Value]) {
        for &at in constants {
            if (at as usize) < self.constants.len() {
                self.constants[at as usize] = self.constant(&program.constants[at as usize], objects);
            }
        }
    }

    fn constant(&mut self, constant: &Constant, objects: &[Value]) -> Value {
        let parts = match constant {
            Constant::Atom(atom) => return self.atom(atom, objects),
            Constant::Compound(parts) => parts,
        };
        let mut values = Vec::new();
        for part in parts {
            let value = match part {
                Part::Atom(atom) => self.atom(atom, objects),
                Part::List { length, dotted } => {
                    let tail = if *dotted { values.pop().unwrap_or_default() } else { Value::Nil };
                    let items = values.split_off(values.len().saturating_sub(*length as usize));
                    self.heap.list_with_tail(&items, tail)
                }
                Part::Vector { length } => {
                    let items = values.split_off(values.len().saturating_sub(*length as usize));
                    self.heap.vector(items)
                }
            };
            values.push(value);
        }
        values.pop().unwrap_or_default()
    }

    fn atom(&mut self, atom: &Atom, objects: &[Value]) -> Value {
        match atom {
            Atom::Int(value) => Value::Int(*value),
            Atom::Float(value) => Value::Float(*value),
            Atom::Str(text) => self.heap.string(text),
            Atom::Symbol(symbol) => Value::Symbol(*symbol),
            Atom::Keyword(symbol) => Value::Keyword(*symbol),
            Atom::Nil => Value::Nil,
            Atom::True => Value::True,
            Atom::Native(number) => Value::Native(*number),
            Atom::Object(index) => objects.get(*index as usize).copied().unwrap_or(Value::Nil),
        }
    }

    /// Gives a global of the robot its fluent.
    pub fn define_system_fluent(&mut self, global: u32, name: Symbol, value: Value) -> u32 {
        let fluent = self.fluents.insert(Fluent::new(Some(name), value, Origin::System));
        self.globals[global as usize] = Value::Fluent(fluent);
        fluent
    }

    /// Starts the main task on code without parameters.
    pub fn start_main(&mut self, code: u32) {
        let name = self.symbols.intern("main");
        let mut task = Task::new(code, Registers::default(), name, 0);
        let call = PlanCall::new(name, 1, None);
        task.scopes.push(Scope { kind: ScopeKind::Call(Box::new(call)), depth: 0 });
        task.exposed = true;
        self.main = self.tasks.insert(task);
        self.make_ready(self.main);
        self.trace_task_begin(self.main);
    }
}
