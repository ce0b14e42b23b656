//! Stepping, breakpoints, watches.

use super::{GREET, session};

#[test]
fn a_plan_is_stepped_through_with_its_variables() {
    let shown = session(&["repl"], &format!("{GREET}:step (greet 'ann)\n:step\n:next\nwho\n:out\n:continue\n"));
    assert_eq!(
        shown.out,
        "greet
0.000 s  main  <2>:1:1
    1 ▶ (greet 'ann)
        ^^^^^^^^^^^^
0.000 s  main/greet  <1>:2:3
    1   (def-plan greet (who)
    2 ▶   (print who)
          ^^^^^^^^^^^
    3     (wait-time 2)
    4     (list 'hello who))
    who = ann
ann
=> ann
0.000 s  main/greet  <1>:3:3
    1   (def-plan greet (who)
    2     (print who)
    3 ▶   (wait-time 2)
          ^^^^^^^^^^^^^
    4     (list 'hello who))
    who = ann
ann
(hello ann)
"
    );
}

#[test]
fn what_the_stopped_call_sees_can_be_assigned() {
    let lines = "(defvar seen nil)\n(def-plan add (x y) (wait-time 1) (setf seen x) (+ x y))\n:step (add 1 2)\n:step\n\
                 (setf x 40)\n(setf seen 'nothing)\n:continue\nseen\n";
    let shown = session(&["repl"], lines);
    assert!(shown.out.ends_with("40\nnothing\n42\n40\n"), "{}", shown.out);
    assert!(shown.errors.contains("`x` counts from the next form on"), "{}", shown.errors);
    assert!(!shown.errors.contains("`seen` counts"), "{}", shown.errors);
}

#[test]
fn a_run_stops_at_names_lines_and_conditions() {
    let lines = format!(
        "(def-fluent level 0)\n{GREET}:break greet\n(greet 'ann)\n:delete\n:break (> level 2)\n:continue\n\
         (par (seq (wait-time 3) (setf (value level) 3) (wait-time 9)) (wait-time 1))\n:fluents lev\n:continue\n:break\n"
    );
    let shown = session(&["repl"], &lines);
    assert!(
        shown.errors.contains("stopped at greet") && shown.errors.contains("stopped at (> level 2)"),
        "{}",
        shown.errors
    );
    assert!(shown.out.contains("5.000 s\nlevel = 3\n"), "{}", shown.out);
    assert!(shown.out.ends_with("1  (> level 2)\n"), "{}", shown.out);
}

#[test]
fn a_file_is_stepped_from_its_first_form() {
    let shown = session(&["step", "first-steps.rpl"], ":tasks\n:quit\n");
    assert!(shown.out.contains("first-steps.rpl:"), "{}", shown.out);
}

#[test]
fn a_run_that_is_about_to_fail_is_stopped_where_the_failure_is_raised() {
    let lines = "(defun empty () (fail \"nothing is left\"))\n:break failure\n:break\n\
                 (with-timeout 5 (seq (wait-time 2) (empty)))\n:task\n:abort\n\
                 (ignore-failures (plan-failure) (empty))\n\
                 (with-timeout 1 (wait-time 3))\n:why\n:abort\n:delete\n(empty)\n(now)\n";
    let shown = session(&["repl"], lines);
    assert!(shown.out.contains("1  failure\n"), "{}", shown.out);
    assert!(shown.out.contains("2.000 s  main/with-timeout  <1>:1:17\n"), "{}", shown.out);
    assert_eq!(shown.errors.matches("given up, clean-ups done").count(), 2, "{}", shown.errors);
    assert_eq!(shown.errors.matches("failed: ").count(), 3, "{}", shown.errors);
    assert_eq!(shown.errors.matches("about to fail").count(), 2, "what is handled does not stop: {}", shown.errors);
    assert!(shown.out.ends_with("3.0\n"), "{}", shown.out);
}

#[test]
fn stepping_goes_over_the_library_unless_it_is_asked_into_it() {
    let begin = "(defun root (x) (sqrt x))\n:step (map #'root '(4 9))\n";
    let over = session(&["repl"], &format!("{begin}:step\n:step\n"));
    assert!(over.out.contains("  <1>:1:17\n"), "what the library calls of ours is ours: {}", over.out);
    assert!(!over.out.contains("prelude:"), "{}", over.out);
    let into = session(&["repl"], &format!("{begin}:into\n:next\n:out\n:continue\n"));
    assert!(into.out.matches("  prelude:").count() >= 2, "{}", into.out);
    assert!(into.out.ends_with("(2.0 3.0)\n"), "{}", into.out);
    let stopped = session(
        &["repl"],
        "(defun pick (x) (if x (print 'one) (print 'two)))\n:break pick\n(list (pick 1) (pick nil))\n:continue\n:continue\n",
    );
    assert_eq!(stopped.errors.matches("stopped at pick").count(), 2, "whichever form comes first: {}", stopped.errors);
    let stopped = session(&["repl"], ":break map\n(map #'car '((1)))\n:continue\n");
    assert!(stopped.errors.contains("stopped at map"), "{}", stopped.errors);
}

#[test]
fn a_run_goes_past_breakpoints_into_calls_and_up_to_a_time() {
    let lines = format!(
        "{GREET}(def-plan twice () (greet 'ann) (greet 'bob))\n:break greet\n:run (twice)\n\
         :step (twice)\n:delete\n:into\n:until 5.5s\n:tasks\n:task\n"
    );
    let shown = session(&["repl"], &lines);
    assert!(shown.out.contains("ann\nbob\n(hello bob)\n"), "{}", shown.out);
    assert!(!shown.errors.contains("stopped at greet"), "{}", shown.errors);
    assert!(shown.out.contains("main/twice/greet.2") || shown.out.contains("main/twice.2/greet"), "{}", shown.out);
    assert!(shown.out.contains("who = ann"), "{}", shown.out);
}

#[test]
fn what_is_watched_is_shown_at_each_stop_and_says_when_it_cannot_be() {
    let lines = "(def-fluent level 0)\n:watch (+ 1 (value level))\n:watch (no-such level)\n:watch (car (value level))\n\
                 :step (progn (setf (value level) 1) (wait-time 1))\n:next\n:watch\n:next\n";
    let shown = session(&["repl"], lines);
    for line in [
        "    (+ 1 (value level)) = 1\n",
        "    (+ 1 (value level)) = 2\n",
        "    (no-such level) = not a form that can be evaluated here\n",
        "    (car (value level)) = type-error: ",
    ] {
        assert!(shown.out.contains(line), "{line}{}", shown.out);
    }
    assert_eq!(shown.out.matches("(no-such level)").count(), 2, "{}", shown.out);
}
