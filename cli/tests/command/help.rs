//! Help, manual pages, documentation, lists; and words that are mistyped.

use crate::folder::{folder, put, text_in};
use crate::rpl::run;

#[test]
fn what_is_mistyped_is_told_with_what_was_probably_meant() {
    for (line, meant) in [
        (&["rnu", "x.rpl"][..], "'run'"),
        (&["experimnt", "rotated"], "'experiment'"),
        (&["run", "x.rpl", "--wrold", "dept"], "'--world'"),
        (&["test", "x.rpl", "--jnuit", "x.xml"], "'--junit'"),
        (&["--colour", "never"], "'--color'"),
        (&["--color", "allways"], "'always'"),
        (&["run", "x.rpl", "--map", "nome"], "'none'"),
        (&["completions", "bsh"], "'bash'"),
    ] {
        let found = run(line);
        assert!(found.errors.contains("similar") && found.errors.contains(meant), "{line:?}: {}", found.errors);
        assert_eq!((found.out.as_str(), found.status), ("", 2), "{line:?}");
    }
}

#[test]
fn the_version_is_told() {
    let version = env!("CARGO_PKG_VERSION");
    for line in ["--version", "-V"] {
        assert!(run(&[line]).out.starts_with(&format!("rpl {version}")));
    }
}

#[test]
fn every_command_has_its_manual_page() {
    let folder = folder("man").join("man1");
    let found = run(&["man", &folder.to_string_lossy()]);
    assert_eq!(found.status, 0, "{}", found.errors);
    let help = run(&["--help"]);
    let list = help.out.split("Commands:\n").nth(1).and_then(|rest| rest.split("\n\n").next()).expect("a list");
    let begins = |line: &&str| line.starts_with("  ") && !line.starts_with("   ");
    let names: Vec<&str> = list.lines().filter(begins).filter_map(|line| line.split_whitespace().next()).collect();
    assert!(names.len() > 12, "{names:?}");
    for name in names.iter().filter(|name| **name != "help") {
        let page = text_in(&folder, &format!("rpl-{name}.1"));
        assert!(page.contains(&format!("rpl\\-{name}")) && page.contains(".SH OPTIONS"), "{page}");
    }
    let page = text_in(&folder, "rpl.1");
    assert!(page.contains(".TH rpl 1") && page.contains("Exit status"), "{page}");
    assert!(text_in(&folder, "rpl-trace-diff.1").contains(".SH SYNOPSIS"));
    let found = run(&["man", &put(&folder, "file", "")]);
    assert!(found.errors.contains("cannot make the folder"), "{}", found.errors);
    assert_eq!(found.status, 2);
}

#[test]
fn the_command_line_is_explained() {
    for wrong in [&["run"][..], &["rnu", "x.rpl"], &["run", "first-steps", "--until", "soon"], &["--no-such"]] {
        let found = run(wrong);
        assert_eq!((found.out.as_str(), found.status), ("", 2), "{wrong:?}");
        assert!(!found.errors.is_empty(), "{wrong:?}");
    }
    assert!(run(&["--help"]).out.contains("Exit status"));
    assert!(run(&["completions", "bash"]).out.contains("rpl"));
}

#[test]
fn names_are_documented() {
    assert!(run(&["doc", "try-all"]).out.contains("Succeeds at the first success"));
    assert!(run(&["doc", "wait-time"]).out.starts_with("(wait-time "));
    assert!(run(&["doc", "behaviours"]).out.contains("active-localization"));
    assert!(run(&["doc", "waiting"]).out.contains("wait-for"));
    assert!(run(&["doc", "timeout"]).out.starts_with("timeout below failure, with seconds\n"));
    assert!(run(&["doc", "fmt"]).out.starts_with("rpl fmt "));
    let found = run(&["doc", "semaphore"]);
    assert!(found.out.contains("def-valve"), "{}", found.out);
    let found = run(&["doc", "try-al"]);
    assert!(found.errors.contains("did you mean `try-all`?"), "{}", found.errors);
    assert_eq!(found.status, 2);
}

#[test]
fn worlds_and_examples_are_listed_and_shown() {
    assert!(run(&["worlds"]).out.contains("dept"));
    assert!(run(&["worlds", "test-room"]).out.contains("table-side"));
    assert!(run(&["examples"]).out.contains("first-steps.rpl"));
    assert!(run(&["examples", "first-steps"]).out.starts_with(';'));
}
