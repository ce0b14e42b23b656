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

/// Why a datum has no code.
enum Uncompiled {
    /// It is no plan.
    Wrong(Raise),
    /// There is no room for what becomes of it, or there was none for its macros; if nothing can be given
    /// back, this is the failure.
    NoRoom(Raise),
}

fn wrong(message: String) -> Uncompiled {
    Uncompiled::Wrong(Raise::new("error", message))
}

/// A datum to compile.
struct Datum {
    tree: Tree,
    root: NodeId,
    objects: Vec<Value>,
    /// Parts that its macros may make.
    most: usize,
}

impl<O: Outside> System<O> {
    /// Compiles a datum for the running task, which asked for it, and lets the task go on in it or with it.
    pub(crate) fn execute_datum(&mut self, datum: Value, answered: fn(u32) -> Answered) -> Ran {
        let (outcome, steps) = self.compile_datum(datum);
        self.with_machine(|machine, around| machine.enter(around, outcome.map(answered), steps))
    }

    /// The code of a datum, or what is wrong with it; and how many steps that takes.
    pub(crate) fn compile_datum(&mut self, datum: Value) -> (Result<u32, Raise>, usize) {
        if self.units.are_due(self.machine.unit_bytes) {
            self.sweep_units();
        }
        let (mut steps, mut has_collected) = (STEPS_A_UNIT, false);
        loop {
            match self.unit_of(datum, &mut steps) {
                Ok(code) => return (Ok(code), steps),
                Err(Uncompiled::Wrong(raise)) => return (Err(raise), steps),
                Err(Uncompiled::NoRoom(raise)) if has_collected => return (Err(raise), steps),
                Err(Uncompiled::NoRoom(_)) => {
                    self.sweep_units();
                    has_collected = true;
                }
            }
        }
    }

    /// The code of a datum, if there is room for what becomes of it.
    fn unit_of(&mut self, datum: Value, steps: &mut usize) -> Result<u32, Uncompiled> {
        // A text that is given back leaves its name to the next one.
        let source = self.program.sources.next();
        let most = (self.machine.room() / BYTES_A_NODE).min(MAX_NODES);
        let (mut tree, root, objects) = self.tree_of(datum, source, most)?;
        let nodes = tree.nodes.len();
        let key = datum_key(&tree, root).filter(|key| key.len() <= MAX_SHARED_KEY);
        if let Some(code) = key.as_ref().and_then(|key| self.units.find(key)) {
            *steps = nodes;
            return Ok(code);
        }
        *steps += nodes * STEPS_A_NODE;
        let text = pretty::pretty(&mut tree, &self.machine.symbols, root, PLAN_WIDTH, source);
        self.compile_unit(Datum { tree, root, objects, most: most - nodes }, &text, key, steps)
    }

    /// A datum as a tree of at most `most` parts, with the objects in it.
    fn tree_of(
        &mut self,
        datum: Value,
        source: SourceId,
        most: usize,
    ) -> Result<(Tree, NodeId, Vec<Value>), Uncompiled> {
        let span = Span { source, start: 0, end: 0 };
        let (mut tree, mut objects) = (Tree::default(), Vec::new());
        let Machine { heap, symbols, .. } = &mut self.machine;
        match datum::to_node(heap, symbols, &mut tree, datum, span, None, &mut objects, most) {
            Ok(root) => Ok((tree, root, objects)),
            Err(Unfit::Circle) => Err(wrong("the datum is a circular list and cannot be a plan".to_string())),
            Err(Unfit::TooLarge) if most == MAX_NODES => Err(wrong(format!(
                "the datum has more than {MAX_NODES} parts and cannot be a plan; long texts count for several"
            ))),
            Err(Unfit::TooLarge) => Err(Uncompiled::NoRoom(self.machine.out_of_memory())),
        }
    }

    /// Adds the code of a datum to the program.
    fn compile_unit(
        &mut self,
        datum: Datum,
        text: &str,
        key: Option<Vec<u8>>,
        steps: &mut usize,
    ) -> Result<u32, Uncompiled> {
        let Datum { tree, root, objects, most } = datum;
        let is_whole = most + tree.nodes.len() == MAX_NODES;
        let program = Arc::make_mut(&mut self.program);
        let machine = &mut self.machine;
        let globals = program.globals.len();
        let name = format!("plan#{}", program.sources.made());
        let source = program.sources.add(&name, text);
        let mut macros = self.macros.0.take().unwrap_or_else(|| Box::new(self.library.macros(program)));
        macros.begin(program, machine.limits.bytes);
        let compiled = self.library.compile_datum(program, &mut machine.symbols, &mut macros, tree, root, most);
        *steps = steps.saturating_add(compiled.expanded * STEPS_A_NODE).saturating_add(macros.steps() as usize);
        let has_run_out = macros.has_run_out();
        // Macros may come to use what it defines, in places that were used before.
        self.macros.0 = (!compiled.defines() && macros.is_small()).then_some(macros);
        machine.renew_constants(program, &compiled.constants, &objects);
        if has_error(&compiled.diagnostics) {
            let drawn = render(&compiled.diagnostics, &program.sources, false);
            if !compiled.defines() {
                program.globals.truncate(globals);
                give_back(program, machine, &compiled.codes, &compiled.constants, source);
            }
            machine.bring_up_to(program, &objects);
            if compiled.lacks_room && !is_whole {
                return Err(Uncompiled::NoRoom(machine.out_of_memory()));
            }
            let raise = Raise::new("error", format!("the datum cannot be executed:\n{drawn}"));
            return Err(if has_run_out { Uncompiled::NoRoom(raise) } else { Uncompiled::Wrong(raise) });
        }
        machine.bring_up_to(program, &objects);
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
