//! The prompt, with its lines from a pipe: what is shown, and the exit status.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

struct Shown {
    out: String,
    errors: String,
    status: Option<i32>,
}

fn session(arguments: &[&str], lines: &str) -> Shown {
    session_in(Path::new("."), "false", arguments, lines)
}

/// A folder of its own for a test, empty.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    // The one before may not be there.
    std::fs::remove_dir_all(&folder).ok();
    std::fs::create_dir_all(&folder).expect("it can be made");
    folder
}

fn session_in(folder: &Path, editor: &str, arguments: &[&str], lines: &str) -> Shown {
    let mut child = Command::new(env!("CARGO_BIN_EXE_rpl"))
        .args(arguments)
        .current_dir(folder)
        .env("EDITOR", editor)
        .env_remove("VISUAL")
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
fn going_back_no_step_changes_nothing() {
    let shown = session(&["repl"], "(defvar n 1)\n(wait-time 5)\n(setf n 2)\n:back 0\n(list n (now))\n");
    assert_eq!((shown.errors.as_str(), shown.out.as_str()), ("", "1\nnil\n2\n5.000 s\n(2 5.0)\n"));
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

/// Words that fit no command, or only some.
const WRONG: &[&str] = &[
    "",
    "no-such-thing",
    "(",
    ")",
    "((((((((",
    "(car 5)",
    "'",
    "\"",
    "#|",
    "-1",
    "0",
    "99999999999999999999",
    "1e400s",
    "nan",
    "/",
    ".",
    "/no/such/folder/file.rpl",
    "a\u{0}b",
    "\u{1b}[31m\u{7}",
    "\u{feff}\u{200b}",
    "Größe/…",
];

#[test]
fn no_command_ends_the_prompt_but_quit_whatever_stands_behind_it() {
    let commands: Vec<String> = session(&["repl"], ":help\n")
        .out
        .lines()
        .filter_map(|line| line.split_whitespace().next())
        .filter(|word| word.starts_with(':') && *word != ":quit")
        .map(str::to_string)
        .collect();
    let huge = "x".repeat(100_000);
    let wrong = || WRONG.iter().copied().chain([huge.as_str()]);
    // Where nothing runs, and in the midst of a form.
    for begin in ["(defvar alive 'alive)\n", "(defvar alive 'alive)\n:step (wait-time 1)\n"] {
        for arguments in [&["repl"][..], &["repl", "--world", "test-room"]] {
            let lines: String =
                commands.iter().flat_map(|command| wrong().map(move |word| format!("{command} {word}\n"))).collect();
            let folder = folder("wrong-arguments");
            let shown = session_in(
                &folder,
                "false",
                arguments,
                &format!("{begin}{lines}:abort\n(list 'still 'alive)\n:quit\n"),
            );
            assert!(
                shown.out.ends_with("(still alive)\n"),
                "{}",
                &shown.errors[shown.errors.len().saturating_sub(2000)..]
            );
            assert!(!shown.errors.contains("panicked") && !shown.errors.contains("fault of rpl"), "{}", shown.errors);
            assert_eq!(shown.status, Some(2));
        }
    }
}

#[test]
fn what_the_session_defines_is_documented() {
    let lines = "(def-plan greet (who &optional (how 'kindly)) \"Greets somebody.\" (list how who))\n\
                 (defun bare (x) x)\n(defvar cups 5 \"How many cups there are.\")\n(def-fluent level 3)\n\
                 (def-failure slipped (plan-failure) (object))\n\
                 :doc greet\n:doc BARE\n:doc cups\n:doc level\n:doc slipped\n:doc gret\n:doc no-such-name-at-all\n:doc :back\n(bare 1)\n";
    let shown = session(&["repl"], lines);
    for text in [
        "(greet who &optional (how 'kindly))\n  Greets somebody.\n  a plan, defined at <1>:1:1\n",
        "(bare x)\n  It has no documentation.\n  a function, defined at <2>:1:1\n",
        "cups\n  How many cups there are.\n  a variable, defined at <3>:1:1; its value is 5\n",
        "level\n  It has no documentation.\n  a fluent, defined at <4>:1:1; its value is 3\n",
        "  a class of failures, defined at <5>:1:1\n",
        "    :back 10s\n",
    ] {
        assert!(shown.out.contains(text), "{text}{}", shown.out);
    }
    assert!(shown.errors.contains("nothing is called `gret`; did you mean `greet`?"), "{}", shown.errors);
    assert!(shown.errors.contains("nothing is called `no-such-name-at-all`; `:doc` lists"), "{}", shown.errors);
    assert!(shown.out.ends_with("1\n"), "{}", shown.out);
}

#[test]
fn each_command_is_explained_with_an_example() {
    let shown = session(&["repl"], ":help back\n:help :save\n:help contineu\n");
    assert!(shown.out.starts_with(":back [N|TIME"), "{}", shown.out);
    assert!(
        shown.out.contains("\n    :back 10s\n") && shown.out.contains("\n    :save my-plans.rpl\n"),
        "{}",
        shown.out
    );
    assert!(shown.errors.contains("there is no command `:contineu`; did you mean `:continue`?"), "{}", shown.errors);
}

#[test]
fn the_text_of_a_definition_is_shown_whoever_wrote_it() {
    let lines = "; Adds one.\n(defun more (x)\n  (+ x 1))\n:source more\n:source for-each\n:source car\n:source mroe\n:source\n";
    let shown = session(&["repl"], lines);
    assert!(shown.out.contains("; <1>:2:1\n; Adds one.\n(defun more (x)\n  (+ x 1))\n"), "{}", shown.out);
    assert!(shown.out.contains("(defun for-each (function elements &rest more)\n"), "{}", shown.out);
    for advice in [
        "`car` is a function that is built in, without a text; `:doc car` documents it",
        "nothing is called `mroe`; did you mean `more`?",
        "`:source NAME`: a name is expected",
    ] {
        assert!(shown.errors.contains(advice), "{advice}\n{}", shown.errors);
    }
}

#[test]
fn what_the_session_defines_is_saved_as_a_file_that_loads() {
    let folder = folder("saving");
    std::fs::write(folder.join("tea.rpl"), "; How it is made.\n(def-plan tea () (brew 'tea))\n(print 'loaded)\n")
        .expect("it can be written");
    let lines = "(defmacro brew (what) `(list 'old ,what))\n:load tea.rpl\n(defvar cups 1)\n(setf cups 7)\n(defvar cups 2)\n\
                 (defmacro brew (what) `(list 'fresh ,what))\n(deftest tea (assert t))\n\
                 :save mine.rpl\n(defun extra () 3)\n:save mine.rpl\n:save tea.rpl\n:save no/such/folder.rpl\n:save\n";
    let shown = session_in(&folder, "false", &["repl"], lines);
    assert!(
        shown.errors.contains("saved 4 definitions in `mine.rpl`; `:load mine.rpl` loads them\n"),
        "{}",
        shown.errors
    );
    assert!(shown.errors.contains("saved 5 definitions in `mine.rpl`"), "what it wrote itself: {}", shown.errors);
    assert!(shown.errors.contains("cannot save to `tea.rpl`: it is there already"), "{}", shown.errors);
    assert!(shown.errors.contains("cannot save to `no/such/folder.rpl`: there is no such folder"), "{}", shown.errors);
    let saved = std::fs::read_to_string(folder.join("mine.rpl")).expect("it is there");
    assert!(saved.contains("; How it is made.\n(def-plan tea () (brew 'tea))\n"), "{saved}");
    let again = session_in(&folder, "false", &["repl"], ":load mine.rpl\n(list (tea) cups (extra))\n");
    assert!(again.out.ends_with("((fresh tea) 2 3)\n"), "{}{}", again.out, again.errors);
    std::fs::write(folder.join("mine.rpl"), "; Changed by somebody.\n").expect("it can be written");
    let lines = "(defun f () 1)\n:save mine.rpl\n";
    let refused = session_in(&folder, "false", &["repl"], lines);
    assert!(refused.errors.contains("it is there already"), "{}", refused.errors);
    assert_eq!(std::fs::read_to_string(folder.join("mine.rpl")).expect("it is there"), "; Changed by somebody.\n");
}

#[test]
fn a_form_and_a_definition_go_through_the_editor_and_back() {
    let lines = "(defun tea () 'green)\n(list (tea) 1)\n:edit\n:edit tea\n(tea)\n";
    let shown = session_in(Path::new("."), "sed -i -e 's/1/2/' -e 's/green/black/'", &["repl"], lines);
    assert_eq!(shown.out, "tea\n(green 1)\n(green 2)\ntea\nblack\n", "{}", shown.errors);
    let lines = "(defun tea () 'green)\n:edit tea\n:edit no-such\n(tea)\n";
    for (editor, told) in [
        ("false", "the editor `false` ended with status 1; nothing is run"),
        ("no-such-editor", "there is no editor `no-such-editor`; set the variable EDITOR to yours"),
        ("true", "the text is as it was; nothing is run"),
        ("rm", "what the editor left cannot be read: there is no such file"),
        ("sh -c 'kill -9 $$' sh", "the editor `sh -c 'kill -9 $$' sh`"),
        ("truncate -s 0", "the text is empty; nothing is run"),
    ] {
        let shown = session_in(Path::new("."), editor, &["repl"], lines);
        assert!(shown.errors.contains(told), "{editor}: {}", shown.errors);
        assert_eq!(shown.out, "tea\ngreen\n", "{editor}");
    }
}

#[test]
fn a_text_that_the_editor_left_wrong_is_there_again() {
    let lines = "(list 'tea)\n:edit\n:edit\n";
    let editor = "sed -i -e 's/(list .tea)/(no-such-thing)/;t' -e 's/no-such-thing/list 1 2/'";
    let shown = session_in(Path::new("."), editor, &["repl"], lines);
    assert!(shown.out.ends_with("(1 2)\n"), "{}{}", shown.out, shown.errors);
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
fn a_run_goes_back_to_where_its_failure_was_raised() {
    let lines = "(def-plan pour (cups) (unwind-protect (dotimes (i cups) (wait-time 1) (when (= i 2) (car i))) (print 'clean)))\n\
                 :back failure\n(par (pour 4) (wait-time 9))\n:back failure\n(list cups i)\n:tasks\n:back\n:continue\n:abort\n(now)\n";
    let shown = session(&["repl"], lines);
    assert!(shown.errors.contains("no form has failed yet"), "{}", shown.errors);
    assert!(shown.out.contains("3.000 s  main/par[0]/pour  <1>:1:"), "{}", shown.out);
    assert!(shown.out.contains("cups = 4, i = 2\n(4 2)\n"), "{}", shown.out);
    assert!(
        shown.out.contains("par[1]  waits for time until 9.000 s, in 6.000 s"),
        "the other tasks live: {}",
        shown.out
    );
    assert_eq!(shown.out.matches("clean\n").count(), 2, "before and after going back: {}", shown.out);
    assert_eq!(shown.errors.matches("failed: type-error").count(), 2, "{}", shown.errors);
    assert_eq!(shown.status, Some(2));
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
    assert!(made.contains("3.2 MB made"), "{made}");
    assert!(session(&["repl"], ":time\n").errors.contains("`:time FORM`: a form is expected"));
}

#[test]
fn stepping_goes_over_the_library_unless_it_is_asked_into_it() {
    let begin = "(defun half (x) (/ x 2))\n:step (map #'half '(2 4))\n";
    let over = session(&["repl"], &format!("{begin}:step\n:step\n"));
    assert!(over.out.contains("  <1>:1:17\n"), "what the library calls of ours is ours: {}", over.out);
    assert!(!over.out.contains("prelude:"), "{}", over.out);
    let into = session(&["repl"], &format!("{begin}:into\n:next\n:out\n:continue\n"));
    assert!(into.out.matches("  prelude:").count() >= 2, "{}", into.out);
    assert!(into.out.ends_with("(1 2)\n"), "{}", into.out);
    let stopped = session(
        &["repl"],
        "(defun pick (x) (if x (print 'one) (print 'two)))\n:break pick\n(list (pick 1) (pick nil))\n:continue\n:continue\n",
    );
    assert_eq!(stopped.errors.matches("stopped at pick").count(), 2, "whichever form comes first: {}", stopped.errors);
    let stopped = session(&["repl"], ":break map\n(map #'car '((1)))\n:continue\n");
    assert!(stopped.errors.contains("stopped at map"), "{}", stopped.errors);
}

#[test]
fn who_suspended_a_task_and_until_when_one_waits_is_told() {
    let lines = "(defvar painter (spawn (wait-time 10)))\n\
                 (spawn (with-task-suspended (painter) (wait-time 4)))\n\
                 (def-fluent open? nil)\n(spawn (wait-for open? :timeout 7))\n(wait-time 1)\n\
                 :why main/spawn\n:why spawn.2\n:why spawn.3\n:tasks\n\
                 (suspend painter)\n(wait-time 5)\n:why main/spawn\n";
    let shown = session(&["repl"], lines);
    for text in [
        "main/spawn  suspended (was waiting for time until 10.000 s, in 9.000 s)\n",
        "  it is suspended by\n    main/spawn.2  waits for time until 4.000 s, in 3.000 s\n",
        "main/spawn.3  waits for fluent open?, at most until 7.000 s, in 6.000 s\n",
        "\n  spawn.2  waits for time until 4.000 s, in 3.000 s\n",
        "main/spawn  suspended (was waiting for time until 10.000 s, in 4.000 s)\n",
    ] {
        assert!(shown.out.contains(text), "{text}{}", shown.out);
    }
    let last = shown.out.rfind("main/spawn  suspended").expect("it is told");
    assert!(shown.out[last..].contains("  it was suspended by `suspend`, or a task above it was"), "{}", shown.out);
}

#[test]
fn what_is_logged_has_its_time_and_stands_between_what_is_printed() {
    let shown = session(&["repl"], "(progn (log 'one) (wait-time 2.5) (log 'two))\n");
    assert_eq!(shown.errors, "0.0 s  one\n2.5 s  two\n");
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
