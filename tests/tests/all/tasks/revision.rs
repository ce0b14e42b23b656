//! Tasks that are given other plans while they run.

use rpl_runtime::run::system::Progress;
use rpl_tests::{check, run, system, transcript};

/// r[swap.form], r[swap.leaves], r[swap.same-task]
#[test]
fn a_task_leaves_its_plan_like_one_that_is_evaporated_and_runs_the_other() {
    check(
        "(par (:tag a (unwind-protect (par (wait-time 9) (unwind-protect (wait-time 9) (print 'inner)))
                                      (seq (wait-time 1) (print 'outer))))
              (seq (wait-time 1) (swap-plan a '(seq (print (now)) (wait-time 1) (print 'new) 7)) (print 'swapped)
                   (wait-for (end-task a)) (print (value (result a))) (value (status a))))",
        "inner\nouter\n2.0\nswapped\nnew\n7\n=> succeeded",
    );
    // Its path, the line of its construct and the deadline around it are what they were.
    check(
        "(ignore-failures (timeout)
           (with-timeout 3
             (par (:tag a (wait-time 9))
                  (seq (wait-time 1) (swap-plan a '(seq (print (task-path (this-task))) (wait-time 9)))))))
         (now)",
        "main/with-timeout/a\n=> 3.0",
    );
    check("(pursue (:tag a (wait-time 9) 1) (seq (wait-time 1) (swap-plan a ''two) (wait-time 9)))", "=> two");
}

/// r[swap.form]
#[test]
fn the_plan_begins_before_who_gave_it_goes_on() {
    let given = |plan: &str| format!("(par (:tag a (wait-time 1)) (seq (swap-plan a '(print 'new)) {plan}))");
    check(&given("(print 'swapped)"), "new\nswapped\n=> swapped");
    check(
        "(par (:tag a (evap-protect (wait-time 9) (wait-time 1))) (seq (swap-plan a '(print 'new)) (print 'swapped)))",
        "new\nswapped\n=> swapped",
    );
}

/// r[swap.form]
#[test]
fn a_plan_that_is_none_is_told_before_anything_is_left() {
    let told = run("(par (:tag a (evap-protect (wait-time 2) (print 'left)))
              (with-failure-handling ((error (f) (print (string-search \"nowhere\" (failure-message f)))))
                (swap-plan a '(nowhere 1))))");
    assert!(!told.contains("left") && told.starts_with(char::is_numeric), "{told}");
    check(
        "(swap-plan 1 'nil)",
        "failed: type-error: argument 1 of `swap-plan` must be a task, and it is the integer 1",
    );
    check(
        "(par (:tag a (wait-time 2)) (swap-plan a 'nil :keep (a)))",
        "failed: type-error: each of `:keep` of `swap-plan` must be a valve, and it is a task",
    );
}

/// r[swap.safe]
#[test]
fn a_clean_up_or_a_handled_failure_under_way_is_waited_for() {
    check(
        "(par (:tag a (unwind-protect (wait-time 1) (seq (wait-time 2) (print 'cleaned))) (print 'never))
              (seq (wait-time 1.5) (swap-plan a '(print (now)))))",
        "cleaned\n3.0\n=> nil",
    );
    check(
        "(par (:tag a (with-failure-handling ((failure () (print 'never)))
                 (unwind-protect (seq (wait-time 1) (fail)) (wait-time 2) (print 'cleaned))))
              (seq (wait-time 1.5) (swap-plan a '(print (now)))))",
        "cleaned\n3.0\n=> nil",
    );
    // Below it counts as well.
    check(
        "(par (:tag a (par (wait-time 9) (ignore-failures (failure)
                 (unwind-protect (seq (wait-time 1) (fail)) (wait-time 2)))))
              (seq (wait-time 1.5) (swap-plan a '(print (now)))))",
        "3.0\n=> nil",
    );
}

/// r[swap.dead]
#[test]
fn what_has_ended_or_is_about_to_is_not_revised() {
    let refused =
        |form: &str| run(&format!("(with-failure-handling ((control-error (f) (print (failure-message f)))) {form})"));
    let ended = "has ended: no other plan can be put in place of its own\n=>";
    let leaving = "is on its way out: no other plan can be put in place of its own\n=>";
    assert!(refused("(seq (:tag a 1) (swap-plan a 'nil))").contains(ended));
    for way in ["(evaporate a)", "(suspend a)"] {
        let text = format!(
            "(par (:tag a (unwind-protect (seq (wait-time 1) {}) (wait-time 2))) (seq (wait-time 1) {way})
                  (seq (wait-time 2) (swap-plan a '(print 'new))))",
            if way == "(suspend a)" { "(fail)" } else { "(wait-time 9)" }
        );
        assert!(refused(&text).contains(leaving), "{}", refused(&text));
    }
    assert!(refused("(seq (swap-plan a 'nil) (:tag a 1))").contains("a tag that was not reached yet"));
    assert!(refused("(swap-plan (task \"main\") 'nil)").contains("main cannot be given another plan"));
    // Evaporated while it leaves its plan, it does not begin the other.
    check(
        "(par (:tag a (unwind-protect (wait-time 9) (wait-time 2)))
              (seq (wait-time 1) (ignore-failures (control-error) (swap-plan a '(print 'new)))
                   (print (list (now) (value (status a)))))
              (seq (wait-time 2) (evaporate a)))",
        "(3.0 evaporated)\n=> nil",
    );
}

/// r[swap.valves]
#[test]
fn a_valve_is_given_back_after_the_clean_ups_unless_it_is_kept() {
    let text = |keep: &str| {
        format!(
            "(def-valve v)
             (par (:tag a (request-valve v) (unwind-protect (wait-time 9) (seq (wait-time 1) (print 'cleaned))))
                  (seq (wait-time 1) (swap-plan a '(seq (print (list (now) (holds-valve? v))) (wait-time 3)) {keep}))
                  (seq (wait-time 1.5) (with-valve v (print (list 'other (now))))))"
        )
    };
    check(&text(""), "cleaned\n(2.0 nil)\n(other 2.0)\n=> (other 2.0)");
    check(&text(":keep (v)"), "cleaned\n(2.0 t)\n(other 5.0)\n=> (other 5.0)");
    // It moves to the task from one below it, without anybody else having it between.
    check(
        "(def-valve v)
         (par (:tag a (par (with-valve v (unwind-protect (wait-time 9) (wait-time 1)))))
              (seq (wait-time 1) (swap-plan a '(seq (print (holds-valve? v)) (with-valve v (wait-time 1))
                                                    (release-valve v) (wait-time 5)) :keep (v)))
              (seq (wait-time 1.5) (with-valve v (print (now)))))",
        "t\n3.0\n=> 3.0",
    );
    check(
        "(def-valve v) (par (:tag a (wait-time 9)) (swap-plan a 'nil :keep (v)))",
        "failed: valve-error: neither main/a nor a task below it holds the valve `v` now, so it cannot be kept",
    );
}

/// r[swap.created], r[swap.suspended]
#[test]
fn what_has_not_begun_begins_with_the_new_plan_and_what_is_suspended_at_the_resume() {
    check(
        "(plan ((:tag a (wait-time 2)) (:tag b (print 'old)) (:tag c (swap-plan b '(print (list 'new (now))))))
               (:order a b))",
        "(new 2.0)\n=> nil",
    );
    check(
        "(par (:tag a (unwind-protect (wait-time 9) (print (list 'cleaned (now)))))
              (seq (suspend a) (wait-time 1) (swap-plan a '(print (list 'new (now)))) (print (list 'told (now)))
                   (wait-time 1) (print (value (status a))) (resume a)))",
        "(cleaned 1.0)\n(told 1.0)\nsuspended\n(new 2.0)\n=> nil",
    );
}

/// r[swap.own]
#[test]
fn a_task_swaps_its_own_plan_or_that_of_a_task_around_it_at_the_end_only() {
    check("(:tag a (wait-time 1) (swap-plan a '(seq (wait-time 1) (now))))", "=> 2.0");
    check(
        "(:tag a (par (wait-time 9) (unwind-protect (wait-time 9) (print 'cleaned))
                      (seq (wait-time 1) (swap-plan a '(seq (wait-time 1) (now))))))",
        "cleaned\n=> 2.0",
    );
    for text in [
        "(:tag a (swap-plan a 'nil) (print 'never))",
        "(:tag a (loop (swap-plan a 'nil)))",
        "(:tag a (par (seq (swap-plan a 'nil) (print 'never))))",
        "(def-plan p (task) (swap-plan task 'nil)) (:tag a (p a))",
    ] {
        let told = run(text);
        assert!(told.contains("let `swap-plan` be the last form of the task"), "{text}: {told}");
    }
    for text in
        ["(:tag a (no-revision (par (swap-plan a 'nil))))", "(:tag a (unwind-protect nil (par (swap-plan a 'nil))))"]
    {
        let told = run(text);
        assert!(
            told.contains("would wait for itself: a clean-up, a hook or `no-revision` of main/a"),
            "{text}: {told}"
        );
    }
    // Without end it takes no more than its steps.
    let mut endless = system("(defvar p '(swap-plan (this-task) p)) (:tag a (swap-plan a p))");
    endless.machine.limits.steps = 100_000;
    while endless.advance() == Progress::Running {}
    assert!(transcript(&mut endless).starts_with("failed: runaway"));
}

/// r[fence.form], r[fence.next]
#[test]
fn a_fence_is_waited_for_and_the_next_one_is_not_entered() {
    check(
        "(par (:tag a (unwind-protect (loop (no-revision (wait-time 1) (wait-time 1) (print (list 'delivered (now)))))
                                      (print 'cleaned)))
              (seq (wait-time 2.5) (swap-plan a '(print (list 'new (now)))) (print 'told)))",
        "(delivered 2.0)\n(delivered 4.0)\ncleaned\n(new 4.0)\ntold\n=> told",
    );
    // Below it, and however the fence is left.
    check(
        "(par (:tag a (par (wait-time 9) (ignore-failures (failure) (no-revision (wait-time 2) (fail)))))
              (seq (wait-time 1) (swap-plan a '(print (list 'new (now))))))",
        "(new 2.0)\n=> nil",
    );
    // Who does not want it any more takes it back.
    check(
        "(par (:tag a (no-revision (wait-time 3)) (print 'old))
              (seq (wait-time 1) (ignore-failures (timeout) (with-timeout 1 (swap-plan a '(print 'new))))))",
        "old\n=> nil",
    );
    // Evaporation does not ask.
    check("(with-timeout 1 (no-revision (wait-time 3)))", "failed: timeout: not done within 1 s");
    // Two who want different plans get them one after the other.
    check(
        "(par (:tag a (no-revision (wait-time 3)) (print 'old))
              (seq (wait-time 1) (swap-plan a '(seq (print 'one) (wait-time 9))) (print 'first))
              (seq (wait-time 2) (swap-plan a '(seq (print 'two) (wait-time 9))) (print 'second)))
         (now)",
        "one\nfirst\ntwo\nsecond\n=> 12.0",
    );
}

/// r[swap.finished]
#[test]
fn what_the_old_plan_has_finished_the_new_one_knows() {
    check(
        "(par (:tag a (ignore-failures (failure) (:tag lost (fail))) (:tag done (wait-time 1))
                      (par (seq (:tag below (wait-time 1)) (:tag cut (wait-time 9)))))
              (seq (wait-time 3)
                   (swap-plan a '(print (list (finished? done) (finished? below) (finished? lost) (finished? cut)
                                              (finished? never) (par (finished? done)))))))",
        "(t t nil nil nil t)\n=> nil",
    );
    // The last run counts.
    check(
        "(dotimes (i 2) (ignore-failures (failure) (:tag a (when (= i 1) (fail)))) (print (finished? a)))",
        "t\nnil\n=> nil",
    );
}

/// r[swap.leaves]
#[test]
fn a_failure_in_a_clean_up_is_warned_of_and_the_plan_begins() {
    let told = run("(par (:tag a (unwind-protect (wait-time 9) (fail \"lost\"))) (swap-plan a '(print 'new)))");
    assert!(
        told.starts_with("log: warning: a failure in a clean-up before another plan: plan-failure: lost"),
        "{told}"
    );
    assert!(told.contains("\nnew\n"), "{told}");
}
