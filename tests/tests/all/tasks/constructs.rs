//! The parallel family: what decides, when, and with which value.

use rpl_tests::{check, run};

/// r[construct.value]
#[test]
fn par_has_the_value_of_the_last_child_by_position() {
    check("(par (seq (wait-time 2) 'a) (seq (wait-time 1) 'b))", "=> b");
}

/// r[par.failure]
#[test]
fn par_fails_at_the_first_failure_and_evaporates_the_others() {
    check(
        "(with-failure-handling ((plan-failure (f) (list (failure-message f) (now))))
           (par (unwind-protect (wait-time 9) (print 'clean)) (seq (wait-time 1) (fail \"no\")) (wait-time 5)))",
        "clean\n=> (\"no\" 1.0)",
    );
}

/// r[construct.decide]
#[test]
fn a_decision_falls_in_the_step_in_which_a_child_ends() {
    // All three are ready in the same instant; the losers run nothing but clean-ups.
    check(
        "(def-fluent go nil)
         (par (pursue (seq (wait-for go) (print 'first) 1)
                      (seq (wait-for go) (print 'second) 2)
                      (evap-protect (seq (wait-for go) (print 'third)) (print 'clean)))
              (seq (wait-time 1) (setf (value go) t)))
         (now)",
        "first\nclean\n=> 1.0",
    );
}

/// r[construct.decide], r[construct.start]
#[test]
fn children_that_have_not_started_never_start() {
    check("(pursue (print 'a) (print 'b))", "a\n=> a");
    check("(ignore-failures (failure) (par (fail \"x\") (print 'b)))", "=> nil");
    check("(try-all (seq (fail \"x\")) (print 'b) (print 'c))", "b\n=> b");
}

/// r[try-all.composite]
#[test]
fn try_all_fails_with_every_failure() {
    check(
        "(with-failure-handling ((composite-failure (f) (map failure-message (failure-parts f))))
           (try-all (seq (wait-time 2) (fail \"a\")) (fail \"b\")))",
        "=> (\"b\" \"a\")",
    );
}

/// r[try-in-order.next]
#[test]
fn try_in_order_takes_the_first_success() {
    check("(try-in-order (fail \"a\") (seq (wait-time 1) 'b) (print 'c))", "=> b");
    check(
        "(with-failure-handling ((composite-failure (f) (map failure-message (failure-parts f))))
           (try-in-order (fail \"a\") (fail \"b\")))",
        "=> (\"a\" \"b\")",
    );
    check("(try-each-in-order (x '(1 2 3)) (if (< x 2) (fail \"small\") x))", "=> 2");
}

/// r[construct.empty]
#[test]
fn empty_forms() {
    check("(list (seq) (par))", "=> (nil nil)");
    for form in ["(pursue)", "(try-all)", "(try-in-order)", "(try-each-in-order (x nil) x)"] {
        check(&format!("(with-failure-handling ((composite-failure (f) (failure-parts f))) {form})"), "=> nil");
    }
    check("(par-map (x nil) x)", "=> nil");
}

/// r[construct.evaporated]
#[test]
fn evaporated_children_count_as_done() {
    check(
        "(seq (par (:tag a (wait-time 9)) (seq (evaporate a) 'b)) (list (value (status a)) (now)))",
        "=> (evaporated 0.0)",
    );
    check(
        "(with-failure-handling ((composite-failure (f) (length (failure-parts f))))
           (try-all (:tag a (wait-time 9)) (seq (evaporate a) (fail \"x\"))))",
        "=> 1",
    );
    check(
        "(par (with-failure-handling ((composite-failure (f) (print (length (failure-parts f)))))
                (pursue (:tag a (wait-time 9))))
              (evaporate a))",
        "0\n=> nil",
    );
}

/// r[construct.clean]
#[test]
fn leaving_means_clean() {
    check(
        "(pursue (unwind-protect (wait-time 9) (seq (wait-time 2) (print 'slow)))
                 (unwind-protect (wait-time 9) (seq (wait-time 1) (print 'quick)))
                 (wait-time 1))
         (now)",
        "quick\nslow\n=> 3.0",
    );
}

/// r[construct.clean]
#[test]
fn clean_ups_start_in_order_of_position() {
    check(
        "(pursue (evap-protect (par (evap-protect (wait-time 9) (print 'a-inner))) (print 'a))
                 (evap-protect (wait-time 9) (print 'b))
                 (evap-protect (wait-time 9) (print 'c))
                 (wait-time 1))",
        "a-inner\nb\nc\na\n=> nil",
    );
}

/// r[plan.order]
#[test]
fn a_plan_keeps_its_order_however_the_first_step_died() {
    check("(plan ((:tag b (print 'b)) (:tag a (seq (wait-time 1) (print 'a)))) (:order a b))", "a\nb\n=> a");
    check(
        "(plan ((:tag a (wait-time 9)) (:tag b (print (now))) (seq (wait-time 1) (evaporate a))) (:order a b))",
        "1.0\n=> nil",
    );
    check(
        "(def-plan p () (plan ((:tag a (wait-time 1)) (:tag b (print 'b)) (seq (print (value (status b))))) (:order a b)))
         (p)",
        "created\nb\n=> created",
    );
    let cycle = run("(plan ((:tag a 1) (:tag b 2)) (:order a b) (:order b a))");
    assert!(cycle.contains("circle"), "{cycle}");
}

/// r[timeout.instant], r[timeout.failure]
#[test]
fn a_timeout_fails_at_the_deadline_and_not_in_its_instant() {
    check("(with-timeout 1 (wait-time 1) 'done)", "=> done");
    check(
        "(with-failure-handling ((timeout (f) (list (failure-slot f 'seconds) (now))))
           (with-timeout 1 (evap-protect (wait-time 1.5) (wait-time 1))))",
        "=> (1.0 2.0)",
    );
    check(
        "(def-fluent f nil) (with-timeout 1 (par (seq (wait-time 1) (setf (value f) t)) (wait-for f)) 'in-time)",
        "=> in-time",
    );
}

/// r[construct.fixed]
#[test]
fn the_outcome_is_fixed_when_leaving_starts() {
    // The deadline falls into the clean-up of a failure: the failure stays.
    check(
        "(with-failure-handling ((timeout () 'timeout) (plan-failure (f) (list (failure-message f) (now))))
           (with-timeout 2 (unwind-protect (seq (wait-time 1) (fail \"first\")) (wait-time 3))))",
        "=> (\"first\" 4.0)",
    );
}

/// r[spawn.life], r[spawn.failure]
#[test]
fn spawn_lives_as_long_as_the_plan_call() {
    check(
        "(def-plan p () (spawn (evap-protect (wait-time 9) (seq (wait-time 1) (print 'gone)))) (wait-time 1) 'p)
         (print (p)) (now)",
        "gone\np\n=> 2.0",
    );
    check(
        "(def-plan p () (spawn (seq (wait-time 1) (fail \"spawned\"))) (evap-protect (wait-time 9) (print 'cut)))
         (with-failure-handling ((plan-failure (f) (list (failure-message f) (now)))) (p))",
        "cut\n=> (\"spawned\" 1.0)",
    );
    check("(def-plan p () (spawn 7)) (def-plan q () (value (result (p)))) (print 1) (q)", "1\n=> nil");
}

/// r[spawn.failure], r[cleanup.protected]
#[test]
fn a_spawned_failure_waits_for_a_clean_up() {
    check(
        "(def-plan p ()
           (spawn (seq (wait-time 1) (fail \"spawned\")))
           (unwind-protect (seq) (seq (wait-time 2) (print 'cleaned)))
           (print 'not-reached))
         (with-failure-handling ((plan-failure (f) (list (failure-message f) (now)))) (p))",
        "cleaned\n=> (\"spawned\" 2.0)",
    );
}

/// r[map.children]
#[test]
fn maps_have_one_child_an_element() {
    check("(par-map (x '(3 1 2)) (wait-time x) (print x))", "1\n2\n3\n=> 2");
    check("(pursue-map (x '(3 1 2)) (wait-time x) x)", "=> 1");
    check("(try-all-map (x '(3 1 2)) (wait-time x) (if (= x 1) (fail \"one\") x))", "=> 2");
}

#[test]
fn a_child_without_work_still_is_a_child() {
    check("(par nil 5)", "=> 5");
    check("(pursue nil 5)", "=> nil");
}

/// r[seq.order]
#[test]
fn seq_ends_at_the_first_failure() {
    check("(seq (wait-time 1) (print (task-path (this-task))) 'last)", "main\n=> last");
    check("(seq (print 1) (fail \"two\") (print 3))", "1\nfailed: plan-failure: two");
}

/// r[pursue.first]
#[test]
fn in_pursue_whoever_ends_first_decides() {
    check("(pursue (seq (wait-time 2) 'slow) (seq (wait-time 1) 'quick))", "=> quick");
    check(
        "(with-failure-handling ((plan-failure (f) (list (failure-message f) (now))))
           (pursue (evap-protect (wait-time 2) (print 'cut)) (seq (wait-time 1) (fail \"first\"))))",
        "cut\n=> (\"first\" 1.0)",
    );
}

/// r[try-all.first], r[try-all.tie]
#[test]
fn in_try_all_failures_before_a_success_are_forgotten() {
    check("(list (try-all (seq (wait-time 2) 'a) (fail \"b\") (seq (wait-time 1) (fail \"c\"))) (now))", "=> (a 2.0)");
    check("(try-all (seq (wait-time 1) 'first) (seq (wait-time 1) 'second))", "=> first");
    // Its timer was set first, so it becomes ready first.
    check("(try-all (seq (wait-time 0.5) (wait-time 0.5) 'first) (seq (wait-time 1) 'second))", "=> second");
}

/// r[construct.start], r[construct.value]
#[test]
fn children_start_in_the_order_of_their_position() {
    check("(par (print 1) (par (print 2) (print 3)) (print 4))", "1\n4\n2\n3\n=> 4");
    check("(plan ((:tag a (wait-time 1) 'a) (:tag b 'b) (seq (wait-time 0.5) 'c)) (:order b a))", "=> c");
    check("(list (par-map (x nil) x) (par-map (x '(3 1)) (wait-time x) x))", "=> (nil 1)");
}

/// r[plan.order]
#[test]
fn an_order_that_cannot_be_kept_is_an_error_of_the_text() {
    for (text, code) in [
        ("(plan ((:tag a 1)) (:order a a))", "order-cycle"),
        ("(plan ((:tag a 1) (:tag b 2) (:tag c 3)) (:order a b) (:order b c) (:order c a))", "order-cycle"),
        ("(plan ((:tag a 1)) (:order a nobody))", "unknown-step"),
        ("(plan ((:tag a 1) (:tag b 2)) (:order a b a))", "malformed"),
    ] {
        let found = run(text);
        assert!(found.starts_with(&format!("error[{code}]")), "{text}\n{found}");
    }
    let data = run("(execute-plan '(plan ((:tag a 1) (:tag b 1)) (:order a b) (:order b a)))");
    assert!(data.starts_with("failed: error") && data.contains("order-cycle"), "{data}");
    check(
        "(ignore-failures (failure) (partial-order ((:tag a (wait-time 1) (fail \"x\")) (:tag b (print 'never))) (:order a b)))",
        "=> nil",
    );
}

/// r[map.children], r[construct.empty]
#[test]
fn maps_over_nothing() {
    check("(par-map (x nil) x)", "=> nil");
    for form in ["(pursue-map (x nil) x)", "(try-all-map (x nil) x)"] {
        check(&format!("(with-failure-handling ((composite-failure (f) (failure-parts f))) {form})"), "=> nil");
    }
}

/// r[timeout.negative], r[timeout.instant]
#[test]
fn a_deadline_that_is_over() {
    check("(list (with-timeout 0 'a) (with-timeout -1 (wait-time 0) 'b))", "=> (a b)");
    check("(with-failure-handling ((timeout () (now))) (with-timeout -5 (wait-time 1)))", "=> 0.0");
}

/// r[spawn.task]
#[test]
fn spawn_goes_on_at_once() {
    check(
        "(let ((task (spawn (print 'child) (wait-time 1) 'done)))
           (print (list (taskp task) (value (status task)) (now)))
           (wait-for (end-task task))
           (value (result task)))",
        "(t ready 0.0)\nchild\n=> done",
    );
}

/// r[construct.fixed]
#[test]
fn what_comes_late_is_attached() {
    check(
        "(with-failure-handling
             ((plan-failure (f) (list (failure-message f) (map failure-message (failure-while-cleaning-up f)))))
           (par (seq (wait-time 1) (fail \"first\"))
                (evap-protect (wait-time 9) (seq (wait-time 1) (fail \"late\")))))",
        "log: warning: a failure in a clean-up during evaporation: plan-failure: late\n=> (\"first\" nil)",
    );
    check(
        "(def-plan p () (spawn (seq (wait-time 1.5) (fail \"spawned\"))) (evap-protect (seq (wait-time 1) (fail \"first\")) (wait-time 1)))
         (with-failure-handling
             ((plan-failure (f) (list (failure-message f) (map failure-message (failure-while-cleaning-up f)) (now)))) (p))",
        "=> (\"first\" (\"spawned\") 2.0)",
    );
}

/// r[construct.stands]
#[test]
fn what_a_construct_has_decided_stands_whatever_comes_while_it_cleans_up() {
    // An evaporation.
    check(
        "(par (:tag c (par (seq (wait-time 1) (fail \"lost\")) (evap-protect (wait-time 9) (wait-time 2))))
              (seq (wait-time 2) (evaporate c)))",
        "failed: plan-failure: lost",
    );
    // A deadline.
    check(
        "(with-timeout 2 (par (seq (wait-time 1) (fail \"x\")) (evap-protect (wait-time 9) (wait-time 3))))",
        "failed: plan-failure: x",
    );
    check(
        "(with-failure-handling ((failure (f) (map failure-class (failure-while-cleaning-up f))))
           (with-timeout 2 (par (seq (wait-time 1) (fail \"x\")) (evap-protect (wait-time 9) (wait-time 3)))))",
        "=> (timeout)",
    );
    // Every construct alike.
    for form in [
        "(par (seq (wait-time 1) (fail \"first\")) (evap-protect (wait-time 9) (wait-time 3)))",
        "(pursue (seq (wait-time 1) (fail \"first\")) (evap-protect (wait-time 9) (wait-time 3)))",
        "(par-map (x (list 1 2)) (if (= x 1) (seq (wait-time 1) (fail \"first\")) (evap-protect (wait-time 9) (wait-time 3))))",
        "(plan ((seq (wait-time 1) (fail \"first\")) (evap-protect (wait-time 9) (wait-time 3))))",
        "(with-policy (seq (wait-time 1) (fail \"first\")) (evap-protect (wait-time 9) (wait-time 3)))",
        "(with-policy (evap-protect (wait-time 9) (wait-time 3)) (wait-time 1) (fail \"first\"))",
        "(seq (spawn (seq (wait-time 1) (fail \"first\"))) (evap-protect (wait-time 9) (wait-time 3)))",
        "(unwind-protect (seq (wait-time 1) (fail \"first\")) (wait-time 3))",
        "(with-retry-counters ((k 1)) (with-failure-handling ((timeout () (retry)))
           (unwind-protect (seq (wait-time 1) (fail \"first\")) (wait-time 3))))",
    ] {
        for end in ["(evaporate c)", "(par (suspend c) (seq (wait-time 4) (evaporate c)))"] {
            let text = format!(
                "(def-plan p () {form})
                 (ignore-failures (failure) (par (:tag c (p)) (seq (wait-time 2) {end}))
                   (print 'no-failure))
                 (def-plan q () (with-failure-handling ((failure (f) (print (failure-message f))))
                   (par (:tag c (p)) (seq (wait-time 2) {end}))))
                 (q) nil"
            );
            assert_eq!(run(&text), "first\n=> nil", "{text}");
        }
    }
}

/// r[construct.stands], r[construct.fixed]
#[test]
fn an_evaporation_waits_for_the_end_of_a_construct_that_has_succeeded() {
    check(
        "(par (:tag c (print (pursue (seq (wait-time 1) 'won) (evap-protect (wait-time 9) (wait-time 3)))) (print 'never))
              (seq (wait-time 2) (evaporate c) (print (list (value (status c)) (now)))))",
        "(evaporated 4.0)\n=> (evaporated 4.0)",
    );
    // A failure that is handled is no outcome of the task.
    check(
        "(par (:tag c (with-failure-handling ((failure () (print 'handled)))
                (par (seq (wait-time 1) (fail)) (evap-protect (wait-time 9) (wait-time 3)))))
              (seq (wait-time 2) (evaporate c) (print (list (value (status c)) (now)))))",
        "(evaporated 4.0)\n=> (evaporated 4.0)",
    );
}

/// r[construct.stands], r[spawn.failure]
#[test]
fn a_spawned_failure_does_not_take_the_place_of_a_decided_one() {
    check(
        "(def-plan p ()
           (spawn (seq (wait-time 2) (fail \"spawned\")))
           (par (seq (wait-time 1) (fail \"first\")) (evap-protect (wait-time 9) (wait-time 3))))
         (with-failure-handling ((failure (f) (list (failure-message f) (now) (map failure-message (failure-while-cleaning-up f))))) (p))",
        "=> (\"first\" 4.0 (\"spawned\"))",
    );
    // Where the construct succeeds, it is the plan call's after that.
    check(
        "(def-plan p ()
           (spawn (seq (wait-time 2) (fail \"spawned\")))
           (pursue (wait-time 1) (evap-protect (wait-time 9) (wait-time 3)))
           (print 'never))
         (with-failure-handling ((failure (f) (list (failure-message f) (now)))) (p))",
        "=> (\"spawned\" 4.0)",
    );
}

/// r[timeout.wins], r[timeout.suspended]
#[test]
fn a_deadline_that_passes_with_the_end_of_its_body_while_suspended_wins() {
    check(
        "(par (:tag a (with-failure-handling ((timeout () (print (list 'timeout (now))))) (with-timeout 4 (wait-time 2) (print 'done))))
              (seq (wait-time 1) (suspend a) (wait-time 5) (resume a)))",
        "(timeout 6.0)\n=> nil",
    );
    // The body ends in a clean-up, which no suspension stops, after the deadline.
    check(
        "(par (:tag a (with-failure-handling ((timeout () (print (list 'timeout (now))))) (with-timeout 2 (unwind-protect nil (wait-time 3)))))
              (seq (wait-time 1) (suspend a) (wait-time 5) (resume a)))",
        "(timeout 8.0)\n=> nil",
    );
    // Of two, the earlier one.
    check(
        "(par (:tag a (with-failure-handling ((timeout (f) (print (failure-slot f 'seconds)))) (with-timeout 3 (with-timeout 2 (wait-time 9)))))
              (seq (wait-time 1) (suspend a) (wait-time 5) (resume a)))",
        "2.0\n=> nil",
    );
}

/// r[timeout.one-by-one]
#[test]
fn deadlines_of_one_instant_take_effect_one_by_one() {
    check(
        "(def-fluent go nil)
         (par (ignore-failures (timeout) (with-timeout 2 (unwind-protect (wait-time 9) (setf (value go) t))))
              (with-failure-handling ((timeout () (print 'timeout))) (with-timeout 2 (wait-for go) (print 'in-time))))",
        "in-time\n=> in-time",
    );
}
