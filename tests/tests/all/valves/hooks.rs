//! Hooks of those that are interrupted and go on.

use rpl_tests::check;

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
