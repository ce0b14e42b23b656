//! Texts that are a part of the library, as the plans of a module are.

use crate::evaluate::{evaluate_in, library_with};

#[test]
fn what_a_library_defines_begins_anew_in_each_run() {
    let text = "(defvar asked 0) (defconstant names '(a b)) (def-fluent seen nil) (defvar nothing)
                (def-plan ask () (incf asked) (setf (value seen) t) (list asked names (value seen) nothing))";
    let library = library_with(&[("own.rpl", text)]).expect("it consists of definitions");
    for _ in 0..2 {
        assert_eq!(
            evaluate_in(&library, "(list (value seen) (ask) (ask))").as_deref(),
            Ok("(nil (1 (a b) t nil) (2 (a b) t nil))")
        );
    }
    let waits = "(par (seq (wait-for seen) 'was-seen) (seq (wait-time 1) (ask)))";
    assert!(evaluate_in(&library, waits).is_ok());
}

#[test]
fn what_would_never_run_is_refused() {
    for (text, part) in [
        ("(defvar later (+ 1 2))", "what a library defines begins as a constant"),
        ("(def-fluent later (list 1))", "what a library defines begins as a constant"),
        ("(print 1)", "a library consists of definitions"),
        ("(progn (print 1))", "a library consists of definitions"),
    ] {
        let faults = library_with(&[("own.rpl", text)]).err().unwrap_or_default();
        assert!(faults.contains(part), "{text}: {faults}");
    }
}
