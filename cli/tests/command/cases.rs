//! What the command tells about a text: for each `NAME.rpl` in a folder of `tests/cases`, `NAME.expected`
//! holds the exit status and what a user reads. A comment `; rpl run --ARGUMENT...` (or `; rpl check`)
//! in the first line adds arguments.
//!
//! `UPDATE_EXPECTED=1` writes the files anew; read every line before keeping it.

use crate::rpl::run_in;
use rpl_tests::repository::root;
use std::fs;
use std::path::{Path, PathBuf};

/// A folder of cases, and how they are run.
struct Cases {
    folder: &'static str,
    command: &'static str,
    arguments: &'static [&'static str],
}

const ERRORS: Cases = Cases { folder: "errors", command: "run", arguments: &["--quiet"] };
const CHECK: Cases = Cases { folder: "check", command: "check", arguments: &[] };

/// The files of a folder that end so, in order.
fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("the folder is there").map(|entry| entry.expect("a file").path());
    let mut files: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|found| found == extension)).collect();
    files.sort();
    files
}

fn name(path: &Path) -> String {
    path.file_name().expect("a file has a name").to_string_lossy().into_owned()
}

impl Cases {
    fn folder(&self) -> PathBuf {
        root().join("tests/cases").join(self.folder)
    }

    fn outcome(&self, case: &Path) -> String {
        let bytes = fs::read(case).expect("the case can be read");
        let text = String::from_utf8_lossy(&bytes);
        let first = text.lines().next().unwrap_or_default();
        let own = first.strip_prefix(&format!("; rpl {}", self.command)).unwrap_or_default().split_whitespace();
        let name = name(case);
        let arguments: Vec<&str> =
            [self.command, &name].into_iter().chain(own).chain(self.arguments.iter().copied()).collect();
        let found = run_in(&self.folder(), &arguments);
        format!("exit status {}\n{}", found.status, found.errors)
    }

    fn are_as_expected(&self) {
        let mut wrong = Vec::new();
        for case in files(&self.folder(), "rpl") {
            let expected_path = case.with_extension("expected");
            let found = self.outcome(&case);
            if std::env::var_os("UPDATE_EXPECTED").is_some() {
                fs::write(&expected_path, &found).expect("the expectation can be written");
            }
            let expected = fs::read_to_string(&expected_path).unwrap_or_default();
            if found != expected {
                wrong.push(format!("{}\n--- expected\n{expected}\n--- found\n{found}", case.to_string_lossy()));
            }
        }
        assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
        for expectation in files(&self.folder(), "expected") {
            assert!(expectation.with_extension("rpl").is_file(), "{} has no case", expectation.to_string_lossy());
        }
    }
}

#[test]
fn every_bad_input_is_explained() {
    ERRORS.are_as_expected();
}

#[test]
fn every_fault_is_found_without_running() {
    CHECK.are_as_expected();
    let cases = files(&CHECK.folder(), "rpl");
    assert!(cases.len() >= 30, "there are {} seeded faults", cases.len());
    for case in cases {
        assert!(!CHECK.outcome(&case).contains("no findings"), "{} is no fault", case.to_string_lossy());
    }
}

/// What `rpl check` says about files of a folder; each must be without findings.
fn assert_clean(folder: &Path, files: &[PathBuf], arguments: &[&str]) {
    let names =
        files.iter().map(|file| file.strip_prefix(folder).ok().and_then(Path::to_str).expect("a file of the folder"));
    let arguments: Vec<&str> = ["check"].into_iter().chain(arguments.iter().copied()).chain(names).collect();
    let found = run_in(folder, &arguments);
    assert_eq!((found.errors.as_str(), found.status), ("", 0));
    assert_eq!(found.out.matches(": no findings\n").count(), files.len());
}

#[test]
fn nothing_is_said_about_clean_programs() {
    let folder = CHECK.folder().join("clean");
    let clean = files(&folder, "rpl");
    assert!(clean.len() >= 30, "there are {} clean programs", clean.len());
    assert_clean(&folder, &clean, &[]);
}

#[test]
fn nothing_is_said_about_the_examples() {
    let folder = root().join("examples");
    assert_clean(&folder, &files(&folder, "rpl"), &[]);
    assert_clean(&folder, &files(&folder.join("scenarios"), "rpl"), &["--scenario"]);
    let experiments = folder.join("experiments");
    assert_clean(&folder, &[experiments.join("no-relocalization.rpl")], &[]);
    assert_clean(&folder, &[experiments.join("rotated.rpl")], &["--scenario"]);
}

#[test]
fn the_library_itself_is_clean() {
    for library in [
        "stdlib/src/prelude/constructs.rpl",
        "stdlib/src/prelude/functions.rpl",
        "stdlib/src/prelude/revision.rpl",
        "stdlib/src/prelude/rules.rpl",
        "stdlib/src/prelude/foresight.rpl",
        "robot/src/office/plans.rpl",
    ] {
        let told = run_in(&root(), &["check", library]).errors;
        let is_expected = |line: &&str| line.starts_with("warning[redefines-library]");
        let findings = told.lines().filter(|line| line.starts_with("error[") || line.starts_with("warning["));
        let others: Vec<&str> = findings.filter(|line| !is_expected(line)).collect();
        assert!(others.is_empty(), "{library}\n{}", others.join("\n"));
        assert!(told.contains("redefines-library"), "{library} defines names of the library");
    }
}
