//! What a program can see: what it cannot see makes no difference to it.

use crate::run::library::{Library, Loaded};
use crate::step::native::Native;
use rpl_lang::code::{Atom, Code, Constant, GlobalKind, Op, Program};
use std::collections::BTreeSet;

/// What a plan can see of that which a canonical state otherwise leaves out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Visible {
    /// The time since the start.
    pub time: bool,
    /// The paths of tasks, with the numbers in them.
    pub names: bool,
}

/// Natives that tell the time, those that tell the names of tasks, and those by which a plan can come to call
/// anything.
const TIME: &[&str] = &["now", "at-time"];
const NAMES: &[&str] = &["task", "task-path"];
const ANYTHING: &[&str] = &["execute-plan", "%compile-plan"];

impl Visible {
    /// What the forms of a text, and all that they can come to call, can see. Cost: linear in the code.
    pub fn by(loaded: &Loaded, library: &Library) -> Self {
        Reach { program: &loaded.program, natives: &library.natives, codes: BTreeSet::new(), visible: Self::default() }
            .follow(loaded.main)
    }
}

/// The code that can be come to.
struct Reach<'p> {
    program: &'p Program,
    natives: &'p [Native],
    codes: BTreeSet<u32>,
    visible: Visible,
}

impl Reach<'_> {
    fn follow(mut self, main: u32) -> Visible {
        let mut waiting = vec![main];
        while let Some(number) = waiting.pop() {
            if self.codes.insert(number) {
                let program = self.program;
                let code = &program.codes[number as usize];
                code.ops.iter().for_each(|op| self.op(code, op, &mut waiting));
            }
        }
        self.visible
    }

    fn op(&mut self, code: &Code, op: &Op, waiting: &mut Vec<u32>) {
        match *op {
            Op::Global(_, global)
            | Op::Call(_, _, global)
            | Op::CallSlot(_, _, global)
            | Op::CallSetSlot(_, _, global)
            | Op::TailCall(_, _, global) => {
                if let GlobalKind::Function(code) = self.program.globals[global as usize].kind {
                    waiting.push(code);
                }
            }
            Op::CallCode(_, code) | Op::Closure(_, code) | Op::Network(_, code) => waiting.push(code),
            Op::Parallel(_, construct) | Op::ParallelMap(_, _, construct) | Op::Spawn(_, construct) => {
                waiting.extend(code.constructs[construct as usize].children.iter().map(|child| child.code));
            }
            Op::CallNative(_, _, _, native) => self.native(native),
            Op::Const(_, constant) => self.constant(constant),
            _ => {}
        }
    }

    fn native(&mut self, native: u16) {
        let Some(native) = self.natives.get(usize::from(native)) else { return };
        let is_anything = ANYTHING.contains(&native.name);
        self.visible.time |= is_anything || TIME.contains(&native.name);
        self.visible.names |= is_anything || NAMES.contains(&native.name);
    }

    /// A constant may be a native function that is passed on.
    fn constant(&mut self, constant: u32) {
        if let Some(Constant::Atom(Atom::Native(native))) = self.program.constants.get(constant as usize) {
            self.native(*native);
        }
    }
}
