//! Values of fluents never change: a place within one is assigned by assigning a copy.

use rpl_lang::compile::NoFiles;
use rpl_runtime::robot::NoRobot;
use rpl_runtime::run::system::System;
use rpl_tests::{check, library, run};

/// Forms that change `x` in place, by what it is.
const CHANGES: [(&str, &str); 9] = [
    ("(list 1 2 3)", "(setf (nth 1 x) 9)"),
    ("(list 1 2 3)", "(setf (cdr x) nil)"),
    ("(list 1 (list 2 3))", "(push 9 (cdr (second x)))"),
    ("(vector 1 2)", "(setf (vref x 0) 9)"),
    ("(vector 1 (list 2))", "(setf (first (vref x 1)) 9)"),
    ("(alist->hash-table '((a . 1)))", "(setf (gethash 'a x) 9)"),
    ("(alist->hash-table '((a . 1)))", "(remhash 'a x)"),
    ("(alist->hash-table (list (cons 'a (list 1 2))))", "(incf (second (gethash 'a x)))"),
    ("(make-state :battery 1)", "(setf (state-battery x) 9)"),
];

/// r[fluent.frozen]
#[test]
fn what_a_fluent_has_is_not_changed_in_place() {
    for (value, change) in CHANGES {
        for assigned in [format!("(def-fluent f {value})"), format!("(def-fluent f nil) (setf (value f) {value})")] {
            let told = run(&format!("(defstruct state battery) {assigned} (let ((x (value f))) {change})"));
            assert!(told.starts_with("failed: type-error: this ") && told.contains("never change"), "{change}: {told}");
            // Nor what it had.
            let told =
                run(&format!("(defstruct state battery) {assigned} (let ((x (value f))) (setf (value f) 1) {change})"));
            assert!(told.contains("never change"), "{change}: {told}");
        }
        // What no fluent has had is changed as ever, also a value made of the same parts.
        let free = run(&format!("(defstruct state battery) (let ((x {value})) {change}) 'free"));
        assert_eq!(free, "=> free", "{change}");
    }
    check(
        "(def-fluent f (list 1 2 3)) (let ((x (copy-list (value f)))) (setf (nth 1 x) 9) (list x (value f)))",
        "=> ((1 9 3) (1 2 3))",
    );
    check("(def-fluent f (list 1)) (let ((x (value f))) (push 2 x) x)", "=> (2 1)");
}

/// r[fluent.frozen]
#[test]
fn a_copy_of_a_run_and_a_saved_one_know_what_is_frozen() {
    let text = "(def-fluent f (list 1 (vector 2) (alist->hash-table '((a . 1))))) (defvar x (value f))
         (wait-time 1)
         (print (map (lambda (change) (with-failure-handling ((type-error () 'kept)) (change)))
                     (list (lambda () (setf (first x) 9))
                           (lambda () (setf (vref (second x) 0) 9))
                           (lambda () (setf (gethash 'a (third x)) 9)))))";
    let mut system = rpl_tests::system(text);
    system.run_until(500_000);
    let saved = system.save();
    let loaded =
        library().load("test.rpl", text, &mut NoFiles).unwrap_or_else(|found| panic!("{}", found.render(false)));
    let loaded = System::load(&saved, library().clone(), loaded, NoRobot).unwrap_or_else(|error| panic!("{error}"));
    for copy in &mut [system.clone(), system, loaded] {
        copy.run_until(5_000_000);
        assert!(rpl_tests::transcript(copy).starts_with("(kept kept kept)"));
    }
}

/// r[fluent.within]
#[test]
fn a_place_within_a_value_is_assigned_by_a_copy_that_is_seen() {
    let places = [
        ("(list 1 2 3)", "(setf (nth 1 (value f)) 9)", "9 (1 9 3)"),
        ("(list 1 2 3)", "(setf (second (value f)) 9)", "9 (1 9 3)"),
        ("(list 1 2 3)", "(setf (cddr (value f)) '(9))", "(9) (1 2 9)"),
        ("(list 1 2 3)", "(setf (elt (value f) 2) 9)", "9 (1 2 9)"),
        ("(list (list 1 2) 3)", "(setf (cdar (value f)) 9)", "9 ((1 . 9) 3)"),
        ("(list 1 (vector 2 (list 3 4)))", "(setf (car (vref (nth 1 (value f)) 1)) 9)", "9 (1 #(2 (9 4)))"),
        ("(list 1 2 3)", "(incf (first (value f)) 5)", "6 (6 2 3)"),
        ("(list 1 2 3)", "(push 9 (cdr (value f)))", "(9 2 3) (1 9 2 3)"),
        ("(list (list 1 2) 3)", "(pop (first (value f)))", "1 ((2) 3)"),
        ("(vector 1 2)", "(setf (vref (value f) 1) 9)", "9 #(1 9)"),
        ("(vector 1 2)", "(setf (elt (value f) 1) 9)", "9 #(1 9)"),
        ("(make-state :battery 1 :pose (list 2 3))", "(setf (second (state-pose (value f))) 9)", "9 (state 1 (2 9))"),
    ];
    for (value, change, expected) in places {
        let text = format!(
            "(defstruct state battery pose)
             (def-fluent f {value})
             (defvar before (value f))
             (def-fluent rounds 0)
             (with-policy (whenever (changed f) (incf (value rounds)))
               (seq (wait-time 1) (print (format \"~s ~s\" {change} (value f))) (wait-time 1)))
             (list (value rounds) (equal before {value}))"
        );
        check(&text, &format!("{expected}\n=> (1 t)"));
    }
    check(
        "(def-fluent f (make-hash-table))
         (setf (gethash 'a (value f)) 1)
         (incf (gethash 'a (value f)) 4)
         (push 'k (gethash 'b (value f)))
         (list (gethash 'a (value f)) (gethash 'b (value f)))",
        "=> (5 (k))",
    );
    // The arguments of the place are evaluated once.
    check(
        "(def-fluent f (list 1 2 3)) (defvar n 0)
         (incf (nth (incf n) (value (progn (print 'once) f))))
         (list n (value f))",
        "once\n=> (1 (1 3 3))",
    );
    for (change, part) in [
        ("(setf (nth 7 (value f)) 9)", "index-error: there is no element 7 to set"),
        ("(setf (vref (value f) 0) 9)", "type-error: "),
        ("(setf (nth -1 (value f)) 9)", "type-error: the position must be an integer from 0 on"),
        ("(setf (nth 0 (value 7)) 9)", "type-error: "),
    ] {
        let told = run(&format!("(def-fluent f (list 1 2 3)) {change}"));
        assert!(told.contains(part), "{change}: {told}");
    }
    let told = run("(def-fluent f 1) (setf (no-slot (value f)) 9)");
    assert!(told.starts_with("error[not-a-place]"), "{told}");
}

/// r[fluent.within], r[limit.steps]
#[test]
fn what_is_copied_counts_as_steps() {
    for value in ["(alist->hash-table (map (lambda (i) (cons i i)) (iota 1000)))", "(make-vector 1000 0)"] {
        let accessor = if value.starts_with("(make") { "vref (value f) 7" } else { "gethash 7 (value f)" };
        let mut system =
            rpl_tests::system(&format!("(def-fluent f {value}) (wait-time 1) (dotimes (i 50) (setf ({accessor}) i))"));
        system.machine.limits.steps = 20_000;
        while system.advance() == rpl_runtime::run::system::Progress::Running {}
        let told = rpl_tests::transcript(&mut system);
        assert!(told.starts_with("failed: runaway"), "{value}: {told}");
    }
}

/// r[fluent.within]
#[test]
fn what_comes_to_the_front_of_a_long_value_costs_no_walk() {
    let work = |length: usize| {
        let text = format!(
            "(def-fluent f (range 0 {length})) (dotimes (i 50) (push i (value f)) (setf (first (value f)) nil))"
        );
        let mut system = rpl_tests::system(&text);
        system.run_until(1);
        assert!(system.outcome().is_some());
        system.machine.work()
    };
    let (short, long) = (work(10), work(20_000));
    assert!(long < short + 2 * 20_000, "10 elements cost {short}, 20,000 cost {long}");
}
