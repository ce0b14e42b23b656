//! What every program starts from: natives, prelude and, with a robot, its names.

use crate::robot::{BehaviourSpec, RobotGlobals, RobotTables};
use crate::run::macro_host::MacroMachine;
use crate::state::failure::base_classes;
use crate::step::native::Native;
use rpl_lang::check::{BehaviourSignature, KnownPlaces, Subject};
use rpl_lang::code::{Global, GlobalKind, Program};
use rpl_lang::compile::{
    Compilation, Compiled, Loader, Names, NamesElsewhere, NativeSignature, NoFiles, Purpose, Resolved, Test, no_names,
};
use rpl_lang::diagnostic::render;
use rpl_lang::diagnostic::{Diagnostic, Severity};
use rpl_lang::source::SourceId;
use rpl_lang::symbol::Symbols;
use rpl_lang::syntax::NodeId;
use rpl_lang::syntax::Tree;
use rpl_lang::{check, compile};
use std::sync::{Arc, OnceLock};

/// A program that has been compiled and can be started.
#[derive(Clone)]
pub struct Loaded {
    /// All code.
    pub program: Arc<Program>,
    /// The names.
    pub symbols: Symbols,
    /// Code of the file's forms.
    pub main: u32,
    /// The file's tests: to run one, its code takes the place of `main`.
    pub tests: Vec<Test>,
    /// Warnings.
    pub warnings: Vec<Diagnostic>,
}

/// A text that cannot run: what was found, and the texts it was found in.
#[derive(Clone, Debug)]
pub struct Rejected {
    /// At least one error.
    pub diagnostics: Vec<Diagnostic>,
    /// The texts.
    pub program: Arc<Program>,
}

impl Rejected {
    /// The findings, drawn into their texts.
    pub fn render(&self, colour: bool) -> String {
        render(&self.diagnostics, &self.program.sources, colour)
    }
}

/// A text that was looked at without running it, faults and all.
#[derive(Clone, Debug)]
pub struct Examined {
    /// All that was found, in order of place.
    pub diagnostics: Vec<Diagnostic>,
    /// All code, the text's included.
    pub program: Arc<Program>,
    /// The names.
    pub symbols: Symbols,
    /// The number of the text among the sources.
    pub source: SourceId,
    /// What the text was resolved to.
    pub resolved: Resolved,
    /// Its tests.
    pub tests: Vec<Test>,
}

/// The library: natives and prelude, compiled once and shared.
#[derive(Clone)]
pub struct Library {
    /// The native functions, by number.
    pub natives: Arc<[Native]>,
    pub(crate) signatures: Arc<[NativeSignature]>,
    pub(super) program: Program,
    pub(super) symbols: Symbols,
    pub(super) robot_names: Arc<Names>,
    pub(super) names_elsewhere: Arc<NamesElsewhere>,
    /// Where the robot's names stand in the program.
    pub(crate) robot: Arc<RobotGlobals>,
    /// What a check needs to know beyond the program.
    pub(super) behaviours: Arc<[BehaviourSignature]>,
    /// What its texts were resolved to; made when a check asks for it, if the library was read back.
    pub(super) resolved: Arc<OnceLock<Vec<Resolved>>>,
}

impl Library {
    /// Compiles preludes over native functions, with what a robot offers.
    ///
    /// # Errors
    /// The findings in a prelude.
    pub fn new(natives: Vec<Native>, preludes: &[(&str, &str)], tables: &RobotTables) -> Result<Self, Rejected> {
        let mut symbols = Symbols::default();
        let mut program = Program { failure_classes: base_classes(&mut symbols), ..Program::default() };
        for (number, behaviour) in tables.behaviours.iter().enumerate() {
            define(&mut program, &mut symbols, &behaviour.name, GlobalKind::Behaviour(number as u16), &behaviour.doc);
        }
        let mut fluents = Vec::new();
        for fluent in &tables.fluents {
            fluents.push(define(&mut program, &mut symbols, &fluent.name, GlobalKind::Fluent, &fluent.doc));
        }
        for valve in &tables.valves {
            define(
                &mut program,
                &mut symbols,
                valve,
                GlobalKind::Valve { places: 1 },
                "A valve of the robot: whatever moves what it guards holds it.",
            );
        }
        let signatures = natives.iter().map(Native::signature).collect();
        let behaviours = tables.behaviours.iter().map(BehaviourSpec::signature).collect();
        let valve_of = |behaviour: &BehaviourSpec| {
            let valve = symbols.find(behaviour.valve.as_deref()?)?;
            program.names.get(&valve).copied()
        };
        let robot = RobotGlobals { fluents, valves: tables.behaviours.iter().map(valve_of).collect() };
        let mut library = Self {
            natives: natives.into(),
            signatures,
            program,
            symbols,
            robot_names: Arc::new(no_names()),
            names_elsewhere: Arc::default(),
            robot: Arc::new(robot),
            behaviours,
            resolved: Arc::default(),
        };
        let mut resolved = Vec::new();
        for &(name, text) in preludes {
            let source = library.program.sources.add(name, text);
            let (mut program, mut symbols) =
                (std::mem::take(&mut library.program), std::mem::take(&mut library.symbols));
            let compiled = library.compile(&mut program, &mut symbols, source, Purpose::Library, &mut NoFiles);
            library.program = program;
            library.symbols = symbols;
            resolved.push(compiled.resolved);
            if has_error(&compiled.diagnostics) {
                return Err(Rejected { diagnostics: compiled.diagnostics, program: Arc::new(library.program) });
            }
        }
        library.program.library_globals = library.program.globals.len() as u32;
        library.resolved = Arc::new(OnceLock::from(resolved));
        library.program.library_sources = library.program.sources.len() as u32;
        Ok(library)
    }

    /// A library that knows which names exist only with a robot, so that a plan without one gets a helpful error.
    #[must_use]
    pub fn knowing_robot_names(self, robot_names: Names) -> Self {
        Self { robot_names: Arc::new(robot_names), ..self }
    }

    /// A library that knows which names only another kind of text has, so that a text that is taken for one of
    /// another kind gets a helpful error.
    #[must_use]
    pub fn refusing_names(self, names_elsewhere: NamesElsewhere) -> Self {
        Self { names_elsewhere: Arc::new(names_elsewhere), ..self }
    }

    fn compile(
        &self,
        program: &mut Program,
        symbols: &mut Symbols,
        source: SourceId,
        purpose: Purpose,
        loader: &mut dyn Loader,
    ) -> Compiled {
        let mut macros = self.macros(program);
        let surroundings = Compilation {
            program,
            library: match purpose {
                Purpose::Library => None,
                Purpose::User => Some(&self.program),
            },
            symbols,
            natives: &self.signatures,
            macros: &mut macros,
            loader,
            robot_names: &self.robot_names,
            names_elsewhere: &self.names_elsewhere,
        };
        compile::compile_text(surroundings, source, purpose)
    }

    /// Compiles a file.
    ///
    /// # Errors
    /// All findings, if one of them is an error.
    pub fn load(&self, name: &str, text: &str, loader: &mut dyn Loader) -> Result<Loaded, Rejected> {
        let mut program = self.program.clone();
        let mut symbols = self.symbols.clone();
        let compiled = self.extend(&mut program, &mut symbols, name, text, loader);
        let program = Arc::new(program);
        if has_error(&compiled.diagnostics) {
            return Err(Rejected { diagnostics: compiled.diagnostics, program });
        }
        Ok(Loaded { program, symbols, main: compiled.main, tests: compiled.tests, warnings: compiled.diagnostics })
    }

    /// All that is found in a file without running it, in order of place, and the texts it was found
    /// in. With the places of a world those that are named are looked up.
    pub fn check(
        &self,
        name: &str,
        text: &str,
        places: Option<&KnownPlaces>,
        loader: &mut dyn Loader,
    ) -> (Vec<Diagnostic>, Arc<Program>) {
        let examined = self.examine(name, text, places, loader);
        (examined.diagnostics, examined.program)
    }

    /// The same with all that was made of the text.
    pub fn examine(&self, name: &str, text: &str, places: Option<&KnownPlaces>, loader: &mut dyn Loader) -> Examined {
        let mut program = self.program.clone();
        let mut symbols = self.symbols.clone();
        let source = program.sources.add(name, text);
        let compiled = self.compile(&mut program, &mut symbols, source, Purpose::User, loader);
        let mut diagnostics = compiled.diagnostics;
        let subject = Subject {
            program: &program,
            symbols: &symbols,
            natives: &self.signatures,
            behaviours: &self.behaviours,
            places,
            library: self.resolved(),
            text: &compiled.resolved,
        };
        diagnostics.extend(check::check(subject, &diagnostics));
        diagnostics.sort_by_key(|diagnostic| diagnostic.span);
        let Compiled { resolved, tests, .. } = compiled;
        Examined { diagnostics, program: Arc::new(program), symbols, source, resolved, tests }
    }

    /// What an empty text would be compiled into: the code of the library and its names.
    pub fn names(&self) -> (&Program, &Symbols) {
        (&self.program, &self.symbols)
    }

    /// Compiles a text into a program that was started from this library.
    pub(crate) fn extend(
        &self,
        program: &mut Program,
        symbols: &mut Symbols,
        name: &str,
        text: &str,
        loader: &mut dyn Loader,
    ) -> Compiled {
        let source = program.sources.add(name, text);
        self.compile(program, symbols, source, Purpose::User, loader)
    }

    /// A machine that expands the macros of a program.
    pub(crate) fn macros(&self, program: &Program) -> MacroMachine {
        MacroMachine::new(program, self.natives.clone(), self.signatures.clone())
    }

    /// Compiles a datum into a program that runs; its macros may make `most` parts.
    pub(crate) fn compile_datum(
        &self,
        program: &mut Program,
        symbols: &mut Symbols,
        macros: &mut MacroMachine,
        tree: Tree,
        root: NodeId,
        most: usize,
    ) -> Compiled {
        let surroundings = Compilation {
            program,
            library: Some(&self.program),
            symbols,
            natives: &self.signatures,
            macros,
            loader: &mut NoFiles,
            robot_names: &self.robot_names,
            names_elsewhere: &self.names_elsewhere,
        };
        compile::compile_datum(surroundings, tree, root, most)
    }
}

/// Adds a global of the robot; gives its number.
fn define(program: &mut Program, symbols: &mut Symbols, name: &str, kind: GlobalKind, doc: &str) -> u32 {
    let name = symbols.intern(name);
    program.globals.push(Global { name, kind, doc: Some(doc.into()), span: None, initial: None });
    let global = program.globals.len() as u32 - 1;
    program.names.insert(name, global);
    global
}

/// Whether one of the findings keeps the text from running.
pub fn has_error(diagnostics: &[Diagnostic]) -> bool {
    diagnostics.iter().any(|diagnostic| diagnostic.severity == Severity::Error)
}
