//! Valves: borrowing, interruption, hooks, clean-ups, circles of waiting.

use rpl_tests::{check, run};

/// r[valve.line]
#[test]
fn equals_take_turns_in_the_order_of_asking() {
    check(
        "(def-valve v)
         (par (with-valve v (wait-time 1) (print 1)) (with-valve v (wait-time 1) (print 2)) (with-valve v (wait-time 1) (print 3)))
         (now)",
        "1\n2\n3\n=> 3.0",
    );
}

/// r[valve.borrow]
#[test]
fn descendants_borrow_one_at_a_time() {
    check(
        "(def-valve v)
         (with-valve v (with-valve v (par (with-valve v (wait-time 1) (print (now))) (with-valve v (wait-time 1) (print (now))))))
         (holds-valve? v)",
        "1.0\n2.0\n=> nil",
    );
}

/// r[valve.preempt]
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

/// r[valve.preempt]
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

/// r[valve.hooks]
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

/// r[valve.return]
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

/// r[valve.dead], r[valve.is]
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

/// r[valve.calls]
#[test]
fn releasing_what_one_does_not_hold_is_an_error() {
    check("(def-valve v) (with-failure-handling ((valve-error () 'error)) (release-valve v))", "=> error");
    check(
        "(def-valve v) (request-valve v) (release-valve v) (with-failure-handling ((valve-error () 'error)) (release-valve v))",
        "=> error",
    );
}

/// r[valve.evaporated]
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

/// r[valve.clean-up]
#[test]
fn pre_emption_waits_for_a_clean_up() {
    check(
        "(def-valve v)
         (par (with-valve v (unwind-protect (seq) (seq (wait-time 2) (print (list 'cleaned (now))))) (wait-time 1) (print (list 'body (now))))
              (with-priority 1 (wait-time 1) (with-valve v (print (list 'got (now))) (wait-time 2))))",
        "(cleaned 2.0)\n(got 2.0)\n(body 5.0)\n=> nil",
    );
}

/// r[valve.timers], r[timeout.suspended]
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

/// r[valve.circle]
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

/// r[valve.line]
#[test]
fn the_more_important_stands_before_others_in_the_line() {
    check(
        "(def-valve v)
         (par (with-priority 5 (with-valve v (wait-time 2)))
              (seq (wait-time 1) (with-valve v (print 'first-to-ask)))
              (with-priority 1 (wait-time 1.5) (with-valve v (print 'more-important)))
              (seq (wait-time 1) (with-valve v (print 'third))))",
        "more-important\nfirst-to-ask\nthird\n=> third",
    );
}

/// r[valve.calls]
#[test]
fn a_valve_taken_twice_is_given_back_twice() {
    check(
        "(def-valve v)
         (request-valve v) (request-valve v)
         (list (holds-valve? v) (progn (release-valve v) (holds-valve? v)) (progn (release-valve v) (holds-valve? v)))",
        "=> (t t nil)",
    );
    let found = run("(def-valve v) (par (with-valve v (wait-time 1)) (release-valve v))");
    assert!(found.starts_with("failed: valve-error"), "{found}");
}

/// r[valve.hook-failure], r[valve.hooks]
#[test]
fn a_hook_that_fails_stops_nothing() {
    check(
        "(def-valve v)
         (par (with-valve v (on-interrupt (print 'outer) (on-interrupt (fail \"hook\") (wait-time 2) (print 'goes-on))))
              (with-priority 1 (wait-time 1) (with-valve v (print 'lent))))",
        "outer\nlog: warning: a failure in a hook: plan-failure: hook\nlent\ngoes-on\n=> lent",
    );
}

/// r[valve.hooks], r[valve.clean-up]
#[test]
fn hooks_run_at_the_priority_of_the_one_who_waits() {
    check(
        "(def-valve v)
         (par (with-valve v (on-interrupt (seq (wait-time 1) (print 'hook)) (wait-time 5)))
              (with-priority 1 (wait-time 2) (print 'between))
              (with-priority 2 (wait-time 1) (with-valve v (print 'lent))))",
        "hook\nlent\nbetween\n=> lent",
    );
}

/// r[valve.clean-up]
#[test]
fn a_clean_up_in_the_way_runs_at_the_priority_of_the_one_who_waits() {
    check(
        "(def-valve v) (def-fluent go nil)
         (par (with-valve v (unwind-protect (seq) (seq (wait-for go) (print 'clean))))
              (with-priority 1 (wait-for go) (print 'middle))
              (with-priority 2 (with-valve v (print 'high)))
              (with-priority 3 (wait-time 1) (setf (value go) t)))",
        "clean\nhigh\nmiddle\n=> t",
    );
}

/// r[valve.preempt], r[valve.return]
#[test]
fn whoever_gets_the_valve_back_goes_on_where_it_was() {
    check(
        "(def-valve v)
         (par (with-valve v (dotimes (i 3) (wait-time 1) (print (list 'low i (now)))))
              (with-priority 1 (wait-time 1.5) (with-valve v (wait-time 10))))",
        "(low 0 1.0)\n(low 1 11.5)\n(low 2 12.5)\n=> nil",
    );
    // A requester that dies in the line asks no more.
    check(
        "(def-valve v)
         (par (with-valve v (wait-time 3) (print 'kept))
              (ignore-failures (timeout) (with-timeout 1 (with-valve v (print 'never)))))",
        "kept\n=> nil",
    );
}

/// r[valve.circle]
#[test]
fn the_circle_is_told_with_tasks_and_valves() {
    let result = run("(def-valve left) (def-valve right)
         (par (:tag one (with-valve left (wait-time 1) (with-valve right 1)))
              (:tag two (with-valve right (wait-time 1) (with-valve left 1))))");
    for part in ["failed: deadlock", "main/one waits for valve right", "main/two waits for valve left"] {
        assert!(result.contains(part), "{result}");
    }
    let joined = run("(def-valve v) (with-valve v (par (with-priority -1 (wait-time 1)) (with-valve v 1)) 'through)");
    assert_eq!(joined, "=> through");
    let evaporating = run("(def-valve v)
         (par (:tag a (unwind-protect (wait-time 9) (with-valve v 1)))
              (with-valve v (wait-time 1) (evaporate a)))");
    assert!(evaporating.contains("waits for the end of main/a"), "{evaporating}");
}

/// r[valve.preempt], r[valve.nested]
#[test]
fn a_request_from_outside_takes_the_valve_whoever_borrows_waits_or_was_interrupted() {
    check(
        "(def-valve v)
         (with-policy (seq (wait-time 1) (with-valve v (print (now))))
           (with-valve v (par (with-valve v (wait-time 100)) (with-valve v (wait-time 100)))))",
        "1.0\n=> nil",
    );
    // One borrower was interrupted from inside: the other children are suspended as well.
    check(
        "(def-valve v)
         (with-policy (seq (wait-time 1) (with-valve v (wait-time 2)))
           (with-valve v (par (with-valve v (wait-time 3)) (with-priority 1 (with-valve v (wait-time 3)))
                              (seq (wait-time 1.5) (print (now))))))",
        "3.0\n=> 3.0",
    );
}

/// r[valve.preempt]
#[test]
fn a_request_from_inside_takes_the_valve_whoever_else_waits_there() {
    check(
        "(def-valve v)
         (with-policy (seq (wait-time 1) (with-valve v (print (now))))
           (with-valve v (with-policy (seq (wait-time 2) (with-valve v (print (list 'policy (now)))))
                                      (par (with-valve v (wait-time 9)) (with-valve v (wait-time 9))))))",
        "1.0\n(policy 2.0)\n=> nil",
    );
}

/// r[valve.return]
#[test]
fn the_more_important_comes_first_when_a_borrower_gives_back() {
    check(
        "(def-valve v)
         (par (with-valve v (par (with-priority 3 (with-valve v (wait-time 1)))
                                 (seq (wait-time 0.5) (with-valve v (print (list 'inside (now)))))
                                 (wait-time 2)))
              (with-priority 2 (wait-time 0.6) (with-valve v (print (list 'outside (now))) (wait-time 3))))",
        "(outside 1.0)\n(inside 4.0)\n=> nil",
    );
}

/// r[valve.return-inside]
#[test]
fn after_an_interruption_from_inside_the_interrupted_borrower_and_those_outside_stand_in_one_line() {
    let with_outsider = |outsider: &str| {
        format!(
            "(def-valve v)
             (par (with-priority 1 (with-valve v
                    (par (with-valve v (on-interrupt (print 'away) (on-resume (print 'again)
                           (wait-time 3) (print (list 'inside (now))))))
                         (with-priority 5 (wait-time 2) (with-valve v (wait-time 4))))))
                  {outsider})"
        )
    };
    // More important than the interrupted borrower, less than the one that interrupts it.
    check(
        &with_outsider(
            "(with-priority 1 (with-priority 2 (wait-time 3) (with-valve v (print (list 'outside (now))) (wait-time 2))))",
        ),
        "away\n(outside 6.0)\nagain\n(inside 8.0)\n=> nil",
    );
    check(
        &with_outsider("(with-priority 1 (wait-time 3) (with-valve v (print (list 'outside (now)))))"),
        "away\nagain\n(inside 6.0)\n(outside 6.0)\n=> (outside 6.0)",
    );
}

/// r[valve.chain]
#[test]
fn interruptions_survive_the_death_of_a_link() {
    check(
        "(def-valve v)
         (par (with-priority 1 (with-valve v (wait-time 2) (print (list 'low (now)))))
              (with-priority 2 (wait-time 1) (:tag middle (with-valve v (wait-time 5))))
              (with-priority 3 (wait-time 2) (with-valve v (wait-time 1)))
              (seq (wait-time 2.5) (evaporate middle)))",
        "(low 3.0)\n=> nil",
    );
    // Two links at once.
    check(
        "(def-valve v)
         (par (with-valve v (wait-time 9) (print (list 'low (now))))
              (with-priority 1 (wait-time 1) (:tag a (with-valve v (wait-time 9))))
              (with-priority 2 (wait-time 2) (:tag b (with-valve v (wait-time 9))))
              (with-priority 3 (wait-time 3) (with-valve v (wait-time 2)))
              (seq (wait-time 4) (par (evaporate a) (evaporate b))))",
        "(low 9.0)\n=> nil",
    );
}

/// r[valve.nested]
#[test]
fn the_children_of_a_borrower_borrow_from_it() {
    check(
        "(def-valve v)
         (with-valve v (par (with-valve v (par (with-valve v (wait-time 1)) (with-valve v (print 1))))
                            (with-valve v (print 2))))
         (now)",
        "1\n2\n=> 1.0",
    );
}

/// r[valve.boost]
#[test]
fn a_clean_up_that_has_given_the_valve_back_is_as_important_as_before() {
    check(
        "(def-valve v)
         (with-policy (seq (wait-time 1) (with-valve v (print 'policy)))
           (unwind-protect nil (with-valve v (wait-time 2)) (print 'clean-up)))",
        "policy\nclean-up\n=> nil",
    );
    // Nor once the one that waited is gone.
    check(
        "(def-valve v) (def-fluent go nil)
         (par (with-valve v (unwind-protect nil (wait-for go) (print 'clean-up)))
              (with-priority 1 (wait-for go) (print 'middle))
              (:tag high (with-priority 2 (with-valve v (print 'high))))
              (with-priority 3 (wait-time 1) (evaporate high) (setf (value go) t)))",
        "middle\nclean-up\n=> t",
    );
}

/// r[valve.clean-up], r[valve.evaporated]
#[test]
fn a_clean_up_that_waits_for_the_valve_keeps_nobody_from_pre_empting_its_holder() {
    check(
        "(def-valve v)
         (par (:tag low (with-valve v (unwind-protect (wait-time 9) (with-valve v (print (list 'clean-up (now)))))))
              (with-priority 1 (wait-time 1) (with-valve v (wait-time 4) (print (list 'middle (now)))))
              (seq (wait-time 2) (evaporate low))
              (with-priority 3 (wait-time 3) (with-valve v (print (list 'high (now))) (wait-time 1))))",
        "(high 3.0)\n(middle 5.0)\n(clean-up 5.0)\n=> nil",
    );
}

/// r[valve.rest]
#[test]
fn while_a_clean_up_runs_in_the_subtree_nothing_is_suspended() {
    check(
        "(def-valve v)
         (with-policy (seq (wait-time 1) (with-valve v (print (list 'policy (now))) (wait-time 3)))
           (with-valve v (par (unwind-protect nil (wait-time 3) (print (list 'cleaned (now))))
                              (dotimes (i 4) (wait-time 0.75) (print (now))))))",
        "0.75\n1.5\n2.25\n(cleaned 3.0)\n(policy 3.0)\n6.0\n=> nil",
    );
}

/// r[valve.branch]
#[test]
fn the_branch_of_a_borrower_that_died_goes_on_when_the_valve_comes_back() {
    check(
        "(def-valve v)
         (with-valve v
           (par (par (:tag borrower (with-valve v (wait-time 9))) (dotimes (i 3) (wait-time 1) (print (list i (now)))))
                (with-priority 1 (wait-time 1.5) (with-valve v (wait-time 4)))
                (seq (wait-time 2) (evaporate borrower))))",
        "(0 1.0)\n(1 5.5)\n(2 6.5)\n=> nil",
    );
}

/// r[valve.leaving]
#[test]
fn a_task_that_leaves_goes_on_when_it_gives_a_valve_back() {
    check(
        "(def-valve v)
         (with-policy (seq (wait-time 1) (with-valve v (print 'policy)))
           (ignore-failures (failure)
             (unwind-protect (with-valve v (unwind-protect (fail \"x\") (wait-time 2) (print 'inner)))
               (print 'outer) (print 'still))))",
        "inner\nouter\nstill\npolicy\n=> nil",
    );
}

/// r[valve.hooks]
#[test]
fn scopes_that_are_interrupted_already_have_had_their_turn() {
    check(
        "(def-valve v)
         (with-policy (seq (wait-time 2) (with-valve v (print (list 'outside (now))) (wait-time 1)))
           (with-valve v
             (on-interrupt (print 'owner-down)
               (on-resume (print 'owner-up)
                 (par (with-valve v (on-interrupt (print 'down) (on-resume (print 'up) (wait-time 2))))
                      (with-priority 1 (wait-time 1) (with-valve v (wait-time 3))))))))",
        "down\nowner-down\n(outside 2.0)\nowner-up\nup\n=> nil",
    );
}

/// r[valve.hooks], r[valve.borrow]
#[test]
fn what_hooks_do_side_by_side_takes_turns() {
    check(
        "(def-valve v)
         (with-policy (seq (wait-time 1) (with-valve v (print (list 'lent (now)))))
           (with-valve v
             (on-interrupt (par (with-valve v (wait-time 1)) (with-valve v (print (list 'second (now)))))
               (wait-time 2))))",
        "(second 2.0)\n(lent 2.0)\n=> nil",
    );
}

/// The work of lines is counted: it grows with the logarithm of their length.
#[test]
fn a_crowd_that_waits_for_one_valve_is_served_and_dies_in_a_line() {
    let work = |places: usize, waiters: usize, end: &str| {
        let text = format!(
            "(def-valve v {places})
             (ignore-failures (timeout)
               (with-timeout 10
                 (par (with-valve v (wait-time 1))
                      (par-map (i (iota {waiters})) (with-valve v {end})))))
             (holds-valve? v)"
        );
        let mut system = rpl_tests::system(&text);
        while system.advance() == rpl_runtime::run::system::Progress::Running {}
        assert_eq!(rpl_tests::transcript(&mut system), "=> nil");
        system.machine.valve_work()
    };
    for (places, end) in [(1, "nil"), (1, "(wait-time 90)"), (3, "nil"), (3, "(wait-time 90)")] {
        let (few, many) = (work(places, 500, end), work(places, 4_000, end));
        assert!(many < few * 12, "{end}: 500 waiters before {places} places cost {few}, 4,000 cost {many}");
    }
}

/// As many valves as tasks: a death looks at those the task had to do with.
#[test]
fn a_crowd_of_tasks_with_a_valve_each_is_linear() {
    let work = |count: usize| {
        let mut text = String::new();
        (0..count).for_each(|number| text.push_str(&format!("(def-valve v{number})\n")));
        let tasks: Vec<String> = (0..count).map(|number| format!("(with-valve v{number} (wait-time 1))")).collect();
        text.push_str(&format!("(par {})", tasks.join(" ")));
        let mut system = rpl_tests::system(&text);
        while system.advance() == rpl_runtime::run::system::Progress::Running {}
        system.machine.valve_work()
    };
    let (few, many) = (work(250), work(2_000));
    assert!(many <= few * 9, "250 valves cost {few}, 2,000 cost {many}");
}

/// r[valve.rest], r[cleanup.protected]
#[test]
fn what_a_clean_up_starts_is_not_interrupted_from_outside() {
    // However the clean-up wraps what it does.
    for wrapped in [
        "(with-timeout 30 (put-back))",
        "(par (put-back))",
        "(with-priority -1 (put-back))",
        "(:tag home (put-back))",
        "(with-policy nil (put-back))",
        "(par nil (par (with-timeout 30 (put-back))))",
    ] {
        check(
            &format!(
                "(def-valve arm)
                 (def-plan put-back () (with-valve arm (wait-time 2) (print (list 'home (now)))))
                 (with-policy (seq (wait-time 1) (with-valve arm (print (list 'policy (now)))))
                   (unwind-protect nil {wrapped}))
                 nil"
            ),
            "(home 2.0)\n(policy 2.0)\n=> nil",
        );
    }
    check(
        "(def-valve arm)
         (def-plan p ()
           (with-policy (seq (wait-time 3) (with-valve arm (wait-time 2) (print (list 'policy (now)))))
             (par (:tag w (evap-protect (wait-time 9)
                            (par (with-valve arm (wait-time 2) (print (list 'put-back (now)))))))
                  (seq (wait-time 2) (evaporate w)))))
         (p)",
        "(put-back 4.0)\n=> nil",
    );
    // Inside one clean-up the rule is what it always is.
    check(
        "(def-valve arm)
         (unwind-protect nil
           (par (with-valve arm (wait-time 2) (print (list 'low (now))))
                (with-priority 1 (wait-time 1) (with-valve arm (wait-time 3) (print (list 'high (now)))))))
         nil",
        "(high 4.0)\n(low 4.0)\n=> nil",
    );
    // Who waits outside lends the clean-up its priority: then nobody inside is more important.
    check(
        "(def-valve arm)
         (with-policy (seq (wait-time 0.5) (with-valve arm (print (list 'policy (now)))))
           (unwind-protect nil
             (par (with-valve arm (wait-time 2) (print (list 'low (now))))
                  (with-priority -1 nil)
                  (with-priority 1 (wait-time 1) (with-valve arm (wait-time 1) (print (list 'high (now))))))))
         nil",
        "(low 2.0)\n(policy 2.0)\n(high 3.0)\n=> nil",
    );
}

/// r[priority.run], r[valve.clean-up]
#[test]
fn a_clean_up_that_comes_to_another_priority_keeps_its_place_among_those_that_are_ready() {
    check(
        "(def-valve v)
         (with-policy (seq (wait-time 1) (par (with-policy (wait-time 1) (print 'later)) (with-valve v)))
           (with-valve v (unwind-protect nil (wait-time 1) (print 'clean-up))))
         nil",
        "clean-up\nlater\n=> nil",
    );
}

/// r[valve.hooks-end]
#[test]
fn hooks_and_clean_ups_of_one_task_never_run_side_by_side() {
    let told = |waits: &str, hook: &str| {
        format!(
            "(def-valve arm)
             (def-plan p ()
               (par (:tag b (with-valve arm
                              (on-interrupt {hook}
                                (par (:tag inner
                                       (evap-protect (wait-time 10)
                                         (print (list 'begins (now)))
                                         (wait-time 2)
                                         (print (list 'ends (now))))))))) 
                    (with-priority 1 (wait-time 1) (with-valve arm))
                    {waits}))
             (p) nil"
        )
    };
    let hook = "(seq (wait-time 2) (print (list 'hook (now))))";
    // Its own hooks are ended.
    check(&told("(seq (wait-time 2) (evaporate b))", hook), "(begins 2.0)\n(ends 4.0)\n=> nil");
    // With their clean-ups.
    let careful = "(evap-protect (wait-time 2) (wait-time 1) (print (list 'hook-ended (now))))";
    check(&told("(seq (wait-time 2) (evaporate b))", careful), "(hook-ended 3.0)\n(begins 3.0)\n(ends 5.0)\n=> nil");
    // Those of a task above are waited for,
    check(&told("(seq (wait-time 2) (evaporate inner))", hook), "(hook 3.0)\n(begins 3.0)\n(ends 5.0)\n=> nil");
    // unless it is they who end it.
    let ends_it = "(seq (evaporate inner) (print (list 'hook (now))))";
    check(&told("nil", ends_it), "(begins 1.0)\n(ends 3.0)\n(hook 3.0)\n=> nil");
}

/// r[valve.circle]
#[test]
fn a_circle_through_what_is_suspended_is_told() {
    check(
        "(def-valve v1) (def-valve v3)
         (with-timeout 60
           (pursue (loop (wait-time 1))
             (par (seq (wait-time 1)
                       (with-priority 1
                         (with-failure-handling ((deadlock () (print (list 'deadlock (now)))))
                           (with-valve v1 (with-valve v3 (print 'both))))))
                  (with-valve v1 (with-priority 1 (with-valve v3 (wait-time 2)))))))
         (now)",
        "(deadlock 1.0)\n=> 2.0",
    );
    let told = run("(def-valve v)
         (def-plan p ()
           (with-timeout 60
             (par (loop (wait-time 1))
                  (:tag held (with-valve v (wait-time 5)))
                  (seq (wait-time 1) (with-task-suspended (held) (with-valve v (print 'both)))))))
         (p)");
    for part in ["failed: deadlock", "waits for valve v", "held is suspended by main/p"] {
        assert!(told.contains(part), "{told}");
    }
    // Whoever is only interrupted has the valve again when the other is done.
    check(
        "(def-valve v1) (def-valve v3)
         (par (with-valve v1 (with-valve v3 (wait-time 2)) (print (now)))
              (with-priority 1 (wait-time 1) (with-valve v1 (wait-time 5)))
              (seq (wait-time 2) (with-valve v3 (print 'last))))
         nil",
        "6.0\nlast\n=> nil",
    );
}

/// r[valve.decision]
#[test]
fn what_one_decision_ends_it_ends_before_a_valve_goes_on() {
    check(
        "(def-valve v)
         (pursue (seq (wait-time 1) 'won)
                 (with-valve v (wait-time 9))
                 (with-valve v (print 'never)))",
        "=> won",
    );
}
