//! Limits: nothing a plan does can hang or crash the program.

use rpl_runtime::run::system::Progress;
use rpl_tests::{run, system, transcript};

fn run_limited(text: &str, steps: u32, bytes: usize) -> String {
    let mut system = system(text);
    system.machine.limits.steps = steps;
    system.machine.limits.bytes = bytes;
    while system.advance() == Progress::Running {}
    if let Err(broken) = system.machine.check_invariants() {
        panic!("{text}: {broken}");
    }
    transcript(&mut system)
}

#[track_caller]
fn fails(text: &str, class: &str) {
    let result = run_limited(text, 100_000, 1 << 24);
    let last = result.lines().find(|line| line.starts_with("failed: ")).unwrap_or(&result).to_string();
    assert!(last.starts_with(&format!("failed: {class}")), "{text}\n{result}");
}

/// r[limit.steps]
#[test]
fn a_runaway_fails_and_can_be_handled_once() {
    fails("(loop)", "runaway");
    let handled = "(with-failure-handling ((runaway (f) 'caught)) (loop))";
    assert_eq!(run_limited(handled, 1_000, 1 << 30), "=> caught");
}

/// r[limit.steps]
#[test]
fn what_fails_without_end_spends_steps_by_its_failures() {
    let failed = "(defvar n 0) (with-failure-handling ((runaway (f) n))
        (with-failure-handling ((plan-failure (f) (incf n) (retry))) (fail \"x\")))";
    let shown = run_limited(failed, 256 * 100, 1 << 30);
    let times: u32 = shown.strip_prefix("=> ").and_then(|times| times.parse().ok()).expect(&shown);
    assert!((80..=100).contains(&times), "{times} failures of 256 steps each");
}

/// r[limit.twice]
#[test]
fn a_second_runaway_in_one_instant_passes_handlers() {
    fails("(loop (ignore-failures (failure) (loop)))", "runaway");
    fails("(loop (ignore-failures (failure) (par (loop))))", "runaway");
    fails("(loop (par (ignore-failures (failure) (loop))))", "runaway");
    fails("(loop (ignore-failures (failure) (try-all (loop) (fail \"x\"))))", "composite-failure");
    fails("(with-failure-handling ((runaway (f) (retry))) (loop))", "runaway");
    let later = "(dotimes (i 5) (ignore-failures (failure) (loop)) (wait-time 1)) (now)";
    assert_eq!(run_limited(later, 1_000, 1 << 30), "=> 5.0");
}

/// r[time.microseconds], r[limit.steps]
#[test]
fn no_time_passes_for_free() {
    fails("(loop (ignore-failures (timeout) (with-timeout 0 (wait-time 5))))", "runaway");
    fails("(loop (wait-time 0.0000001))", "runaway");
    fails("(loop (wait-time 0))", "runaway");
    fails(
        "(def-fluent f nil) (par (whenever f (setf (value f) nil)) (loop (setf (value f) t) (wait-time 0)))",
        "runaway",
    );
}

/// r[limit.steps], r[limit.twice]
#[test]
fn tasks_that_start_or_wake_each_other_without_end_run_away_together() {
    fails("(defun step () (spawn (step))) (def-plan chain () (spawn (step)) (wait-time 1)) (chain)", "runaway");
    fails(
        "(defun step () (spawn (wait-time 0) (step))) (def-plan chain () (spawn (step)) (wait-time 1)) (chain)",
        "runaway",
    );
    fails("(def-plan f () (par (f))) (with-timeout 5 (f))", "runaway");
    // Neither is more than a moment at work when it is its turn.
    fails(
        "(def-fluent ping nil) (def-fluent pong nil)
         (par (loop (wait-for ping) (setf (value ping) nil) (setf (value pong) t))
              (loop (wait-for pong) (setf (value pong) nil) (setf (value ping) t))
              (setf (value ping) t))",
        "runaway",
    );
    let caught = "(defun step () (spawn (step))) (def-plan chain () (spawn (step)) (wait-time 1))
                  (with-failure-handling ((runaway () 'caught)) (with-timeout 5 (chain)))";
    assert_eq!(run_limited(caught, 100_000, 1 << 30), "=> caught");
    // Where each lets time pass, nothing runs away.
    let later = "(defvar n 0)
                 (defun step () (incf n) (wait-time 0.001) (when (< n 5000) (spawn (step))))
                 (def-plan chain () (spawn (step)) (wait-time 10)) (chain) n";
    assert_eq!(run_limited(later, 10_000, 1 << 30), "=> 5000");
}

/// r[cleanup.limits]
#[test]
fn a_clean_up_has_limits_too() {
    fails("(unwind-protect (loop) (loop))", "runaway");
    fails("(def-fluent f nil) (unwind-protect (fail \"x\") (wait-for f))", "plan-failure");
    fails("(def-fluent f nil) (unwind-protect 1 (loop (ignore-failures (failure) (wait-for f))))", "deadlock");
    fails("(def-fluent f nil) (par (unwind-protect (wait-for f) (par (wait-for f) (wait-for f))))", "deadlock");
}

/// r[limit.frames], r[limit.memory]
#[test]
fn runaway_recursion_and_allocation() {
    fails("(defun f (n) (+ 1 (f n))) (f 1)", "");
    let deep = run("(defun f (n) (+ 1 (f n))) (f 1)");
    assert!(deep.starts_with("failed: stack-overflow"), "{deep}");
    fails("(defvar l nil) (loop (push 1 l))", "");
    let wide = run_limited("(defvar l nil) (loop (push (list 1 2 3 4) l))", 100_000_000, 1 << 24);
    assert!(wide.starts_with("failed: out-of-memory"), "{wide}");
    let tasks = run_limited("(def-plan f () (par (f) 1)) (f)", 100_000_000, 1 << 26);
    assert!(tasks.starts_with("failed: out-of-memory"), "{}", &tasks[..200]);
}

/// r[limit.network]
#[test]
fn a_network_that_runs_away_is_a_failure() {
    fails("(def-fluent f 1) (defun g (x) (loop)) (wait-for (g f))", "runaway");
    fails(
        "(def-fluent f 1) (defun g (x) (if (> x 1) (loop) nil)) (defvar n (fluent (g f))) (loop (setf (value f) (+ 1 (value f))))",
        "runaway",
    );
}

/// r[deadlock.all]
#[test]
fn main_deadlocked_names_what_everybody_waits_for() {
    let result = run(
        "(def-fluent f nil) (def-plan p () (par (wait-for f) (:tag a (wait-for (eq f 3)))))(ignore-failures (error) (p))",
    );
    assert!(result.contains("failed: deadlock"), "{result}");
    assert!(result.contains("main/p/par[0] waits for fluent f"), "{result}");
    let once = run("(def-fluent f nil) (ignore-failures (deadlock) (wait-for f)) 'on");
    assert_eq!(once, "=> on");
    let twice = run("(def-fluent f nil) (loop (ignore-failures (deadlock) (wait-for f)))");
    assert!(twice.starts_with("failed: deadlock"), "{twice}");
    let suspended = run("(suspend (this-task))");
    assert!(suspended.contains("main is suspended"), "{suspended}");
}

#[test]
fn a_hundred_thousand_nested_tasks() {
    let nested = "(defun nest (n) (if (= n 0) (wait-time 1) (par (nest (- n 1))))) ";
    assert_eq!(run(&format!("{nested} (nest 100000) (now)")), "=> 1.0");
    assert_eq!(run(&format!("{nested} (pursue (nest 100000) (wait-time 0.5)) (now)")), "=> 0.5");
    let failing = "(defun nest (n) (if (= n 0) (fail \"x\") (try-all (nest (- n 1))))) (ignore-failures (failure) (nest 20000)) (quote done)";
    assert_eq!(run(failing), "=> done");
    let cleaned =
        "(defvar n 0) (defun nest (k) (if (= k 0) (wait-time 9) (par (evap-protect (nest (- k 1)) (incf n)))))
                   (pursue (nest 100000) (wait-time 1)) n";
    assert_eq!(run(cleaned), "=> 100000");
}

#[test]
fn a_hundred_thousand_tasks_beside_one_another() {
    let many = "(let ((l nil)) (dotimes (i 100000) (push i l)) ";
    assert_eq!(
        run(&format!(
            "{many} (par-map (x l) x) (par-map (x l) (wait-time 1) x) (pursue-map (x l) (wait-time 1) x) (now))"
        )),
        "=> 2.0"
    );
    assert_eq!(run("(def-plan p () (dotimes (i 100000) (spawn (wait-time 1))) (wait-time 2)) (p) (p) (now)"), "=> 4.0");
    assert_eq!(run("(def-plan p () (dotimes (i 100000) (spawn (wait-time 9)))) (p) (now)"), "=> 0.0");
    assert_eq!(
        run(
            "(def-fluent f nil) (def-plan p () (dotimes (i 100000) (spawn (wait-for f))) (wait-time 1) (setf (value f) t) (wait-time 1)) (p) (now)"
        ),
        "=> 2.0"
    );
}

#[test]
fn two_thousand_requests_of_one_valve() {
    assert_eq!(
        run(
            "(def-valve v) (def-plan p () (dotimes (i 2000) (spawn (with-valve v (wait-time 0)))) (wait-time 1)) (p) (now)"
        ),
        "=> 1.0"
    );
}

#[test]
fn walking_long_data_costs_steps() {
    for walk in ["(append l nil)", "(sort < l)", "(equal l (copy-list l))", "(write-to-string l)"] {
        let text =
            format!("(defvar l nil) (dotimes (i 1000) (push i l)) (wait-time 1) (dotimes (i 100) {walk}) 'cheap");
        let (scarce, ample) = (run_limited(&text, 20_000, 1 << 28), run_limited(&text, 10_000_000, 1 << 28));
        assert!(scarce.contains("failed: runaway"), "{walk}: {scarce}");
        assert_eq!(ample, "=> cheap", "{walk}");
    }
}

#[test]
fn a_partial_order_starts_each_step_when_all_before_it_are_done() {
    let text = "(plan ((:tag a (print 'a)) (:tag b (print 'b)) (:tag c (wait-time 1) (print 'c)) (:tag d (print 'd)))
                  (:order a d) (:order c d) (:order d b))";
    let result = run_limited(text, 100_000, 1 << 24);
    let printed: Vec<&str> = result.lines().take(4).collect();
    assert_eq!(printed, ["a", "c", "d", "b"], "{result}");
}

/// r[limit.arguments]
#[test]
fn what_is_written_out_has_limits() {
    let parameters = |count: usize| (0..count).map(|n| format!("p{n}")).collect::<Vec<_>>().join(" ");
    let arguments = |count: usize| vec!["1"; count].join(" ");
    let sum = |count: usize| format!("(defun f ({}) p0) (f {})", parameters(count), arguments(count));
    assert_eq!(run(&sum(200)), "=> 1");
    assert!(run(&sum(201)).starts_with("error["), "{}", run(&sum(201)));
    assert_eq!(run(&format!("(par {})", arguments(10_000))), "=> 1");
    let found = run(&format!("(par {})", arguments(10_001)));
    assert!(found.starts_with("error["), "{}", &found[..found.len().min(300)]);
}

/// r[limit.steps], r[fail.carries]
#[test]
fn a_runaway_is_told_with_its_place_and_what_to_do() {
    let result = run_limited("(defun spin () (loop)) (spin)", 1_000, 1 << 30);
    assert!(result.starts_with("failed: runaway: 1000 steps in one instant"), "{result}");
    assert!(result.contains("(wait-time 0.1)"), "{result}");
}

/// r[limit.network]
#[test]
fn a_macro_that_runs_away_has_the_steps_it_is_told_to_have() {
    let result = run("(defmacro spin () (loop)) (spin)");
    assert!(result.contains("runaway: 20000000 steps in one instant"), "{result}");
}

/// r[network.circle]
#[test]
fn a_network_computed_from_itself_fails() {
    let plan = "(def-fluent level 0) (defvar own nil)
                (defvar net (fluent (+ (value level) (if own (value own) 0) 1)))
                (setq own net)
                (setf (value level) 1)
                (with-failure-handling ((network-error () 'circle)) (value net))";
    assert_eq!(run(plan), "=> circle");
}

/// r[limit.frames], r[limit.memory]
#[test]
fn a_limit_can_be_handled() {
    let deep = "(defun f (n) (+ 1 (f n))) (with-failure-handling ((stack-overflow () 'deep)) (f 1))";
    assert_eq!(run(deep), "=> deep");
    let wide =
        "(defvar l nil) (with-failure-handling ((out-of-memory () (setq l nil) 'wide)) (loop (push (list 1 2 3) l)))";
    assert_eq!(run_limited(wide, 100_000_000, 1 << 24), "=> wide");
}
