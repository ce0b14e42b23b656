//! Nested parameter lists: names bound to the parts of a list.

use super::compiler::Compiler;
use super::ir::{Ir, IrKind, Unary, VarId};
use super::lambda_list::{Lists, Section};
use crate::code::{Atom, Constant, Part};
use crate::source::Span;
use crate::syntax::NodeId;

/// A list that is taken apart.
struct Whole {
    list: VarId,
    /// Where its parameter list stands.
    span: Span,
    /// How many of its elements have their place by now.
    passed: usize,
    /// What was bound so far, in order.
    bound: Vec<(VarId, Ir)>,
}

impl Compiler<'_> {
    /// Binds the names of a parameter list, whose elements may be such lists themselves, to the parts of the list that
    /// a variable holds. Gives what is bound, in order.
    pub(super) fn taken_apart(&mut self, pattern: NodeId, list: VarId) -> Vec<(VarId, Ir)> {
        self.nested(pattern, |compiler| compiler.taken_apart_here(pattern, list)).unwrap_or_default()
    }

    fn taken_apart_here(&mut self, pattern: NodeId, list: VarId) -> Vec<(VarId, Ir)> {
        let span = self.tree.span(pattern);
        let sections = self.parameter_sections(pattern);
        let fitted = self.fitted(pattern, &sections, list, span);
        let list = self.new_list(span);
        let mut whole = Whole { list, span, passed: 0, bound: vec![(list, fitted)] };
        for (section, item) in sections {
            match section {
                Section::Required => {
                    let value = self.element(&whole);
                    self.bind_part(item, value, &mut whole);
                    whole.passed += 1;
                }
                Section::Optional => {
                    let (there, value) = (self.tail(&whole), self.element(&whole));
                    self.bind_omissible_part(item, there, value, &mut whole);
                    whole.passed += 1;
                }
                Section::Rest => {
                    let value = self.tail(&whole);
                    self.bind_part(item, value, &mut whole);
                }
                Section::Key => self.bind_key(item, &mut whole),
            }
        }
        whole.bound
    }

    /// A variable no text can name.
    pub(super) fn new_list(&mut self, span: Span) -> VarId {
        let name = self.symbols.uninterned("list");
        self.new_variable(name, span)
    }

    /// The list, if it fits the parameter list; else a failure that says why not.
    fn fitted(&mut self, pattern: NodeId, sections: &[(Section, NodeId)], list: VarId, span: Span) -> Ir {
        let count = |wanted: Section| sections.iter().filter(|(section, _)| *section == wanted).count() as i64;
        let least = count(Section::Required);
        let is_open = count(Section::Rest) + count(Section::Key) > 0;
        let most = if is_open { i64::MAX } else { least + count(Section::Optional) };
        // With `&rest` other keywords may stand there, too.
        let keys: Vec<Part> = match count(Section::Rest) {
            0 => {
                let keys = sections.iter().filter(|(section, _)| *section == Section::Key);
                let names = keys.filter_map(|&(_, item)| self.omissible_name(item));
                names.map(|name| Part::Atom(Atom::Keyword(name))).collect()
            }
            _ => Vec::new(),
        };
        let written = self.datum(pattern);
        let keys = match keys.len() as u32 {
            0 => Constant::Atom(Atom::Nil),
            length => Constant::Compound([keys, vec![Part::List { length, dotted: false }]].concat()),
        };
        let arguments = [
            IrKind::Local(list),
            IrKind::Const(self.constant(written)),
            IrKind::Int(least),
            IrKind::Int(most),
            IrKind::Int(least + count(Section::Optional)),
            IrKind::Const(self.constant(keys)),
        ];
        self.native_ir("%fitted", arguments.map(|kind| Ir { span, kind }).into(), span)
    }

    fn element(&mut self, whole: &Whole) -> Ir {
        self.part("nth", whole)
    }

    fn tail(&mut self, whole: &Whole) -> Ir {
        self.part("nthcdr", whole)
    }

    fn part(&mut self, native: &str, whole: &Whole) -> Ir {
        let arguments = [IrKind::Int(whole.passed as i64), IrKind::Local(whole.list)];
        self.native_ir(native, arguments.map(|kind| Ir { span: whole.span, kind }).into(), whole.span)
    }

    /// A name, or a list that is taken apart in its turn.
    fn bind_part(&mut self, node: NodeId, value: Ir, whole: &mut Whole) {
        let Some((variable, parts)) = self.parameter(node, Lists::Taken) else { return };
        whole.bound.push((variable, value));
        whole.bound.extend(parts);
    }

    /// `name`, `(name default)` or `(name default given?)`; `there` is true if the list has a value for it.
    fn bind_omissible_part(&mut self, node: NodeId, there: Ir, value: Ir, whole: &mut Whole) {
        let span = whole.span;
        let Some(items) = self.omissible_items(node) else { return };
        // The default is resolved before the name is bound: it must not see the parameter itself.
        let default = Box::new(match items.get(1) {
            Some(&default) => self.resolve(default),
            None => self.nil(span),
        });
        let given = there.clone();
        let value = Ir { span, kind: IrKind::If(Box::new(there), Box::new(value), default) };
        self.bind_part(items[0], value, whole);
        if let Some(&flag) = items.get(2) {
            let (yes, no) = (Box::new(Ir { span, kind: IrKind::True }), Box::new(self.nil(span)));
            self.bind_part(flag, Ir { span, kind: IrKind::If(Box::new(given), yes, no) }, whole);
        }
    }

    fn bind_key(&mut self, node: NodeId, whole: &mut Whole) {
        let span = whole.span;
        let Some(name) = self.omissible_name(node) else {
            if let Some(items) = self.omissible_items(node) {
                self.parameter(items[0], Lists::Refused);
            }
            return;
        };
        let key = self.constant(Atom::Keyword(name));
        let arguments = [IrKind::Local(whole.list), IrKind::Int(whole.passed as i64), IrKind::Const(key)];
        let arguments = arguments.map(|kind| Ir { span, kind }).into();
        let at = self.new_list(span);
        whole.bound.push((at, self.native_ir("%behind-key", arguments, span)));
        let there = Ir { span, kind: IrKind::Local(at) };
        let value = Ir { span, kind: IrKind::Unary(Unary::Car, Box::new(there.clone())) };
        self.bind_omissible_part(node, there, value, whole);
    }
}
