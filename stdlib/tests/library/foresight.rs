//! Projections of plans without a robot: what they leave to chance, and when they end, is all there is to
//! foresee.

use crate::evaluate::{check, check_failures, evaluate, library};
use rpl_runtime::run::system::{Progress, System};

/// The value of a text that gives a number.
fn number(text: &str) -> f64 {
    let value = evaluate(text).unwrap_or_else(|failure| panic!("{text}\nfails: {failure}"));
    value.parse().unwrap_or_else(|_| panic!("{text}\ngives {value}"))
}

// r[project.record] r[project.horizon]
#[test]
fn what_is_certain_is_projected_so() {
    check(&[
        ("(projection-time (project '(wait-time 5) :runs 10))", "(5.0 5.0 5.0)"),
        (
            "(let ((p (project '(wait-time 5) :runs 10))) (list (projection-runs p) (projection-successes p)))",
            "(10 10)",
        ),
        ("(projection-successes (project '(fail \"x\") :runs 10))", "0"),
        // Ten of ten leave a probability of 11/12 behind, not 1.
        ("(= (first (projection-success (project '(wait-time 5) :runs 10))) (/ 11.0 12))", "t"),
        ("(projection-failures (project '(wait-time 5) :runs 10))", "nil"),
        (
            "(let ((failure (first (projection-failures (project '(/ 1 0) :runs 4)))))
            (list (first failure) (second failure) (fourth failure)))",
            "(1.0 arithmetic-error \"division by zero\")",
        ),
        ("(second (first (projection-failures (project '(wait-time 100) :runs 4 :horizon 99))))", "unfinished"),
        ("(second (first (projection-failures (project '(wait-for (create-fluent nil)) :runs 4))))", "deadlock"),
    ]);
    check_failures(&[("(project '(no-such-function))", "the datum cannot be executed")]);
}

// r[project.chance]
#[test]
fn chance_is_drawn_anew_in_each_run_and_leaves_the_real_run_as_it_is() {
    let share =
        number("(first (projection-success (project '(when (< (random 1.0) 0.3) (fail \"bad luck\")) :runs 3000)))");
    // Four standard errors of 3000 draws.
    assert!((share - 0.7).abs() < 0.034, "{share}");
    let plan = "(project '(random 1.0) :runs 5)";
    assert_eq!(number(&format!("{plan} (random 1.0)")), number("(random 1.0)"));
}

// r[project.fork]
#[test]
fn nothing_of_it_is_seen_outside() {
    check(&[
        (
            "(defvar x 1) (def-fluent f 1) (project '(progn (setq x 2) (setf (value f) 2) (wait-time 1)) :runs 3) (list x (value f))",
            "(1 1)",
        ),
        (
            "(def-fluent f 0) (list (projecting?) (projection-fluent (project '(setf (value f) (if (projecting?) 7 8)) :runs 3) 'f))",
            "(nil (7.0 7.0 7.0))",
        ),
    ]);
    let text = "(print 'before) (project '(dotimes (i 5000) (print i)) :runs 3) (print 'after)";
    let mut system = System::without_robot(library(), "test", text, 0).expect("the text is right");
    while system.advance() == Progress::Running {}
    let lines: Vec<&str> = system.machine.output.iter().map(|line| line.text.as_str()).collect();
    assert_eq!(lines, ["before", "after"]);
}

// r[project.rest]
#[test]
fn what_runs_beside_goes_on_in_the_projection() {
    check(&[
        (
            "(def-fluent done nil)
             (with-policy (seq (wait-time 30) (setf (value done) t) (wait-for (create-fluent nil)))
               (wait-time 10)
               (projection-time (project '(wait-for done) :runs 4)))",
            "(20.0 20.0 20.0)",
        ),
        (
            "(defvar rest nil)
             (par (:tag job (wait-time 50))
                  (seq (wait-time 10) (setq rest (project-rest :task job :runs 4))))
             (projection-time rest)",
            "(40.0 40.0 40.0)",
        ),
        (
            "(defvar rest nil)
             (par (:tag job (wait-time 50))
                  (seq (wait-time 10) (setq rest (project '(evaporate (task \"main/par.1/job\")) :task job :runs 4))))
             (second (first (projection-failures rest)))",
            "evaporated",
        ),
    ]);
}

#[test]
fn the_timeline_tells_when_tagged_steps_begin() {
    check(&[(
        "(map (lambda (step) (list (first step) (second step) (fourth step)))
              (projection-timeline (project '(seq (wait-time 3) (:tag lift (wait-time 4)) (:tag lower (wait-time 1))) :runs 4)))",
        "((\"main/lift\" 1.0 3.0) (\"main/lower\" 1.0 7.0))",
    )]);
}

// r[project.compare]
#[test]
fn two_plans_are_compared_on_the_same_chances() {
    check(&[
        ("(comparison-better (compare-plans '(wait-time 100) '(wait-time 50) :horizon 200))", "t"),
        ("(comparison-better (compare-plans '(wait-time 50) '(wait-time 100) :horizon 200))", "nil"),
        // Half a minute of ten is worth 0.025.
        ("(comparison-better (compare-plans '(wait-time 60) '(wait-time 30) :horizon 600 :margin 0.05))", "nil"),
        (
            "(let ((c (compare-plans '(wait-time (random 60.0)) '(wait-time (random 60.0)) :horizon 200)))
            (list (comparison-better c) (comparison-difference c) (comparison-runs c) (comparison-certain c)))",
            "(nil 0.0 64 nil)",
        ),
        (
            "(let ((c (compare-plans '(wait-time 20) '(wait-time 10) :horizon 200 :runs 500)))
            (list (comparison-better c) (comparison-runs c) (comparison-certain c)))",
            "(t 8 t)",
        ),
        (
            "(> (comparison-runs (compare-plans '(wait-time (random 60.0)) '(progn (random 1.0) (wait-time (random 60.0))))) 8)",
            "t",
        ),
    ]);
}

// r[project.compare]
#[test]
fn of_many_plans_those_that_fall_behind_run_less() {
    check(&[
        (
            "(map (lambda (c) (list (comparison-better c) (comparison-runs c)))
                  (compare-all '(wait-time 60) '((wait-time 10) (wait-time 90) (wait-time 30)) :horizon 200))",
            "((t 8) (nil 8) (t 8))",
        ),
        // The second is far from the first by the first eight runs; which of the other two is better takes more.
        (
            "(let ((c (compare-all '(wait-time (+ 50 (random 9.0)))
                                   '((wait-time (+ 10 (random 9.0)))
                                     (wait-time (+ 90 (random 9.0)))
                                     (progn (random 1.0) (wait-time (+ 10.5 (random 9.0)))))
                                   :horizon 200)))
               (list (comparison-better (first c)) (comparison-better (second c))
                     (< (comparison-runs (second c)) (comparison-runs (first c)))))",
            "(t nil t)",
        ),
        ("(compare-all '(wait-time 60) nil)", "nil"),
    ]);
}

// r[project.compare]
#[test]
fn what_happens_seldom_decides_although_the_first_runs_do_not_meet_it() {
    // The shorter plan fails one time in twenty, which costs more than the ten seconds of five minutes.
    let compared = "(compare-plans '(wait-time 20) '(progn (wait-time 10) (when (< (random 1.0) 0.05) (fail \"rare\")))
                                   :horizon 300 :runs 1024)";
    check(&[(
        &*format!(
            "(let ((c {compared})) (list (comparison-better c) (< (comparison-difference c) 0) (< 8 (comparison-runs c))))"
        ),
        "(nil t t)",
    )]);
}

// r[project.time]
#[test]
fn thinking_takes_time_and_the_answer_says_whether_it_is_stale() {
    let plan = "(project '(progn (random 1.0) (dotimes (i 100) (wait-time 1))) :runs 1000)";
    // A thousand runs of a hundred instants.
    assert!((number(&format!("{plan} (now)")) - 2.0).abs() < 0.01);
    // Without chance a single one tells all.
    assert!(number("(project '(dotimes (i 100) (wait-time 1)) :runs 1000) (now)") < 0.01);
    let stale = |at_s: f64| {
        let text = format!(
            "(def-fluent orders 0) (defvar p nil)
             (par (seq (wait-time {at_s}) (incf (value orders))) (setq p {plan}))
             (projection-stale p)"
        );
        evaluate(&text).unwrap_or_else(|failure| panic!("{failure}"))
    };
    assert_eq!([stale(1.0), stale(3.0)], ["t", "nil"]);
}

// r[project.refused]
#[test]
fn what_cannot_be_projected_is_refused_with_a_reason() {
    check_failures(&[
        ("(project '(wait-time 1) :runs 1000000)", "1000000 runs cannot be projected; write `:runs` 1 to 10000"),
        ("(project '(wait-time 1) :runs 0)", "0 runs cannot be projected"),
        (
            "(project '(wait-time 1) :horizon 0)",
            "nothing can be projected for 0 s; write a time such as `:horizon 20min`",
        ),
        ("(unwind-protect 1 (project '(wait-time 1)))", "a clean-up cannot wait for a projection"),
    ]);
    check(&[(
        "(let ((failure (first (projection-failures (project '(project '(wait-time 1)) :runs 2)))))
           (list (second failure) (fourth failure)))",
        "(projection-failure \"this is a projected run, and none is projected inside another; ask `(projecting?)` before\")",
    )]);
}

// r[project.bounds]
#[test]
fn endless_plans_are_given_up() {
    check(&[
        ("(second (first (projection-failures (project '(loop (+ 1 1)) :runs 2))))", "runaway"),
        (
            "(second (first (projection-failures (project '(with-failure-handling ((failure (f) (retry))) (loop (+ 1 1))) :runs 2))))",
            "runaway",
        ),
    ]);
}
