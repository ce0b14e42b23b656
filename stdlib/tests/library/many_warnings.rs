//! Texts with very many warnings: found and drawn in time that follows their size. What these tests would take
//! otherwise is minutes.

use crate::evaluate::library;
use rpl_lang::compile::NoFiles;
use rpl_lang::diagnostic::{Diagnostic, render};

const MANY: usize = 30_000;

/// What is found in a text, and how it is told.
fn told(text: &str) -> (Vec<Diagnostic>, String) {
    let (found, program) = library().check("test", text, None, &mut NoFiles);
    let told = render(&found, &program.sources, false);
    (found, told)
}

fn count(found: &[Diagnostic], code: &str) -> usize {
    found.iter().filter(|diagnostic| diagnostic.code == code).count()
}

#[test]
fn many_warnings_in_one_line() {
    let (found, told) = told(&format!("(defvar x '({}))", "a 'b ".repeat(MANY)));
    assert_eq!(count(&found, "quote-in-data"), MANY);
    // The last one stands where it stands.
    let last = 12 + 5 * (MANY - 1) + 2 + 1;
    assert!(told.contains(&format!("test:1:{last} ]")), "{}", &told[told.len() - 400..]);
    // Each in a line of its own that a comment allows, but for one.
    let allowed = "(print (cos 60)) ; check: allow angle-without-unit\n".repeat(MANY);
    let (found, _) = self::told(&format!("(print (cos 60)) (print 'ä)\n\n{allowed}"));
    assert_eq!(count(&found, "angle-without-unit"), 1);
}

#[test]
fn what_is_told_of_two_places_far_from_each_other_shows_both() {
    let text = format!("(defun first-of (x) x)\n{}(defun first-of (x) (list x))", "\n".repeat(2_000));
    let (found, drawn) = told(&text);
    assert_eq!(count(&found, "duplicate-definition"), 1);
    assert!(drawn.contains("test:2002:8 ]") && drawn.contains("test:1:8 ]"), "{drawn}");
    assert!(drawn.contains("first defined here") && drawn.contains("defined again here"), "{drawn}");
    let (found, drawn) = told(&"(defun f (x) x)\n".repeat(MANY));
    assert_eq!(count(&found, "duplicate-definition"), MANY - 1);
    assert!(drawn.ends_with('\n'));
}

#[test]
fn fluents_that_are_waited_for_and_taken_many_times_over() {
    // In one function, where each wait is behind all others, and branches and loops come between.
    let waits = |n: usize| {
        format!("(wait-for (> f{n} 0)) (when (print 1) (print 2)) (dotimes (i 2) (print i)) (decf (value f{n}))\n")
    };
    let fluents: String = (0..2_000).map(|n| format!("(def-fluent f{n} 1)\n")).collect();
    let body: String = (0..2_000).map(waits).collect();
    let (found, _) = told(&format!("{fluents}(def-plan p () {body})\n(par (p) (p))"));
    assert!(count(&found, "wait-then-take") > 0);
    // Or all first, and all taken afterwards.
    let before: String = (0..2_000).map(|n| format!("(wait-for (> f{n} 0)) (when (print 1) (print 2))\n")).collect();
    let after: String = (0..2_000).map(|n| format!("(decf (value f{n}))\n")).collect();
    let (found, _) = told(&format!("{fluents}(def-plan p () {before}{after})\n(par (p) (p))"));
    assert!(count(&found, "wait-then-take") > 0);
    // In functions of their own.
    let each = |n: usize| format!("(def-plan p{n} () (wait-for (> f{n} 0)) (decf (value f{n}))) (par (p{n}) (p{n}))\n");
    let (found, _) = told(&format!("{fluents}{}", (0..2_000).map(each).collect::<String>()));
    assert!(count(&found, "wait-then-take") > 0);
}
