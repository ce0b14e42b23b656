//! Code made at run time: data compiled for `execute-plan`.

use crate::robot::Outside;
use crate::run::datum;
use crate::run::datum::{MAX_NODES, Unfit};
use crate::run::library::has_error;
use crate::run::macro_host::Macros;
use crate::run::system::System;
use crate::run::units::{datum_key, give_back};
use crate::state::failure::Raise;
use crate::state::machine::Machine;
use crate::state::projected::Answered;
use crate::state::value::Value;
use crate::step::exec::turn::Ran;
use rpl_lang::diagnostic::render;
use rpl_lang::pretty;
use rpl_lang::source::{SourceId, Span};
use rpl_lang::syntax::{NodeId, Tree};
use std::sync::Arc;

/// Steps that compiling a datum takes, and each of its parts.
const STEPS_A_UNIT: usize = 500;
const STEPS_A_NODE: usize = 20;

/// What a part of a datum takes at most while it is compiled.
const BYTES_A_NODE: usize = 512;

/// Width at which plans made at run time are printed for their errors.
const PLAN_WIDTH: usize = 100;

/// A datum whose key has more bytes than this is not kept for being used again.
const MAX_SHARED_KEY: usize = 1 << 16;

impl<O: Outside> System<O> {
    /// Compiles a datum for the running task, which asked for it, and lets the task go on in it or with it.
    pub(crate) fn execute_datum(&mut self, datum: Value, answered: fn(u32) -> Answered) -> Ran {
        let (outcome, steps) = self.compile_datum(datum);
        self.with_machine(|machine, around| machine.enter(around, outcome.map(answered), steps))
    }

    /// The code of a datum, or what is wrong with it; and how many steps that takes.
    pub(crate) fn compile_datum(&mut self, datum: Value) -> (Result<u32, Raise>, usize) {
        let (mut tree, root, objects, source) = match self.tree_of(datum) {
            Ok(made) => made,
            Err(raise) => return (Err(raise), STEPS_A_UNIT),
        };
        let nodes = tree.nodes.len();
        let key = datum_key(&tree, root).filter(|key| key.len() <= MAX_SHARED_KEY);
        if let Some(code) = key.as_ref().and_then(|key| self.units.find(key)) {
            return (Ok(code), nodes);
        }
        let text = pretty::pretty(&mut tree, &self.machine.symbols, root, PLAN_WIDTH, source);
        let unit = self.compile_unit(tree, root, &text, &objects, key);
        (unit, STEPS_A_UNIT + nodes * STEPS_A_NODE)
    }

    /// A datum as a tree, if there is room for what becomes of it; with the objects in it, and the name
    /// its text will have.
    fn tree_of(&mut self, datum: Value) -> Result<(Tree, NodeId, Vec<Value>, SourceId), Raise> {
        if self.units.are_due(self.machine.unit_bytes) {
            self.sweep_units();
        }
        let mut has_collected = false;
        loop {
            // A text that is given back leaves its name to the next one.
            let source = self.program.sources.next();
            let span = Span { source, start: 0, end: 0 };
            let machine = &mut self.machine;
            let most = (machine.room() / BYTES_A_NODE).min(MAX_NODES);
            let (mut tree, mut objects) = (Tree::default(), Vec::new());
            let Machine { heap, symbols, .. } = machine;
            match datum::to_node(heap, symbols, &mut tree, datum, span, None, &mut objects, most) {
                Ok(root) => return Ok((tree, root, objects, source)),
                Err(Unfit::Circle) => {
                    return Err(Raise::new("error", "the datum is a circular list and cannot be a plan"));
                }
                Err(Unfit::TooLarge) if most == MAX_NODES => {
                    let message = format!("the datum has more than {MAX_NODES} parts and cannot be a plan");
                    return Err(Raise::new("error", message));
                }
                Err(Unfit::TooLarge) if has_collected => return Err(machine.out_of_memory()),
                Err(Unfit::TooLarge) => {
                    self.sweep_units();
                    has_collected = true;
                }
            }
        }
    }

    /// Adds the code of a datum to the program.
    fn compile_unit(
        &mut self,
        tree: Tree,
        root: NodeId,
        text: &str,
        objects: &[Value],
        key: Option<Vec<u8>>,
    ) -> Result<u32, Raise> {
        let program = Arc::make_mut(&mut self.program);
        let machine = &mut self.machine;
        let globals = program.globals.len();
        let name = format!("plan#{}", program.sources.made());
        let source = program.sources.add(&name, text);
        let mut macros = self.macros.0.take().unwrap_or_else(|| Box::new(self.library.macros(program)));
        macros.begin();
        let compiled = self.library.compile_datum(program, &mut machine.symbols, &mut macros, tree, root);
        // Macros may come to use what it defines, in places that were used before.
        self.macros.0 = (!compiled.defines()).then_some(macros);
        machine.renew_constants(program, &compiled.constants, objects);
        if has_error(&compiled.diagnostics) {
            let drawn = render(&compiled.diagnostics, &program.sources, false);
            if !compiled.defines() {
                program.globals.truncate(globals);
                give_back(program, machine, &compiled.codes, &compiled.constants, source);
            }
            machine.bring_up_to(program, objects);
            return Err(Raise::new("error", format!("the datum cannot be executed:\n{drawn}")));
        }
        machine.bring_up_to(program, objects);
        let bytes = Arc::make_mut(&mut self.units).add(program, &compiled, source, key);
        machine.unit_bytes += bytes;
        machine.heap.allocated += bytes;
        Ok(compiled.main)
    }

    /// Gives back code that was made at run time and that nothing refers to.
    fn sweep_units(&mut self) {
        let marks = self.machine.collect_for(&self.program);
        let (program, units) = (Arc::make_mut(&mut self.program), Arc::make_mut(&mut self.units));
        units.sweep(program, &mut self.machine, &marks);
        self.macros = Macros::default();
        // What was given back is found out by a collection.
        self.machine.collect();
    }
}
