//! Macros of plans: nested parameter lists, places of what they pass on, what follows from a wrong one.

use crate::evaluate::{check, check_failures, evaluate, library};
use rpl_runtime::run::system::{Progress, System};
use rpl_runtime::state::value::Value;

/// r[def.nested-parameters]
#[test]
fn parameter_lists_are_nested() {
    check(&[
        (
            "(defmacro with-header ((name value) &rest body) `(let ((,name ,value)) ,@body))
             (with-header (x 1) (destructuring-bind (a (b c)) '(1 (2 3)) (list x a b c)))",
            "(1 1 2 3)",
        ),
        ("(destructuring-bind (a (b &optional (c (+ a b) given))) '(1 (2)) (list a b c given))", "(1 2 3 nil)"),
        (
            "(destructuring-bind ((a &rest b) &optional ((c d) '(8 9)) &rest e) '((1 2 3)) (list a b c d e))",
            "(1 (2 3) 8 9 nil)",
        ),
        ("(destructuring-bind (a &key (b a) (c 3 c?) d) '(1 :d 4 :b 5) (list a b c c? d))", "(1 5 3 nil 4)"),
        ("(destructuring-bind (a &rest all &key b) '(1 :c 2 :b 3) (list a all b))", "(1 (:c 2 :b 3) 3)"),
        ("(destructuring-bind () nil 7)", "7"),
        ("(defmacro m ((a (b)) &key (c b)) `(list ,a ,b ,c)) (list (m (1 (2))) (m (1 (2)) :c 3))", "((1 2 2) (1 2 3))"),
        ("(let ((f (destructuring-bind (a (b)) '(1 (2)) (lambda () (setq b (+ a b)))))) (f) (f))", "4"),
        (
            "(let ((n 0)) (dolist (pair '((a 1) (b 2))) (destructuring-bind (name (x)) (list (first pair) (rest pair)) (when (eq name 'b) (return (+ n x))))))",
            "2",
        ),
    ]);
    check_failures(&[
        ("(destructuring-bind (a (b c)) '(1 (2)) 1)", "arity-error: `(b c)` takes 2 elements, and the list has 1: (2)"),
        ("(destructuring-bind (a b) '(1 2 3) 1)", "arity-error: `(a b)` takes 2 elements, and the list has 3: (1 2 3)"),
        (
            "(destructuring-bind (a (b c)) '(1 2) 1)",
            "type-error: what `(b c)` takes apart must be a list, and it is the integer 2",
        ),
        ("(destructuring-bind (a &rest b) nil 1)", "takes at least 1 element, and the list has 0: nil"),
        ("(destructuring-bind (a &optional b) '(1 2 3) 1)", "takes 1 to 2 elements"),
        ("(destructuring-bind (&key a) '(:b 1) 1)", "`(&key a)` takes the keywords :a, not `:b`"),
        ("(destructuring-bind (&key a) '(:a) 1)", "`:a` has no value"),
        (
            "(let ((l (list 1 2))) (setf (cdr (cdr l)) l) (destructuring-bind (a b) l 1))",
            "a list that runs in a circle",
        ),
        ("(defmacro m ((a b)) a) (m (1))", "`(a b)` takes 2 elements, and the list has 1: (1)"),
        ("(defun f ((a b)) a) (f '(1 2))", "a parameter must be a name"),
        ("(destructuring-bind (a 3) '(1 2) 1)", "a parameter must be a name"),
        ("(destructuring-bind (&key ((c 3))) nil c)", "a parameter must be a name"),
        ("(destructuring-bind (a . b) '(1 2) 1)", "a parameter list is missing"),
    ]);
}

/// How many errors a text has.
fn errors(text: &str) -> usize {
    evaluate(text).err().map_or(0, |faults| faults.matches("error[").count())
}

/// r[def.macro-broken]
#[test]
fn one_wrong_macro_gives_one_error() {
    for text in [
        "(defmacro with-header ((name 3) &rest body) `(let ((,name 1)) ,@body)) (with-header (x 1) (list x y)) (print (with-header (z 1) z))",
        "(defun f ((a b) c) (list a b c)) (f 1 2)",
        "(defstruct parcel (item 1 2)) (print (parcel-item (make-parcel :item 1)))",
        "(dolist (x) (print x))",
    ] {
        assert_eq!(errors(text), 1, "{text}: {:?}", evaluate(text));
    }
    // What has nothing to do with it is told.
    assert_eq!(errors("(defstruct parcel (item 1 2)) (print (parcl-weight 1))"), 2);
}

/// The text at the place of the failure that a plan ends with.
fn failing_text(text: &str) -> String {
    let mut system =
        System::without_robot(library(), "test", text, 0).unwrap_or_else(|found| panic!("{}", found.render(false)));
    while system.advance() == Progress::Running {}
    system.with_machine(|machine, around| match *machine.tasks[machine.main].value() {
        Value::Failure(failure) => {
            let place = machine.heap.failures[failure].span.expect("it has a place");
            around.program.sources.text_of(place).to_string()
        }
        _ => panic!("{text} does not fail"),
    })
}

/// r[def.macro-place]
#[test]
fn what_a_macro_passes_on_keeps_its_place() {
    for (text, place) in [
        ("(dolist (q '(1)) (when t (print v))) (defvar v 1)", "v"),
        ("(when v (print 1)) (defvar v 1)", "v"),
        ("(when v (print v)) (defvar v 1)", "v"),
        ("(cond (nil 1) (v 2)) (defvar v 1)", "v"),
        ("(cond (v)) (defvar v 1)", "v"),
        ("(dolist (x v) (print x)) (defvar v 1)", "v"),
        ("(case v (1 2)) (defvar v 1)", "v"),
        ("(unless nil (print (when t (list 1 (+ 2 v))))) (defvar v 1)", "v"),
        ("(defmacro m (x) `(list ,x 1)) (m (+ 1 v)) (defvar v 1)", "v"),
        ("(when t (when t (/ 1 0)))", "(/ 1 0)"),
        // What stands twice in the call is not told apart.
        ("(defmacro m (a b) `(list ,a ,b)) (m v v) (defvar v 1)", "(m v v)"),
        ("(let ((x 'a)) (incf x))", "(incf x)"),
    ] {
        assert_eq!(failing_text(text), place, "{text}");
    }
}
