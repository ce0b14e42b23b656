//! Bad input: `tests/cases/errors/NAME.rpl` and, in `NAME.expected`, the exit status and what a
//! user is told. A comment `; rpl run --ARGUMENT...` in the first line adds arguments.
//!
//! `UPDATE_EXPECTED=1` writes the files anew; read every line before keeping it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn cases() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/cases/errors");
    let files = fs::read_dir(folder).expect("the cases are there").map(|entry| entry.expect("a file").path());
    let mut cases: Vec<PathBuf> =
        files.filter(|path| path.extension().is_some_and(|extension| extension == "rpl")).collect();
    cases.sort();
    cases
}

fn arguments(case: &Path) -> Vec<String> {
    let bytes = fs::read(case).expect("the case can be read");
    let text = String::from_utf8_lossy(&bytes);
    let first = text.lines().next().unwrap_or_default();
    first.strip_prefix("; rpl run").unwrap_or_default().split_whitespace().map(str::to_string).collect()
}

fn outcome(case: &Path) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_rpl"))
        .current_dir(case.parent().expect("a case is in a folder"))
        .arg("run")
        .arg(case.file_name().expect("a case has a name"))
        .args(arguments(case))
        .arg("--quiet")
        .output()
        .expect("the command runs");
    let status = output.status.code().expect("the command exits by itself");
    format!("exit status {status}\n{}", String::from_utf8_lossy(&output.stderr))
}

#[test]
fn every_bad_input_is_explained() {
    let mut wrong = Vec::new();
    for case in cases() {
        let expected_path = case.with_extension("expected");
        let found = outcome(&case);
        assert!(!found.contains("panicked"), "{}\n{found}", case.display());
        if std::env::var_os("UPDATE_EXPECTED").is_some() {
            fs::write(&expected_path, &found).expect("the expectation can be written");
        }
        let expected = fs::read_to_string(&expected_path).unwrap_or_default();
        if found != expected {
            wrong.push(format!("{}\n--- expected\n{expected}\n--- found\n{found}", case.display()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn every_expectation_has_its_case() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/cases/errors");
    for entry in fs::read_dir(folder).expect("the cases are there") {
        let path = entry.expect("a file").path();
        if path.extension().is_some_and(|extension| extension == "expected") {
            assert!(path.with_extension("rpl").is_file(), "{} has no case", path.display());
        }
    }
}
