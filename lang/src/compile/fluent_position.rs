//! Fluent position: in a network an expression stands for its value now, and is asked again when a
//! fluent in it changes.

use super::compiler::Compiler;
use super::ir::{Callee, Ir, IrKind, Unary};
use crate::code::CodeKind;
use crate::source::Span;
use crate::syntax::NodeId;

impl Compiler<'_> {
    /// Wraps an expression that may give a fluent, in fluent position.
    pub(super) fn dereferenced(&self, ir: Ir) -> Ir {
        if self.is_network() { Ir { span: ir.span, kind: IrKind::Unary(Unary::Deref, Box::new(ir)) } } else { ir }
    }

    pub(super) fn outside_fluent_position<T>(&mut self, inside: impl FnOnce(&mut Self) -> T) -> T {
        let Some(function) = self.functions.last_mut() else { return inside(self) };
        let before = std::mem::replace(&mut function.network, false);
        let result = inside(self);
        if let Some(function) = self.functions.last_mut() {
            function.network = before;
        }
        result
    }

    /// `value`, `pulsed`, …: their arguments are taken as they are. Inside a network, `pulsed` and
    /// `changed` ask for the propagation under way, and a counter is made once, with the network.
    pub(super) fn fluent_native(&mut self, native: u16, nodes: &[NodeId], span: Span) -> Ir {
        let natives = self.natives;
        let name = natives[usize::from(native)].name.as_str();
        if !self.is_network() {
            let arguments = self.arguments(nodes);
            return Ir { span, kind: IrKind::Call(Callee::Native(native), arguments) };
        }
        if name == "count-pulses" {
            return self.hoisted_counter(native, nodes, span);
        }
        let arguments = self.outside_fluent_position(|compiler| compiler.arguments(nodes));
        let direct = match name {
            "pulsed" => Some("%pulsed-now"),
            "changed" => Some("%changed-now"),
            _ => None,
        };
        if let Some(number) = direct.and_then(|direct| natives.iter().position(|native| native.name == direct)) {
            return Ir { span, kind: IrKind::Call(Callee::Native(number as u16), arguments) };
        }
        self.dereferenced(Ir { span, kind: IrKind::Call(Callee::Native(native), arguments) })
    }

    fn hoisted_counter(&mut self, native: u16, nodes: &[NodeId], span: Span) -> Ir {
        let Some(network) = self.functions.iter().rposition(|function| function.kind == CodeKind::Network) else {
            return self.nil(span);
        };
        // The counter belongs to the function around the network: resolve it there.
        let inner: Vec<_> = self.functions.drain(network..).collect();
        let arguments = self.arguments(nodes);
        let name = self.symbols.uninterned("count");
        let variable = self.new_variable(name, span);
        self.functions.extend(inner);
        let counter = Ir { span, kind: IrKind::Call(Callee::Native(native), arguments) };
        self.functions[network].hoisted.push((variable, counter));
        self.capture(variable);
        Ir { span, kind: IrKind::Unary(Unary::Deref, Box::new(Ir { span, kind: IrKind::Local(variable) })) }
    }
}
