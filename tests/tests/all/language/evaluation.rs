//! Evaluation: order, scope, definitions, numbers.

use rpl_tests::{check, run};

/// r[eval.whole], r[eval.order], r[eval.unbound]
#[test]
fn names_are_resolved_before_anything_runs() {
    let unbound = run("(print 'runs) (nowhere)");
    assert!(unbound.starts_with("error[unbound-name]"), "{unbound}");
    let arity = run("(defun f (a) a) (print 'runs) (f 1 2)");
    assert!(arity.starts_with("error[arity]"), "{arity}");
    check("(defun f () (g)) (defun g () 'later) (f)", "=> later");
    check("(defun f () x) (ignore-failures (unbound-variable) (print (f))) (defvar x 1) (f)", "=> 1");
}

/// r[eval.scope]
#[test]
fn one_namespace_and_lexical_scope() {
    check("(defun twice (f x) (f (f x))) (twice 1+ 3)", "=> 5");
    check("(let ((x 1)) (let ((f (lambda () x))) (let ((x 2)) (f))))", "=> 1");
    check("(let ((list (lambda (x) (* x 10)))) (list 4))", "=> 40");
}

/// r[eval.tail]
#[test]
fn tail_calls_do_not_grow() {
    check("(defun down (n) (if (= n 0) 'done (down (- n 1)))) (down 3000000)", "=> done");
    check(
        "(defun even? (n) (if (= n 0) t (odd? (- n 1)))) (defun odd? (n) (if (= n 0) nil (even? (- n 1)))) (even? 2000000)",
        "=> t",
    );
}

/// r[value.numbers], r[value.division], r[value.overflow]
#[test]
fn numbers() {
    check("(list (/ 6 3) (/ 7 2) (+ 1 2.0) (= 1 1.0) (equal 1 1.0))", "=> (2 3.5 3.0 t nil)");
    check("(with-failure-handling ((arithmetic-error () 'overflow)) (* 9223372036854775807 2))", "=> overflow");
    check("(with-failure-handling ((type-error () 'type)) (+ 1 'a))", "=> type");
}

/// r[loop.words], r[loop.value]
#[test]
fn loops_and_their_values() {
    check("(let ((i 0)) (loop (incf i) until (= i 5)) i)", "=> 5");
    check("(let ((i 0)) (loop while (< i 3) (incf i)))", "=> nil");
    check("(dolist (x '(1 2 3)) (if (= x 2) (return x)))", "=> 2");
    check("(let ((n 0)) (n-times 5 (incf n) until (= n 3)) n)", "=> 3");
}

/// r[def.macro], r[def.parameters]
#[test]
fn macros_and_optional_parameters() {
    check(
        "(defmacro swap (a b) (let ((c (gensym))) `(let ((,c ,a)) (setf ,a ,b) (setf ,b ,c)))) (let ((x 1) (y 2)) (swap x y) (list x y))",
        "=> (2 1)",
    );
    check(
        "(defun f (a &optional (b (* a 2)) &key (c 3)) (list a b c)) (list (f 1) (f 1 5) (f 1 5 :c 7))",
        "=> ((1 2 3) (1 5 3) (1 5 7))",
    );
}

/// r[eval.redefine]
#[test]
fn a_library_name_may_be_redefined() {
    check("(defun length (x) 'mine) (list (length '(1 2)) (sort < '(3 1 2)))", "=> (mine (1 2 3))");
}
