//! Texts with very many names: told by their size and not by its square. What these tests would take
//! otherwise is an hour.

use crate::evaluate::{evaluate, library};
use rpl_lang::compile::NoFiles;
use rpl_lang::diagnostic::Diagnostic;

const MANY: usize = 100_000;

fn each(form: impl Fn(usize) -> String) -> String {
    (0..MANY).map(form).collect::<Vec<_>>().join("\n")
}

fn found(text: &str) -> Vec<Diagnostic> {
    library().check("test", text, None, &mut NoFiles).0
}

/// r[eval.unknown]
#[test]
fn many_unknown_names_are_told_in_a_moment() {
    let defined = each(|n| format!("(defvar known-name-{n} 1)"));
    let unknown = each(|n| format!("(print unknown-nome-{n})"));
    let local = each(|n| format!("(defun f{n} (known-nome-{n}) (print unknown-nome-{n}))"));
    let in_a_macro = format!("(dotimes (i 3) {})", each(|n| format!("(print (+ 1 unknown-nome-{n}))")));
    for text in [format!("{defined}\n{unknown}"), local, in_a_macro] {
        let found = found(&text);
        let unbound = found.iter().filter(|diagnostic| diagnostic.code == "unbound-name").count();
        let more = found.iter().find(|diagnostic| diagnostic.code == "more-errors");
        assert_eq!(unbound, 1_000);
        assert_eq!(more.map(|more| &*more.message), Some("and 99000 more names are not defined anywhere"));
    }
}

/// r[eval.unknown]
#[test]
fn the_first_unknown_names_come_with_what_could_be_meant() {
    let defined = each(|n| format!("(defvar known-name-{n} 1)"));
    let found = found(&format!("{defined}\n(print known-nome-77)\n(print knwon-name-4711)\n(prnt 1)"));
    let helps: Vec<_> = found.iter().filter_map(|diagnostic| diagnostic.help.as_deref()).collect();
    assert_eq!(helps, ["did you mean `known-name-77`?", "did you mean `known-name-4711`?", "did you mean `print`?"]);
    // Another unknown name is nothing that could be meant.
    let two = evaluate("(print somthing-odd) (print somthing-odds)").err().unwrap_or_default();
    assert!(!two.contains("did you mean"), "{two}");
}

#[test]
fn many_classes_that_are_unknown() {
    let classes = each(|n| format!("(def-failure known-class-{n} (failure) ())"));
    let unknown = each(|n| format!("(fail unknown-closs-{n} \"x\")"));
    let parents = each(|n| format!("(def-failure c{n} (unknown-parent-{n}) ())"));
    for text in [format!("{classes}\n{unknown}"), format!("{classes}\n{parents}")] {
        assert!(found(&text).iter().any(|diagnostic| diagnostic.code == "unknown-failure-class"));
    }
}

#[test]
fn many_definitions_between_uses_of_macros() {
    let functions = each(|n| format!("(defun f{n} (x) (incf x) (g{n} x)) (defun g{n} (x) x)"));
    assert!(found(&functions).is_empty());
}

#[test]
fn a_text_of_many_definitions_runs() {
    assert_eq!(evaluate(&format!("{} (f99999 1)", each(|n| format!("(defun f{n} (x) (incf x))")))).as_deref(), Ok("2"));
}
