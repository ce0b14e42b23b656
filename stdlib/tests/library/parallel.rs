//! Values of all children, and a limited number of children at a time.

use crate::evaluate::{check, check_failures};

/// r[map.most]
#[test]
fn so_many_children_at_a_time() {
    check(&[
        (
            "(defvar at 0) (defvar most 0) (defvar began nil)
             (par-map (i (range 0 6) :most 2)
               (incf at) (setq most (max most at)) (push (list i (now)) began) (wait-time 1) (decf at))
             (list most (reverse began) (now))",
            "(2 ((0 0.0) (1 0.0) (2 1.0) (3 1.0) (4 2.0) (5 2.0)) 3.0)",
        ),
        // The next begins as soon as one ends.
        ("(par-map (s '(5 1 1 1) :most 2) (wait-time s) (now))", "3.0"),
        ("(list (par-map (i '(1 2 3) :most 9) i) (par-map (i nil :most 1) i))", "(3 nil)"),
        ("(par-map (i (range 0 100000) :most 1) i)", "99999"),
        // After a failure no child begins any more.
        (
            "(defvar began nil)
             (ignore-failures (plan-failure) (par-map (i (range 0 5) :most 2) (push i began) (wait-time 1) (if (= i 1) (fail))))
             (reverse began)",
            "(0 1)",
        ),
        ("(list (try-all-map (i '(1 2 3 4) :most 1) (wait-time 1) (if (< i 3) (fail) i)) (now))", "(3 3.0)"),
        // A child that is evaporated makes room; one that had not begun made none.
        (
            "(defvar began nil)
             (def-plan all ()
               (par (par-map (i (range 0 5) :most 2) (push (list i (now)) began) (wait-time 10))
                    (seq (wait-time 1) (evaporate (task \"main/all/par[0]/par-map[3]\")) (wait-time 1)
                         (evaporate (task \"main/all/par[0]/par-map[0]\")))))
             (all)
             (reverse began)",
            "((0 0.0) (1 0.0) (2 2.0) (4 10.0))",
        ),
    ]);
    check_failures(&[
        (
            "(par-map (i '(1 2) :most 0) i)",
            "`:most` of `par-map` must be an integer from 1 on, and it is the integer 0",
        ),
        ("(settle-map (i '(1 2) :most 1.5) i)", "`:most` of `settle-map` must be an integer from 1 on"),
        ("(par-map (i '(1 2) :least 1) i)", "this is not of the form `(par-map (NAME LIST [:most N]) FORM...)`"),
        ("(pursue-map (i '(1 2) :most 1) i)", "those that wait for their turn would never begin"),
    ]);
}

/// r[gather.values]
#[test]
fn gather_has_the_values_of_all_in_their_order() {
    check(&[
        ("(gather (seq (wait-time 3) 'a) (seq (wait-time 1) 'b) 'c)", "(a b c)"),
        ("(list (gather-map (s '(3 1 2)) (wait-time s) (* 10 s)) (now))", "((30 10 20) 3.0)"),
        ("(list (gather-map (s '(3 1 2) :most 1) (wait-time s) (* 10 s)) (now))", "((30 10 20) 6.0)"),
        ("(list (gather) (gather-map (x nil) x))", "(nil nil)"),
        // One that is evaporated has no value.
        (
            "(def-plan two () (par (seq (wait-time 1) (evaporate b)) (gather 'a (:tag b (wait-time 5)) 'c))) (two)",
            "(a nil c)",
        ),
        ("(let ((all (gather-map (i (range 0 100000)) i))) (list (length all) (nth 99999 all)))", "(100000 99999)"),
    ]);
    check_failures(&[
        ("(gather 'a (seq (wait-time 1) (fail \"gone\")) (wait-time 9))", "plan-failure: gone"),
        ("(wait-for (gather 1))", "`gather` cannot stand in a fluent network"),
    ]);
}

/// r[settle.values]
#[test]
fn settle_has_failures_among_the_values() {
    check(&[
        (
            "(map (lambda (end) (if (failurep end) (failure-message end) end))
                  (settle (seq (wait-time 3) 'a) (fail \"x\") (seq (wait-time 2) (fail \"y\")) 'd))",
            "(a \"x\" \"y\" d)",
        ),
        (
            "(list (map failurep (settle-map (i (range 0 5) :most 2) (wait-time 1) (if (evenp i) (fail) i))) (now))",
            "((t nil t nil t) 3.0)",
        ),
        ("(list (settle) (settle-map (x nil) x))", "(nil nil)"),
        // It waits for all, and a failure of the task around it is no child's.
        ("(ignore-failures (timeout) (with-timeout 2 (settle (fail) (wait-time 9))))", "nil"),
        (
            "(def-plan two () (par (seq (wait-time 1) (evaporate b)) (settle 'a (:tag b (wait-time 5))))) (two)",
            "(a nil)",
        ),
    ]);
}
