//! Fluents, networks, pulses, waiting.

use rpl_tests::run;

#[track_caller]
fn check(text: &str, expected: &str) {
    assert_eq!(run(text), expected, "{text}");
}

#[test]
fn an_equal_assignment_is_no_change() {
    check(
        "(def-fluent f '(1 2)) (defvar n 0)
         (par (seq (wait-for (changed f) :timeout 1) (print 'over))
              (seq (setf (value f) (list 1 2))))
         (now)",
        "over\n=> 1.0",
    );
}

#[test]
fn diamonds_have_no_glitches() {
    check(
        "(def-fluent a 1)
         (defvar b (fluent (* a 2))) (defvar c (fluent (+ a 10))) (defvar d (fluent (list a b c)))
         (defvar n (fluent (= b (* 2 a))))
         (par (whenever (not n) (print 'glitch))
              (seq (dotimes (i 5) (setf (value a) i)) (wait-time 1) (print (value d)) (fail \"end\")))",
        "(4 8 14)\nfailed: plan-failure: end",
    );
}

#[test]
fn wait_for_returns_the_value() {
    check("(def-fluent f 7) (wait-for f)", "=> 7");
    check("(def-fluent f nil) (par (print (wait-for f)) (pulse f))", "t\n=> nil");
    check("(def-fluent f nil) (list (wait-for f :timeout 2) (now))", "=> (nil 2.0)");
    check(
        "(def-fluent f 1) (par (print (wait-for (and (> f 3) (* f 2)))) (seq (setf (value f) 5) (setf (value f) 0)))",
        "10\n=> 0",
    );
    check("(def-fluent f nil) (list (wait-for f :timeout 0) (now))", "=> (nil 0.0)");
}

#[test]
fn waiters_are_woken_in_the_order_of_waiting() {
    check(
        "(def-fluent f nil) (par (seq (wait-time 0) (wait-for f) (print 1)) (seq (wait-for f) (print 2)) (seq (wait-for f) (print 3)) (seq (wait-time 1) (setf (value f) t)))",
        "2\n3\n1\n=> t",
    );
}

#[test]
fn whenever_runs_once_for_each_time() {
    check(
        "(def-fluent f 1) (pursue (whenever f (print (value f))) (seq (wait-time 1) (setf (value f) 2) (wait-time 1) (setf (value f) nil) (wait-time 1) (setf (value f) 3) (wait-time 1)))",
        "1\n3\n=> nil",
    );
    check(
        "(def-fluent f t) (pursue (whenever f (print 'p)) (seq (wait-time 1) (pulse f) (wait-time 1)))",
        "p\np\n=> nil",
    );
}

#[test]
fn whenever_and_what_is_missed() {
    let text = |mode: &str| {
        format!(
            "(def-fluent f nil)
             (pursue (whenever f {mode} (print (now)) (wait-time 10))
                     (seq (wait-time 1) (pulse f) (wait-time 1) (pulse f) (wait-time 1) (pulse f) (wait-time 30)))"
        )
    };
    check(&text(""), "1.0\n11.0\n=> nil");
    check(&text(":missed :once"), "1.0\n11.0\n=> nil");
    check(&text(":missed :always"), "1.0\n11.0\n21.0\n=> nil");
    check(&text(":missed :never"), "1.0\n=> nil");
}

#[test]
fn whenever_is_left_by_return() {
    check("(def-fluent f t) (whenever f (return 'out))", "=> out");
    check("(def-fluent f t) (whenever f (unwind-protect (return 'out) (print 'clean)))", "clean\n=> out");
}

#[test]
fn pulses() {
    check("(def-fluent f nil) (pulse f) (value f)", "=> nil");
    check("(def-fluent f nil) (par (seq (wait-for (not f)) (print 'at-once)) (seq (pulse f)))", "at-once\n=> nil");
    check(
        "(def-fluent f nil) (defvar c (count-pulses f)) (dotimes (i 3) (pulse f)) (setf (value f) 1) (value c)",
        "=> 3",
    );
    check(
        "(def-fluent f 3) (pursue (seq (wait-for (pulsed f)) 'pulsed) (seq (setf (value f) 4) (wait-time 1) (pulse f) (wait-time 1)))",
        "=> pulsed",
    );
    check(
        "(def-fluent f 3) (pursue (seq (wait-for (and (pulsed f) (> f 3))) (now)) (seq (pulse f) (wait-time 1) (setf (value f) 4) (wait-time 1) (pulse f) (wait-time 1)))",
        "=> 2.0",
    );
    check(
        "(def-fluent f 3) (def-fluent g nil) (pursue (seq (wait-for (and (changed f) g)) (now)) (seq (setf (value f) 4) (wait-time 1) (setf (value g) t) (wait-time 1) (pulse f) (wait-time 1) (setf (value f) 5) (wait-time 1)))",
        "=> 3.0",
    );
    check(
        "(def-fluent f nil) (pursue (seq (wait-for (> (count-pulses f) 2)) (now)) (loop (wait-time 1) (pulse f)))",
        "=> 3.0",
    );
    check("(def-fluent f nil) (defvar p (pulsed f)) (pulse f) (list (value p) (value (changed f)))", "=> (nil nil)");
}

#[test]
fn the_end_of_a_pulse_is_no_event() {
    check(
        "(def-fluent f nil) (defvar n 0)
         (pursue (whenever (not f) (incf n)) (seq (wait-time 1) (pulse f) (wait-time 1) (pulse f) (wait-time 1)))
         n",
        "=> 1",
    );
}

#[test]
fn networks_fail_where_they_are_waited_for() {
    check(
        "(def-fluent f 1) (defvar n (fluent (> f 3))) (setf (value f) 'a) (print 'still) (with-failure-handling ((type-error (e) 'there)) (value n))",
        "still\n=> there",
    );
    check(
        "(def-fluent f 1) (par (with-failure-handling ((type-error (e) (print 'woken))) (wait-for (> f 3))) (seq (wait-time 1) (setf (value f) 'a)))",
        "woken\n=> a",
    );
    check(
        "(def-fluent f 1) (par (with-failure-handling ((type-error (e) (print 'woken))) (whenever (> f 3) (print 'no))) (seq (wait-time 1) (setf (value f) 'a)))",
        "woken\n=> a",
    );
    check("(def-fluent f 'a) (defvar n (fluent (> f 3))) (setf (value f) 5) (value n)", "=> t");
}

#[test]
fn what_a_called_function_reads_counts() {
    check(
        "(def-fluent f 1) (defun big? () (> (value f) 3)) (par (seq (wait-for (big?)) (print (now))) (seq (wait-time 1) (setf (value f) 5)))",
        "1.0\n=> 5",
    );
}

#[test]
fn networks_may_only_look() {
    for text in [
        "(def-fluent f 1) (wait-for (setf (value f) 2))",
        "(def-fluent f 1) (wait-for (pulse f))",
        "(def-fluent f 1) (wait-for (seq (wait-time 1) f))",
        "(def-fluent f 1) (defvar x 1) (wait-for (setq x f))",
        "(wait-for 3)",
    ] {
        let result = run(text);
        assert!(result.starts_with("error["), "{text}\n{result}");
    }
    for text in [
        "(def-fluent f nil) (defun g () (setf (value f) 2)) (wait-for (g))",
        "(def-fluent f nil) (defun g () (wait-time 1)) (wait-for (and (not f) (g)))",
        "(def-fluent f nil) (defun g () (par 1 2)) (wait-for (and (not f) (g)))",
        "(def-fluent f nil) (setf (value (fluent (not f))) 2)",
        "(def-fluent f nil) (pulse (fluent (not f)))",
        "(def-fluent f 1) (+ f 1)",
    ] {
        let result = run(text);
        assert!(
            result.starts_with("failed: network-error") || result.starts_with("failed: type-error"),
            "{text}\n{result}"
        );
    }
}

#[test]
fn time() {
    check("(at-time 3) (at-time 2) (wait-time 0.5) (now)", "=> 3.5");
    check("(par (seq (wait-time 0) (print 1)) (print 2))", "2\n1\n=> 2");
}

#[test]
fn two_timers_of_one_deadline_fire_in_the_order_of_setting() {
    check("(par (seq (wait-time 1) (wait-time 1) (print 1)) (seq (wait-time 2) (print 2)))", "2\n1\n=> 2");
}
