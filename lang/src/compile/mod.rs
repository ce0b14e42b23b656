//! From syntax to register code: expansion, resolution and emission, one top-level form after the
//! other. Errors are collected; code is always produced and runs only if there are none.

mod definitions;
mod emit;
mod foreign;
mod forms;
mod goal;
pub(crate) mod ir;
mod lambda_list;
mod plan_forms;
mod resolve;
mod special;
mod test_form;

use crate::code::{Atom, Code, CodeKind, Constant, Global, GlobalKind, Parameters, Program};
use crate::diagnostic::Diagnostic;
use crate::kind::Kind;
use crate::source::{SourceId, Span};
use crate::symbol::{Symbol, Symbols};
use crate::syntax::{self, NodeId, Tree};
pub use foreign::foreign_words;
pub use ir::Resolved;
use ir::{BlockId, Defined, Definition, Function, Ir, IrKind, VarId, Variable};
use special::Special;
pub use special::{SpecialForm, special_forms};
use std::collections::BTreeMap;
use std::sync::Arc;
use test_form::TestForm;
pub use test_form::{Test, TestOptions};

/// What the compiler knows of a native function.
#[derive(Clone, Debug, PartialEq)]
pub struct NativeSignature {
    /// Its name.
    pub name: String,
    /// Fewest arguments.
    pub min: u8,
    /// Most arguments; none for any number.
    pub max: Option<u8>,
    /// Whether it waits, assigns or acts on tasks, which a network may not.
    pub effect: bool,
    /// Whether it may block its task.
    pub waits: bool,
    /// The kinds of its parameters, optional ones included, but for the last of any number.
    pub kinds: Vec<Kind>,
    /// The kind of the arguments behind these.
    pub rest: Option<Kind>,
    /// Whether it goes on in code of the plan, so that its value is found where a call's is.
    pub calls: bool,
}

/// Runs macros: the evaluator lives above this crate.
pub trait MacroHost {
    /// The expansion of `form`, a call of the macro with this code.
    ///
    /// # Errors
    /// What went wrong in the macro's own code, at its place.
    fn expand(
        &mut self,
        program: &Program,
        symbols: &mut Symbols,
        tree: &mut Tree,
        code: u32,
        form: NodeId,
    ) -> Result<NodeId, Box<Diagnostic>>;
}

/// Finds the text of a `(load "file")`.
pub trait Loader {
    /// The name to print and the text.
    ///
    /// # Errors
    /// One sentence saying why it cannot be read.
    fn load(&mut self, from: &str, path: &str) -> Result<(String, String), String>;
}

/// A [`Loader`] for texts that may not load files.
pub struct NoFiles;

impl Loader for NoFiles {
    fn load(&mut self, _from: &str, _path: &str) -> Result<(String, String), String> {
        Err("this text has no folder to load files from".into())
    }
}

/// What a text is compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// The library: its names can be defined again by a file.
    Library,
    /// A user's file or form.
    User,
}

/// The surroundings of a compilation.
pub struct Compilation<'a> {
    /// Where code is added.
    pub program: &'a mut Program,
    /// The names.
    pub symbols: &'a mut Symbols,
    /// The native functions, by number.
    pub natives: &'a [NativeSignature],
    /// Runs macros.
    pub macros: &'a mut dyn MacroHost,
    /// Finds loaded files.
    pub loader: &'a mut dyn Loader,
    /// Names that exist only with a robot, so that an error can say so.
    pub robot_names: &'a [String],
    /// Names that only a scenario has, so that an error can say so.
    pub scenario_names: &'a [String],
}

/// The result of a compilation: the code of its forms, and the findings.
#[derive(Clone, Debug)]
pub struct Compiled {
    /// Code without parameters that runs the forms in order; its value is the last form's.
    pub main: u32,
    /// The tests of the text, in order; those of loaded files are not among them.
    pub tests: Vec<Test>,
    /// Errors and warnings.
    pub diagnostics: Vec<Diagnostic>,
    /// What the text was resolved to.
    pub resolved: Resolved,
    /// The codes that were added to the program.
    pub codes: Vec<u32>,
    /// The constants that were added.
    pub constants: Vec<u32>,
}

impl Compiled {
    /// Whether the text defines something that stays.
    pub fn defines(&self) -> bool {
        !self.resolved.definitions.is_empty()
    }
}

/// Reads and compiles a text.
pub fn compile_text(surroundings: Compilation<'_>, source: SourceId, purpose: Purpose) -> Compiled {
    let mut tree = Tree::default();
    let text = surroundings.program.sources.get(source).text.clone();
    let (forms, diagnostics) = crate::reader::read(&text, source, surroundings.symbols, &mut tree);
    let mut compiler = Compiler::new(surroundings, tree, purpose);
    compiler.diagnostics = diagnostics;
    compiler.run(&forms, Span { source, start: 0, end: text.len() as u32 })
}

/// Compiles a datum that is already syntax, such as a plan made at run time.
pub fn compile_datum(surroundings: Compilation<'_>, tree: Tree, root: NodeId) -> Compiled {
    let span = tree.span(root);
    Compiler::new(surroundings, tree, Purpose::User).run(&[root], span)
}

pub(crate) struct FunctionScope {
    kind: CodeKind,
    captures: Vec<VarId>,
    /// Whether expressions stand in fluent position.
    network: bool,
    /// Tags of a plan; only a function that is the root of a definition or top-level form has any.
    tags: Option<Vec<(Symbol, VarId)>>,
    /// `count-pulses` inside a network counts from the network's creation.
    hoisted: Vec<(VarId, Ir)>,
}

pub(crate) struct BlockScope {
    name: Option<Symbol>,
    id: BlockId,
    function: usize,
    span: Span,
    token: Option<VarId>,
    used: bool,
    /// Clean-ups around it.
    clean_ups: u32,
}

pub(crate) struct HandlerScope {
    retry: BlockId,
    failure: VarId,
}

/// A name that means nothing yet.
pub(crate) struct Unknown {
    span: Span,
    /// What is bound around it.
    locals: Vec<Symbol>,
}

/// A top-level form with something to run.
pub(crate) enum TopLevel {
    /// The value of a definition.
    Definition(Function),
    /// A form of the main task.
    Form(Function),
    /// A test and its body.
    Test(TestForm, Function),
}

pub(crate) struct Compiler<'a> {
    program: &'a mut Program,
    symbols: &'a mut Symbols,
    natives: &'a [NativeSignature],
    native_numbers: BTreeMap<Symbol, u16>,
    specials: BTreeMap<Symbol, Special>,
    macros: &'a mut dyn MacroHost,
    loader: &'a mut dyn Loader,
    robot_names: &'a [String],
    scenario_names: &'a [String],
    purpose: Purpose,
    tree: Tree,
    diagnostics: Vec<Diagnostic>,
    variables: Vec<Variable>,
    definitions: Vec<Definition>,
    forms: Vec<Function>,
    test_bodies: Vec<Function>,
    bindings: Vec<(Symbol, VarId)>,
    functions: Vec<FunctionScope>,
    blocks: Vec<BlockScope>,
    handlers: Vec<HandlerScope>,
    /// Clean-ups around the form that is resolved.
    clean_ups: u32,
    next_block: u32,
    /// Globals that were used before a definition was seen, with the first place.
    undefined: BTreeMap<u32, Unknown>,
    /// Classes of failure that are handled or raised, checked when all definitions are known; and
    /// whether a variable of that name is bound there.
    classes: Vec<(Symbol, Span, bool)>,
    /// Calls of globals, checked when all definitions are known.
    calls: Vec<(u32, usize, Span)>,
    /// Codes and constants added so far.
    codes: Vec<u32>,
    constants: Vec<u32>,
    expansions: u32,
    /// Forms around the one that is resolved.
    depth: u32,
    loading: Vec<String>,
    /// Names of the tests so far, with their places.
    tests: BTreeMap<Arc<str>, Span>,
    /// Methods of goals, by the plan that tries them.
    methods: BTreeMap<Symbol, goal::Methods>,
}

/// Macros that expand into macros without end are cut here.
const MAX_EXPANSIONS_IN_A_ROW: u32 = 1_000;

/// Forms nest at most so deep: each level takes about 1 KB of stack while it is compiled.
const MAX_FORMS_DEEP: u32 = 10_000;

impl<'a> Compiler<'a> {
    fn new(surroundings: Compilation<'a>, tree: Tree, purpose: Purpose) -> Self {
        let Compilation { program, symbols, natives, macros, loader, robot_names, scenario_names } = surroundings;
        let native_numbers =
            natives.iter().enumerate().map(|(number, native)| (symbols.intern(&native.name), number as u16)).collect();
        let specials = special::names().map(|(name, special)| (symbols.intern(name), special)).collect();
        Self {
            program,
            symbols,
            natives,
            native_numbers,
            specials,
            macros,
            loader,
            robot_names,
            scenario_names,
            purpose,
            tree,
            diagnostics: Vec::new(),
            variables: Vec::new(),
            definitions: Vec::new(),
            forms: Vec::new(),
            test_bodies: Vec::new(),
            bindings: Vec::new(),
            functions: Vec::new(),
            blocks: Vec::new(),
            handlers: Vec::new(),
            clean_ups: 0,
            next_block: 0,
            undefined: BTreeMap::new(),
            classes: Vec::new(),
            calls: Vec::new(),
            codes: Vec::new(),
            constants: Vec::new(),
            expansions: 0,
            depth: 0,
            loading: Vec::new(),
            tests: BTreeMap::new(),
            methods: BTreeMap::new(),
        }
    }

    fn run(mut self, forms: &[NodeId], span: Span) -> Compiled {
        let name = self.symbols.intern("main");
        self.predeclare(forms);
        let mut bodies = Vec::new();
        let mut defined = None;
        for &form in forms {
            let before = (bodies.len(), self.definitions.len());
            self.top_level(form, &mut bodies);
            defined = self.only_defined(form, before, &bodies);
        }
        let (main, tests) = self.emit_main(name, bodies, defined, span);
        self.check_undefined();
        self.check_classes();
        self.check_calls();
        if self.purpose == Purpose::Library {
            self.program.library_globals = self.program.globals.len() as u32;
        }
        let resolved = Resolved {
            definitions: self.definitions,
            forms: self.forms,
            tests: self.test_bodies,
            variables: self.variables,
        };
        let (codes, constants) = (self.codes, self.constants);
        Compiled { main, tests, diagnostics: self.diagnostics, resolved, codes, constants }
    }

    /// The name a top-level form defines if there is nothing to run in it: that is its value.
    /// `before` counts the bodies and definitions before it.
    fn only_defined(&self, form: NodeId, before: (usize, usize), bodies: &[TopLevel]) -> Option<Symbol> {
        let (bodies, definitions) = (&bodies[before.0..], &self.definitions[before.1..]);
        let is_test = |body: &TopLevel| matches!(body, TopLevel::Test(..));
        if !bodies.iter().all(is_test) || bodies.is_empty() && definitions.is_empty() {
            return None;
        }
        let named = self.tree.items(form).get(1).and_then(|&name| self.tree.symbol(name));
        named.or_else(|| definitions.last().map(|definition| definition.name))
    }

    /// One code that runs each form's code in turn: a form is a plan body of its own. Its value is
    /// that of the last, or what the last one `defined`. One more for each test, which runs the
    /// definitions and then the test.
    fn emit_main(
        &mut self,
        name: Symbol,
        bodies: Vec<TopLevel>,
        defined: Option<Symbol>,
        span: Span,
    ) -> (u32, Vec<Test>) {
        let (mut calls, mut definitions, mut forms) = (Vec::new(), Vec::new(), Vec::new());
        for body in bodies {
            match body {
                TopLevel::Definition(body) => {
                    let call = self.emit_call(&body);
                    definitions.push(call);
                    calls.push(call);
                    self.forms.push(body);
                }
                TopLevel::Form(body) => {
                    calls.push(self.emit_call(&body));
                    self.forms.push(body);
                }
                TopLevel::Test(form, body) => {
                    forms.push((form, self.emit_call(&body)));
                    self.test_bodies.push(body);
                }
            }
        }
        let defined = defined.map(|name| self.constant(Atom::Symbol(name)));
        let main = self.add_code(emit::sequence(name, span, &calls, defined));
        let tests = forms
            .into_iter()
            .map(|(form, call)| {
                let calls = [definitions.as_slice(), &[call]].concat();
                form.with_code(self.add_code(emit::sequence(name, span, &calls, None)))
            })
            .collect();
        (main, tests)
    }

    fn emit_call(&mut self, body: &Function) -> (u32, Span) {
        (emit::emit(self, body, &[]), body.span)
    }

    fn note_definition(&mut self, name: Symbol, span: Span, defined: Defined) {
        self.definitions.push(Definition { name, span, defined });
    }

    fn add_code(&mut self, code: Code) -> u32 {
        let code = self.program.add_code(code);
        self.codes.push(code);
        code
    }

    fn constant(&mut self, constant: impl Into<Constant>) -> u32 {
        let constant = self.program.add_constant(constant.into());
        self.constants.push(constant);
        constant
    }

    fn error(
        &mut self,
        code: &'static str,
        span: Span,
        message: impl Into<String>,
        label: impl Into<String>,
    ) -> &mut Diagnostic {
        let at = self.diagnostics.len();
        self.diagnostics.push(Diagnostic::error(code, span, message, label));
        &mut self.diagnostics[at]
    }

    fn check_undefined(&mut self) {
        for (global, Unknown { span, locals }) in std::mem::take(&mut self.undefined) {
            let name = self.program.globals[global as usize].name;
            self.program.names.remove(&name);
            let text = self.symbols.name(name).to_string();
            let span = crate::lexer::find_name(&self.program.sources, span, &text).unwrap_or(span);
            if self.program.macros.contains_key(&name) {
                self.error(
                    "macro-before-definition",
                    span,
                    format!("the macro `{text}` is used above its definition"),
                    "not known yet here",
                )
                .help = Some("move the defmacro above its first use".into());
            } else if let Some(accessor) = text.strip_prefix("%set-") {
                self.not_a_place(span, format!("`({accessor} …)` is not a place that can be assigned"));
            } else if self.robot_names.contains(&text) {
                self.error(
                    "needs-a-world",
                    span,
                    format!("`{text}` belongs to the robot, and there is none"),
                    "needs a world",
                )
                .help = Some("add `--world dept` to the command".into());
            } else if self.scenario_names.contains(&text) {
                self.error(
                    "needs-a-scenario",
                    span,
                    format!("`{text}` belongs to scenarios, and this text is read as a plan"),
                    "only a scenario has it",
                )
                .help = Some(
                    "`rpl check --scenario FILE` checks a scenario, `rpl run PLAN --world W --scenario FILE` runs it beside a plan"
                        .into(),
                );
            } else {
                let goal = text
                    .strip_prefix(goal::PREFIX)
                    .map(|goal| format!("if it is a goal, say how to achieve it: `(def-goal (achieve ({goal} …)) …)`"));
                let foreign = foreign::advice(&text).map(str::to_string);
                let unit = self.unit_apart(span, &text);
                let is_argument = self.is_argument(span);
                let quoted = is_argument.then(|| format!("if the name itself is meant, quote it: `'{text}`"));
                let suggestion = self.suggestion(&text, &locals, is_argument);
                let suggestion = suggestion.map(|near| format!("did you mean `{near}`?"));
                let help = foreign.or(unit).or(suggestion).or(goal).or(quoted);
                self.error("unbound-name", span, format!("`{text}` is not defined anywhere"), "unknown name").help =
                    help;
            }
        }
    }

    /// Notes that a class of failure is handled or raised.
    fn note_class(&mut self, name: Symbol, span: Span) {
        if !self.program.failure_classes.contains_key(&name) {
            let is_variable = self.bindings.iter().any(|&(bound, _)| bound == name);
            self.classes.push((name, span, is_variable));
        }
    }

    fn check_classes(&mut self) {
        for (name, span, is_variable) in std::mem::take(&mut self.classes) {
            if !self.program.failure_classes.contains_key(&name) {
                self.unknown_class(name, span, is_variable);
            }
        }
    }

    fn unknown_class(&mut self, name: Symbol, span: Span, is_variable: bool) {
        let text = self.symbols.name(name).to_string();
        let span = crate::lexer::find_name(&self.program.sources, span, &text).unwrap_or(span);
        let known = self.program.failure_classes.keys().map(|&class| self.symbols.name(class));
        let near = crate::suggest::suggest(&text, known).map(str::to_string);
        let help = match near {
            _ if is_variable => format!(
                "`{text}` is a variable here, and `fail` takes the bare name of a class; to pass a failure on, write `(refail)`"
            ),
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("define it: `(def-failure {text} (failure) ())`"),
        };
        self.error("unknown-failure-class", span, format!("there is no failure class `{text}`"), "unknown class")
            .help = Some(help);
    }

    /// Advice on a unit that stands apart from its number.
    fn unit_apart(&self, span: Span, text: &str) -> Option<String> {
        if !crate::number::unit_names().any(|unit| unit == text) {
            return None;
        }
        let before = self.program.sources.get(span.source).text.get(..span.start as usize)?.trim_end();
        let number = before.rsplit(|c: char| c.is_whitespace() || c == '(').next()?;
        let is_number = crate::number::begins_like_number(number) && number.ends_with(|c: char| c.is_ascii_digit());
        is_number.then(|| one_word(number, text))
    }

    /// Whether a name stands where its value is asked for, not at the head of a form.
    fn is_argument(&self, span: Span) -> bool {
        let before = self.program.sources.get(span.source).text.get(..span.start as usize);
        before.is_some_and(|before| !before.ends_with(['(', '\'']))
    }

    /// Tells, and gives true, if a time has one of these units, and it stands apart from its number.
    fn refuse_unit_apart(&mut self, forms: &[NodeId], units: &[&str]) -> bool {
        let [number, unit, ..] = *forms else { return false };
        let is_number = matches!(self.tree.get(number).kind, syntax::Kind::Int(_) | syntax::Kind::Float(_));
        let Some(name) = self.tree.symbol(unit).filter(|_| is_number) else { return false };
        let text = self.symbols.name(name).to_string();
        if !units.contains(&text.as_str()) || self.lexical(name).is_some() {
            return false;
        }
        let span = self.tree.span(number).to(self.tree.span(unit));
        let written = self.program.sources.text_of(self.tree.span(number)).to_string();
        self.error("unit-apart", span, "a number, and a unit apart from it", "two words").help =
            Some(one_word(&written, &text));
        true
    }

    /// The nearest name a user could have meant; with a value, if one is needed.
    fn suggestion(&self, text: &str, locals: &[Symbol], has_value: bool) -> Option<String> {
        // Of equally near names the text's own come first.
        let (library, own): (Vec<_>, Vec<_>) =
            self.program.names.iter().partition(|&(_, &global)| self.is_library(global));
        let globals = own.into_iter().chain(library).map(|(&name, _)| self.symbols.name(name));
        let natives = self.natives.iter().map(|native| native.name.as_str());
        let specials = special::names().map(|(name, _)| name);
        let macros = self.program.macros.keys().map(|&name| self.symbols.name(name));
        let locals = locals.iter().map(|&name| self.symbols.name(name));
        let forms = specials.chain(macros).filter(|_| !has_value);
        let known = locals.chain(globals).chain(natives).chain(forms);
        crate::suggest::suggest(text, known.filter(|name| !name.starts_with(['%', '#']) && *name != text))
            .map(str::to_string)
    }

    fn check_calls(&mut self) {
        for (global, count, span) in std::mem::take(&mut self.calls) {
            let GlobalKind::Function(code) = self.program.globals[global as usize].kind else { continue };
            let Some(code) = self.program.codes.get(code as usize) else { continue };
            if !code.parameters.accepts(count) {
                let name = self.symbols.name(self.program.globals[global as usize].name).to_string();
                let expected = code.parameters.describe();
                let definition = code.span;
                // What is written is the place, and the value to assign is no argument of it.
                let error = match name.strip_prefix("%set-") {
                    Some(accessor) => self.arity_error(accessor, count - 1, "1 argument", span),
                    None => self.arity_error(&name, count, &expected, span),
                };
                error.related.push((definition, "defined here".into()));
            }
        }
    }

    fn arity_error(&mut self, name: &str, count: usize, expected: &str, span: Span) -> &mut Diagnostic {
        let given = if count == 1 { "1 is given".to_string() } else { format!("{count} are given") };
        self.error("arity", span, format!("`{name}` takes {expected}, and {given}"), format!("takes {expected}"))
    }

    fn new_variable(&mut self, name: Symbol, span: Span) -> VarId {
        let function = self.functions.len() - 1;
        self.variables.push(Variable { name, span, function, captured: false, assigned: false });
        VarId(self.variables.len() as u32 - 1)
    }

    fn bind(&mut self, name: Symbol, span: Span) -> VarId {
        let variable = self.new_variable(name, span);
        self.bindings.push((name, variable));
        variable
    }

    /// Enters a function, resolves its body with `inside`, and gives what it captures.
    fn in_function<T>(
        &mut self,
        kind: CodeKind,
        tags: bool,
        inside: impl FnOnce(&mut Self) -> T,
    ) -> (T, FunctionScope) {
        let bound = self.bindings.len();
        self.functions.push(FunctionScope {
            kind,
            captures: Vec::new(),
            network: kind == CodeKind::Network,
            tags: tags.then(Vec::new),
            hoisted: Vec::new(),
        });
        let result = inside(self);
        self.bindings.truncate(bound);
        let scope = self.functions.pop().unwrap_or_else(|| unreachable!("a function scope was pushed above"));
        (result, scope)
    }

    fn define_global(&mut self, name: Symbol, kind: GlobalKind, doc: Option<Arc<str>>, span: Option<Span>) -> u32 {
        if let Some(&existing) = self.program.names.get(&name)
            && (self.undefined.remove(&existing).is_some()
                || self.purpose == Purpose::Library
                || !self.is_library(existing))
        {
            self.program.globals[existing as usize] = Global { name, kind, doc, span };
            return existing;
        }
        self.program.globals.push(Global { name, kind, doc, span });
        let global = self.program.globals.len() as u32 - 1;
        self.program.names.insert(name, global);
        global
    }

    fn is_library(&self, global: u32) -> bool {
        global < self.program.library_globals
    }

    /// The items of a proper list; `nil`, which is how macros write an empty one, has none.
    fn list_items(&self, node: NodeId) -> Option<Vec<NodeId>> {
        match self.tree.symbol(node) {
            Some(name) if self.symbols.name(name) == "nil" => Some(Vec::new()),
            _ => self.tree.proper_list(node).map(<[NodeId]>::to_vec),
        }
    }

    fn nil(&self, span: Span) -> Ir {
        Ir { span, kind: IrKind::Nil }
    }
}

fn one_word(number: &str, unit: &str) -> String {
    format!("a number and its unit are one word: write `{number}{unit}`")
}

/// A function without parameters around a body.
pub(crate) fn thunk(name: Symbol, kind: CodeKind, body: Ir, scope: FunctionScope, span: Span) -> Function {
    Function {
        name,
        kind,
        parameters: Parameters::default(),
        bindings: Vec::new(),
        captures: scope.captures,
        tags: scope.tags.unwrap_or_default(),
        body: Box::new(body),
        doc: None,
        span,
    }
}
