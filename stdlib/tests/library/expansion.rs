//! How much macros may make of a text or a datum.

use crate::evaluate::{evaluate, library};
use rpl_lang::compile::{Loader, NoFiles};
use rpl_runtime::run::system::{Progress, System};
use std::collections::BTreeMap;

/// A macro that uses itself twice, to a given depth.
const DOUBLING: &str = "(defmacro twice (n) (if (= n 0) 1 (list 'progn (list 'twice (- n 1)) (list 'twice (- n 1)))))";

fn faults(text: &str) -> String {
    evaluate(text).err().unwrap_or_default()
}

/// r[limit.expansion]
#[test]
fn what_macros_make_of_a_text_is_bounded() {
    assert_eq!(evaluate(&format!("{DOUBLING} (twice 10)")).as_deref(), Ok("1"));
    let told = faults(&format!("{DOUBLING}\n(print (twice 24))\n(print (twice 25))\n(not-expanded-either)"));
    assert!(told.contains("error[too-much-expanded]: with this call of `twice`"), "{told}");
    assert!(told.contains("test:2:8"), "{told}");
    assert!(told.contains("let `twice` expand into a call of a function"), "{told}");
    // It is told once, and nothing is said of what comes behind.
    assert_eq!(told.matches("error[").count(), 1, "{told}");
    // One expansion alone can be too large.
    let at_once = faults("(defmacro large () (let ((l '(1))) (dotimes (i 24) (setq l (list 'list l l))) l)) (large)");
    assert!(at_once.contains("error[too-much-expanded]: with this call of `large`"), "{at_once}");
    // At the top level, too.
    let above = faults(
        "(defmacro define (n) (if (= n 0) '(defvar x 1) (list 'progn '(defvar y 1) (list 'define (- n 1)) (list 'define (- n 1)))))
         (define 24)",
    );
    assert!(above.contains("error[too-much-expanded]: with this call of `define`"), "{above}");
}

/// r[limit.expansion]
#[test]
fn a_long_text_may_be_expanded_in_full() {
    let text = format!("(defvar n 0) {} n", "(incf n) ".repeat(60_000));
    assert_eq!(evaluate(&text).as_deref(), Ok("60000"));
}

/// r[limit.expansion]
#[test]
fn steps_of_all_macros_of_a_text_are_bounded() {
    let told = faults(&format!("(defmacro spin () (loop))\n{}", "(spin)\n".repeat(100)));
    assert!(told.contains("error[too-much-expanded]: with this call of `spin`, all macros here have taken"), "{told}");
    assert!(told.matches("error[").count() < 30, "{told}");
}

/// r[limit.expansion], r[limit.memory]
#[test]
fn what_macros_make_of_a_datum_is_bounded_by_the_memory_of_the_run() {
    let failure = |text: &str, bytes: usize| {
        let mut system =
            System::without_robot(library(), "test", text, 0).unwrap_or_else(|r| panic!("{}", r.render(false)));
        system.machine.limits.bytes = bytes;
        while system.advance() == Progress::Running {}
        let value = *system.machine.tasks[system.machine.main].value();
        system.with_machine(|machine, around| machine.show(around.program, value))
    };
    let doubled = format!("{DOUBLING} (execute-plan '(twice 24))");
    let told = failure(&doubled, 1 << 30);
    assert!(told.contains("error[too-much-expanded]: with this call of `twice`"), "{told}");
    let told = failure(&doubled, 1 << 24);
    assert!(told.starts_with("out-of-memory"), "{told}");
    // Texts in a datum count by their length.
    let told =
        failure("(let ((s (string-repeat \"x\" 1000000))) (execute-plan (list 'quote (make-list 1000 s))))", 1 << 30);
    assert!(told.starts_with("error: the datum has more than"), "{told}");
    // What a macro makes while it runs is a part of what the run may make.
    let told = failure("(defmacro grow () (let ((l nil)) (loop (push 1 l)))) (execute-plan '(grow))", 1 << 24);
    assert!(told.contains("out-of-memory: this would pass the limit of 2 MiB"), "{told}");
}

/// r[limit.expansion], r[limit.steps]
#[test]
fn steps_of_macros_in_a_datum_are_steps_of_the_task() {
    let text = "(defmacro slow (n) (dotimes (i 1000000) i) n)
                (dotimes (i 1000) (execute-plan (list 'slow (list 'quote i))))";
    let told = faults(text);
    assert!(told.starts_with("runaway"), "{told}");
}

struct Files(BTreeMap<String, String>);

impl Loader for Files {
    fn load(&mut self, _from: &str, path: &str) -> Result<(String, String), String> {
        self.0.get(path).map(|text| (path.to_string(), text.clone())).ok_or_else(|| "there is no such file".to_string())
    }
}

/// r[limit.expansion]
#[test]
fn files_that_load_each_other_twice_are_bounded() {
    let file = |n: usize| {
        (format!("f{n}"), format!("(load \"f{0}\") (load \"f{0}\") (defvar v{n} '(1 2 3 4 5 6 7 8))", n + 1))
    };
    let mut files = Files((0..40).map(file).collect());
    files.0.insert("f40".to_string(), "(defvar end '(1 2 3 4 5 6 7 8))".to_string());
    let Err(rejected) = library().load("test", "(load \"f0\")", &mut files) else { panic!("it is refused") };
    let told = rejected.render(false);
    assert!(told.contains("error[too-much-expanded]: with `f"), "{told}");
    assert!(library().load("test", "(defvar x 1)", &mut NoFiles).is_ok());
}

/// r[limit.expansion]
#[test]
fn a_macro_without_an_end_is_told_once_however_often_it_uses_itself() {
    for body in [
        "`(boom ,n)",
        "`(progn (boom ,n) (boom ,n))",
        "`(progn (boom ,n) (boom ,n) (boom ,n))",
        "`(list 1 (boom ,n))",
        "`(list (boom ,n) (boom ,n))",
        "`(+ 1 (boom ,n))",
        "`(let ((x (boom ,n))) x)",
        "`(let ((x 1)) (boom ,n))",
        "`(if (boom ,n) (boom ,n))",
        "`(lambda () (boom ,n))",
        "`(cons (print 1) (boom ,n))",
    ] {
        let told = faults(&format!("(defmacro boom (n) {body})\n(boom 1)\n(boom 2)"));
        assert_eq!(told.matches("error[").count(), 1, "{told:.600}");
        assert!(told.contains("error[endless-macro]") && told.contains("test:2:1"), "{told:.600}");
    }
}
