//! Policies, priorities, valves and interruption.

use rpl_tests::run;

#[track_caller]
fn check(text: &str, expected: &str) {
    assert_eq!(run(text), expected, "{text}");
}

#[test]
fn a_policy_starts_first_and_outranks_the_body() {
    check("(with-policy (seq (print 'policy) (wait-time 9)) (print 'body))", "policy\nbody\n=> body");
    check(
        "(def-fluent f nil)
         (with-policy (whenever f (print 'policy))
           (seq (setf (value f) t) (print 'body)))",
        "policy\nbody\n=> body",
    );
}

#[test]
fn a_policy_that_succeeds_leaves_the_body_alone_and_one_that_fails_ends_it() {
    check("(with-policy (seq 1) (wait-time 1) (print 'body))", "body\n=> body");
    check(
        "(with-policy (seq (wait-time 1) (fail \"kept not\")) (evap-protect (wait-time 5) (print 'clean)))",
        "clean\nfailed: plan-failure: kept not",
    );
    check(
        "(ignore-failures (failure) (with-policy (evap-protect (wait-time 9) (print 'policy-clean)) (wait-time 1) (fail \"x\")))",
        "policy-clean\n=> nil",
    );
}

#[test]
fn outer_policies_outrank_inner_ones() {
    check(
        "(def-fluent f nil)
         (with-policies ((whenever f (print 'outer)) (whenever f (print 'middle)))
           (with-policy (whenever f (print 'inner)) (seq (setf (value f) t) (print 'body))))",
        "outer\nmiddle\ninner\nbody\n=> body",
    );
}

#[test]
fn priorities_order_what_is_ready() {
    check(
        "(def-fluent go nil)
         (par (seq (wait-for go) (print 'plain)) (with-priority -1 (wait-for go) (print 'low)) (with-priority 1 (wait-for go) (print 'high))
              (seq (wait-time 1) (setf (value go) t) (print 'setter)))",
        "high\nsetter\nplain\nlow\n=> setter",
    );
}

#[test]
fn equals_take_turns_in_the_order_of_asking() {
    check(
        "(def-valve v)
         (par (with-valve v (wait-time 1) (print 1)) (with-valve v (wait-time 1) (print 2)) (with-valve v (wait-time 1) (print 3)))
         (now)",
        "1\n2\n3\n=> 3.0",
    );
}

#[test]
fn descendants_borrow_one_at_a_time() {
    check(
        "(def-valve v)
         (with-valve v (with-valve v (par (with-valve v (wait-time 1) (print (now))) (with-valve v (wait-time 1) (print (now))))))
         (holds-valve? v)",
        "1.0\n2.0\n=> nil",
    );
}

#[test]
fn a_higher_request_pre_empts_from_outside() {
    check(
        "(def-valve v)
         (par (with-valve v (par (seq (wait-time 2) (print (list 'inside (now)))) (seq (wait-time 3))))
              (with-priority 1 (wait-time 1) (with-valve v (wait-time 4)) (print (list 'back (now)))))
         (now)",
        "(back 5.0)\n(inside 5.0)\n=> 5.0",
    );
}

#[test]
fn a_higher_request_pre_empts_the_branch_from_inside() {
    check(
        "(def-valve v)
         (with-valve v
           (par (with-policy (seq (wait-time 1) (with-valve v (wait-time 3) (print 'policy)))
                  (with-valve v (wait-time 2) (print (list 'branch (now)))))
                (seq (wait-time 2) (print (list 'beside (now))))))
         (now)",
        "(beside 2.0)\npolicy\n(branch 4.0)\n=> 4.0",
    );
}

#[test]
fn hooks_run_innermost_first_and_may_block() {
    check(
        "(def-valve v)
         (par (with-valve v
                (on-interrupt (seq (wait-time 1) (print (list 'outer (now))))
                  (on-resume (print (list 'resume-outer (now)))
                    (on-interrupt (print (list 'inner (now)))
                      (on-resume (seq (wait-time 1) (print (list 'resume-inner (now)))) (wait-time 2) (print (list 'goes-on (now))))))))
              (with-priority 1 (wait-time 1) (with-valve v (print (list 'lent (now))) (wait-time 1))))",
        "(inner 1.0)\n(outer 2.0)\n(lent 2.0)\n(resume-inner 4.0)\n(resume-outer 4.0)\n(goes-on 4.0)\n=> nil",
    );
}

#[test]
fn pre_emption_nests_and_the_pre_empted_come_first_among_equals() {
    check(
        "(def-valve v)
         (par (with-valve v (wait-time 1.5) (print 'low))
              (with-priority 1 (wait-time 1) (with-valve v (wait-time 2) (print 'middle)))
              (with-priority 2 (wait-time 2) (with-valve v (wait-time 1) (print 'high)))
              (with-priority 1 (wait-time 2.5) (with-valve v (print 'middle-too)))
              (seq (wait-time 2.5) (with-valve v (print 'low-too))))",
        "high\nmiddle\nmiddle-too\nlow\nlow-too\n=> low-too",
    );
}

#[test]
fn a_valve_is_given_back_at_death_after_the_clean_ups() {
    check(
        "(def-valve v)
         (par (:tag a (unwind-protect (seq (request-valve v) (wait-time 9)) (seq (wait-time 1) (print 'cleaned))))
              (seq (wait-time 1) (par (evaporate a) (with-valve v (print (now))))))",
        "cleaned\n2.0\n=> 2.0",
    );
    check("(def-valve v) (ignore-failures (failure) (with-valve v (fail \"x\"))) (with-valve v 'again)", "=> again");
    check("(def-valve v) (block b (with-valve v (return-from b 1))) (with-valve v 'again)", "=> again");
}

#[test]
fn releasing_what_one_does_not_hold_is_an_error() {
    check("(def-valve v) (with-failure-handling ((valve-error () 'error)) (release-valve v))", "=> error");
    check(
        "(def-valve v) (request-valve v) (release-valve v) (with-failure-handling ((valve-error () 'error)) (release-valve v))",
        "=> error",
    );
}

#[test]
fn an_evaporated_pre_empted_owner_cleans_up_at_once() {
    check(
        "(def-valve v)
         (par (:tag a (with-valve v (unwind-protect (wait-time 9) (seq (print (list 'clean (now))) (with-valve v (print (list 'drives (now))))))))
              (with-priority 1 (wait-time 1) (with-valve v (wait-time 4)))
              (seq (wait-time 1.5) (with-valve v (print (list 'line (now)))))
              (seq (wait-time 2) (evaporate a) (print (list 'dead (now)))))",
        "(clean 2.0)\n(drives 5.0)\n(line 5.0)\n(dead 5.0)\n=> (dead 5.0)",
    );
}

#[test]
fn pre_emption_waits_for_a_clean_up() {
    check(
        "(def-valve v)
         (par (with-valve v (unwind-protect (seq) (seq (wait-time 2) (print (list 'cleaned (now))))) (wait-time 1) (print (list 'body (now))))
              (with-priority 1 (wait-time 1) (with-valve v (print (list 'got (now))) (wait-time 2))))",
        "(cleaned 2.0)\n(got 2.0)\n(body 5.0)\n=> nil",
    );
}

#[test]
fn a_deadline_passes_while_pre_empted() {
    check(
        "(def-valve v)
         (par (with-failure-handling ((timeout () (print (list 'timeout (now)))))
                (with-timeout 2 (with-valve v (wait-time 9))))
              (with-priority 1 (wait-time 1) (with-valve v (wait-time 4))))",
        "(timeout 2.0)\n=> nil",
    );
    check(
        "(def-valve v)
         (par (with-valve v (with-failure-handling ((timeout () (print (list 'timeout (now))))) (with-timeout 2 (wait-time 9))))
              (with-priority 1 (wait-time 1) (with-valve v (wait-time 4))))",
        "(timeout 5.0)\n=> nil",
    );
}

#[test]
fn a_circle_of_waiting_is_a_deadlock() {
    let result = run("(def-valve v) (def-valve w)
         (par (with-valve v (wait-time 1) (with-valve w 1)) (with-valve w (wait-time 1) (with-valve v 1)))");
    assert!(
        result.starts_with("failed: deadlock") && result.contains("valve v") && result.contains("valve w"),
        "{result}"
    );
    let evaporating = run("(def-valve v)
         (par (:tag a (unwind-protect (wait-time 9) (with-valve v 1)))
              (with-valve v (wait-time 1) (evaporate a)))");
    assert!(evaporating.contains("deadlock: this would close a circle"), "{evaporating}");
}

#[test]
fn a_resume_does_not_undo_a_pre_emption() {
    check(
        "(def-valve v)
         (par (:tag a (with-valve v (wait-time 2) (print (now))))
              (with-priority 1 (wait-time 1) (with-valve v (wait-time 4)))
              (seq (wait-time 2) (resume a)))",
        "5.0\n=> nil",
    );
}
