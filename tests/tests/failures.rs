//! Failures, handlers and clean-ups.

use rpl_tests::run;

#[track_caller]
fn check(text: &str, expected: &str) {
    assert_eq!(run(text), expected, "{text}");
}

#[test]
fn the_first_clause_that_fits_takes_the_failure() {
    check(
        "(def-failure lost (plan-failure) (where)) (def-failure very-lost (lost) (how)) (with-failure-handling ((timeout () 1) (lost (f) (list (failure-class f) (failure-slot f 'where) (failure-slot f 'how))) (failure () 3)) (fail very-lost \"~a\" 'x :where 'here :how 7))",
        "=> (very-lost here 7)",
    );
    check("(fail \"a ~a\" 1)", "failed: plan-failure: a 1");
}

#[test]
fn the_body_is_clean_before_the_handler_runs() {
    check(
        "(with-failure-handling ((failure () (print 'handler) 'value)) (unwind-protect (fail \"x\") (print 'clean)))",
        "clean\nhandler\n=> value",
    );
}

#[test]
fn retry_and_refail() {
    check(
        "(with-retry-counters ((c 3)) (with-failure-handling ((failure () (do-retry c (retry)) 'spent)) (print 'try) (fail \"x\")))",
        "try\ntry\ntry\ntry\n=> spent",
    );
    check(
        "(with-failure-handling ((failure (f) (failure-message f))) (with-failure-handling ((failure () (print 'inner) (refail))) (fail \"x\")))",
        "inner\n=> \"x\"",
    );
    check(
        "(with-failure-handling ((failure (f) (failure-message f))) (with-failure-handling ((failure () (fail \"second\"))) (fail \"first\")))",
        "=> \"second\"",
    );
}

#[test]
fn failures_of_children_are_caught() {
    check(
        "(with-failure-handling ((failure (f) (failure-message f))) (par (wait-time 5) (par (seq (wait-time 1) (fail \"deep\")))))",
        "=> \"deep\"",
    );
}

#[test]
fn evap_protect_runs_only_when_cut_short() {
    check("(evap-protect (seq 1) (print 'no))", "=> 1");
    check("(block b (evap-protect (return-from b 2) (print 'left)))", "left\n=> 2");
    check("(dotimes (i 3) (evap-protect (if (= i 1) (return i)) (print 'left)))", "left\n=> 1");
    check(
        "(with-retry-counters ((c 1)) (with-failure-handling ((failure () (do-retry c) 'end)) (evap-protect (fail \"x\") (print 'left))))",
        "left\nleft\n=> end",
    );
}

#[test]
fn clean_ups_run_innermost_first_and_keep_the_value() {
    check("(unwind-protect (unwind-protect 1 (print 'inner)) (print 'outer))", "inner\nouter\n=> 1");
    check(
        "(pursue (unwind-protect (unwind-protect (wait-time 9) (seq (wait-time 1) (print 'inner))) (print 'outer)) (seq (wait-time 1) 'won))",
        "inner\nouter\n=> won",
    );
}

#[test]
fn a_failing_clean_up() {
    check("(unwind-protect 1 (fail \"clean\"))", "failed: plan-failure: clean");
    check(
        "(with-failure-handling ((failure (f) (list (failure-message f) (map failure-message (failure-while-cleaning-up f)))))
           (unwind-protect (unwind-protect (fail \"first\") (fail \"second\")) (seq (print 'still) (fail \"third\"))))",
        "still\n=> (\"first\" (\"second\" \"third\"))",
    );
    check(
        "(pursue (unwind-protect (wait-time 9) (fail \"x\")) (wait-time 1))",
        "log: warning: a failure in a clean-up during evaporation: plan-failure: x\n=> nil",
    );
}

#[test]
fn a_clean_up_may_use_everything() {
    check(
        "(def-valve v)
         (pursue (unwind-protect (wait-time 9)
                   (seq (par (wait-time 1) (ignore-failures (timeout) (with-timeout 2 (wait-time 5)))) (with-valve v (print (now)))
                        (with-failure-handling ((failure () (print 'handled))) (fail \"inside\"))
                        (block b (return-from b 1))))
                 (wait-time 1))
         (now)",
        "3.0\nhandled\n=> 3.0",
    );
}

#[test]
fn a_clean_up_is_not_evaporated() {
    check(
        "(with-failure-handling ((failure (f) (list (failure-message f) (now))))
           (par (unwind-protect (wait-time 1) (seq (wait-time 3) (print 'cleaned)))
                (seq (wait-time 2) (fail \"x\"))))",
        "cleaned\n=> (\"x\" 4.0)",
    );
}

#[test]
fn blocks_are_left_from_closures_but_not_across_tasks() {
    check("(block b (for-each (lambda (x) (if (> x 1) (return-from b x))) '(1 2 3)))", "=> 2");
    check("(block b (let ((f (lambda () (return-from b 'out)))) (evap-protect (f) (print 'clean))))", "clean\n=> out");
    let visible = run("(block b (par (return-from b 1)))");
    assert!(visible.starts_with("error[leaves-task]"), "{visible}");
    let hidden = run("(block b (let ((f (lambda () (return-from b 1)))) (par (f))))");
    assert!(hidden.starts_with("failed: control-error"), "{hidden}");
    let dead = run("(defvar f nil) (block b (setq f (lambda () (return-from b 1)))) (f)");
    assert!(dead.starts_with("failed: control-error"), "{dead}");
}

#[test]
fn closures_share_what_they_assign_and_loops_bind_afresh() {
    check("(let ((n 0)) (par (setq n (+ n 1)) (seq (wait-time 1) (setq n (+ n 10)))) n)", "=> 11");
    check("(let ((fs nil)) (dotimes (i 3) (push (lambda () i) fs)) (map (lambda (f) (f)) fs))", "=> (2 1 0)");
}

#[test]
fn a_failure_knows_where_it_came_from() {
    let result = run("(def-plan inner () (par (fail \"x\")))\n(def-plan outer () (inner))\n(outer)");
    assert!(result.contains("failed: plan-failure: x"), "{result}");
}
