//! Time, trace and determinism, without a robot.

use rpl_runtime::run::system::{Outcome, Progress, System};
use rpl_runtime::state::trace::{Event, EventKind};
use rpl_runtime::state::value::Value;
use rpl_tests::{library, run, system, transcript};
use std::collections::BTreeSet;

/// A plan in which everything happens that a plan without a robot can do.
const EVERYTHING: &str = "
(def-valve arm)
(def-fluent bell nil)
(def-plan serve (who)
  (with-valve arm (on-interrupt (log \"tray down\") (wait-time 2) (log who))))
(with-policy (whenever bell (with-valve arm (wait-time 1)))
  (measure 'served 1)
  (par (serve 'first)
       (seq (wait-time 1) (setf (value bell) t) (pulse bell))
       (ignore-failures (timeout) (with-timeout 0.5 (unwind-protect (wait-time 9) (fail \"late\"))))))
";

fn trace_of(text: &str) -> Vec<Event> {
    let mut system = system(text);
    system.machine.trace.enabled = true;
    while system.advance() == Progress::Running {}
    system.machine.trace.take()
}

/// r[trace.events]
#[test]
fn the_trace_tells_all_that_happened() {
    let events = trace_of(EVERYTHING);
    let kinds: BTreeSet<&str> = events.iter().map(|event| event.kind.name()).collect();
    for kind in [
        "begin", "end", "call", "return", "blocked", "woken", "fluent", "pulse", "valve", "failed", "handled", "log",
        "measured", "warning",
    ] {
        assert!(kinds.contains(kind), "no event of kind {kind}: {kinds:?}");
    }
    let numbers: Vec<u64> = events.iter().map(|event| event.sequence).collect();
    assert!(numbers.windows(2).all(|pair| pair[0] < pair[1]), "{numbers:?}");
    assert!(events.windows(2).all(|pair| pair[0].time_us <= pair[1].time_us));
    let called = events.iter().find(|event| event.kind == EventKind::Call).expect("a plan is called");
    assert_eq!(called.path, "main/with-policy[1]/par[0]/serve");
    assert_eq!(called.details, [("arguments".to_string(), "'first".to_string())]);
}

/// r[trace.events]
#[test]
fn a_plan_call_has_its_arguments_as_they_stand_in_a_call() {
    let plans = "(def-plan one (a &optional b c) a) (def-plan all (&rest more) more)
        (def-plan some (&key far near) far) (def-plan none () 1)";
    let arguments = |call: &str| {
        let events = trace_of(&format!("{plans} {call}"));
        let called = events.into_iter().find(|event| event.kind == EventKind::Call).expect("a plan is called");
        called.details.into_iter().map(|(name, value)| format!("{name} {value}")).collect::<Vec<_>>().join(" ")
    };
    assert_eq!(arguments("(one 'basin)"), "arguments 'basin");
    assert_eq!(arguments("(one \"a\" nil 2.5)"), "arguments \"a\" nil 2.5");
    assert_eq!(arguments("(one '(a (b c) 3))"), "arguments '(a (…) 3)");
    assert_eq!(arguments("(one (make-vector 100000 1))"), "arguments #(…)");
    assert_eq!(arguments(&format!("(one \"{}\")", "ä".repeat(90_000))), format!("arguments \"{}…\"", "ä".repeat(100)));
    assert_eq!(arguments("(one (range 1 100))"), "arguments '(1 2 3 4 5 6 7 8 …)");
    assert_eq!(arguments("(all 1 'two :three)"), "arguments 1 'two :three");
    assert_eq!(arguments("(some :near 'here)"), "arguments :near 'here");
    assert_eq!(arguments("(none)"), "");
}

/// r[determinism.same], r[determinism.value]
#[test]
fn the_same_text_gives_the_same_trace_and_so_does_a_fork() {
    assert_eq!(trace_of(EVERYTHING), trace_of(EVERYTHING));
    let text = "(dotimes (i 5) (wait-time 1) (print (random 1000)))";
    let mut whole = system(text);
    let mut fork = None;
    while whole.advance() == Progress::Running {
        if whole.machine.now_us == 2_000_000 {
            fork = Some(whole.fork());
        }
    }
    let mut fork = fork.expect("two seconds pass");
    while fork.advance() == Progress::Running {}
    assert_eq!(transcript(&mut whole), transcript(&mut fork));
}

/// r[time.instant], r[time.order], r[time.microseconds]
#[test]
fn a_run_is_a_sequence_of_instants() {
    let computing = "(print (now)) (dotimes (i 100000) (* i i)) (print (now)) (wait-time 1h) (now)";
    assert_eq!(run(computing), "0.0\n0.0\n=> 3600.0");
    // All that is ready in an instant runs before time goes on.
    assert_eq!(
        run("(def-fluent f nil)
             (par (seq (wait-time 1) (setf (value f) t)) (seq (wait-for f) (print (list 'woken (now)))) (seq (wait-time 1.000001) (print 'next)))"),
        "(woken 1.0)\nnext\n=> next"
    );
    assert_eq!(run("(wait-time 0.5000004) (now)"), "=> 0.5");
    // The end of a wait comes before a deadline of the same time, whichever was set first.
    assert_eq!(run("(with-timeout 1 (wait-time 1) 'in-time)"), "=> in-time");
    assert_eq!(
        run("(par (seq (wait-time 0.3) (wait-time 0.7) (print 'set-later)) (seq (wait-time 1) (print 'set-first)))"),
        "set-first\nset-later\n=> set-first"
    );
}

/// r[fail.carries], r[task.path]
#[test]
fn a_failure_carries_place_task_calls_and_parts() {
    let text =
        "(def-plan inner (x) (par (map (lambda (y) (+ y 'a)) (list x))))\n(def-plan outer () (inner 1))\n(outer)";
    let mut system = System::without_robot(library(), "test.rpl", text, 0).expect("it compiles");
    while system.advance() == Progress::Running {}
    let Some(Outcome::Failed(Value::Failure(failure))) = system.outcome() else { panic!("it does not fail") };
    let record = &system.machine.heap.failures[failure];
    assert_eq!(record.path, "main/outer/inner/par[0]");
    assert_eq!(record.calls.len(), 2, "{:?}", record.calls);
    let span = record.span.expect("a place");
    assert_eq!(&text[span.start as usize..span.end as usize], "(+ y 'a)");
    // Inside the library the place is that of the call.
    let text = "(def-plan p () (wait-time 1) (list (map 1+ 3)))\n(p)";
    let mut system = System::without_robot(library(), "test.rpl", text, 0).expect("it compiles");
    while system.advance() == Progress::Running {}
    let Some(Outcome::Failed(Value::Failure(failure))) = system.outcome() else { panic!("it does not fail") };
    let span = system.machine.heap.failures[failure].span.expect("a place");
    assert_eq!(&text[span.start as usize..span.end as usize], "(map 1+ 3)");
}

/// r[task.path]
#[test]
fn of_a_deep_path_the_last_names_are_written() {
    let deepest = |depth: usize| {
        let text =
            format!("(def-plan p (n) (if (> n 1) (seq (p (- n 1)) 1) (print (task-path (this-task))))) (p {depth})");
        run(&text).lines().next().unwrap_or_default().to_string()
    };
    assert_eq!(deepest(31), format!("main{}", "/p".repeat(31)));
    assert_eq!(deepest(32), format!("…{}", "/p".repeat(32)));
    assert_eq!(deepest(5000), format!("…{}", "/p".repeat(32)));
}

/// r[task.path]
#[test]
fn an_endless_recursion_is_traced_with_so_much_for_each_call() {
    let events = |depth: usize| trace_of(&format!("(def-plan p (n) (if (> n 1) (seq (p (- n 1)) 1) 1)) (p {depth})"));
    let longest = |depth: usize| events(depth).iter().map(|event| event.path.len()).max();
    assert_eq!(longest(100), longest(10_000));
    assert!(longest(10_000) < Some(100));
}
