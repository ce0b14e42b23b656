//! Blocks, and how they are left: by a jump, or from inside a closure.

use super::compiler::{BlockScope, Compiler};
use super::ir::{BlockId, Ir, IrKind, VarId, Variable};
use crate::code::CodeKind;
use crate::source::Span;
use crate::symbol::Symbol;

impl Compiler<'_> {
    /// Enters a block and resolves what is inside it.
    pub(super) fn in_block(
        &mut self,
        name: Option<Symbol>,
        span: Span,
        inside: impl FnOnce(&mut Self, BlockId) -> Ir,
    ) -> Ir {
        let id = BlockId(self.next_block);
        self.next_block += 1;
        let function = self.functions.len() - 1;
        let clean_ups = self.clean_ups;
        self.blocks.push(BlockScope { name, id, function, span, token: None, used: false, clean_ups });
        let body = inside(self, id);
        let block = self.blocks.pop().unwrap_or_else(|| unreachable!("the block was pushed above"));
        if block.used {
            Ir { span, kind: IrKind::Block { id, token: block.token, body: Box::new(body) } }
        } else {
            body
        }
    }

    /// Leaves the block at this index of the block list.
    pub(super) fn leave(&mut self, block: usize, value: Ir, span: Span) -> Ir {
        self.blocks[block].used = true;
        let (id, function) = (self.blocks[block].id, self.blocks[block].function);
        // An exit from a clean-up may come too late: it must not touch the block's value before it
        // is known to arrive.
        let is_static = self.blocks[block].clean_ups == self.clean_ups || self.blocks[block].name.is_none();
        if function == self.functions.len() - 1 && is_static {
            return Ir { span, kind: IrKind::Leave(id, Box::new(value)) };
        }
        let crossed = &self.functions[function + 1..];
        if crossed.iter().any(|scope| matches!(scope.kind, CodeKind::Task | CodeKind::Network)) {
            let (from, message) = (self.blocks[block].span, "this would leave a task from inside another");
            self.error("leaves-task", span, message, "the block belongs to the task around it")
                .related
                .push((from, "the block".into()));
            return self.nil(span);
        }
        let token = match self.blocks[block].token {
            Some(token) => token,
            None => {
                let name = self.symbols.uninterned("block");
                self.variables.push(Variable { name, span, function, captured: false, assigned: false });
                let token = VarId(self.variables.len() as u32 - 1);
                self.blocks[block].token = Some(token);
                token
            }
        };
        self.capture(token);
        Ir { span, kind: IrKind::LeaveDynamic(token, Box::new(value)) }
    }
}
