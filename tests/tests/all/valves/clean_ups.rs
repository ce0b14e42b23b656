//! Clean-ups of those that hold a valve, or wait for one.

use rpl_tests::check;

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
