//! What commands show at terminals of several widths, through a pager, and in colours.

use crate::folder::{folder, put};
use crate::rpl::rpl;
use crate::terminal::screen;
use std::io::Read;
use std::process::{ExitStatus, Stdio};

/// No command shows more lines.
const ROWS: u16 = 6000;

/// What a terminal shows after a command.
struct Shown {
    screen: vt100::Parser,
    /// What came, with its escape sequences.
    raw: String,
    status: ExitStatus,
}

impl Shown {
    fn text(&self) -> String {
        self.screen.screen().contents()
    }

    /// The lines that the terminal had to break.
    fn broken(&self) -> Vec<String> {
        let screen = self.screen.screen();
        let columns = screen.size().1.get();
        let broken = (0..ROWS).filter(|&row| screen.row_wrapped(row));
        broken.map(|row| screen.contents_between(row, 0, row, columns)).collect()
    }
}

/// Runs a command at a terminal, without a pager unless the environment names one.
fn at_terminal(arguments: &[&str], columns: u16, environment: &[(&str, &str)]) -> Shown {
    let (pty, child_end) = pty_process::blocking::open().expect("there are pseudo-terminals");
    pty.resize(pty_process::Size::new(50, columns)).expect("it has a size");
    let mut child = pty_process::blocking::Command::new(env!("CARGO_BIN_EXE_rpl"))
        .args(arguments)
        .envs([("TERM", "xterm-256color"), ("RPL_PAGER", "")])
        .env_remove("NO_COLOR")
        .env_remove("CLICOLOR_FORCE")
        .env_remove("CLICOLOR")
        .env_remove("COLUMNS")
        .envs(environment.iter().copied())
        .spawn(child_end)
        .expect("it starts");
    let (mut bytes, mut piece) = (Vec::new(), [0; 4096]);
    // At the end of the last program at a terminal, reading is an error.
    while let Ok(count @ 1..) = (&pty).read(&mut piece) {
        bytes.extend_from_slice(&piece[..count]);
    }
    let mut screen = screen(ROWS, columns, 0);
    screen.process(&bytes);
    let status = child.wait().expect("it ends");
    Shown { screen, raw: String::from_utf8_lossy(&bytes).into_owned(), status }
}

/// What a command writes into pipes, standard output before standard error.
fn in_pipes(arguments: &[&str], environment: &[(&str, &str)]) -> String {
    let output = rpl(arguments)
        .env("TERM", "xterm-256color")
        .env_remove("NO_COLOR")
        .env_remove("CLICOLOR_FORCE")
        .env_remove("COLUMNS")
        .envs(environment.iter().copied())
        .stdin(Stdio::null())
        .output()
        .expect("it runs");
    String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned()
}

fn words(text: &str) -> Vec<&str> {
    text.split_whitespace().collect()
}

const WIDTHS: [u16; 5] = [40, 60, 80, 120, 200];

fn commands() -> Vec<String> {
    let help = in_pipes(&["--help"], &[]);
    let list = help.split("Commands:\n").nth(1).and_then(|rest| rest.split("\n\n").next()).expect("there is a list");
    let begins = |line: &&str| line.starts_with("  ") && !line.starts_with("   ");
    list.lines().filter(begins).filter_map(|line| line.split_whitespace().next()).map(str::to_string).collect()
}

/// Runs a command at a terminal of each width: nothing is broken by the terminal, and what is shown
/// is what is written into a pipe, with other spaces.
fn assert_fits(arguments: &[&str]) {
    let plain = in_pipes(arguments, &[]);
    assert!(!plain.trim().is_empty(), "{arguments:?} says nothing");
    for columns in WIDTHS {
        let shown = at_terminal(arguments, columns, &[]);
        assert!(shown.broken().is_empty(), "{arguments:?} at {columns}: {:#?}", shown.broken());
        assert_eq!(words(&shown.text()), words(&plain), "{arguments:?} at {columns}");
    }
}

#[test]
fn help_fits_every_width() {
    let commands = commands();
    assert!(commands.len() > 12, "{commands:?}");
    assert_fits(&["--help"]);
    for command in commands {
        assert_fits(&[&command, "--help"]);
        assert_fits(&[&command, "-h"]);
    }
}

#[test]
fn help_in_a_pipe_has_at_most_a_hundred_columns() {
    for command in commands() {
        let help = in_pipes(&[&command, "--help"], &[]);
        let long = help.lines().find(|line| line.chars().count() > 100);
        assert_eq!(long, None, "rpl {command} --help");
    }
}

#[test]
fn lists_and_explanations_fit_every_width() {
    for arguments in [
        &["worlds"][..],
        &["worlds", "dept"],
        &["examples"],
        &["doc"],
        &["doc", "behaviours"],
        &["doc", "with-failure-handling"],
        &["doc", "navigation"],
        &["doc", "no-such-name"],
        &["experiment", "rotated", "--row", "no-such-row"],
        &["run", "no-such-plan"],
        &["rnu"],
        &["run", "a.rpl", "--no-such-option", "7"],
        &["localize"],
    ] {
        assert_fits(arguments);
    }
}

#[test]
fn tables_are_whole_at_every_width() {
    let arguments = ["experiment", "first-steps", "--runs", "3"];
    let plain = in_pipes(&arguments, &[]);
    let lines = |text: &str| text.lines().count();
    for columns in WIDTHS {
        let shown = at_terminal(&arguments, columns, &[]);
        let text = shown.text();
        assert!(shown.broken().is_empty(), "at {columns}:\n{text}");
        assert!(words(&plain).iter().all(|word| words(&text).contains(word)), "at {columns}:\n{text}");
        // What does not fit stands below, behind the name of its row.
        assert_eq!(text.matches("time [s]").count() > 1, columns < 64, "at {columns}:\n{text}");
        assert!(lines(text.trim_end()) >= lines(&plain), "at {columns}:\n{text}");
    }
}

#[test]
fn tests_fit_every_width() {
    let text = "(deftest the-kettle-is-filled-before-it-is-put-on-the-stove (wait-time 1))\n\
                (deftest fails (fail \"the message of this failure is longer than a line of forty columns\"))\n";
    let plan = put(&folder("layout-tests"), "long.rpl", text);
    let arguments = ["test", &plan];
    for columns in WIDTHS {
        let shown = at_terminal(&arguments, columns, &[]);
        assert!(shown.broken().is_empty(), "at {columns}: {:#?}", shown.broken());
        assert!(shown.text().contains("the-kettle-is-filled-before-it-is-put-on-the-stove") || columns < 60);
    }
}

/// A program of this test's own that a pager can be.
#[cfg(unix)]
fn script(name: &str, text: &str) -> String {
    use std::os::unix::fs::PermissionsExt;
    let path = put(&folder("layout-pager"), name, format!("#!/bin/sh\n{text}\n"));
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).expect("it can be made a program");
    path
}

#[cfg(unix)]
#[test]
fn documentation_goes_through_a_pager_at_a_terminal() {
    let own = script("pager with a space", "echo this is a page; exec cat");
    let own = format!("'{own}'");
    let paged = at_terminal(&["doc", "waiting"], 80, &[("RPL_PAGER", &own)]);
    assert!(paged.text().starts_with("this is a page\nFluents and waiting"), "{}", paged.text());
    // One's own pager for rpl comes before that for all.
    let both = at_terminal(&["doc", "waiting"], 80, &[("RPL_PAGER", "sed s/^/rpl:/"), ("PAGER", &own)]);
    assert!(both.text().starts_with("rpl:Fluents"), "{}", both.text());
    // It is laid out for the terminal, which the pager hides.
    let narrow = at_terminal(&["doc", "go-to"], 40, &[("RPL_PAGER", "cat")]);
    assert!(narrow.broken().is_empty(), "{}", narrow.text());
    assert!(narrow.status.success());
}

#[cfg(unix)]
#[test]
fn a_pager_that_fails_loses_nothing() {
    let whole = at_terminal(&["doc"], 80, &[]).text();
    for pager in ["no-such-pager-anywhere 2>/dev/null", "false", "exit 3"] {
        let shown = at_terminal(&["doc"], 80, &[("RPL_PAGER", pager)]);
        assert_eq!(shown.text(), whole, "{pager}");
        assert!(shown.status.success(), "{pager}");
    }
}

#[cfg(unix)]
#[test]
fn a_pager_that_is_left_early_is_no_error() {
    let shown = at_terminal(&["doc"], 80, &[("RPL_PAGER", "head -n 2")]);
    assert_eq!(shown.text().trim_end().lines().count(), 2, "{}", shown.text());
    assert!(shown.status.success());
}

#[test]
fn there_is_no_pager_without_a_terminal_or_an_able_one() {
    assert!(in_pipes(&["doc", "waiting"], &[("RPL_PAGER", "echo no")]).starts_with("Fluents and waiting"));
    let shown = at_terminal(&["doc", "waiting"], 80, &[("RPL_PAGER", "echo no"), ("TERM", "dumb")]);
    assert!(shown.text().starts_with("Fluents and waiting"), "{}", shown.text());
    // What is wrong is told in any case.
    let wrong = at_terminal(&["doc", "no-such-name"], 80, &[("RPL_PAGER", "cat")]);
    assert!(wrong.text().contains("nothing is called `no-such-name`"), "{}", wrong.text());
    assert_eq!(wrong.status.code(), Some(2));
}

fn has_colours(text: &str) -> bool {
    text.contains("\u{1b}[")
}

#[test]
fn colours_are_written_where_they_are_wanted() {
    let plan = put(&folder("colours"), "wrong.rpl", "(deftest fails (fail \"x\"))\n(print\n 1)\n");
    for arguments in [
        &["test", &plan][..],
        &["eval", "(undefined)"],
        &["eval", "(fail \"x\")"],
        &["--help"],
        &["rnu"],
        &["fmt", "--diff", &plan],
    ] {
        let with = |colour: &'static str| [arguments, &["--color", colour]].concat();
        let (no, force) = (("NO_COLOR", "1"), ("CLICOLOR_FORCE", "1"));
        // At a terminal, unless something speaks against it.
        assert!(has_colours(&at_terminal(arguments, 80, &[]).raw), "{arguments:?}");
        assert!(!has_colours(&at_terminal(arguments, 80, &[no]).raw), "{arguments:?}");
        assert!(!has_colours(&at_terminal(&with("never"), 80, &[]).raw), "{arguments:?}");
        assert!(has_colours(&at_terminal(&with("always"), 80, &[no]).raw), "{arguments:?}");
        // In a pipe only if they are forced.
        assert!(!has_colours(&in_pipes(arguments, &[])), "{arguments:?}");
        assert!(has_colours(&in_pipes(arguments, &[force])), "{arguments:?}");
        assert!(!has_colours(&in_pipes(arguments, &[force, no])), "{arguments:?}");
        assert!(has_colours(&in_pipes(&with("always"), &[])), "{arguments:?}");
        assert!(!has_colours(&in_pipes(&with("never"), &[force])), "{arguments:?}");
    }
}
