//! Completions, as the shells themselves make them.
#![cfg(unix)]

use crate::folder::{folder, put};
use crate::rpl::{Ended, rpl, run};
use crate::terminal::{TAB, Terminal};
use pty_process::blocking::Command as CommandAtTerminal;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A folder with what can be completed there.
fn folder_to_complete(name: &str) -> PathBuf {
    let folder = folder(name);
    std::fs::create_dir(folder.join("rooms")).expect("the folder can be made");
    for (file, text) in [
        ("kitchen.rpl", "(defvar cups 3)\n(def-fluent cold? nil)\n(print cups)\n"),
        ("kiln.txt", "no plan"),
        ("keep.toml", "name = \"keep\"\n"),
    ] {
        put(&folder, file, text);
    }
    folder
}

/// The path on which `rpl` is the program under test.
fn path() -> String {
    let program = Path::new(env!("CARGO_BIN_EXE_rpl"));
    let folder = program.parent().expect("a program is in a folder");
    format!("{}:{}", folder.to_string_lossy(), std::env::var("PATH").unwrap_or_default())
}

fn is_there(shell: &str) -> bool {
    std::env::split_paths(&std::env::var("PATH").unwrap_or_default()).any(|folder| folder.join(shell).is_file())
}

/// What the program answers to a shell, whether or not the shell is there.
fn answers(shell: &str, folder: &Path, line: &[&str]) -> Vec<String> {
    let index = (line.len() - 1).to_string();
    let output = rpl(&["--"])
        .args(line)
        .current_dir(folder)
        .envs([("RPL_COMPLETE", shell), ("_CLAP_COMPLETE_INDEX", &index), ("_CLAP_IFS", "\n")])
        .output()
        .expect("it runs");
    let found = Ended::from(output);
    assert_eq!(found.status, 0, "{line:?}: {}", found.errors);
    // Some shells get an explanation of each.
    found.out.lines().map(|line| line.split(['\t', ':']).next().unwrap_or_default().to_string()).collect()
}

#[test]
fn every_kind_of_name_is_completed() {
    let folder = folder_to_complete("complete-names");
    let cases: &[(&[&str], &[&str])] = &[
        (&["rpl", "worl"], &["worlds"]),
        (&["rpl", "worlds", "test"], &["test-room"]),
        (&["rpl", "run", "x.rpl", "--robot", "nom"], &["nomad-200"]),
        (&["rpl", "worlds", "k"], &["keep.toml"]),
        (&["rpl", "run", "ki"], &["kitchen.rpl"]),
        (&["rpl", "run", "deliv"], &["delivery.rpl"]),
        (&["rpl", "run", "ro"], &["rooms/"]),
        (&["rpl", "run", "delivery", "--world", "dept-c"], &["dept-crowded"]),
        (&["rpl", "run", "delivery", "--world=dept-c"], &["--world=dept-crowded"]),
        (&["rpl", "run", "delivery", "--scenario", "rot"], &["rotated.rpl"]),
        (&["rpl", "run", "kitchen.rpl", "--set", "c"], &["cups=", "cold?="]),
        (&["rpl", "examples", "first"], &["first-steps.rpl"]),
        (&["rpl", "experiment", "kidn"], &["kidnapped"]),
        (&["rpl", "experiment", "ki"], &["kidnapped", "kitchen.rpl"]),
        (&["rpl", "experiment", "barn", "--row", "s"], &["seen so far"]),
        (&["rpl", "experiment", "worlds", "--row", "ri"], &["ring"]),
        (&["rpl", "experiment", "sensing", "--row", "laser, a"], &["laser, active"]),
        (&["rpl", "doc", "wait-t"], &["wait-time"]),
        (&["rpl", "doc", "behaviours"], &["behaviours"]),
        (&["rpl", "doc", "nav"], &["navigation", "navigation-active?*", "navigation-failure"]),
        (&["rpl", "check", "ki"], &["kitchen.rpl"]),
        (&["rpl", "completions", "z"], &["zsh"]),
        (&["rpl", "--color", "n"], &["never"]),
    ];
    for (line, expected) in cases {
        let mut found = answers("fish", &folder, line);
        found.sort();
        let mut expected = expected.to_vec();
        expected.sort_unstable();
        assert_eq!(found, expected, "{line:?}");
    }
    // All rows, and nothing of other experiments.
    let rows = answers("fish", &folder, &["rpl", "experiment", "rotated", "--row", ""]);
    assert_eq!(rows, ["rotated", "undisturbed", "no relocalization", "literal equations"]);
}

#[test]
fn every_shell_gets_a_script_and_an_answer() {
    let folder = folder_to_complete("complete-shells");
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = run(&["completions", shell]);
        assert!(script.status == 0 && script.out.contains("RPL_COMPLETE"), "{shell}: {}", script.out);
        let found = answers(shell, &folder, &["rpl", "worlds", "test"]);
        assert_eq!(found.first().map(|found| found.trim_end()), Some("test-room"), "{shell}");
    }
    // A shell that takes a word apart at spaces gets them quoted.
    let row = answers("bash", &folder, &["rpl", "experiment", "rotated", "--row", "no"]);
    assert_eq!(row, ["no\\ relocalization"]);
}

/// A shell at a terminal.
struct Shell(Terminal);

impl Shell {
    fn start(program: &str, arguments: &[&str], folder: &Path) -> Self {
        let program = CommandAtTerminal::new(program)
            .args(arguments)
            .current_dir(folder)
            .envs([("TERM", "xterm"), ("PATH", &path()), ("PS1", "ready> "), ("HOME", &folder.to_string_lossy())])
            .env_remove("RPL_COMPLETE");
        Self(Terminal::start(program, 40, 120))
    }

    fn runs(&mut self, command: &str) {
        self.0.stands_behind("ready> ");
        self.0.keys(&format!("{command}\r"));
        self.0.stands_behind("ready> ");
    }

    /// Types a line and the tabulator, and waits for what becomes of it.
    fn completes(&mut self, typed: &str, line: &str) {
        self.0.stands_behind("ready> ");
        self.0.keys(typed);
        self.0.stands_behind(&format!("ready> {typed}"));
        self.0.keys(TAB);
        self.0.stands_behind(&format!("ready> {line}"));
        // Away with the line.
        self.0.keys("\x15");
    }
}

const LINES: [(&str, &str); 7] = [
    ("rpl worlds test", "rpl worlds test-room "),
    ("rpl run kit", "rpl run kitchen.rpl "),
    ("rpl run delivery --scenario rot", "rpl run delivery --scenario rotated.rpl "),
    ("rpl experiment kidn", "rpl experiment kidnapped "),
    ("rpl experiment rotated --row no", "rpl experiment rotated --row no\\ relocalization "),
    ("rpl experiment rotated --row no\\ rel", "rpl experiment rotated --row no\\ relocalization "),
    ("rpl doc wait-t", "rpl doc wait-time "),
];

#[test]
fn bash_completes_at_a_terminal() {
    if !is_there("bash") {
        return;
    }
    let mut bash = Shell::start("bash", &["--norc", "--noprofile", "-i"], &folder_to_complete("complete-bash"));
    bash.runs("bind 'set enable-bracketed-paste off'; clear");
    bash.runs("source <(rpl completions bash); clear");
    for (typed, line) in LINES {
        bash.completes(typed, line);
    }
    bash.completes("rpl run roo", "rpl run rooms/");
}

#[test]
fn zsh_completes_at_a_terminal() {
    if !is_there("zsh") {
        return;
    }
    let mut zsh = Shell::start("zsh", &["-f", "-i"], &folder_to_complete("complete-zsh"));
    zsh.runs("PS1='ready> '; unsetopt prompt_sp prompt_cr; autoload -U compinit; compinit -u -D; clear");
    zsh.runs("source <(rpl completions zsh); clear");
    for (typed, line) in LINES {
        zsh.completes(typed, line);
    }
}

#[test]
fn fish_completes() {
    if !is_there("fish") {
        return;
    }
    let folder = folder_to_complete("complete-fish");
    for (typed, line) in LINES {
        let output = Command::new("fish")
            .args(["--no-config", "-c", "rpl completions fish | source; complete --do-complete $argv[1]", typed])
            .current_dir(&folder)
            .envs([("PATH", path()), ("HOME", folder.to_string_lossy().into_owned())])
            .output()
            .expect("it runs");
        let found = String::from_utf8_lossy(&output.stdout).into_owned();
        let name = found.lines().next().and_then(|line| line.split('\t').next()).unwrap_or_default();
        let wanted = line.trim_end().rsplit_once(" --row ").map_or(line.trim_end(), |(_, row)| row).replace('\\', "");
        assert!(
            wanted.ends_with(name) && !name.is_empty(),
            "{typed}: {found}{}",
            String::from_utf8_lossy(&output.stderr)
        );
    }
}
