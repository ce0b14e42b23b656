//! Policies and priorities: who runs first, and what a policy does to its body.

use rpl_tests::check;

/// r[policy.is], r[policy.before]
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

/// r[policy.end]
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

/// r[priority.list], r[policy.is]
#[test]
fn outer_policies_outrank_inner_ones() {
    check(
        "(def-fluent f nil)
         (with-policies ((whenever f (print 'outer)) (whenever f (print 'middle)))
           (with-policy (whenever f (print 'inner)) (seq (setf (value f) t) (print 'body))))",
        "outer\nmiddle\ninner\nbody\n=> body",
    );
}

/// r[priority.run], r[priority.switch]
#[test]
fn priorities_order_what_is_ready() {
    check(
        "(def-fluent go nil)
         (par (seq (wait-for go) (print 'plain)) (with-priority -1 (wait-for go) (print 'low)) (with-priority 1 (wait-for go) (print 'high))
              (seq (wait-time 1) (setf (value go) t) (print 'setter)))",
        "high\nsetter\nplain\nlow\n=> setter",
    );
}

/// r[priority.whole], r[priority.list]
#[test]
fn a_priority_is_a_list_of_whole_numbers() {
    check(
        "(def-fluent go nil)
         (par (with-priority 1.0 (wait-for go) (print 'first))
              (with-priority 1 (wait-for go) (print 'second))
              (with-priority 1 (with-priority 1 (wait-for go) (print 'deeper)))
              (with-priority 1 (with-priority -1 (wait-for go) (print 'below)))
              (seq (wait-time 1) (setf (value go) t)))",
        "deeper\nfirst\nsecond\nbelow\n=> t",
    );
    check(
        "(with-failure-handling ((type-error () (print 'refused))) (with-priority 1.5 (print 'ran)))",
        "refused\n=> refused",
    );
    // What is missing counts 0: the plain child began to wait first.
    check(
        "(def-fluent go nil)
         (par (with-priority 0 (wait-for go) (print 'zero)) (seq (wait-for go) (print 'plain))
              (seq (wait-time 1) (setf (value go) t)))",
        "plain\nzero\n=> t",
    );
}

/// r[priority.switch]
#[test]
fn a_task_that_is_switched_out_stays_at_the_front() {
    check(
        "(def-fluent go nil)
         (par (seq (wait-time 1) (print 'a) (setf (value go) t) (print 'a-goes-on))
              (seq (wait-time 1) (print 'b))
              (with-priority 1 (wait-for go) (print 'urgent)))",
        "a\nurgent\na-goes-on\nb\n=> urgent",
    );
    // No time slices: whatever it does, an equal waits until it blocks.
    check("(par (seq (dotimes (i 100000) (+ i 1)) (print 'long)) (print 'short))", "long\nshort\n=> short");
}

/// r[policy.before]
#[test]
fn the_body_rests_while_its_policy_has_something_to_run() {
    check(
        "(def-fluent f nil)
         (with-policy (whenever f (print 'one) (dotimes (i 1000) (+ i 1)) (print 'two) (wait-time 2) (print 'three))
           (setf (value f) t) (print 'body) (wait-time 1) (print (list 'goes-on (now))) (wait-time 3))",
        "one\ntwo\nbody\n(goes-on 1.0)\nthree\n=> nil",
    );
}

/// r[policy.end]
#[test]
fn a_policy_that_fails_ends_the_body_which_cleans_up_first() {
    check(
        "(with-failure-handling ((plan-failure (f) (list (failure-message f) (now))))
           (with-policy (seq (wait-time 1) (fail \"policy\")) (unwind-protect (wait-time 9) (wait-time 2))))",
        "=> (\"policy\" 3.0)",
    );
    check("(with-policies () 'body)", "=> body");
}
