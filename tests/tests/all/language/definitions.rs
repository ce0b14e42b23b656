//! What a text defines, and the forms that order and bind.

use rpl_tests::{check, run};

#[track_caller]
fn refused(text: &str, code: &str) {
    let found = run(text);
    assert!(found.starts_with(&format!("error[{code}]")), "{text}\n{found}");
}

/// r[def.top-level]
#[test]
fn definitions_stand_at_the_top_level() {
    check("(progn (defvar a 1) (defun f () (+ a 1))) (f)", "=> 2");
    check("(defmacro two (a b) `(progn (defvar ,a 1) (defvar ,b 2))) (two x y) (list x y)", "=> (1 2)");
    for definition in ["(defvar a 1)", "(defun f () 1)", "(def-plan p () 1)", "(def-fluent f 1)", "(def-valve v)"] {
        refused(&format!("(let () {definition})"), "definition-inside");
    }
}

/// r[def.variable]
#[test]
fn variables_and_constants() {
    check("(defvar a) (defvar b 2) (setq b (+ b 1)) (list a b)", "=> (nil 3)");
    refused("(defconstant c 1) (setq c 2)", "assigns-constant");
}

/// r[def.plan], r[plan.node]
#[test]
fn a_plan_is_called_like_a_function_and_is_a_node() {
    check(
        "(def-interp-proc inner (&key (to 'home)) (par (print (list to (task-path (this-task))))))
         (def-plan outer () (inner :to 'shelf) (inner))
         (defun not-a-plan () (task-path (this-task)))
         (outer) (not-a-plan)",
        "(shelf \"main/outer/inner/par[0]\")\n(home \"main/outer/inner.2/par[0]\")\n=> \"main\"",
    );
}

/// r[eval.plan-call]
#[test]
fn a_plan_call_is_no_tail_call() {
    let result = run("(def-plan p () (p)) (p)");
    assert!(result.starts_with("failed: stack-overflow"), "{result}");
}

/// r[def.doc]
#[test]
fn a_string_before_the_body_is_documentation() {
    check("(defun f () \"doc\" 1) (defvar v 2 \"doc\") (defun g () \"value\") (list (f) v (g))", "=> (1 2 \"value\")");
}

/// r[def.macro], r[eval.order]
#[test]
fn macros_write_forms() {
    check(
        "(defun sum-of (names) (cons '+ names))
         (defmacro sum (&rest names) (sum-of names))
         (defmacro either (a &optional (b 7) &key (c 9)) `(list ,a ,b ,c))
         (defmacro in-order (a &body forms) `(list ,a (progn ,@forms)))
         (list (sum 1 2 3) (either 1) (either 1 2 :c 3) (in-order 1 2 3))",
        "=> (6 (1 7 9) (1 2 3) (1 3))",
    );
    // The name made by `gensym` cannot be meant by the argument.
    check(
        "(defmacro twice (form) (let ((name (gensym))) `(let ((,name ,form)) (list ,name ,name))))
         (let ((n 0)) (list (twice (incf n)) n))",
        "=> ((1 1) 1)",
    );
    refused("(m) (defmacro m () 1)", "macro-before-definition");
    refused("(defmacro m () (helper)) (m) (defun helper () 1)", "macro");
    refused("(defmacro m () (wait-time 1)) (m)", "macro");
}

/// r[def.goal]
#[test]
fn the_methods_of_a_goal_are_tried_in_order() {
    let methods = "(def-goal (achieve (clean room)) \"doc\" (print 'sweep) (fail \"no broom\"))
                   (def-goal (achieve (clean place)) (print (list 'wipe place (task-path (this-task)))) 'wiped)
                   (def-goal (achieve (clean room)) (print 'never))";
    // A goal may be used above its methods.
    check(
        &format!("(print (achieve (clean 'hall))) {methods} (now)"),
        "sweep\n(wipe hall \"main/achieve-clean/achieve-clean#2\")\nwiped\n=> 0.0",
    );
    check(
        "(def-goal (achieve (a n)) (wait-time n) (fail \"one\")) (def-goal (achieve (a n)) (fail \"two\"))
         (with-failure-handling ((composite-failure (f) (list (now) (map failure-message (failure-parts f)))))
           (achieve (a 2)))",
        "=> (2.0 (\"one\" \"two\"))",
    );
    check("(def-goal (achieve (only)) (fail \"itself\")) (achieve (only))", "failed: plan-failure: itself");
    refused("(def-goal (achieve (a n)) 1) (def-goal (achieve (a n m)) 1)", "goal-parameters");
    refused("(def-goal (achieve (a n)) 1) (achieve (a))", "arity");
    let unknown = run("(achieve (nowhere 1))");
    assert!(unknown.contains("(def-goal (achieve (nowhere PARAMETER...)) FORM...)"), "{unknown}");
}

/// r[def.struct], r[setf.places]
#[test]
fn a_record_has_slots_that_are_places() {
    let parcel = "(defstruct parcel item (weight 2)) ";
    check(
        &format!(
            "{parcel} (let ((p (make-parcel :item 'book)) (n 0))
               (setf (parcel-item p) 'mail)
               (incf (parcel-weight (progn (incf n) p)) 3)
               (list p (parcel-item p) n))"
        ),
        "=> ((parcel mail 5) mail 1)",
    );
    check(
        &format!(
            "{parcel} (let ((p (make-parcel)))
               (let ((q (copy-parcel p)))
                 (setf (parcel-item q) 'other)
                 (list (parcel-p p) (parcel-p '(1 2)) (parcel-p 3) (equal p q) (equal p (make-parcel)))))"
        ),
        "=> (t nil nil nil t)",
    );
    // Used above its definition.
    check(&format!("(let ((p (make-parcel))) (push 1 (parcel-item p)) p) {parcel} 'read"), "=> read");
    let wrong = run(&format!("{parcel} (parcel-item '(letter 1))"));
    assert!(wrong.starts_with("failed: type-error: this must be a `parcel`, and it is (letter 1)"), "{wrong}");
    let wrong = run(&format!("{parcel} (setf (parcel-weight '(letter 1)) 2)"));
    assert!(wrong.starts_with("failed: type-error: this must be a `parcel`, and it is (letter 1)"), "{wrong}");
    // A list that somebody has made may be shorter than its kind says.
    check(&format!("{parcel} (parcel-weight '(parcel book))"), "=> nil");
    let short = run(&format!("{parcel} (setf (parcel-weight (list 'parcel 'book)) 2)"));
    assert!(short.starts_with("failed: index-error: there is no element 2 to set: the length is 2"), "{short}");
    // A slot as a function, and in a network.
    check(&format!("{parcel} (map parcel-weight (list (make-parcel :weight 3) (make-parcel)))"), "=> (3 2)");
    let network = run(&format!(
        "{parcel} (defvar p (make-parcel)) (defun heavier () (incf (parcel-weight p))) (def-fluent f 1) (wait-for (and (heavier) f))"
    ));
    assert!(network.contains("a slot cannot be assigned while a fluent network"), "{network}");
    let few = run(&format!("{parcel} (setf (parcel-item) 2)"));
    assert!(few.starts_with("error[arity]: `parcel-item` takes 1 argument, and 0 are given"), "{few}");
    refused("(setf (nowhere 1) 2)", "not-a-place");
    refused("(setf 3 2)", "not-a-place");
    refused("(let ((%set-x 1)) (setf (x 1) 2))", "not-a-place");
}

/// r[setf.places]
#[test]
fn places_and_their_arguments() {
    check(
        "(def-fluent f 1)
         (let ((l (list 1 2 3)) (h (make-hash-table)) (v 0))
           (setf v 9 (value f) 8 (nth 1 l) 'b (car l) 'a (gethash 'k h) 5)
           (list v (value f) l (gethash 'k h) (setf (second l) 'c (third l) 'd) l))",
        "=> (9 8 (a c d) 5 d (a c d))",
    );
    check("(let ((n 0) (l (list 1 2))) (incf (nth (progn (incf n) 0) l) 5) (list n l))", "=> (1 (6 2))");
    check(
        "(let ((h (make-hash-table))) (push 1 (gethash 'k h)) (incf (gethash 'n h 0)) (list (gethash 'k h) (pop (gethash 'k h)) (gethash 'n h)))",
        "=> ((1) 1 1)",
    );
}

/// r[control.conditions]
#[test]
fn conditions_and_their_values() {
    check(
        "(list (if 0 1 2) (if nil 1) (cond (nil 1)) (cond ((assoc 'b '((a . 1) (b . 2))))) (case 3 (1 2)))",
        "=> (1 nil nil (b . 2) nil)",
    );
    check(
        "(list (case \"x\" (\"x\" 'same)) (case 2.5 ((1 2.5) 'float)) (case 'z (otherwise 'else)) (cond (nil 1) (else 2)))",
        "=> (same float else 2)",
    );
    check("(list (and) (or) (and 1 nil 2) (or nil 3) (when 1 2 3) (unless 1 2))", "=> (t nil nil 3 3 nil)");
}

/// r[control.binding]
#[test]
fn what_the_names_of_let_mean() {
    check("(let ((x 1)) (list (let ((x 2) (y x)) y) (let* ((x 2) (y x)) y)))", "=> (1 2)");
    check(
        "(letrec ((even (lambda (n) (if (= n 0) t (odd (- n 1))))) (odd (fn (n) (if (= n 0) nil (even (- n 1)))))) (even 101))",
        "=> nil",
    );
    check("(list (flet ((f (x) (* x 2))) (f 3)) (labels ((g (n) (if (= n 0) 'end (g (- n 1))))) (g 5)))", "=> (6 end)");
    check("(list (prog1 1 2) (destructuring-bind (a &optional (b 2)) '(1) (list a b)))", "=> (1 (1 2))");
    check("(do ((i 0 (+ i 1)) (seen nil (cons i seen)) (fixed 7)) ((= i 3) (list seen fixed)))", "=> ((2 1 0) 7)");
}

/// r[eval.forms]
#[test]
fn each_form_is_a_plan_body_of_its_own() {
    check("(print 1) (wait-time 2) (print (now)) 'last", "1\n2.0\n=> last");
    check("", "=> nil");
    refused("(:tag a 1) (evaporate a)", "unbound-name");
}
