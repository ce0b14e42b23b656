//! The prompt, with its lines from a pipe: what is shown, and the exit status.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

struct Shown {
    out: String,
    errors: String,
    status: Option<i32>,
}

fn session(arguments: &[&str], lines: &str) -> Shown {
    let mut child = Command::new(env!("CARGO_BIN_EXE_rpl"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    child.stdin.take().expect("it reads").write_all(lines.as_bytes()).expect("it takes the lines");
    let output = child.wait_with_output().expect("it ends");
    let text = |bytes| String::from_utf8(bytes).expect("it writes text");
    Shown { out: text(output.stdout), errors: text(output.stderr), status: output.status.code() }
}

const GREET: &str = "(def-plan greet (who)\n  (print who)\n  (wait-time 2)\n  (list 'hello who))\n";

#[test]
fn forms_over_several_lines_are_run_and_their_values_printed() {
    let shown = session(&["repl"], &format!("{GREET}(greet 'ann)\n_\n(length _)\n"));
    assert_eq!(shown.out, "greet\nann\n(hello ann)\n(hello ann)\n2\n");
    assert_eq!((shown.errors.as_str(), shown.status), ("", Some(0)));
}

#[test]
fn the_prompt_is_what_starts_without_a_command() {
    assert_eq!(session(&[], "(+ 1 2)\n").out, "3\n");
}

#[test]
fn the_exit_status_tells_the_worst_that_happened() {
    let failed = session(&["repl"], "(car 5)\n(+ 1 1)\n");
    assert_eq!((failed.out.as_str(), failed.status), ("2\n", Some(1)));
    assert!(failed.errors.starts_with("failed: type-error"), "{}", failed.errors);
    let wrong = session(&["repl"], "(no-such-thing)\n(+ 1 1)\n");
    assert_eq!((wrong.out.as_str(), wrong.status), ("2\n", Some(2)));
}

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
fn what_is_typed_beside_and_has_to_wait_goes_on_with_the_run() {
    let lines = "(def-fluent done? nil)\n:step (progn (wait-for done?) 'seen)\n\
                 (seq (wait-time 2) (setf (value done?) t) 'done)\n(car 5)\n:continue\n(now)\n";
    let shown = session(&["repl"], lines);
    assert!(shown.errors.contains("main/typed waits for time; it goes on with the run"), "{}", shown.errors);
    assert!(shown.errors.contains("failed: type-error"), "{}", shown.errors);
    assert!(shown.out.ends_with("main/typed => done\nseen\n2.0\n"), "{}", shown.out);
}

#[test]
fn a_file_is_loaded_beside_the_form_that_runs() {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("beat.rpl");
    std::fs::write(&file, "(def-plan beat () (wait-time 0.25) 'fast)\n").expect("it can be written");
    let lines = format!(
        "(def-plan beat () (wait-time 1) 'slow)\n:step (list (beat) (beat))\n:until 0.5s\n:load {}\n:continue\n",
        file.display()
    );
    let shown = session(&["repl"], &lines);
    assert!(shown.out.ends_with("beat\n(slow fast)\n"), "{}", shown.out);
    assert!(shown.errors.contains("the old text still runs in main/beat"), "{}", shown.errors);
}

#[test]
fn a_run_goes_back_a_step_and_on_again_to_the_same_end() {
    let shown = session(
        &["repl"],
        "(defvar log nil)\n:step (progn (push (now) log) (wait-time 1) (push (now) log) (reverse log))\n:next\n:next\n:next\n:back\n:continue\n:back 1s\n",
    );
    assert!(shown.out.contains("(0.0 1.0)\n"), "{}", shown.out);
    assert_eq!(shown.out.matches("(0.0 1.0)").count(), 1);
    assert_eq!(shown.status, Some(0));
}

#[test]
fn going_back_before_the_start_stops_at_the_start() {
    let shown = session(&["repl"], "(wait-time 5)\n:back 100\n(now)\n:at 3h\n");
    assert!(shown.errors.contains("this is the start"), "{}", shown.errors);
    assert!(shown.errors.contains("has not come yet; `:until 3h` goes there"), "{}", shown.errors);
    assert!(shown.out.ends_with("0.0\n"), "{}", shown.out);
}

#[test]
fn going_back_by_a_time_before_the_start_stops_at_the_start() {
    let shown = session(&["repl"], "(wait-time 5)\n:back 10s\n(now)\n");
    assert_eq!((shown.errors.as_str(), shown.out.as_str()), ("this is the start\n", "nil\n0.000 s\n0.0\n"));
}

#[test]
fn definitions_go_back_with_the_run_and_that_is_told() {
    let lines = "(def-plan tea () 'green)\n:fork first\n(wait-time 5)\n(def-plan tea () 'black)\n\
                 (def-plan cake () 'good)\n(wait-time 5)\n:back 7s\n(tea)\n:switch first\n";
    let shown = session(&["repl"], lines);
    let told = "definitions are those of this instant: here `cake` is not defined, `tea` has another text\n";
    assert_eq!(shown.errors, format!("kept as `first`; `:switch first` goes there\n`tea` is defined anew\n{told}"));
    assert!(shown.out.contains("green\n"), "{}", shown.out);
}

#[test]
fn a_file_of_many_lines_is_read_from_a_pipe() {
    let plans: String = (0..60).map(|n| format!("; Plan {n}.\n(def-plan plan-{n} (x)\n\n  (+ x {n}))\n")).collect();
    let shown = session(&["repl"], &format!("{plans}(plan-59 1)\n"));
    assert_eq!(shown.out.lines().count(), 61, "{}", shown.out);
    assert_eq!((shown.out.lines().last(), shown.status), (Some("60"), Some(0)));
}

#[test]
fn a_definition_changed_in_the_past_counts_from_there_on() {
    let lines = "(def-plan beat () (wait-time 1) 'slow)\n(list (beat) (beat) (now))\n:at 0s\n\
                 (def-plan beat () (wait-time 0.25) 'fast)\n:continue\n";
    let shown = session(&["repl"], lines);
    assert!(shown.out.contains("(slow slow 2.0)") && shown.out.ends_with("(slow fast 1.25)\n"), "{}", shown.out);
    assert!(shown.errors.contains("the old text still runs in main/beat"), "{}", shown.errors);
}

#[test]
fn what_still_runs_in_the_old_text_is_told() {
    let lines = "(def-plan tick () (wait-time 10) 'old)\n(defvar ticking (spawn (tick)))\n(wait-time 1)\n(def-plan tick () 'new)\n(tick)\n";
    let shown = session(&["repl"], lines);
    assert!(shown.errors.contains("the old text still runs in main/"), "{}", shown.errors);
    assert!(shown.out.ends_with("new\n"), "{}", shown.out);
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
fn forks_are_kept_side_by_side() {
    let lines = "(defvar n 1)\n:fork before\n(incf n)\n:switch before\nn\n:switch main\nn\n:forks\n:switch nowhere\n";
    let shown = session(&["repl"], lines);
    let numbers: Vec<&str> = shown.out.lines().filter(|line| line.parse::<i64>().is_ok()).collect();
    assert_eq!(numbers, ["1", "2", "1", "2"]);
    assert!(shown.errors.contains("no run is called `nowhere`"), "{}", shown.errors);
}

#[test]
fn causes_are_followed_from_task_to_fluent() {
    let lines = "(def-fluent open? nil)\n(def-valve arm)\n\
                 (spawn (with-valve arm (wait-for open?)))\n(spawn (with-valve arm 1))\n(wait-time 1)\n\
                 :tasks\n:valves\n:why spawn.2\n:why no-such\n";
    let shown = session(&["repl"], lines);
    assert!(shown.out.contains("main  waits for the next form"), "{}", shown.out);
    assert!(shown.out.contains("  spawn  waits for fluent open?, holds arm\n"), "{}", shown.out);
    assert!(shown.out.contains("arm  held by main/spawn\n    in line: main/spawn.2"), "{}", shown.out);
    let why = "main/spawn.2  waits for valve arm\n";
    assert!(shown.out.contains(why) && shown.out.contains("the valve is held by\n"), "{}", shown.out);
    assert!(shown.out.contains("open? = nil"), "{}", shown.out);
    assert!(shown.out.contains("no task has the path `no-such`"), "{}", shown.out);
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
fn a_mission_is_stopped_looked_at_and_finished() {
    let lines = ":break (eq holding* 'mail)\n:load delivery.rpl\n:map\n:valves\n:watch (value holding*)\n:back 5s\n:delete\n:continue\n";
    let shown = session(&["repl", "--world", "dept"], lines);
    assert!(shown.out.contains("estimate, certainty"), "{}", shown.out);
    assert!(shown.out.contains("held by main/"), "{}", shown.out);
    assert!(shown.out.contains("(value holding*) = nil"), "{}", shown.out);
    assert!(shown.out.contains("mail delivered after"), "{}", shown.out);
    assert_eq!(shown.status, Some(0));
}

#[test]
fn mistakes_are_told_with_what_to_type() {
    let shown = session(
        &["repl"],
        ":contineu\n:go\n:stop\n:break gret\n:break 99\n:break nowhere.rpl:3\n:break (> no-such 3)\n:fork here\n:fork here\n:switch her\n:until soon\n:back soon\n:delete 3\n:step\n:map\n:load nowhere.rpl\n",
    );
    for advice in [
        "did you mean `:continue`?",
        "`:go` needs somebody at a terminal",
        "the clock does not run",
        "no plan, function or tag is called `gret`",
        "no text has a line 99",
        "no text is called `nowhere.rpl`; `:load` loads one",
        "`(> no-such 3)` is no condition",
        "a run is kept as `here` already",
        "no run is called `her`; did you mean `here`?",
        "no plan, function or tag is called `soon`",
        "neither a number of steps nor a time",
        "there is no breakpoint `3`",
        "nothing runs; type a form",
        "there is no plan `nowhere.rpl`",
    ] {
        assert!(shown.errors.contains(advice), "{advice}\n{}", shown.errors);
    }
    assert!(shown.out.contains("start `rpl --world dept`"), "{}", shown.out);
    assert_eq!(shown.status, Some(2));
}

#[test]
fn a_file_is_stepped_from_its_first_form() {
    let shown = session(&["step", "first-steps.rpl"], ":tasks\n:quit\n");
    assert!(shown.out.contains("first-steps.rpl:"), "{}", shown.out);
}

/// What is typed in this file and in the pages about the prompt.
#[test]
fn every_command_has_a_test() {
    let shown = session(&["repl"], ":help\n");
    let typed = [include_str!("prompt.rs"), include_str!("../../docs/prompt.md")].concat();
    let commands: Vec<&str> = shown
        .out
        .lines()
        .filter_map(|line| line.split_whitespace().next())
        .filter(|word| word.starts_with(':'))
        .collect();
    assert!(commands.len() > 20, "{}", shown.out);
    for command in commands {
        let is_typed = typed.match_indices(command).any(|(at, _)| {
            let before = typed[..at].chars().next_back();
            let after = typed[at + command.len()..].chars().next();
            matches!(before, Some('"' | 'n' | ' ')) && matches!(after, Some(' ' | '\\' | '\n' | '"'))
        });
        assert!(is_typed, "{command} has no test");
    }
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
fn events_and_documentation_are_looked_up() {
    let lines = "(def-fluent level 0)\n(setf (value level) 7)\n(setf (value level) 8)\n:trace level 7\n:trace nothing-such\n:doc wait-for\n:doc\n";
    let shown = session(&["repl"], lines);
    assert!(shown.out.contains("fluent     main  level = 7\nno such event\n"), "{}", shown.out);
    assert!(shown.out.contains("(wait-for "), "{}", shown.out);
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
