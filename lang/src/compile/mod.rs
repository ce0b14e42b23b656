//! From syntax to register code: expansion, resolution and emission, one top-level form after the
//! other. Errors are collected; code is always produced and runs only if there are none.
//!
//! A text has one more body for each of its tests: the definitions of the text, then the test.

mod blocks;
mod compilation;
mod compiler;
mod datum;
mod emit;
mod expansion;
mod fluent_position;
mod foreign;
pub(crate) mod forms;
mod goals;
mod habits;
mod intrinsics;
pub(crate) mod ir;
mod lambda_list;
mod locals;
mod macro_calls;
mod meaning;
mod out_of_scope;
mod pattern;
mod resolve;
pub(crate) mod resolved;
mod top_level;
mod unresolved;

use crate::reader::read;
use crate::source::{SourceId, Span};
use crate::syntax::{NodeId, Tree};
pub use compilation::{
    Compilation, Loader, MacroHost, Names, NamesElsewhere, NativeSignature, NoFiles, Purpose, TextKind, Unexpanded,
    no_names,
};
use compiler::Compiler;
use expansion::Expansion;
pub use foreign::foreign_words;
pub use forms::{SpecialForm, special_forms};
pub use resolved::{Compiled, DefinedKind, Resolved, Test, TestOptions};

/// Reads and compiles a text.
pub fn compile_text(surroundings: Compilation<'_>, source: SourceId, purpose: Purpose) -> Compiled {
    let mut tree = Tree::default();
    let text = surroundings.program.sources.get(source).text.clone();
    let (forms, diagnostics) = read(&text, source, surroundings.symbols, &mut tree);
    let mut expansion = Expansion::of_text();
    expansion.has_read(tree.nodes.len());
    let mut compiler = Compiler::new(surroundings, forms::special_names(), tree, expansion, purpose);
    compiler.diagnostics = diagnostics;
    compiler.run(&forms, Span { source, start: 0, end: text.len() as u32 })
}

/// Compiles a datum that is already syntax, such as a plan made at run time. What macros in it expand into
/// may have `most` parts.
pub fn compile_datum(surroundings: Compilation<'_>, tree: Tree, root: NodeId, most: usize) -> Compiled {
    let (span, expansion) = (tree.span(root), Expansion::of_datum(most));
    Compiler::new(surroundings, forms::special_names(), tree, expansion, Purpose::User).run(&[root], span)
}
