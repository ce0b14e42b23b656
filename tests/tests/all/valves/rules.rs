//! Lines, borrowing, and interruption.

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

/// r[valve.calls]
#[test]
fn releasing_what_one_does_not_hold_is_an_error() {
    check("(def-valve v) (with-failure-handling ((valve-error () 'error)) (release-valve v))", "=> error");
    check(
        "(def-valve v) (request-valve v) (release-valve v) (with-failure-handling ((valve-error () 'error)) (release-valve v))",
        "=> error",
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
