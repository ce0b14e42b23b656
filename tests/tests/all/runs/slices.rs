//! Control comes back from the middle of an instant after a slice of steps, and no run can tell.

use rpl_runtime::run::system::{Outcome, Progress, Turn};
use rpl_tests::{system, transcript};

/// Programs in which a task works for long without waiting: its own loops and calls, natives that
/// burn steps, clean-ups, handlers, networks, and others that are ready meanwhile.
const BUSY: &[&str] = &[
    "(let ((n 0)) (with-failure-handling ((runaway (f) n)) (loop (incf n))))",
    "(let ((n 0) (l (range 0 37))) (with-failure-handling ((runaway (f) n)) (loop (incf n (length (append l l))))))",
    "(defun f (n) (if (= n 0) 0 (+ 1 (f (- n 1))))) (list (f 700) (f 300))",
    "(defun g (n) (if (= n 0) 'end (g (- n 1)))) (list (g 900) (apply #'g '(800)))",
    "(unwind-protect (loop) (dotimes (i 500) (if (= i 499) (print i))))",
    "(par (dotimes (i 300) (if (= (mod i 100) 0) (print (list 'a i)))) (dotimes (i 300) (if (= (mod i 100) 0) (print (list 'b i)))))",
    "(par (with-priority 2 (wait-time 1) (print 'high)) (seq (wait-time 1) (dotimes (i 400) i) (print 'low)))",
    "(def-fluent f 0) (with-policy (whenever (> f 5) (print (value f)) (setf (value f) 0)) (dotimes (i 30) (setf (value f) (+ i f)) (wait-time 0)))",
    "(def-fluent f 0) (let ((task (spawn (loop (incf (value f)) (if (> f 200) (wait-time 1)))))) (wait-time 0.5) (print (value f)) (evaporate task))",
    "(let ((n 0) (end 700)) (loop while (< n end) (setq n (+ n 1))) (dotimes (i 9000 n) (setq n i)))",
    "(sort (lambda (a b) (> a b)) (range 0 200))",
    "(let ((n 0)) (unwind-protect (seq (with-failure-handling ((runaway (f) n)) (loop (incf n))) (loop (incf n))) (print n)))",
];

fn run(text: &str, slice_steps: u32) -> (String, Vec<String>, usize) {
    let mut system = system(text);
    system.machine.limits.steps = 3_000;
    system.machine.trace.enabled = true;
    system.slice_steps = slice_steps;
    let mut cuts = 0;
    while system.outcome().is_none() {
        match system.step_slice() {
            Turn::Idle => system.next_instant(),
            Turn::Over => {}
            Turn::Cut => cuts += 1,
        }
        system.machine.check_invariants().unwrap_or_else(|broken| panic!("{text}: {broken}"));
    }
    let trace = system.machine.trace.take().iter().map(ToString::to_string).collect();
    (transcript(&mut system), trace, cuts)
}

/// r[determinism.same], r[limit.steps]
#[test]
fn a_run_in_slices_is_the_run_in_one_go() {
    for text in BUSY {
        let (transcript, trace, cuts) = run(text, u32::MAX);
        assert_eq!(cuts, 0, "{text}");
        for slice_steps in [1, 2, 7, 100] {
            let sliced = run(text, slice_steps);
            assert_eq!((&sliced.0, &sliced.1), (&transcript, &trace), "slices of {slice_steps}\n{text}");
            assert!(sliced.2 > 0 || slice_steps > 1, "single steps cut nothing\n{text}");
        }
    }
}

#[test]
fn many_short_turns_are_cut_too() {
    let mut system = system("(loop (par (dotimes (i 100) i)))");
    system.slice_steps = 1_000;
    let turns = (0..10_000).map(|_| system.step_slice()).collect::<Vec<Turn>>();
    let cuts = turns.iter().filter(|&&turn| turn == Turn::Cut).count();
    assert!((400..2_000).contains(&cuts), "{cuts} cuts in 10,000 turns of some hundred steps");
}

/// r[cleanup.stop]
#[test]
fn a_run_is_told_to_stop_in_the_middle_of_an_instant() {
    let mut system = system("(unwind-protect (loop) (print 'clean))");
    assert!((0..3).all(|_| system.step_slice() == Turn::Cut), "the loop does not end");
    system.stop();
    while system.advance() == Progress::Running {}
    assert_eq!(system.outcome(), Some(Outcome::Evaporated));
    assert_eq!(transcript(&mut system), "clean\nevaporated");
}

/// A native works on all of its data at once, so what takes longer than a walk over it is done in
/// pieces: between two of them control can come back.
#[test]
fn sorting_much_comes_back_often() {
    let count = 1 << 18;
    let text = format!("(let ((sorted (sort #'< (reverse (range 0 {count}))))) (list (car sorted) (last sorted)))");
    let mut system = system(&text);
    system.slice_steps = 1;
    let (mut before, mut most) = (0, 0);
    while system.outcome().is_none() {
        if system.step_slice() == Turn::Idle {
            system.next_instant();
        }
        let steps = system.machine.spent.steps;
        most = most.max(steps.saturating_sub(before));
        before = steps;
    }
    assert_eq!(transcript(&mut system), format!("=> (0 ({}))", count - 1));
    assert!(most < 8 * count, "one piece of work takes {most} steps for {count} elements");
}
