//! What a run defines, as it is written: found in its texts, the library's included.

use rpl_drive::stopping::own_text::UNTYPED;
use rpl_lang::bars::read_name;
use rpl_lang::reader::read;
use rpl_lang::source::{SourceId, Span};
use rpl_lang::symbol::Symbols;
use rpl_lang::syntax::{NodeId, Tree};
use rpl_mission::robot::Robot;
use rpl_runtime::run::system::System;

/// A definition in a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Definition {
    /// What the form begins with: `def-plan`, `defvar`.
    pub form: String,
    /// What it defines, in lower case.
    pub name: String,
    /// The whole form.
    pub span: Span,
    /// The form as it is written.
    pub text: String,
}

/// Forms that define what a name means to the compiler; all other definitions have names of their
/// own.
const MEANINGS: &[&str] = &[
    "def-plan",
    "def-interp-proc",
    "def-resume",
    "defun",
    "defmacro",
    "defvar",
    "defconstant",
    "def-fluent",
    "global-fluent",
    "def-valve",
];

impl Definition {
    /// Whether a later definition takes the place of this one. Definitions of one goal stand beside
    /// each other.
    fn gives_way_to(&self, later: &Self) -> bool {
        let is_meaning = |definition: &Self| MEANINGS.contains(&definition.form.as_str());
        let is_same_kind = self.form == later.form || is_meaning(self) && is_meaning(later);
        self.name == later.name && is_same_kind && (self.form != "def-goal" || self.text == later.text)
    }
}

/// What the texts that were typed and loaded define, the latest for each name, in the order of the
/// texts.
pub fn own(system: &System<Robot>) -> Vec<Definition> {
    let program = &system.program;
    let mut latest: Vec<Definition> = Vec::new();
    for number in program.library_sources..program.sources.len() as u32 {
        for definition in in_text(system, SourceId(number)) {
            latest.retain(|earlier| !earlier.gives_way_to(&definition));
            latest.push(definition);
        }
    }
    latest
}

/// Whether a text ends with a definition, whose value is but its name.
pub fn is_last(text: &str) -> bool {
    let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
    let (forms, _) = read(text, SourceId(0), &mut symbols, &mut tree);
    forms.last().and_then(|&form| tree.head(form)).is_some_and(|head| is_definition(symbols.name(head)))
}

/// Whether a form that begins so defines something. As the formatter has it, be it the user's own
/// macro.
fn is_definition(head: &str) -> bool {
    head.starts_with("def") || head == "global-fluent"
}

/// What the library and the robot's plans define.
pub fn of_library(system: &System<Robot>) -> Vec<Definition> {
    (0..system.program.library_sources).flat_map(|number| in_text(system, SourceId(number))).collect()
}

/// The definition of a name: the session's own, else the library's.
pub fn named(system: &System<Robot>, name: &str) -> Option<Definition> {
    let name = read_name(name);
    let is_it = |definition: &Definition| definition.name == name;
    own(system).into_iter().rev().find(is_it).or_else(|| of_library(system).into_iter().find(is_it))
}

fn in_text(system: &System<Robot>, source: SourceId) -> Vec<Definition> {
    let text = system.program.sources.get(source);
    if UNTYPED.contains(&&*text.name) {
        return Vec::new();
    }
    let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
    let (forms, _) = read(&text.text, source, &mut symbols, &mut tree);
    let definition = |form| {
        let head = symbols.name(tree.head(form)?);
        if !is_definition(head) {
            return None;
        }
        let span = tree.span(form);
        let written = |span| system.program.sources.text_of(span);
        let name = written(tree.span(named_in(&tree, *tree.items(form).get(1)?)));
        let (form, name, text) = (head.to_string(), read_name(name).into_owned(), written(span).to_string());
        Some(Definition { form, name, span, text })
    };
    forms.into_iter().filter_map(definition).collect()
}

/// The node of the name: itself, the first of `(point :x 0)`, the goal of `(achieve (clean room))`.
fn named_in(tree: &Tree, node: NodeId) -> NodeId {
    match *tree.items(node) {
        [_, goal] if !tree.items(goal).is_empty() => tree.items(goal)[0],
        [first, ..] => first,
        [] => node,
    }
}

/// A definition as it is written, with the comment lines right above it.
pub fn with_comments(system: &System<Robot>, definition: &Definition) -> String {
    let whole = &system.program.sources.get(definition.span.source).text;
    let above = whole.get(..definition.span.start as usize).unwrap_or_default();
    // What stands before it on its own line belongs to something else.
    let (above, indent) = above.rsplit_once('\n').unwrap_or(("", above));
    if !indent.trim().is_empty() {
        return definition.text.clone();
    }
    let comments: Vec<&str> = above.lines().rev().take_while(|line| line.trim_start().starts_with(';')).collect();
    let mut lines: Vec<&str> = comments.into_iter().rev().map(str::trim).collect();
    lines.push(&definition.text);
    lines.join("\n")
}
