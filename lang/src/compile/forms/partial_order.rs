//! `plan`: steps side by side, but for those that wait for others.

use super::special_form::Written;
use crate::code::Quorum;
use crate::compile::compiler::Compiler;
use crate::compile::ir::{ChildIr, Ir};
use crate::symbol::Symbol;
use crate::syntax::NodeKind;

impl Compiler<'_> {
    /// `(plan (STEP...) (:order A B)...)`
    pub(super) fn partial_order(&mut self, written: &Written<'_>) -> Ir {
        let (rest, span) = (written.rest(), written.span);
        let steps = rest.first().and_then(|&list| self.list_items(list));
        let Some(steps) = steps else {
            return self.malformed(span, "`(plan (STEP...) (:order A B)...)`");
        };
        let children: Vec<ChildIr> = steps.iter().map(|&step| self.child(step)).collect();
        let mut order = Vec::new();
        for &constraint in &rest[1..] {
            let place = self.tree.span(constraint);
            let items = self.tree.items(constraint).to_vec();
            let is_order = items.first().is_some_and(
                |&head| matches!(self.tree.get(head).kind, NodeKind::Keyword(word) if self.symbols.name(word) == "order"),
            );
            let names: Vec<Symbol> = items.iter().skip(1).filter_map(|&name| self.tree.symbol(name)).collect();
            let (true, [before, after]) = (is_order, names.as_slice()) else {
                self.malformed(place, "`(:order A B)`");
                continue;
            };
            let position = |name: Symbol| children.iter().position(|child| child.name == Some(name));
            match (position(*before), position(*after)) {
                (Some(before), Some(after)) => order.push((before as u16, after as u16)),
                (before, _) => {
                    let missing = if before.is_none() { names[0] } else { names[1] };
                    let text = self.symbols.name(missing).to_string();
                    self.error(
                        "unknown-step",
                        place,
                        format!("no step of this plan has the tag `{text}`"),
                        "unknown step",
                    )
                    .help = Some(format!("name a step: `(:tag {text} …)`"));
                }
            }
        }
        if let Some(step) = cycle_in(children.len(), &order) {
            let name = children[step].name.map_or("a step", |name| self.symbols.name(name)).to_string();
            self.error(
                "order-cycle",
                span,
                format!("the order of these steps is a circle through `{name}`"),
                "can never start",
            );
        }
        self.construct(Quorum::PAR, written, children, order, None)
    }
}

/// A step on a circle of the order, if there is one (Kahn's algorithm leaves exactly those and
/// what depends on them).
fn cycle_in(steps: usize, order: &[(u16, u16)]) -> Option<usize> {
    let mut open: Vec<usize> =
        (0..steps).map(|step| order.iter().filter(|&&(_, after)| usize::from(after) == step).count()).collect();
    let mut ready: Vec<usize> = (0..steps).filter(|&step| open[step] == 0).collect();
    let mut done = vec![false; steps];
    while let Some(step) = ready.pop() {
        done[step] = true;
        for &(before, after) in order {
            if usize::from(before) == step {
                open[usize::from(after)] -= 1;
                if open[usize::from(after)] == 0 {
                    ready.push(usize::from(after));
                }
            }
        }
    }
    done.iter().position(|&done| !done)
}
