//! The commands as a whole: explained, mistyped, tested.

use super::{session, session_in};
use crate::folder::folder;

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
    assert_eq!(shown.status, 2);
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
    let folder = folder("wrong-arguments");
    let wrong = || WRONG.iter().copied().chain([huge.as_str()]);
    // Where nothing runs, and in the midst of a form.
    for begin in ["(defvar alive 'alive)\n", "(defvar alive 'alive)\n:step (wait-time 1)\n"] {
        for arguments in [&["repl"][..], &["repl", "--world", "test-room"]] {
            let lines: String =
                commands.iter().flat_map(|command| wrong().map(move |word| format!("{command} {word}\n"))).collect();
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
            assert_eq!(shown.status, 2);
        }
    }
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

/// What is typed in the tests of the prompt and in the page about it.
#[test]
fn every_command_has_a_test() {
    let shown = session(&["repl"], ":help\n");
    let typed = [
        include_str!("commands.rs"),
        include_str!("definitions.rs"),
        include_str!("forms.rs"),
        include_str!("history.rs"),
        include_str!("stepping.rs"),
        include_str!("understanding.rs"),
        include_str!("../../../../docs/prompt.md"),
    ]
    .concat();
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
