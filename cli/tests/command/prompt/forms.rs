//! Forms and files handed in, their values, and the exit status.

use super::{GREET, session};
use crate::folder::{folder, put};

#[test]
fn forms_over_several_lines_are_run_and_their_values_printed() {
    let shown = session(&["repl"], &format!("{GREET}(greet 'ann)\n_\n(length _)\n"));
    assert_eq!(shown.out, "greet\nann\n(hello ann)\n(hello ann)\n2\n");
    assert_eq!((shown.errors.as_str(), shown.status), ("", 0));
}

#[test]
fn the_prompt_is_what_starts_without_a_command() {
    assert_eq!(session(&[], "(+ 1 2)\n").out, "3\n");
}

#[test]
fn the_exit_status_tells_the_worst_that_happened() {
    let failed = session(&["repl"], "(car 5)\n(+ 1 1)\n");
    assert_eq!((failed.out.as_str(), failed.status), ("2\n", 1));
    assert!(failed.errors.starts_with("failed: type-error"), "{}", failed.errors);
    let wrong = session(&["repl"], "(no-such-thing)\n(+ 1 1)\n");
    assert_eq!((wrong.out.as_str(), wrong.status), ("2\n", 2));
}

#[test]
fn what_is_typed_beside_and_has_to_wait_goes_on_with_the_run() {
    let lines = "(def-fluent done? nil)\n:step (progn (wait-for done?) 'seen)\n\
                 (seq (wait-time 2) (setf (value done?) t) 'done)\n(car 5)\n:continue\n(now)\n";
    let shown = session(&["repl"], lines);
    assert!(
        shown.errors.contains("main/typed waits for time until 2.000 s, in 2.000 s; it goes on with the run"),
        "{}",
        shown.errors
    );
    assert!(shown.errors.contains("failed: type-error"), "{}", shown.errors);
    assert!(shown.out.ends_with("main/typed => done\nseen\n2.0\n"), "{}", shown.out);
}

#[test]
fn a_file_is_loaded_beside_the_form_that_runs() {
    let file = put(&folder("beside"), "beat.rpl", "(def-plan beat () (wait-time 0.25) 'fast)\n");
    let lines = format!(
        "(def-plan beat () (wait-time 1) 'slow)\n:step (list (beat) (beat))\n:until 0.5s\n:load {file}\n:continue\n"
    );
    let shown = session(&["repl"], &lines);
    assert!(shown.out.ends_with("beat\n(slow fast)\n"), "{}", shown.out);
    assert!(shown.errors.contains("the old text still runs in main/beat"), "{}", shown.errors);
}

#[test]
fn a_file_of_many_lines_is_read_from_a_pipe() {
    let plans: String = (0..60).map(|n| format!("; Plan {n}.\n(def-plan plan-{n} (x)\n\n  (+ x {n}))\n")).collect();
    let shown = session(&["repl"], &format!("{plans}(plan-59 1)\n"));
    assert_eq!(shown.out.lines().count(), 61, "{}", shown.out);
    assert_eq!((shown.out.lines().last(), shown.status), (Some("60"), 0));
}

#[test]
fn what_still_runs_in_the_old_text_is_told() {
    let lines = "(def-plan tick () (wait-time 10) 'old)\n(defvar ticking (spawn (tick)))\n(wait-time 1)\n(def-plan tick () 'new)\n(tick)\n";
    let shown = session(&["repl"], lines);
    assert!(shown.errors.contains("the old text still runs in main/"), "{}", shown.errors);
    assert!(shown.out.ends_with("new\n"), "{}", shown.out);
}

#[test]
fn a_form_given_up_cleans_up() {
    let lines = "(def-fluent never nil)\n:break (> (value (fluent (now))) 2)\n\
                 :step (unwind-protect (wait-for never) (print 'clean))\n:abort\n";
    let shown = session(&["repl"], lines);
    assert!(shown.out.contains("clean\n"), "{}", shown.out);
    assert!(shown.errors.contains("given up, clean-ups done"), "{}", shown.errors);
}

#[test]
fn values_are_kept_by_the_number_of_their_text() {
    let lines = "(+ 1 2)\n(defun tea () 'green)\n(tea)\n(list _1 _2 _3 _)\n(car _9)\n:back 100\n(+ 1 2)\n";
    let shown = session(&["repl"], lines);
    assert!(shown.out.starts_with("3\ntea\ngreen\n(3 tea green green)\n"), "{}", shown.out);
    assert!(shown.errors.contains("`_9` is not defined anywhere"), "{}", shown.errors);
    // The run keeps them: they are there again when it is repeated, and what is typed beside has one too.
    let lines = "(progn (wait-time 1) 'first)\n:step (progn (wait-time 5) 'second)\n(list 'beside _1)\n:continue\n\
                 (list _1 _2 _3)\n:at 3s\n_1\n:continue\n(list _1 _2 _3)\n";
    let shown = session(&["repl"], lines);
    assert_eq!(shown.out.matches("(first second (beside first))\n").count(), 2, "{}{}", shown.out, shown.errors);
}

#[test]
fn what_a_form_costs_is_told() {
    let cost = |form: &str| {
        let shown = session(&["repl"], &format!(":time {form}\n"));
        let line = shown.errors.lines().last().expect("it is told").to_string();
        let number = |unit: &str| {
            let before = line.split(unit).next().expect("there is a unit").trim_end();
            before.rsplit([' ', ',']).next().expect("a number").parse::<f64>().unwrap_or_else(|_| panic!("{line}"))
        };
        (number(" steps"), number(" s of the plan"), line.clone())
    };
    let (few, _, _) = cost("(dotimes (i 1000) i)");
    let (many, _, _) = cost("(dotimes (i 10000) i)");
    assert!(many > few + 8000.0 && many < few + 10_000.0, "{few} {many}");
    let (_, plan_s, line) = cost("(wait-time 2.5)");
    assert!((plan_s - 2.5).abs() < 1e-9 && line.contains(" s of computing, ") && line.contains(" made, "), "{line}");
    let made = cost("(length (let ((l nil)) (dotimes (i 100000) (push i l)) l))").2;
    assert!(made.contains("2.0 MB made"), "{made}");
    assert!(session(&["repl"], ":time\n").errors.contains("`:time FORM`: a form is expected"));
}

#[test]
fn what_is_logged_has_its_time_and_stands_between_what_is_printed() {
    let shown = session(&["repl"], "(progn (log 'one) (wait-time 2.5) (log 'two))\n");
    assert_eq!(shown.errors, "0.0 s  one\n2.5 s  two\n");
}
