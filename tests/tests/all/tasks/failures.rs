//! Failures, handlers and clean-ups.

use rpl_tests::{check, run};

/// r[handle.clause], r[fail.form], r[fail.define]
#[test]
fn the_first_clause_that_fits_takes_the_failure() {
    check(
        "(def-failure lost (plan-failure) (where)) (def-failure very-lost (lost) (how)) (with-failure-handling ((timeout () 1) (lost (f) (list (failure-class f) (failure-slot f 'where) (failure-slot f 'how))) (failure () 3)) (fail very-lost \"~a\" 'x :where 'here :how 7))",
        "=> (very-lost here 7)",
    );
    check("(fail \"a ~a\" 1)", "failed: plan-failure: a 1");
}

/// r[handle.clause]
#[test]
fn the_body_is_clean_before_the_handler_runs() {
    check(
        "(with-failure-handling ((failure () (print 'handler) 'value)) (unwind-protect (fail \"x\") (print 'clean)))",
        "clean\nhandler\n=> value",
    );
}

/// r[handle.retry], r[handle.counter]
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

/// r[handle.children]
#[test]
fn failures_of_children_are_caught() {
    check(
        "(with-failure-handling ((failure (f) (failure-message f))) (par (wait-time 5) (par (seq (wait-time 1) (fail \"deep\")))))",
        "=> \"deep\"",
    );
}

/// r[cleanup.evap]
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

/// r[cleanup.once], r[cleanup.unwind]
#[test]
fn clean_ups_run_innermost_first_and_keep_the_value() {
    check("(unwind-protect (unwind-protect 1 (print 'inner)) (print 'outer))", "inner\nouter\n=> 1");
    check(
        "(pursue (unwind-protect (unwind-protect (wait-time 9) (seq (wait-time 1) (print 'inner))) (print 'outer)) (seq (wait-time 1) 'won))",
        "inner\nouter\n=> won",
    );
}

/// r[cleanup.failure], r[cleanup.success], r[cleanup.evaporated]
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

/// r[cleanup.protected]
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

/// r[cleanup.protected], r[construct.fixed]
#[test]
fn a_clean_up_is_not_evaporated() {
    check(
        "(with-failure-handling ((failure (f) (list (failure-message f) (now))))
           (par (unwind-protect (wait-time 1) (seq (wait-time 3) (print 'cleaned)))
                (seq (wait-time 2) (fail \"x\"))))",
        "cleaned\n=> (\"x\" 4.0)",
    );
}

/// r[return.border]
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

/// r[loop.fresh]
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

/// r[fail.form]
#[test]
fn how_a_failure_is_written() {
    check(
        "(with-failure-handling ((failure (f) (list (failure-class f) (failure-message f)))) (fail))",
        "=> (plan-failure \"failed\")",
    );
    check(
        "(def-failure wet (plan-failure) (where how))
         (with-failure-handling ((wet (f) (list (failure-message f) (failure-slot f 'where) (failure-slot f 'how))))
           (fail wet \"~a of ~d\" 'drop 3 :where 'floor))",
        "=> (\"drop of 3\" floor nil)",
    );
}

/// r[fail.tree]
#[test]
fn the_classes_form_a_tree() {
    let tree = [
        ("plan-failure", "failure"),
        ("error", "failure"),
        ("timeout", "failure"),
        ("deadlock", "failure"),
        ("valve-error", "failure"),
        ("composite-failure", "failure"),
        ("behaviour-failure", "failure"),
        ("type-error", "error"),
        ("unbound-variable", "error"),
        ("arity-error", "error"),
        ("arithmetic-error", "error"),
        ("index-error", "error"),
        ("control-error", "error"),
        ("network-error", "error"),
        ("runaway", "error"),
        ("stack-overflow", "error"),
        ("out-of-memory", "error"),
        ("navigation-failure", "behaviour-failure"),
        ("unreachable", "navigation-failure"),
        ("blocked", "navigation-failure"),
        ("interrupted", "behaviour-failure"),
        ("localization-failure", "behaviour-failure"),
        ("grasp-failure", "behaviour-failure"),
    ];
    for (class, parent) in tree {
        check(
            &format!(
                "(with-failure-handling (({parent} (f) (list (failure-class f) (failure-is? f '{parent})))) (fail {class}))"
            ),
            &format!("=> ({class} t)"),
        );
        check(
            &format!(
                "(with-failure-handling (({class} () 'caught)) (with-failure-handling ((failure (f) (refail))) (fail {class})))"
            ),
            "=> caught",
        );
    }
    check("(with-failure-handling ((failure (f) (failure-is? f 'error))) (fail \"mine\"))", "=> nil");
}

/// r[fail.define]
#[test]
fn classes_are_defined_with_slots_that_are_inherited() {
    check(
        "(def-failure spilt (plan-failure) (what)) (def-failure burnt (spilt) (where)) (def-failure plain)
         (with-failure-handling ((spilt (f) (list (failure-class f) (failure-slot f 'what) (failure-slot f 'where))))
           (fail burnt \"ouch\" :what 'tea :where 'kitchen))",
        "=> (burnt tea kitchen)",
    );
    check("(def-failure plain) (with-failure-handling ((plan-failure () 'below)) (fail plain))", "=> below");
    let unknown = run("(def-failure a (nowhere) ())");
    assert!(unknown.starts_with("error[unknown-failure-class]"), "{unknown}");
    let slot = run("(fail plan-failure \"x\" :colour 3)");
    assert!(slot.starts_with("failed: type-error") && slot.contains("no slot `colour`"), "{slot}");
}

/// r[fail.readers]
#[test]
fn a_failure_can_be_looked_into() {
    check(
        "(with-failure-handling
             ((failure (f) (list (failure-class f) (failure-message f) (failure-slot f 'seconds) (failure-parts f)
                                 (failure-while-cleaning-up f) (failure-is? f 'error) (failurep f) (failure-slot f 'none))))
           (with-timeout 2 (wait-time 3)))",
        "=> (timeout \"not done within 2 s\" 2.0 nil nil nil t nil)",
    );
    check(
        "(with-failure-handling ((composite-failure (f) (map failure-class (failure-parts f))))
           (try-all (fail \"a\") (+ 1 'x) (with-timeout 1 (wait-time 2))))",
        "=> (plan-failure type-error timeout)",
    );
}

/// r[fail.again]
#[test]
fn a_failure_kept_can_be_raised_again() {
    check(
        "(with-failure-handling ((type-error (f) 'again))
           (with-failure-handling ((composite-failure (f) (fail (car (failure-parts f)))))
             (try-all (+ 1 'a) (fail \"b\"))))",
        "=> again",
    );
    check(
        "(let ((class 'timeout)) (with-failure-handling ((timeout (f) 'computed)) (fail (car (list class)) \"x\")))",
        "=> computed",
    );
}

/// r[handle.clause], r[handle.retry]
#[test]
fn clauses_and_what_they_may_do() {
    check(
        "(with-failure-handling (((timeout plan-failure) () 'either) (failure () 'other)) (fail \"x\"))",
        "=> either",
    );
    check("(with-failure-handling ((timeout () 'no)) (fail \"goes on\"))", "failed: plan-failure: goes on");
    check(
        "(defvar tries 0)
         (with-failure-handling ((plan-failure () (if (< tries 3) (retry) (list 'tries tries (now)))))
           (incf tries) (wait-time 1) (fail \"x\"))",
        "=> (tries 3 3.0)",
    );
    // A failure in a clause is the form's, and `refail` keeps the failure as it was.
    check(
        "(with-failure-handling ((plan-failure (f) (failure-slot f 'n)))
           (with-failure-handling ((failure (f) (refail))) (with-failure-handling ((failure () (fail \"second\"))) (fail \"first\"))))",
        "=> nil",
    );
    for word in ["(retry)", "(refail)"] {
        let found = run(word);
        assert!(found.starts_with("error[no-handler]"), "{found}");
    }
}

/// r[handle.counter]
#[test]
fn a_counter_of_n_makes_n_plus_one_tries() {
    check(
        "(defvar tries 0)
         (with-retry-counters ((a 2) (b 1))
           (with-failure-handling ((failure () (do-retry a (retry)) (do-retry b) (list tries (do-retry a (retry)))))
             (incf tries) (fail \"x\")))",
        "=> (4 nil)",
    );
}

/// r[handle.ignore]
#[test]
fn ignored_failures() {
    check(
        "(list (ignore-failures (timeout plan-failure) (fail \"x\")) (ignore-failures (timeout) 'fine))",
        "=> (nil fine)",
    );
    check("(ignore-failures (timeout) (fail \"not this one\"))", "failed: plan-failure: not this one");
}

/// r[cleanup.evap], r[cleanup.unwind], r[cleanup.once]
#[test]
fn every_way_of_leaving_cleans_up_once() {
    let ways = [
        ("(block b PROTECT)", "(return-from b 'left)", "left"),
        ("(loop PROTECT)", "(return 'left)", "left"),
        ("(dolist (x '(1 2 3)) PROTECT)", "(return x)", "1"),
        ("(ignore-failures (failure) PROTECT)", "(fail \"x\")", "nil"),
        ("(pursue PROTECT (seq (wait-time 1) 'won))", "(wait-time 9)", "won"),
        ("(ignore-failures (failure) (with-timeout 1 PROTECT))", "(wait-time 9)", "nil"),
        ("(block b (for-each (lambda (x) PROTECT) '(1 2)))", "(return-from b x)", "1"),
    ];
    for (around, leaving, value) in ways {
        for form in ["evap-protect", "unwind-protect"] {
            let protect = format!("({form} (par {leaving} ) (print 'clean))").replace("(par (return", "(seq (return");
            let protect =
                protect.replace("(par (wait-time 9) )", "(par (unwind-protect (wait-time 9) (print 'child)))");
            let text = around.replace("PROTECT", &protect);
            let child = if leaving.contains("wait-time") { "child\n" } else { "" };
            check(&text, &format!("{child}clean\n=> {value}"));
        }
    }
    check("(list (evap-protect 'a (print 'no)) (unwind-protect 'b (print 'yes)))", "yes\n=> (a b)");
    check(
        "(with-retry-counters ((c 2)) (with-failure-handling ((failure () (do-retry c) 'end)) (evap-protect (fail \"x\") (print 'clean))))",
        "clean\nclean\nclean\n=> end",
    );
}

/// r[cleanup.return]
#[test]
fn a_failure_while_a_block_is_left_takes_its_place() {
    check(
        "(with-failure-handling ((plan-failure (f) (list 'failed (failure-message f))))
           (block b (unwind-protect (return-from b 'value) (fail \"clean-up\"))))",
        "=> (failed \"clean-up\")",
    );
}

/// r[cleanup.no-exit], r[construct.fixed]
#[test]
fn an_exit_from_a_clean_up_turns_no_departure_aside() {
    check("(block b (unwind-protect (fail \"stays\") (return-from b 'turned)))", "failed: plan-failure: stays");
    check("(loop (unwind-protect (return 1) (return 2)))", "=> 1");
    check("(block a (block b (unwind-protect (return-from a 1) (return-from b 2))) 3)", "=> 1");
    check(
        "(pursue (loop (unwind-protect (wait-time 9) (seq (print 'clean) (return 2)))) (seq (wait-time 1) 'won))",
        "clean\n=> won",
    );
    // With nothing under way it is an exit like any other.
    check("(block b (unwind-protect 1 (return-from b 2)) 3)", "=> 2");
    check("(unwind-protect 1 (dolist (x '(1 2)) (return x)))", "=> 1");
}

/// r[cleanup.protected]
#[test]
fn a_suspension_waits_for_the_end_of_a_clean_up() {
    check(
        "(par (:tag a (unwind-protect 1 (seq (wait-time 2) (print (list 'cleaned (now))))) (print (list 'on (now))))
              (seq (wait-time 1) (suspend a) (print (list 'at-rest (now))) (wait-time 3) (resume a)))",
        "(cleaned 2.0)\n(at-rest 2.0)\n(on 5.0)\n=> nil",
    );
}

/// r[cleanup.failure]
#[test]
fn failures_in_several_clean_ups_are_all_kept() {
    check(
        "(with-failure-handling ((failure (f) (cons (failure-message f) (map failure-message (failure-while-cleaning-up f)))))
           (unwind-protect (unwind-protect (unwind-protect (fail \"first\") (fail \"inner\")) (print 'between)) (fail \"outer\")))",
        "between\n=> (\"first\" \"inner\" \"outer\")",
    );
}

/// r[return.border]
#[test]
fn no_exit_leads_over_the_border_of_a_task() {
    for text in [
        "(loop (par (return 1)))",
        "(block b (with-timeout 1 (return-from b 1)))",
        "(dolist (x '(1)) (spawn (return x)))",
        "(block b (with-policy (return-from b 1) 2))",
        "(block b (:tag a (return-from b 1)))",
        "(with-failure-handling ((failure () (par (retry)))) (fail \"x\"))",
    ] {
        let found = run(text);
        assert!(found.starts_with("error[leaves-task]"), "{text}\n{found}");
    }
}
