//! The prompt at a terminal: lines edited, completed, kept; runs that go on while one types.

use crate::folder::{folder, put};
use crate::terminal::{BACKSPACE, ENTER, HOME, INTERRUPT, TAB, Terminal, UP};
use pty_process::blocking::Command as CommandAtTerminal;
use rustix::termios::LocalModes;
use std::path::Path;
use std::process::Command;

/// The prompt on a screen of the usual size, with a history of its own.
fn prompt(name: &str, arguments: &[&str]) -> Terminal {
    prompt_in(&folder(&format!("prompt-{name}")), arguments, 24, 80)
}

/// The prompt with its history in a folder.
fn prompt_in(state: &Path, arguments: &[&str], rows: u16, columns: u16) -> Terminal {
    let program = CommandAtTerminal::new(env!("CARGO_BIN_EXE_rpl"))
        .args(arguments)
        .env("XDG_STATE_HOME", state)
        .env("TERM", "xterm-256color")
        .env("EDITOR", "sed -i s/tea/coffee/")
        .env_remove("VISUAL")
        .env_remove("NO_COLOR");
    Terminal::start(program, rows, columns)
}

#[test]
fn a_signal_ends_the_prompt_and_leaves_the_terminal_as_it_was() {
    let mut terminal = prompt("signal", &[]);
    terminal.stands_behind("rpl> ");
    terminal.keys("(list 1");
    terminal.stands_behind("rpl> (list 1");
    let modes = |terminal: &Terminal| {
        rustix::termios::tcgetattr(terminal.keyboard.as_ref()).expect("it is a terminal").local_modes
    };
    assert!(!modes(&terminal).contains(LocalModes::ECHO), "lines are edited key by key");
    let id = terminal.child.id().to_string();
    assert!(Command::new("kill").args(["-TERM", &id]).status().expect("kill runs").success());
    assert_eq!(terminal.child.wait().expect("it ends").code(), Some(130));
    assert!(modes(&terminal).contains(LocalModes::ECHO | LocalModes::ICANON));
}

#[test]
fn a_form_may_go_over_several_lines() {
    let mut terminal = prompt("lines", &[]);
    terminal.stands_behind("rpl> ");
    terminal.keys("(def-plan greet (who)\r");
    terminal.keys("  (list 'hello who))\r");
    terminal.stands_behind("rpl> ");
    terminal.shows("\ngreet\n");
    terminal.enter("(greet 'ann)", "(hello ann)", "rpl> ");
    assert_eq!(terminal.end(), 0);
}

#[test]
fn a_line_that_goes_on_is_marked_and_indented_by_the_rules_of_the_language() {
    let mut terminal = prompt("continuation", &[]);
    terminal.stands_behind("rpl> ");
    terminal.keys("(def-plan greet (who)\r");
    terminal.stands_behind("...>   ");
    terminal.keys("(let ((a who)\r");
    terminal.stands_behind("...>         ");
    terminal.keys(BACKSPACE);
    terminal.stands_behind("...>   (let ((a who)");
    terminal.keys(")\r");
    terminal.stands_behind("...>     ");
    terminal.keys("(list \"one\r");
    terminal.stands_behind("");
    terminal.keys("  two\" a)))\r");
    terminal.shows("\ngreet\n");
    terminal.stands_behind("rpl> ");
    terminal.enter("(greet 'ann)", "_2 = (\"one\\n  two\" ann)", "rpl> ");
    // The places are those of the text without marks.
    terminal.enter(
        ":source greet",
        "; <1>:1:1\n(def-plan greet (who)\n  (let ((a who))\n    (list \"one\n  two\" a)))\n",
        "rpl> ",
    );
}

#[test]
fn an_editor_has_the_terminal_and_gives_it_back() {
    let mut terminal = prompt("editing", &[]);
    terminal.stands_behind("rpl> ");
    terminal.enter("(list 'tea)", "_1 = (tea)", "rpl> ");
    terminal.enter(":edit", "_2 = (coffee)", "rpl> ");
    terminal.enter(":edit", "the text is as it was; nothing is run", "rpl> ");
    terminal.enter("(+ 1 1)", "_3 = 2", "rpl> ");
}

#[test]
fn a_failure_says_how_to_go_back_to_its_place() {
    let mut terminal = prompt("failure", &[]);
    terminal.stands_behind("rpl> ");
    terminal.enter("(let ((cups 5)) (wait-time 1) (car cups))", "`:back failure` goes back to its place", "rpl 1.0s> ");
    terminal.keys(":back failure\r");
    terminal.shows("cups = 5");
    terminal.stands_behind("rpl 1.0s stopped> ");
    terminal.enter("(+ cups 1)", "_2 = 6", "rpl 1.0s stopped> ");
    terminal.enter(":abort", "given up, clean-ups done", "rpl 1.0s> ");
}

#[test]
fn tab_completes_and_a_call_is_explained_while_it_is_typed() {
    let mut terminal = prompt("completion", &[]);
    terminal.stands_behind("rpl> ");
    terminal.keys("(relea");
    terminal.keys(TAB);
    terminal.stands_behind("rpl> (release-valve");
    terminal.keys(INTERRUPT);
    terminal.stands_behind("rpl> ");
    terminal.keys("(def-plan count-the-cups (room) room)\r");
    terminal.shows("\ncount-the-cups\n");
    terminal.stands_behind("rpl> ");
    terminal.keys("(count-t");
    terminal.keys(TAB);
    terminal.stands_behind("rpl> (count-the-cups");
    terminal.keys(" ");
    terminal.shows("(count-the-cups    (count-the-cups room)");
    terminal.keys("'hall)\r");
    terminal.shows("\n_2 = hall\n");
    terminal.stands_behind("rpl> ");
    terminal.keys(":contin\t");
    terminal.stands_behind("rpl> :continue");
}

#[test]
fn the_history_is_there_at_the_next_start() {
    let state = folder("prompt-history");
    let mut first = prompt_in(&state, &[], 24, 80);
    first.stands_behind("rpl> ");
    first.enter("(+ 20 3)", "\n_1 = 23\n", "rpl> ");
    assert_eq!(first.end(), 0);
    let mut second = prompt_in(&state, &[], 24, 80);
    second.stands_behind("rpl> ");
    second.keys(UP);
    second.stands_behind("rpl> (+ 20 3)");
    second.keys(ENTER);
    second.shows("\n_1 = 23\n");
}

#[test]
fn ctrl_c_interrupts_a_plan_and_leaves_everything_intact() {
    let mut terminal = prompt("interrupt", &[]);
    terminal.stands_behind("rpl> ");
    terminal.enter("(defvar rounds 0)", "\n0\n", "rpl> ");
    terminal.keys("(progn (print 'begun) (loop (incf rounds) (wait-time 1)))\r");
    terminal.shows("\nbegun");
    terminal.keys(INTERRUPT);
    terminal.shows("interrupted; `:continue` goes on");
    terminal.stands_behind_an("stopped> ");
    let status_line = |terminal: &Terminal| terminal.contents().contains("certainty");
    assert!(!status_line(&terminal), "{}", terminal.contents());
    terminal.keys("(> rounds 0)\r");
    terminal.shows("\n_3 = t\n");
    terminal.keys(":abort\r");
    terminal.shows("given up, clean-ups done");
    terminal.keys("(list 'still 'here)\r");
    terminal.shows("(still here)");
}

#[test]
fn ctrl_c_gives_the_prompt_back_from_the_middle_of_an_instant() {
    let mut terminal = prompt("interrupt-instant", &[]);
    terminal.stands_behind("rpl> ");
    terminal.keys("(progn (print 'begun) (unwind-protect (loop) (progn (print 'cleans) (loop))))\r");
    terminal.shows("\nbegun");
    terminal.keys(INTERRUPT);
    terminal.shows("interrupted; `:continue` goes on");
    terminal.stands_behind_an("stopped> ");
    // A clean-up that computes on and on is interrupted like everything else.
    terminal.keys(":abort\r");
    terminal.shows("\ncleans");
    terminal.keys(INTERRUPT);
    terminal.stands_behind_an("stopped> ");
    terminal.keys("(list 'still 'here)\r");
    terminal.shows("(still here)");
}

#[test]
fn a_whole_file_can_be_pasted() {
    let mut terminal = prompt("paste", &[]);
    terminal.stands_behind("rpl> ");
    let file = "; A comment, and a tab:\n(def-plan twice (x)\n\t(* 2 x))\n\n(def-plan thrice (x)\n  (* 3 x))\n\n(list (twice 4)\n      (thrice 5))\n";
    terminal.keys(&format!("\x1b[200~{file}\x1b[201~"));
    terminal.shows("(thrice 5))");
    terminal.keys(ENTER);
    terminal.shows("\n_1 = (8 15)\n");
    terminal.stands_behind("rpl> ");
    terminal.enter("(thrice 2)", "\n_2 = 6\n", "rpl> ");
}

#[test]
fn a_file_of_many_lines_can_be_pasted() {
    let mut terminal = prompt("long-paste", &[]);
    terminal.stands_behind("rpl> ");
    let plans: String = (0..40).map(|n| format!("; Plan {n}.\n(def-plan plan-{n} (x)\n\n  (+ x {n}))\n")).collect();
    terminal.keys(&format!("\x1b[200~{plans}(plan-39 (plan-0 961))\n\x1b[201~"));
    terminal.shows("(plan-39 (plan-0 961))");
    terminal.keys(ENTER);
    terminal.shows("\n_1 = 1000\n");
    terminal.stands_behind("rpl> ");
}

#[test]
fn what_is_told_is_broken_between_words() {
    let mut terminal = prompt("layout", &[]);
    terminal.stands_behind("rpl> ");
    let advice =
        "error: no plan, function or tag is called `no-such-plan`; a line is a number, a\n    condition stands in ( )";
    terminal.enter(":break no-such-plan", advice, "rpl> ");
    terminal.enter("(def-fluent open? nil)", "#<fluent open?>", "rpl> ");
    let plan = "(def-plan a-plan-with-a-rather-long-name () (par (wait-for open?)))";
    terminal.enter(plan, "\na-plan-with-a-rather-long-name\n", "rpl> ");
    terminal.enter("(spawn (par (par (par (a-plan-with-a-rather-long-name)))))", "#<task main/spawn>", "rpl> ");
    terminal.enter("(wait-time 1)", "\nnil\n", "rpl 1.0s> ");
    terminal.enter(":why spawn", "waits for fluent open?", "rpl 1.0s> ");
    terminal.enter(":doc deftest", "more of the kind", "rpl 1.0s> ");
    let screen = terminal.screen.screen();
    let wrapped: Vec<u16> = (0..24).filter(|&row| screen.row_wrapped(row)).collect();
    assert!(wrapped.is_empty(), "{wrapped:?}\n{}", terminal.contents());
}

#[test]
fn a_changed_file_is_loaded_while_a_form_runs() {
    let state = folder("prompt-loading");
    let file = state.join("beat.rpl");
    let write = |value: &str| {
        std::fs::write(&file, format!("(def-plan beat () (wait-time 3) '{value})\n")).expect("it can be written");
    };
    let load = format!(":load {}\r", file.to_string_lossy());
    write("slow");
    let mut terminal = prompt_in(&state, &[], 24, 200);
    terminal.stands_behind("rpl> ");
    terminal.keys(&load);
    terminal.shows("\nbeat\n");
    terminal.stands_behind("rpl> ");
    terminal.keys(":step (list (beat) (beat))\r");
    terminal.stands_behind_an("stopped> ");
    terminal.keys(":until 1s\r");
    terminal.shows("\n0.000 s\n");
    terminal.stands_behind_an("stopped> ");
    write("fast");
    terminal.keys(&load);
    terminal.shows("`beat` is defined anew from its next call on; the old text still runs in main/beat\n");
    terminal.stands_behind_an("stopped> ");
    terminal.keys(":continue\r");
    terminal.shows("\n_1 = (slow fast)\n");
}

#[test]
fn ctrl_c_gives_the_prompt_back_from_a_file_that_never_ends() {
    let state = folder("prompt-endless");
    let file = state.join("endless.rpl");
    let text = "(defvar before 1)\n(print 'begun)\n(loop (wait-time 1))\n(defvar after 2)\n";
    std::fs::write(&file, text).expect("it can be written");
    let mut terminal = prompt_in(&state, &[], 24, 80);
    terminal.stands_behind("rpl> ");
    terminal.keys(&format!(":load {}\r", file.to_string_lossy()));
    terminal.shows("\nbegun");
    terminal.keys(INTERRUPT);
    terminal.shows("interrupted; `:continue` goes on");
    terminal.stands_behind_an("stopped> ");
    terminal.keys("(list 'before before)\r");
    terminal.shows("(before 1)");
    terminal.keys(":abort\r");
    terminal.shows("given up, clean-ups done");
}

#[test]
fn output_of_running_tasks_does_not_destroy_the_line_being_typed() {
    let mut terminal = prompt("above", &[]);
    terminal.stands_behind("rpl> ");
    terminal.keys(":go 20\r");
    terminal.stands_behind_an("s running> ");
    terminal.keys("(spawn (loop (wait-time 4) (print 'tick)))\r");
    terminal.shows("#<task main/spawn>");
    terminal.keys("(list 'typed");
    terminal.until("ticks above the line", |terminal| {
        terminal.contents().matches("\ntick").count() >= 3 && terminal.line().ends_with("running> (list 'typed")
    });
    terminal.keys(" 'meanwhile)");
    terminal.keys(HOME);
    terminal.keys(ENTER);
    terminal.shows("\n_2 = (typed meanwhile)");
    terminal.stands_behind_an("running> ");
    terminal.keys(INTERRUPT);
    terminal.shows("stopped at ");
    terminal.stands_behind_an("s> ");
}

#[test]
fn what_is_projected_while_the_clock_runs_is_told_above_the_line_being_typed() {
    let mut terminal = prompt("projecting", &[]);
    terminal.stands_behind("rpl> ");
    terminal.keys(":go 20\r");
    terminal.stands_behind_an("s running> ");
    terminal.keys(":project (dotimes (n 2000) (wait-time 1))\r");
    terminal.until("the next line", |terminal| {
        terminal.contents().matches("(wait-time 1))").count() == 1 && terminal.line().ends_with("s running> ")
    });
    terminal.keys("(list 'typed");
    terminal.until("what is known above the line", |terminal| {
        terminal.contents().contains("\n60 of 60 runs succeed") && terminal.line().ends_with("(list 'typed")
    });
    terminal.keys(" 'meanwhile)\r");
    terminal.shows("= (typed meanwhile)");
}

#[test]
fn plans_are_handed_in_and_conditions_stop_the_clock() {
    let mut terminal = prompt("clock", &[]);
    terminal.stands_behind("rpl> ");
    terminal.enter("(def-fluent level 0)", "#<fluent level>", "rpl> ");
    terminal.enter(":break (> level 2)", ":break", "rpl> ");
    terminal.keys(":go 20\r");
    terminal.stands_behind_an("s running> ");
    terminal.keys("(progn (wait-for (> level 9)) 'high)\r");
    terminal.until("the next line", |terminal| {
        terminal.contents().matches("'high)").count() == 1 && terminal.line().ends_with("s running> ")
    });
    terminal.keys("(setf (value level) 2)\r");
    terminal.shows("\n_3 = 2\n");
    terminal.keys("(seq (wait-time 3) (setf (value level) 5) (wait-time 3) (setf (value level) 10))\r");
    terminal.shows("main/typed.2 waits for time until ");
    terminal.shows("stopped at (> level 2)");
    terminal.stands_behind_an("s stopped> ");
    terminal.keys(":continue\r");
    terminal.shows("\n_2 = high\n");
    terminal.shows("main/typed.2 => 10");
}

#[test]
fn a_form_is_marked_within_the_width_of_the_screen() {
    let mut terminal = prompt("width", &[]);
    terminal.stands_behind("rpl> ");
    let long = format!("(list {})", "'a-symbol ".repeat(12));
    terminal.keys(&format!(":step {long}\r"));
    terminal.shows("1 ▶ (list");
    terminal.stands_behind_an("stopped> ");
    let screen = terminal.screen.screen();
    let marked = (0..24).find(|&row| screen.contents_between(row, 0, row, 80).contains('▶')).expect("it is shown");
    assert!(!screen.row_wrapped(marked), "{}", terminal.contents());
}

#[test]
fn a_mission_is_watched_interrupted_and_taken_back() {
    let folder = folder("prompt-mission");
    // It must still run when somebody has looked.
    let plan = "(n-times 100 (go-to 'mail-slots) (log \"at the mail slots\") (go-to 'wolframs-shelf))";
    let rounds = put(&folder, "rounds.rpl", plan);
    let mut terminal = prompt_in(&folder, &["--world", "dept"], 50, 200);
    terminal.stands_behind("rpl> ");
    terminal.keys(&format!(":load {rounds}\r"));
    terminal.shows("navigation  certainty");
    terminal.keys(INTERRUPT);
    terminal.shows("interrupted; `:continue` goes on");
    terminal.stands_behind_an("stopped> ");
    assert!(!terminal.contents().contains("navigation  certainty"), "{}", terminal.contents());
    terminal.keys(":map\r");
    terminal.shows("? estimate, certainty");
    terminal.stands_behind_an("stopped> ");
    terminal.keys(":at 0s\r");
    terminal.shows("\n0.000 s");
    terminal.stands_behind_an("stopped> ");
    terminal.keys(":continue\r");
    terminal.shows("at the mail slots");
}
