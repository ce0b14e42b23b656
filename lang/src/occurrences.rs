//! Every place of a text where a name stands that the text itself gives a meaning, with that meaning:
//! what an editor asks to follow a name, to list where it is used, and to change it everywhere.
//!
//! Works on resolved forms. What stands in the call of a macro has the place of the call there, so
//! names in it are found by what the expansion reads and binds; where that does not tell which of
//! several variables of one name is meant, the occurrence is not certain.

use crate::check::walk::each_function_form;
use crate::code::Program;
use crate::compile::Resolved;
use crate::compile::ir::{Callee, Function, IrKind, VarId};
use crate::compile::resolved::Defined;
use crate::lexer::BAR;
use crate::reader::read;
use crate::source::{SourceId, Span};
use crate::symbol::{Qualifier, Symbol, Symbols};
use crate::syntax::{NodeId, NodeKind, Tree};
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// What a name of a text stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Target {
    /// A lexical variable or a tag, by its number in the text.
    Local(u32),
    /// A global, by its number in the program.
    Global(u32),
    /// A macro.
    Macro(Symbol),
    /// A class of failure.
    Failure(Symbol),
}

/// A place where a name stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Occurrence {
    /// The name, and nothing else.
    pub span: Span,
    /// The same with `library:` or `global:` in front of it, if it has one.
    pub whole: Span,
    /// The name.
    pub name: Symbol,
    /// What it stands for.
    pub target: Target,
    /// Whether it is defined or bound here.
    pub is_binding: bool,
    /// Whether no other variable of this name can be meant.
    pub is_certain: bool,
}

/// What a compiled text says of a name within a form.
#[derive(Clone, Copy)]
struct Use {
    within: Span,
    target: Target,
    is_binding: bool,
}

/// A name as it is written, outside of quoted data.
#[derive(Clone, Copy)]
struct WrittenName {
    /// The name, and nothing else.
    span: Span,
    /// The name as it is written, with its qualifier.
    whole: Span,
    qualifier: Option<Qualifier>,
    /// The list that it is the head of.
    heads: Option<Span>,
}

/// The occurrences in one text of a program, in order of place. Cost: n log n in the length of the text, but for forms in
/// calls of macros that nest very deep.
pub fn occurrences(source: SourceId, program: &Program, symbols: &Symbols, resolved: &Resolved) -> Vec<Occurrence> {
    let uses = uses(source, program, symbols, resolved);
    let mut found = Vec::new();
    for (name, written) in written_names(source, program, symbols) {
        let uses = uses.get(&name).map_or(&[][..], Vec::as_slice);
        NameInText { name, program, written: &written, uses }.resolve(&mut found);
    }
    found.sort_by_key(|occurrence| occurrence.span);
    found
}

/// The names that are written in a text, each with its places in order.
fn written_names(source: SourceId, program: &Program, symbols: &Symbols) -> BTreeMap<Symbol, Vec<WrittenName>> {
    let (mut symbols, mut tree) = (symbols.clone(), Tree::default());
    let text = &program.sources.get(source).text;
    let (roots, _) = read(text, source, &mut symbols, &mut tree);
    let mut names: BTreeMap<Symbol, Vec<WrittenName>> = BTreeMap::new();
    // How many quasi-quotes are around it that are not undone.
    let mut left: Vec<(NodeId, u32, Option<Span>)> = roots.iter().map(|&root| (root, 0, None)).collect();
    while let Some((node, quotes, heads)) = left.pop() {
        let span = tree.span(node);
        if let Some((qualifier, name)) = tree.name(node).filter(|_| quotes == 0) {
            names.entry(name).or_default().push(WrittenName::new(text, span, qualifier, heads));
        }
        match tree.get(node).kind {
            NodeKind::Vector { .. } if quotes > 0 => {
                left.extend(tree.elements(node).iter().map(|&item| (item, quotes, None)));
            }
            NodeKind::List { .. } => {
                let items = tree.items(node);
                let inner = match tree.head(node).map(|head| symbols.name(head)) {
                    Some("quote") => continue,
                    Some("quasiquote") => quotes + 1,
                    Some("unquote" | "unquote-splicing") => quotes.saturating_sub(1),
                    _ => quotes,
                };
                left.extend(items.iter().enumerate().map(|(at, &item)| (item, inner, (at == 0).then_some(span))));
            }
            _ => {}
        }
    }
    names.values_mut().for_each(|places| places.sort_by_key(|written| written.span));
    names
}

impl WrittenName {
    fn new(text: &str, whole: Span, qualifier: Option<Qualifier>, heads: Option<Span>) -> Self {
        let span = qualifier.map_or(whole, |qualifier| {
            let bar = if text[whole.start as usize..].starts_with(BAR) { BAR.len_utf8() as u32 } else { 0 };
            Span { start: whole.start + bar + qualifier.prefix().len() as u32, end: whole.end - bar, ..whole }
        });
        Self { span, whole, qualifier, heads }
    }
}

/// What the resolved forms say of the names of a text.
fn uses(source: SourceId, program: &Program, symbols: &Symbols, resolved: &Resolved) -> BTreeMap<Symbol, Vec<Use>> {
    let mut uses: BTreeMap<Symbol, Vec<Use>> = BTreeMap::new();
    let mut add = |name: Symbol, within: Span, target: Target, is_binding: bool| {
        if within.source == source && !symbols.name(name).starts_with(['%', '#']) {
            uses.entry(name).or_default().push(Use { within, target, is_binding });
        }
    };
    for definition in &resolved.definitions {
        let target = match &definition.defined {
            Defined::Function(global, _) => Target::Global(*global),
            Defined::Macro(_) => Target::Macro(definition.name),
            Defined::Failure => Target::Failure(definition.name),
            Defined::Value => match program.names.get(&definition.name) {
                Some(&global) => Target::Global(global),
                None => continue,
            },
        };
        add(definition.name, definition.span, target, true);
    }
    for (number, variable) in resolved.variables.iter().enumerate() {
        add(variable.name, variable.span, Target::Local(number as u32), true);
    }
    let variable = |id: VarId| (resolved.variables[id.0 as usize].name, Target::Local(id.0));
    let global = |number: u32| (program.globals[number as usize].name, Target::Global(number));
    for root in roots(resolved) {
        each_function_form(root, &mut |_, ir| {
            let (name, target) = match &ir.kind {
                IrKind::Local(id) | IrKind::SetLocal(id, _) => variable(*id),
                IrKind::Global(number)
                | IrKind::SetGlobal(number, _)
                | IrKind::DefFluent(number, _)
                | IrKind::Call(Callee::Global(number), _) => global(*number),
                IrKind::Handler { clauses, .. } => {
                    for clause in clauses {
                        clause.classes.iter().for_each(|&class| add(class, clause.span, Target::Failure(class), false));
                    }
                    return;
                }
                _ => return,
            };
            add(name, ir.span, target, false);
        });
    }
    uses
}

/// Every function of a text that stands at the top.
fn roots(resolved: &Resolved) -> impl Iterator<Item = &Function> {
    let definitions = resolved.definitions.iter().filter_map(|definition| match &definition.defined {
        Defined::Function(_, function) | Defined::Macro(function) => Some(function),
        Defined::Value | Defined::Failure => None,
    });
    definitions.chain(&resolved.forms).chain(&resolved.tests)
}

/// One name, where it is written, and what is said of it.
struct NameInText<'a> {
    name: Symbol,
    program: &'a Program,
    written: &'a [WrittenName],
    uses: &'a [Use],
}

/// What a written name was found to be.
#[derive(Clone, Copy)]
struct Finding {
    target: Target,
    is_binding: bool,
    is_certain: bool,
}

impl NameInText<'_> {
    fn resolve(&self, found: &mut Vec<Occurrence>) {
        let mut findings = vec![None; self.written.len()];
        let same = self.take_bindings(&mut findings);
        let mut apart: BTreeMap<(u32, Reverse<u32>), Vec<Target>> = BTreeMap::new();
        for used in self.uses.iter().filter(|used| !used.is_binding) {
            let target = same.get(&used.target).copied().unwrap_or(used.target);
            match self.exactly(used.within) {
                Some(at) => {
                    findings[at].get_or_insert(Finding { target, is_binding: false, is_certain: true });
                }
                None => apart.entry((used.within.start, Reverse(used.within.end))).or_default().push(target),
            }
        }
        self.take_apart(&apart, &mut findings);
        for (written, finding) in self.written.iter().zip(findings) {
            let by_name = || Some(Finding { target: self.by_name(written)?, is_binding: false, is_certain: true });
            if let Some(Finding { target, is_binding, is_certain }) = finding.or_else(by_name) {
                let &WrittenName { span, whole, .. } = written;
                found.push(Occurrence { span, whole, name: self.name, target, is_binding, is_certain });
            }
        }
    }

    /// A name is bound where it first stands in the form that binds it. Gives the targets that are the same as
    /// another: an expansion may bind a name it was given more than once.
    fn take_bindings(&self, findings: &mut [Option<Finding>]) -> BTreeMap<Target, Target> {
        let mut same = BTreeMap::new();
        let mut taken = BTreeMap::new();
        for binding in self.uses.iter().filter(|used| used.is_binding) {
            if let Some(&first) = taken.get(&binding.within) {
                same.insert(binding.target, first);
                continue;
            }
            taken.insert(binding.within, binding.target);
            let from = self.written.partition_point(|written| written.span.start < binding.within.start);
            let inside = (from..self.written.len()).take_while(|&at| self.written[at].span.end <= binding.within.end);
            let can_be_bound = |&at: &usize| findings[at].is_none() && self.written[at].qualifier.is_none();
            if let Some(at) = inside.into_iter().find(can_be_bound) {
                findings[at] = Some(Finding { target: binding.target, is_binding: true, is_certain: true });
            }
        }
        same
    }

    /// The written name that is a form, or the head of one, at this place.
    fn exactly(&self, place: Span) -> Option<usize> {
        let from = self.written.partition_point(|written| written.span.start < place.start);
        // Before the head of a list stands its parenthesis, and perhaps a comment.
        let at = self.written.get(from)?;
        (at.whole == place || at.heads == Some(place)).then_some(from)
    }

    /// What is written in calls of macros: what the smallest form around it that speaks of the name says.
    fn take_apart(&self, apart: &BTreeMap<(u32, Reverse<u32>), Vec<Target>>, findings: &mut [Option<Finding>]) {
        let mut groups: BTreeMap<(u32, Reverse<u32>), Vec<usize>> = BTreeMap::new();
        let mut forms = apart.keys().copied().peekable();
        let mut around: Vec<(u32, Reverse<u32>)> = Vec::new();
        for (at, written) in self.written.iter().enumerate() {
            while let Some(form) = forms.next_if(|&(start, _)| start <= written.span.start) {
                around.retain(|&(_, Reverse(end))| end > form.0);
                around.push(form);
            }
            around.retain(|&(_, Reverse(end))| end >= written.span.end);
            if let (None, Some(&form)) = (findings[at], around.last()) {
                groups.entry(form).or_default().push(at);
            }
        }
        for (form, places) in groups {
            let (qualified, plain): (Vec<usize>, Vec<usize>) =
                places.into_iter().partition(|&at| self.written[at].qualifier.is_some());
            let targets = &apart[&form];
            in_order(&plain, targets, findings);
            // With a qualifier no variable is meant, whatever is bound.
            let globals: Vec<Target> =
                targets.iter().copied().filter(|target| !matches!(target, Target::Local(_))).collect();
            in_order(&qualified, &globals, findings);
        }
    }

    /// What a name means by itself, where no resolved form speaks of it.
    fn by_name(&self, written: &WrittenName) -> Option<Target> {
        if written.qualifier == Some(Qualifier::Library) {
            return None;
        }
        if written.heads.is_some() && self.program.macros.contains_key(&self.name) {
            return Some(Target::Macro(self.name));
        }
        self.program.failure_classes.contains_key(&self.name).then_some(Target::Failure(self.name))
    }
}

/// Gives places of a name in a form the targets that the form speaks of: it is mostly evaluated in the order in which it
/// is written.
fn in_order(places: &[usize], targets: &[Target], findings: &mut [Option<Finding>]) {
    let is_certain = targets.iter().all(|target| *target == targets[0]);
    for (number, &at) in places.iter().enumerate() {
        let target = targets.get(number).or(targets.last());
        findings[at] = target.map(|&target| Finding { target, is_binding: false, is_certain });
    }
}
