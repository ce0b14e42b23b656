//! Fluents, networks, pulses, waiting.

use rpl_runtime::run::system::Progress;
use rpl_runtime::state::value::Value;
use rpl_tests::{check, run, system};

/// r[propagate.equal]
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

/// r[propagate.once]
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

/// r[wait-for.value], r[wait-for.timeout]
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

/// Networks that only read, add and compare are evaluated in a way of their own.
#[test]
fn a_network_has_the_value_it_has_where_a_function_is_called_in_it() {
    for form in [
        "(> a b)",
        "(< 2 a)",
        "(<= a 3.5)",
        "(= a b)",
        "(/= a b)",
        "(eq a 'x)",
        "(not (>= a b))",
        "(+ a b k)",
        "(- a b 1)",
        "(* a a)",
        "(and (> a 1) (* a 2))",
        "(or (not a) (not b) k)",
        "(if (> a b) (1+ a) unset)",
    ] {
        for (a, b) in
            [("1", "2"), ("2.5", "2"), ("3", "2.5"), ("'x", "2"), ("9223372036854775807", "1"), ("nil", "nil")]
        {
            let network = |form: &str| {
                run(&format!(
                    "(def-fluent a 3) (def-fluent b 3) (defvar k 7) (defun same (x) x) (defun later () unset)
                     (defvar n (fluent {form})) (setf (value b) {b}) (setf (value a) {a}) (print (value n)) (defvar unset 1)"
                ))
            };
            assert_eq!(network(form), network(&format!("(same {form})")), "{form} of {a} and {b}");
        }
    }
}

/// r[wait-for.order]
#[test]
fn waiters_are_woken_in_the_order_of_waiting() {
    check(
        "(def-fluent f nil) (par (seq (wait-time 0) (wait-for f) (print 1)) (seq (wait-for f) (print 2)) (seq (wait-for f) (print 3)) (seq (wait-time 1) (setf (value f) t)))",
        "2\n3\n1\n=> t",
    );
}

/// r[whenever.rounds], r[whenever.staying]
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

/// r[whenever.missed]
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

/// r[whenever.rounds], r[loop.value]
#[test]
fn whenever_is_left_by_return() {
    check("(def-fluent f t) (whenever f (return 'out))", "=> out");
    check("(def-fluent f t) (whenever f (unwind-protect (return 'out) (print 'clean)))", "clean\n=> out");
}

/// r[pulse.is], r[derived.pulsed], r[derived.count]
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

/// r[pulse.is]
#[test]
fn the_end_of_a_pulse_is_no_event() {
    check(
        "(def-fluent f nil) (defvar n 0)
         (pursue (whenever (not f) (incf n)) (seq (wait-time 1) (pulse f) (wait-time 1) (pulse f) (wait-time 1)))
         n",
        "=> 1",
    );
}

/// r[network.failure]
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

/// r[network.failure]
#[test]
fn the_failure_of_a_network_names_the_task_that_waits_and_its_calls() {
    let watch = "(def-fluent y 1) (def-fluent n 2) (def-plan watch () FORM) (def-plan guarding () (watch) 1)";
    let later = "(par (:tag guard (wait-time 1) (guarding)) (seq (wait-time 2) (setf (value y) 3)))";
    for (form, path) in [
        ("(wait-for (> (/ 1 (- (value y) 1)) 5))", "main/guard/guarding/watch"),
        ("(wait-for (> (/ 1 (- (value y) 3)) 5))", "main/guard/guarding/watch"),
        ("(whenever (> (/ 1 (- (value y) 3)) 5) 1)", "main/guard/guarding/watch"),
        ("(value (fluent (/ 1 (- (value y) 1))))", "main/guard/guarding/watch"),
    ] {
        let mut system = system(&format!("{} {later}", watch.replace("FORM", form)));
        while system.advance() == Progress::Running {}
        let machine = &system.machine;
        let Value::Failure(failure) = *machine.tasks[machine.main].value() else { panic!("{form} fails") };
        let failure = &machine.heap.failures[failure];
        let calls: Vec<_> = failure.calls.iter().map(|&(name, _)| machine.symbols.name(name)).collect();
        assert_eq!((&*failure.path, calls), (path, vec!["watch", "guarding"]), "{form}");
        assert!(failure.span.is_some(), "{form}");
    }
}

/// r[fluent.calls]
#[test]
fn what_a_called_function_reads_counts() {
    check(
        "(def-fluent f 1) (defun big? () (> (value f) 3)) (par (seq (wait-for (big?)) (print (now))) (seq (wait-time 1) (setf (value f) 5)))",
        "1.0\n=> 5",
    );
}

/// r[network.look], r[network.constant], r[fluent.object]
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
    let asked = run("(wait-for (project '(wait-time 1)))");
    assert!(asked.contains("network-error") && asked.contains("`project` cannot be called while"), "{asked}");
}

/// r[time.waits]
#[test]
fn time() {
    check("(at-time 3) (at-time 2) (wait-time 0.5) (now)", "=> 3.5");
    check("(par (seq (wait-time 0) (print 1)) (print 2))", "2\n1\n=> 2");
}

/// r[time.order]
#[test]
fn two_timers_of_one_deadline_fire_in_the_order_of_setting() {
    check("(par (seq (wait-time 1) (wait-time 1) (print 1)) (seq (wait-time 2) (print 2)))", "2\n1\n=> 2");
}

/// r[fluent.is]
#[test]
fn a_fluent_is_read_assigned_and_pulsed() {
    check(
        "(global-fluent f 3)
         (let ((g (create-fluent nil)))
           (setf (value f) 4 (value g) (+ (value f) 1))
           (incf (value g))
           (pulse f)
           (list (value f) (value g) (fluentp f) (fluentp 3)))",
        "=> (4 6 t nil)",
    );
}

/// r[fluent.position], r[fluent.arguments]
#[test]
fn in_fluent_position_a_fluent_stands_for_its_value() {
    // A local variable, a value of a function, and a status all count.
    check(
        "(def-fluent level 0)
         (def-plan p (local)
           (par (:tag worker (wait-time 1) (setf (value local) 2) (wait-time 1))
                (seq (wait-for (and (> local 1) (eq (status worker) 'blocked) (not (end-task worker)))) (print (now)))))
         (p level)",
        "1.0\n=> 1.0",
    );
    // What `pulsed` takes is the fluent itself, which may be nil.
    check(
        "(def-fluent f nil) (par (seq (wait-for (or (pulsed f) (changed f))) (now)) (seq (wait-time 1) (pulse f)))",
        "=> nil",
    );
    check("(def-fluent f 2) (list (wait-for (value f)) (wait-for (+ (value f) f)))", "=> (2 4)");
}

/// r[fluent.object]
#[test]
fn elsewhere_a_fluent_is_an_object() {
    for text in ["(+ f 1)", "(= f 1)", "(< 1 f)", "(sqrt f)"] {
        let found = run(&format!("(def-fluent f 1) {text}"));
        assert!(found.starts_with("failed: type-error") && found.contains("write `(value f)`"), "{text}\n{found}");
    }
    check("(def-fluent f 1) (defun g (x) (value x)) (g f)", "=> 1");
}

/// r[derived.fluent]
#[test]
fn a_network_is_a_value() {
    check(
        "(def-fluent a 1) (def-fluent b 1)
         (defun both (x y) (fluent (and (> x 3) (> y 3))))
         (let ((ready (both a b)))
           (par (seq (wait-for ready) (print (now)))
                (seq (wait-time 1) (setf (value a) 9) (wait-time 1) (setf (value b) 9)))
           (list (value ready) (fluentp ready)))",
        "2.0\n=> (t t)",
    );
}

/// r[propagate.once]
#[test]
fn a_network_of_networks_is_brought_up_to_date_once() {
    check(
        "(def-fluent a 1)
         (defvar turns 0)
         (defvar b (fluent (+ a 1)))
         (defvar c (fluent (* b 10)))
         (defvar d (fluent (- c b)))
         (let ((seen (create-fluent 0)))
           (pursue (whenever (changed d) (incf (value seen)))
                   (seq (setf (value a) 2) (wait-time 1) (setf (value a) 3) (wait-time 1)))
           (list (value seen) (value d)))",
        "=> (2 36)",
    );
}

/// r[pulse.is]
#[test]
fn in_a_pulse_only_what_is_nil_reads_as_true() {
    check(
        "(def-fluent f nil) (def-fluent g 7) (par (print (wait-for (and f g))) (seq (pulse f) (pulse g)))",
        "7\n=> nil",
    );
    check(
        "(def-fluent f nil) (pursue (seq (wait-for (changed f)) 'changed) (seq (pulse f) (wait-time 1) 'pulse))",
        "=> pulse",
    );
    check(
        "(def-fluent f 1) (pursue (seq (wait-for (pulsed f)) 'pulsed) (seq (setf (value f) 2) (wait-time 1) 'change))",
        "=> change",
    );
}

/// r[wait-for.kept]
#[test]
fn a_woken_wait_does_not_test_again() {
    check(
        "(def-fluent f nil)
         (par (seq (print (wait-for f)) (print (value f)))
              (seq (wait-time 1) (setf (value f) 'yes) (setf (value f) nil)))",
        "yes\nnil\n=> nil",
    );
    // The first wake-up counts: a signal before the deadline, the condition before the next value.
    check(
        "(def-fluent f nil)
         (par (:tag a (print (wait-for f)))
              (seq (wait-time 1) (suspend a) (setf (value f) 'first) (setf (value f) 'second) (wait-time 1) (resume a)))",
        "first\n=> nil",
    );
}

/// r[whenever.missed]
#[test]
fn becoming_true_again_during_a_round_is_not_lost() {
    check(
        "(def-fluent f nil)
         (pursue (whenever f (print (now)) (wait-time 5))
                 (seq (wait-time 1) (setf (value f) t) (setf (value f) nil) (wait-time 1) (setf (value f) t) (wait-time 20)))",
        "1.0\n6.0\n=> nil",
    );
}

/// r[whenever.missed], r[wait-for.kept]
#[test]
fn what_happens_before_a_round_begins_belongs_to_it() {
    let text = |mode: &str| {
        format!(
            "(def-fluent f nil)
             (par (:tag a (whenever f {mode} (print (now))))
                  (seq (wait-time 1) (suspend a) (pulse f) (wait-time 1) (pulse f) (wait-time 1) (resume a)
                       (wait-time 1) (evaporate a)))"
        )
    };
    check(&text(""), "3.0\n=> nil");
    check(&text(":missed :always"), "3.0\n3.0\n=> nil");
    check(&text(":missed :never"), "3.0\n=> nil");
}

/// r[network.failure]
#[test]
fn a_failing_network_hurts_nobody_else() {
    check(
        "(def-fluent f 1) (def-fluent other nil)
         (defvar broken (fluent (> f 3)))
         (par (seq (wait-for other) (print 'untouched))
              (with-failure-handling ((type-error () (print 'mine))) (wait-for broken))
              (seq (wait-time 1) (setf (value f) 'a) (print 'assigned) (setf (value other) t)))",
        "assigned\nmine\nuntouched\n=> t",
    );
}

/// r[time.waits]
#[test]
fn negative_times() {
    for text in ["(wait-time -1)", "(wait-time 'a)"] {
        let found = run(text);
        assert!(found.starts_with("failed: type-error"), "{text}\n{found}");
    }
    check("(def-fluent f nil) (list (wait-for f :timeout -1) (at-time -3) (now))", "=> (nil nil 0.0)");
    check(
        "(par (seq (wait-time 0) (print 'end)) (with-priority -1 (print 'low)) (print 'line))",
        "line\nend\nlow\n=> line",
    );
}

/// r[wait-for.order]
#[test]
fn whoever_one_propagation_wakes_is_woken_in_the_order_of_waiting() {
    // The network the first waits for is brought up to date last.
    check(
        "(def-fluent f nil)
         (def-fluent g (fluent (and f t)))
         (def-fluent h (fluent (and g t)))
         (par (seq (wait-for h) (print 1))
              (seq (wait-for f) (print 2))
              (seq (wait-for (and g t)) (print 3))
              (whenever f (print 4) (return nil))
              (seq (wait-for f) (print 5))
              (seq (wait-time 1) (setf (value f) t)))",
        "1\n2\n3\n4\n5\n=> t",
    );
    check(
        "(def-fluent f nil)
         (par (seq (wait-for f) (print 1)) (whenever f (print 2) (return nil)) (seq (wait-for f) (print 3))
              (seq (wait-time 1) (pulse f)))",
        "1\n2\n3\n=> nil",
    );
}
