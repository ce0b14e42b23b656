//! The compiler's state, and what all of its parts do with it.

use super::compilation::{Compilation, Loader, MacroHost, Names, NamesElsewhere, NativeSignature, Purpose};
use super::expansion::Expansion;
use super::goals::{Goals, Methods, UndefinedGoal};
use super::ir::{BlockId, Callee, Function, Ir, IrKind, VarId, Variable};
use super::locals::{Locals, Surrounding};
use super::resolved::{Defined, Definition};
use crate::code::{Code, CodeKind, Constant, Global, GlobalKind, Parameters, Program};
use crate::diagnostic::{Diagnostic, NOT_OF_THE_FORM};
use crate::source::{Span, lies_in};
use crate::symbol::{Symbol, Symbols};
use crate::syntax::{NodeId, NodeKind, Tree, mark_of};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Where a special form has its row: its table, and its place there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FormPlace {
    pub(super) table: usize,
    pub(super) row: usize,
}

/// A compilation under way.
pub(crate) struct Compiler<'a> {
    pub(super) program: &'a mut Program,
    pub(super) library: Option<&'a Program>,
    pub(super) symbols: &'a mut Symbols,
    pub(super) natives: &'a [NativeSignature],
    pub(super) native_numbers: BTreeMap<Symbol, u16>,
    /// The names of special forms.
    pub(super) specials: BTreeMap<Symbol, FormPlace>,
    pub(super) macros: &'a mut dyn MacroHost,
    pub(super) loader: &'a mut dyn Loader,
    pub(super) robot_names: &'a Names,
    pub(super) names_elsewhere: &'a NamesElsewhere,
    pub(super) purpose: Purpose,
    pub(super) tree: Tree,
    /// Where the tree has nothing because it could not be read, in order of place.
    holes: Vec<Span>,
    pub(super) diagnostics: Vec<Diagnostic>,
    pub(super) variables: Vec<Variable>,
    pub(super) definitions: Vec<Definition>,
    pub(super) forms: Vec<Function>,
    pub(super) test_bodies: Vec<Function>,
    pub(super) locals: Locals,
    pub(super) functions: Vec<FunctionScope>,
    pub(super) blocks: Vec<BlockScope>,
    pub(super) handlers: Vec<HandlerScope>,
    /// Macros whose definition has an error: what follows from that is not told.
    pub(super) broken_macros: BTreeSet<Symbol>,
    /// Names in calls of macros at top level that could not be expanded: what such a call would have defined has a
    /// name made of them.
    pub(super) unexpanded: BTreeSet<Symbol>,
    /// Whether what is resolved is the body of a macro.
    pub(super) in_macro: bool,
    /// Names that a text of the library defines.
    pub(super) own_names: BTreeSet<Symbol>,
    /// Clean-ups around the form that is resolved.
    pub(super) clean_ups: u32,
    pub(super) next_block: u32,
    /// Globals that were used before a definition was seen, with the first place.
    pub(super) undefined: BTreeMap<u32, Unknown>,
    /// Classes of failure that are handled or raised, checked when all definitions are known; and
    /// whether a variable of that name is bound there.
    pub(super) classes: Vec<(Symbol, Span, bool)>,
    /// Classes that were told to be unknown.
    pub(super) unknown_classes: usize,
    /// Calls of globals, checked when all definitions are known.
    pub(super) calls: Vec<(u32, usize, Span)>,
    /// Codes and constants added so far.
    pub(super) codes: Vec<u32>,
    pub(super) constants: Vec<u32>,
    pub(super) expansion: Expansion,
    /// Forms around the one that is resolved.
    pub(super) depth: u32,
    /// Files around the form that is resolved, and all that were loaded.
    pub(super) loading: Vec<String>,
    pub(super) loaded: BTreeSet<String>,
    /// Names of the tests so far, with their places.
    pub(super) tests: BTreeMap<Arc<str>, Span>,
    /// Methods of goals, by the plan that tries them.
    pub(super) methods: BTreeMap<Symbol, Methods>,
    /// What can be achieved, by the names of the goals.
    pub(super) goals: BTreeMap<Symbol, Goals>,
    /// Goals of names that none had, where they are first to be achieved, by the plans that would do it.
    pub(super) undefined_goals: BTreeMap<Symbol, UndefinedGoal>,
}

pub(crate) struct FunctionScope {
    pub(super) kind: CodeKind,
    pub(super) captures: Vec<VarId>,
    /// Whether expressions stand in fluent position.
    pub(super) network: bool,
    /// Tags of a plan; only a function that is the root of a definition or top-level form has any.
    pub(super) tags: Option<BTreeMap<Symbol, VarId>>,
    /// `count-pulses` inside a network counts from the network's creation.
    pub(super) hoisted: Vec<(VarId, Ir)>,
}

impl FunctionScope {
    /// The tags in the order in which they were found.
    pub(super) fn tags_in_order(&self) -> Vec<(Symbol, VarId)> {
        let mut tags: Vec<_> = self.tags.iter().flatten().map(|(&name, &variable)| (name, variable)).collect();
        tags.sort_by_key(|&(_, variable)| variable);
        tags
    }
}

pub(crate) struct BlockScope {
    pub(super) name: Option<Symbol>,
    pub(super) id: BlockId,
    pub(super) function: usize,
    pub(super) span: Span,
    pub(super) token: Option<VarId>,
    pub(super) used: bool,
    /// Clean-ups around it.
    pub(super) clean_ups: u32,
}

pub(crate) struct HandlerScope {
    pub(super) retry: BlockId,
    pub(super) failure: VarId,
}

/// A name that means nothing yet.
pub(crate) struct Unknown {
    pub(super) span: Span,
    /// What is bound around it.
    pub(super) around: Surrounding,
    /// Whether another error says that it has no value.
    pub(super) is_told: bool,
}

impl<'a> Compiler<'a> {
    /// `specials` are the names of the special forms, each with the form's place.
    pub(super) fn new(
        surroundings: Compilation<'a>,
        specials: impl Iterator<Item = (&'static str, FormPlace)>,
        tree: Tree,
        expansion: Expansion,
        purpose: Purpose,
    ) -> Self {
        let Compilation { program, library, symbols, natives, macros, loader, robot_names, names_elsewhere } =
            surroundings;
        let native_numbers =
            natives.iter().enumerate().map(|(number, native)| (symbols.intern(&native.name), number as u16)).collect();
        let specials = specials.map(|(name, place)| (symbols.intern(name), place)).collect();
        Self {
            program,
            library,
            symbols,
            natives,
            native_numbers,
            specials,
            macros,
            loader,
            robot_names,
            names_elsewhere,
            purpose,
            holes: holes(&tree, 0),
            tree,
            diagnostics: Vec::new(),
            variables: Vec::new(),
            definitions: Vec::new(),
            forms: Vec::new(),
            test_bodies: Vec::new(),
            locals: Locals::default(),
            functions: Vec::new(),
            blocks: Vec::new(),
            handlers: Vec::new(),
            broken_macros: BTreeSet::new(),
            unexpanded: BTreeSet::new(),
            in_macro: false,
            own_names: BTreeSet::new(),
            clean_ups: 0,
            next_block: 0,
            undefined: BTreeMap::new(),
            classes: Vec::new(),
            unknown_classes: 0,
            calls: Vec::new(),
            codes: Vec::new(),
            constants: Vec::new(),
            expansion,
            depth: 0,
            loading: Vec::new(),
            loaded: BTreeSet::new(),
            tests: BTreeMap::new(),
            methods: BTreeMap::new(),
            goals: BTreeMap::new(),
            undefined_goals: BTreeMap::new(),
        }
    }

    pub(super) fn note_definition(&mut self, name: Symbol, span: Span, defined: Defined) {
        self.definitions.push(Definition { name, span, defined });
    }

    pub(super) fn add_code(&mut self, code: Code) -> u32 {
        let code = self.program.add_code(code);
        self.codes.push(code);
        code
    }

    pub(super) fn constant(&mut self, constant: impl Into<Constant>) -> u32 {
        let constant = self.program.add_constant(constant.into());
        self.constants.push(constant);
        constant
    }

    pub(super) fn error(
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

    /// Notes what could not be read of a text that is loaded; its nodes are those from a number on. Texts come in
    /// their order.
    pub(super) fn note_holes(&mut self, from: usize) {
        self.holes.extend(holes(&self.tree, from));
    }

    /// Whether something in a place cannot be read, which is told.
    pub(super) fn has_hole(&self, within: Span) -> bool {
        let first = self.holes.partition_point(|hole| (hole.source, hole.start) < (within.source, within.start));
        self.holes.get(first).is_some_and(|&hole| lies_in(hole, within))
    }

    pub(super) fn malformed(&mut self, span: Span, form: &str) -> Ir {
        if self.has_hole(span) {
            return self.nil(span);
        }
        let help = self.shape_advice(span, form);
        self.error("malformed", span, format!("{NOT_OF_THE_FORM}{form}"), format!("expected {form}")).help = help;
        self.nil(span)
    }

    pub(super) fn new_variable(&mut self, name: Symbol, span: Span) -> VarId {
        let function = self.functions.len() - 1;
        self.variables.push(Variable { name, span, function, captured: false, assigned: false });
        VarId(self.variables.len() as u32 - 1)
    }

    pub(super) fn bind(&mut self, name: Symbol, span: Span) -> VarId {
        let variable = self.new_variable(name, span);
        self.locals.bind(name, variable);
        variable
    }

    /// Enters a function, resolves its body with `inside`, and gives what it captures.
    pub(super) fn in_function<T>(
        &mut self,
        kind: CodeKind,
        tags: bool,
        inside: impl FnOnce(&mut Self) -> T,
    ) -> (T, FunctionScope) {
        let bound = self.locals.count();
        self.functions.push(FunctionScope {
            kind,
            captures: Vec::new(),
            network: kind == CodeKind::Network,
            tags: tags.then(BTreeMap::new),
            hoisted: Vec::new(),
        });
        let result = inside(self);
        self.locals.leave(bound);
        let scope = self.functions.pop().unwrap_or_else(|| unreachable!("a function scope was pushed above"));
        (result, scope)
    }

    pub(super) fn define_global(
        &mut self,
        name: Symbol,
        kind: GlobalKind,
        doc: Option<Arc<str>>,
        span: Option<Span>,
    ) -> u32 {
        self.program.macros.remove(&name);
        if let Some(&existing) = self.program.names.get(&name)
            && (self.undefined.remove(&existing).is_some()
                || self.purpose == Purpose::Library
                || !self.is_library(existing))
        {
            self.program.globals[existing as usize] = Global { name, kind, doc, span, initial: None };
            self.macros.defined(existing);
            return existing;
        }
        self.program.globals.push(Global { name, kind, doc, span, initial: None });
        let global = self.program.globals.len() as u32 - 1;
        self.program.names.insert(name, global);
        self.macros.defined(global);
        global
    }

    pub(super) fn is_library(&self, global: u32) -> bool {
        global < self.program.library_globals
    }

    /// The items of a proper list; `nil`, which is how macros write an empty one, has none.
    pub(super) fn list_items(&self, node: NodeId) -> Option<Vec<NodeId>> {
        match self.tree.symbol(node) {
            Some(name) if self.symbols.name(name) == "nil" => Some(Vec::new()),
            _ => self.tree.proper_list(node).map(<[NodeId]>::to_vec),
        }
    }

    pub(super) fn nil(&self, span: Span) -> Ir {
        Ir { span, kind: IrKind::Nil }
    }

    pub(super) fn is_network(&self) -> bool {
        self.functions.last().is_some_and(|function| function.network)
    }

    /// Whether a name can be bound or assigned: constants and keywords cannot.
    pub(super) fn is_bindable(&self, name: Symbol) -> bool {
        !matches!(self.symbols.name(name), "nil" | "t") && !self.symbols.name(name).starts_with('&')
    }

    /// Tells, and gives true, if a name may nowhere be bound: one that says where it is looked up, and those that
    /// marks such as `'` stand for.
    pub(super) fn refuses_to_bind(&mut self, node: NodeId) -> bool {
        let (message, help) = match self.tree.get(node).kind {
            NodeKind::Qualified { written, name, .. } => {
                let (written, name) = (self.symbols.name(written), self.symbols.name(name));
                let message = format!("`{written}` says where `{name}` is looked up, and cannot be bound or defined");
                (message, format!("write `{name}`"))
            }
            NodeKind::Symbol(name) => {
                let text = self.symbols.name(name);
                let Some(mark) = mark_of(text) else { return false };
                let message = format!("`{text}` is what `{mark}` stands for, and cannot be bound or defined");
                (message, "take another name".to_string())
            }
            _ => return false,
        };
        let span = self.tree.span(node);
        self.error("reserved-name", span, message, "reserved name").help = Some(help);
        true
    }

    /// A call of a native function by its name.
    pub(super) fn native_ir(&mut self, name: &str, arguments: Vec<Ir>, span: Span) -> Ir {
        match self.natives.iter().position(|native| native.name == name) {
            Some(number) => Ir { span, kind: IrKind::Call(Callee::Native(number as u16), arguments) },
            None => self.malformed(span, "a form the library supports"),
        }
    }
}

/// Where nothing could be read, in order of place.
fn holes(tree: &Tree, from: usize) -> Vec<Span> {
    let unread = tree.nodes[from..].iter().filter(|node| node.kind == NodeKind::Hole);
    let mut holes: Vec<Span> = unread.map(|node| node.span).collect();
    holes.sort();
    holes
}

/// A function without parameters around a body.
pub(crate) fn thunk(name: Symbol, kind: CodeKind, body: Ir, scope: FunctionScope, span: Span) -> Function {
    Function {
        name,
        kind,
        parameters: Parameters::default(),
        bindings: Vec::new(),
        tags: scope.tags_in_order(),
        captures: scope.captures,
        body: Box::new(body),
        doc: None,
        span,
    }
}
