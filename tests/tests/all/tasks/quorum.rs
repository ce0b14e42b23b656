//! Quorums: how many children must succeed, how many may fail, and the first n of `pursue-first-n`.

use rpl_tests::{check, run};

/// r[quorum.counts]
#[test]
fn par_pursue_and_try_all_are_quorums() {
    let bodies = [
        "(seq (wait-time 2) 'a) (seq (wait-time 1) 'b)",
        "(seq (wait-time 2) 'a) (seq (wait-time 1) (fail \"b\")) (seq (wait-time 3) 'c)",
        "(seq (wait-time 2) (fail \"a\")) (fail \"b\")",
        "(unwind-protect (wait-time 9) (print 'clean)) (seq (wait-time 1) 'b)",
    ];
    for body in bodies {
        for (construct, quorum) in [("par", ":all 1"), ("pursue", "1 1"), ("try-all", "1 :all")] {
            let run_of = |head: &str| {
                run(&format!(
                    "(with-failure-handling ((failure (f) (print (list (failure-class f) (map failure-message (failure-parts f))))))
                       ({head} {body}) (print 'succeeds))
                     (now)"
                ))
            };
            assert_eq!(run_of(construct), run_of(&format!("quorum {quorum}")), "{construct} {body}");
        }
    }
}

/// r[quorum.counts]
#[test]
fn a_quorum_lets_so_many_fail() {
    let body = "(seq (wait-time 2) 'a) (fail \"b\") (seq (wait-time 1) (fail \"c\")) (seq (wait-time 3) 'd)";
    check(&format!("(list (quorum :all 3 {body}) (now))"), "=> ((a d) 3.0)");
    check(&format!("(list (quorum 1 3 {body}) (now))"), "=> ((a) 2.0)");
    check(
        &format!(
            "(with-failure-handling ((composite-failure (f) (list (map failure-message (failure-parts f)) (now))))
               (quorum :all 2 {body}))"
        ),
        "=> ((\"b\" \"c\") 1.0)",
    );
    check("(quorum :all :all (fail \"a\") (fail \"b\"))", "failed: composite-failure: 2 of 2 failed");
    check("(quorum :all 2 (fail \"a\") (fail \"b\") (wait-time 1))", "failed: composite-failure: 2 of 3 failed");
    check("(quorum :all 5 (fail \"a\") 'b)", "=> (b)");
}

/// r[quorum.counts], r[construct.empty]
#[test]
fn the_numbers_of_a_quorum_are_from_1_on() {
    for (number, found) in [("0", "0"), ("-1", "-1"), ("1.0", "1.0"), (":most", ":most"), ("nil", "nil")] {
        for (numbers, which) in [(format!("{number} 1"), "successes"), (format!("1 {number}"), "failures")] {
            let result = run(&format!("(quorum {numbers} (print 'starts))"));
            let expected =
                format!("failed: type-error: the {which} of `quorum` must be an integer from 1 on or :all, and it is ");
            assert!(result.starts_with(&expected) && result.contains(found), "{result}");
        }
    }
    check("(let ((n 2)) (quorum n n 'a 'b 'c))", "=> (a b)");
    check("(quorum :all 1)", "=> nil");
    check(
        "(with-failure-handling ((composite-failure (f) (list (failure-message f) (failure-parts f))))
           (quorum 2 1 (print 'starts)))",
        "=> (\"only 1 of 1 can succeed, and 2 must\" nil)",
    );
    check("(quorum 1 1)", "failed: composite-failure: only 0 of 0 can succeed, and 1 must");
    assert!(run("(quorum 1)").starts_with("error[malformed]"));
    assert!(run("(wait-for (quorum 1 1 t))").starts_with("error[network-effect]"));
}

/// r[quorum.value], r[quorum.failure]
#[test]
fn a_quorum_has_the_values_and_failures_as_they_come() {
    check("(quorum 2 :all (seq (wait-time 3) 'a) (seq (wait-time 2) 'b) (seq (wait-time 1) 'c))", "=> (c b)");
    check("(quorum 2 :all (seq (wait-time 1) 'a) (seq (wait-time 1) 'b) (seq (wait-time 1) 'c))", "=> (a b)");
    // Its timer was set first, so it becomes ready first.
    check("(quorum 2 :all (seq (wait-time 0.5) (wait-time 0.5) 'a) (seq (wait-time 1) 'b))", "=> (b a)");
    check("(quorum 2 1 (wait-time 1) (fail \"only\") (wait-time 1))", "failed: plan-failure: only");
    check(
        "(with-failure-handling ((composite-failure (f) (map failure-message (failure-parts f))))
           (quorum 2 2 (seq (wait-time 2) (fail \"a\")) (seq (wait-time 1) (fail \"b\")) (wait-time 3) (wait-time 3)))",
        "=> (\"b\" \"a\")",
    );
}

/// r[quorum.reach], r[construct.evaporated]
#[test]
fn a_quorum_fails_as_soon_as_too_few_are_left() {
    check(
        "(with-failure-handling
             ((composite-failure (f) (list (failure-message f) (map failure-message (failure-parts f)) (now))))
           (par (quorum 2 :all (:tag a (wait-time 9)) (seq (wait-time 1) (fail \"b\"))
                               (evap-protect (wait-time 9) (print 'cut)))
                (seq (wait-time 2) (evaporate a))))",
        "cut\n=> (\"only 1 of 3 can succeed, and 2 must\" (\"b\") 2.0)",
    );
    check(
        "(with-failure-handling ((composite-failure (f) (list (failure-message f) (now))))
           (par (quorum 1 :all (:tag a (wait-time 9))) (evaporate a)))",
        "=> (\"only 0 of 1 can succeed, and 1 must\" 0.0)",
    );
    check("(par (quorum :all 1 (:tag a (wait-time 9)) (seq (wait-time 1) 'b)) (evaporate a) (now))", "=> 0.0");
}

/// r[pursue-first-n.first], r[construct.decide], r[construct.clean]
#[test]
fn pursue_first_n_has_the_first_n_values() {
    check(
        "(print (pursue-first-n 2
                  (evap-protect (wait-time 9) (seq (wait-time 1) (print 'clean)))
                  (seq (wait-time 2) 'slow)
                  (seq (wait-time 1) 'quick)
                  (seq (wait-time 2) (print 'never))))
         (now)",
        "clean\n(quick slow)\n=> 3.0",
    );
    check("(pursue-first-n 1 (seq (wait-time 2) 'a) (fail \"b\") (seq (wait-time 1) 'c))", "=> (c)");
    check("(pursue-first-n 2 (seq (wait-time 1) 'a) 'b)", "=> (b a)");
    // Children that have not started never start.
    check("(pursue-first-n 2 (print 'a) (print 'b) (print 'c))", "a\nb\n=> (a b)");
}

/// r[pursue-first-n.first]
#[test]
fn pursue_first_n_fails_when_fewer_than_n_can_succeed() {
    check(
        "(with-failure-handling
             ((composite-failure (f) (list (failure-message f) (map failure-message (failure-parts f)) (now))))
           (pursue-first-n 2
             (unwind-protect (wait-time 9) (print 'cut))
             (seq (wait-time 2) (fail \"a\"))
             (seq (wait-time 1) (fail \"b\"))))",
        "cut\n=> (\"only 1 of 3 can succeed, and 2 must\" (\"b\" \"a\") 2.0)",
    );
    check("(ignore-failures (composite-failure) (pursue-first-n 2 (fail \"a\") (print 'never)))", "=> nil");
    // A success before does not help.
    check(
        "(with-failure-handling ((composite-failure (f) (now)))
           (pursue-first-n 3 'a (wait-time 9) (seq (wait-time 1) (fail \"c\"))))",
        "=> 1.0",
    );
}

/// r[pursue-first-n.number]
#[test]
fn pursue_first_n_takes_a_number_of_its_forms() {
    for form in ["(pursue-first-n 0 1)", "(pursue-first-n 2 1)", "(pursue-first-n -1 1)", "(pursue-first-n \"1\" 1)"] {
        let found = run(form);
        assert!(found.contains("where N is from 1 to the number of forms"), "{form}\n{found}");
    }
    check("(let ((n 2)) (pursue-first-n n 'a 'b 'c))", "=> (a b)");
    for (number, found) in [("0", "0"), ("4", "4"), ("1.5", "1.5"), ("nil", "nil")] {
        check(
            &format!("(let ((n {number})) (pursue-first-n n (print 'a) (print 'b) (print 'c)))"),
            &format!(
                "failed: type-error: the number of `pursue-first-n` must be an integer from 1 to 3, and it is {found}"
            ),
        );
    }
}

/// r[pursue-first-n.first]
#[test]
fn pursue_first_n_under_policies_and_within_itself() {
    check(
        "(def-fluent battery 100)
         (with-policy (whenever (< battery 20) (print 'charge) (setf (value battery) 100))
           (print (pursue-first-n 2
                    (with-policy (seq (wait-time 1) (fail \"policy\")) (wait-time 5))
                    (with-policy (whenever (> battery 1000)) (wait-time 2) 'kept)
                    (seq (wait-time 3) (setf (value battery) 10) 'last)))
           (wait-time 1)
           (now))",
        "charge\n(kept last)\n=> 4.0",
    );
    check(
        "(pursue-first-n 2
           (pursue-first-n 1 (fail \"x\"))
           (pursue-first-n 2 (seq (wait-time 2) 'a) 'b (wait-time 9))
           (try-all (seq (wait-time 1) 'c)))",
        "=> (c (b a))",
    );
    check(
        "(ignore-failures (timeout) (with-timeout 2 (pursue-first-n 1 (unwind-protect (wait-time 9) (print (now))))))",
        "2.0\n=> nil",
    );
    check(
        "(par (:tag q (pursue-first-n 2 'a (evap-protect (wait-time 9) (print 'cut)))) (seq (wait-time 1) (evaporate q) (now)))",
        "cut\n=> 1.0",
    );
}
