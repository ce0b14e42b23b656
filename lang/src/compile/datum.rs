//! Data written out become constants.

use super::compiler::Compiler;
use crate::code::{Atom, Constant, Part};
use crate::syntax::{NodeId, NodeKind};

/// What is left to do of a datum on its way to a constant.
enum DatumStep {
    Datum(NodeId),
    /// The part that makes the whole of those before it.
    End(Part),
}

impl Compiler<'_> {
    /// A datum as a constant.
    pub(super) fn datum(&self, node: NodeId) -> Constant {
        let mut parts = Vec::new();
        let mut steps = vec![DatumStep::Datum(node)];
        while let Some(step) = steps.pop() {
            let node = match step {
                DatumStep::Datum(node) => node,
                DatumStep::End(part) => {
                    parts.push(part);
                    continue;
                }
            };
            match self.tree.get(node).kind {
                NodeKind::List { dotted, .. } => {
                    let items = self.tree.items(node);
                    let length = items.len() - usize::from(dotted);
                    if length > 0 {
                        steps.push(DatumStep::End(Part::List { length: length as u32, dotted }));
                        steps.extend(items.iter().rev().map(|&item| DatumStep::Datum(item)));
                    } else {
                        // A list of nothing but its tail is that tail.
                        steps.extend(items.last().map(|&item| DatumStep::Datum(item)));
                        parts.extend(items.is_empty().then_some(Part::Atom(Atom::Nil)));
                    }
                }
                NodeKind::Vector { len, .. } => {
                    steps.push(DatumStep::End(Part::Vector { length: len }));
                    steps.extend(self.tree.elements(node).iter().rev().map(|&item| DatumStep::Datum(item)));
                }
                ref atom => parts.push(Part::Atom(self.atom(atom))),
            }
        }
        match (parts.pop(), parts.is_empty()) {
            (Some(Part::Atom(atom)), true) => Constant::Atom(atom),
            (last, _) => {
                parts.extend(last);
                Constant::Compound(parts)
            }
        }
    }

    fn atom(&self, kind: &NodeKind) -> Atom {
        match kind {
            NodeKind::Symbol(name) => match self.symbols.name(*name) {
                "nil" => Atom::Nil,
                "t" => Atom::True,
                _ => Atom::Symbol(*name),
            },
            NodeKind::Qualified { written, .. } => Atom::Symbol(*written),
            NodeKind::Keyword(name) => Atom::Keyword(*name),
            NodeKind::Int(value) => Atom::Int(*value),
            NodeKind::Float(value) => Atom::Float(*value),
            NodeKind::Str(text) => Atom::Str(text.clone()),
            NodeKind::Object(index) => Atom::Object(*index),
            NodeKind::Hole | NodeKind::List { .. } | NodeKind::Vector { .. } => Atom::Nil,
        }
    }
}
