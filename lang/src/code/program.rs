//! All code of a system, its names and its classes of failure.

use super::{Atom, Code, Constant};
use crate::source::{Sources, Span};
use crate::symbol::Symbol;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// What a global name stands for, as far as the text knows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum GlobalKind {
    /// A function or plan: its code.
    Function(u32),
    /// A variable.
    Variable,
    /// A constant: never assigned.
    Constant,
    /// A fluent.
    Fluent,
    /// A valve.
    Valve {
        /// How many tasks can have it at a time.
        places: u32,
    },
    /// A behaviour, by its number in the robot's table.
    Behaviour(u16),
}

/// A global name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Global {
    /// Its name.
    pub name: Symbol,
    /// What it stands for.
    pub kind: GlobalKind,
    /// Documentation string.
    pub doc: Option<Arc<str>>,
    /// Where it is defined; none for what the library or the robot brings.
    pub span: Option<Span>,
    /// The constant that is its value when a run begins, if it is a variable or a fluent of the library.
    pub initial: Option<u32>,
}

/// A class of failure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FailureClass {
    /// The class above it; none for `failure`.
    pub parent: Option<Symbol>,
    /// Its own slots.
    pub slots: Vec<Symbol>,
}

/// All code of a system. What was there at its start, and what is defined later, stays; code that runs
/// once can be given back.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Program {
    /// All bodies.
    pub codes: Vec<Arc<Code>>,
    /// All constants.
    pub constants: Vec<Constant>,
    /// All global names; a name defined again in a file has a second entry.
    pub globals: Vec<Global>,
    /// Which global a name means now.
    pub names: BTreeMap<Symbol, u32>,
    /// Macros: their code.
    pub macros: BTreeMap<Symbol, u32>,
    /// The tree of failure classes.
    pub failure_classes: BTreeMap<Symbol, FailureClass>,
    /// Plans that run first when a run goes on in another process (`def-resume`), in the order of definition.
    pub resumptions: Vec<Symbol>,
    /// The texts.
    pub sources: Sources,
    /// Places of codes that were given back, and are used again.
    pub free_codes: Vec<u32>,
    /// Places of constants that were given back.
    pub free_constants: Vec<u32>,
    /// How many globals belong to the library and the robot; those may be defined again.
    pub library_globals: u32,
    /// How many texts are the library's and the robot's; a failure in them is shown where the plan
    /// calls them.
    pub library_sources: u32,
}

impl Program {
    /// Adds a code and gives its number.
    pub fn add_code(&mut self, code: Code) -> u32 {
        let code = Arc::new(code);
        match self.free_codes.pop() {
            Some(place) => {
                self.codes[place as usize] = code;
                place
            }
            None => {
                self.codes.push(code);
                self.codes.len() as u32 - 1
            }
        }
    }

    /// Adds a constant and gives its number.
    pub fn add_constant(&mut self, constant: Constant) -> u32 {
        match self.free_constants.pop() {
            Some(place) => {
                self.constants[place as usize] = constant;
                place
            }
            None => {
                self.constants.push(constant);
                self.constants.len() as u32 - 1
            }
        }
    }

    /// Gives the place of a code back that nothing refers to.
    pub fn free_code(&mut self, code: u32) {
        let none = Code::none(&self.codes[code as usize]);
        self.codes[code as usize] = Arc::new(none);
        self.free_codes.push(code);
    }

    /// Gives the place of a constant back that nothing refers to.
    pub fn free_constant(&mut self, constant: u32) {
        self.constants[constant as usize] = Constant::Atom(Atom::Nil);
        self.free_constants.push(constant);
    }

    /// Whether `class` is `ancestor` or below it.
    pub fn is_failure_subclass(&self, class: Symbol, ancestor: Symbol) -> bool {
        let mut at = Some(class);
        while let Some(class) = at {
            if class == ancestor {
                return true;
            }
            at = self.failure_classes.get(&class).and_then(|known| known.parent);
        }
        false
    }

    /// The slots of a class, inherited ones first.
    pub fn failure_slots(&self, class: Symbol) -> Vec<Symbol> {
        let mut lines = Vec::new();
        let mut at = self.failure_classes.get(&class);
        while let Some(known) = at {
            lines.push(known.slots.as_slice());
            at = known.parent.and_then(|parent| self.failure_classes.get(&parent));
        }
        lines.into_iter().rev().flatten().copied().collect()
    }
}
