//! The definitions of a text, by its tokens alone: for the many texts of a project, which nobody compiles, and while one
//! is typed.

use crate::lines::Lines;
use crate::outline::Outline;
use lsp_types::{Range, SymbolKind};
use rpl_lang::bars::{begins_definition, read_name};
use rpl_lang::symbol::base_name;

/// A name, and where a text defines it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Definition {
    /// The name as it is written; of a goal what is achieved.
    pub name: String,
    /// What it is, by the word that defines it.
    pub kind: SymbolKind,
    /// Where the name stands.
    pub name_range: Range,
    /// The first line of the definition.
    pub line: u32,
}

/// The definitions of a text that stand by themselves, in order. Cost: linear.
pub fn definitions(text: &str, outline: &Outline, lines: &Lines) -> Vec<Definition> {
    let defined = outline.forms().filter_map(|form| {
        let head = outline.head(text, form).filter(|head| is_definition(head))?;
        let name = outline.named(form)?;
        Some(Definition {
            name: text[name.clone()].split_whitespace().collect::<Vec<_>>().join(" "),
            kind: kind_of(base_name(&read_name(head))),
            name_range: lines.range(text, name),
            line: lines.position(text, outline.lexemes[form].start).line,
        })
    });
    defined.collect()
}

/// Whether the text has forms that run: neither definitions nor `load`. Cost: linear.
pub fn runs_something(text: &str, outline: &Outline) -> bool {
    let is_run = |form| outline.head(text, form).is_none_or(|head| !is_definition(head) && read_name(head) != "load");
    outline.forms().any(is_run)
}

/// Whether a word at the head of a list says that the list defines something.
pub fn is_definition(head: &str) -> bool {
    begins_definition(head) || base_name(&read_name(head)) == "global-fluent"
}

fn kind_of(head: &str) -> SymbolKind {
    match head {
        "def-plan" | "def-interp-proc" | "def-goal" => SymbolKind::METHOD,
        "defun" | "def-resume" | "defmacro" | "def-revision" => SymbolKind::FUNCTION,
        "def-failure" | "defstruct" => SymbolKind::CLASS,
        "def-fluent" | "global-fluent" => SymbolKind::PROPERTY,
        "defconstant" => SymbolKind::CONSTANT,
        "def-valve" => SymbolKind::INTERFACE,
        "deftest" => SymbolKind::EVENT,
        _ => SymbolKind::VARIABLE,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn definitions_are_found_in_texts_that_cannot_be_read() {
        let text = "(def-plan a (x)\n  (b \"\n(defun c () 1)\n; (defun d ())\n'(defun e ())\n(def-goal (achieve (warm room)) 1)";
        let closed = text.replacen("\"\n", "\n", 1);
        let outline = Outline::of(&closed);
        let found = definitions(&closed, &outline, &Lines::of(&closed));
        let names: Vec<_> = found.iter().map(|one| (one.name.as_str(), one.kind, one.line)).collect();
        let expected = [
            ("a", SymbolKind::METHOD, 0),
            ("c", SymbolKind::FUNCTION, 2),
            ("(achieve (warm room))", SymbolKind::METHOD, 5),
        ];
        assert_eq!(names, expected);
    }

    #[test]
    fn what_runs_is_neither_defined_nor_loaded() {
        for (text, runs) in [
            ("(def-plan a () 1)\n(load \"b.rpl\")\n(deftest c (a))", false),
            ("(def-plan a () 1)\n(a)", true),
            ("((lambda () 1))", true),
            ("; nothing", false),
        ] {
            assert_eq!(runs_something(text, &Outline::of(text)), runs, "{text}");
        }
    }
}
