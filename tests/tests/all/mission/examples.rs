//! The examples a user reads and runs.

use rpl_tests::mission::{Mission, dept};
use rpl_tests::repository::{files_below, root};
use rpl_tests::run;
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    root().join("examples")
}

/// All plans below the folder.
fn plans() -> Vec<PathBuf> {
    files_below(&folder(), &["rpl"])
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).expect("an example")
}

fn needs_robot(text: &str) -> bool {
    text.contains("Needs a robot")
}

#[test]
fn every_example_begins_by_saying_what_it_shows() {
    let all = plans();
    assert!(all.len() > 10);
    for path in all {
        let text = text(&path);
        let comment = text.lines().take_while(|line| line.starts_with(';')).collect::<Vec<_>>().join(" ");
        assert!(
            comment.trim_start_matches([';', ' ']).len() > 20,
            "{} does not say what it shows",
            path.to_string_lossy()
        );
    }
}

#[test]
fn examples_without_a_robot() {
    for path in plans().into_iter().filter(|path| path.parent() == Some(&folder())) {
        let text = text(&path);
        if needs_robot(&text) {
            continue;
        }
        let name = path.file_stem().and_then(|name| name.to_str()).expect("a name");
        insta::assert_snapshot!(format!("example-{name}"), run(&text));
    }
}

#[test]
fn examples_with_a_robot_run_undisturbed() {
    let mut names = Vec::new();
    for path in plans().into_iter().filter(|path| path.parent() == Some(&folder())) {
        let text = text(&path);
        // The day at the office lasts an hour; `office` looks at a part of it.
        // What needs an unknown place is run in arenas; `instructions` looks at that, and `cases` at the rest.
        let is_elsewhere = ["--world arena", "--world olin-rice"].iter().any(|world| text.contains(world));
        if needs_robot(&text) && !path.ends_with("office.rpl") && !is_elsewhere {
            let run = Mission::new(dept(), &text).run(5, 600.0);
            assert!(run.outcome().starts_with("=>"), "{}: {}", path.to_string_lossy(), run.outcome());
            names.push(path.file_stem().and_then(|name| name.to_str()).expect("a name").to_string());
        }
    }
    assert!(names.contains(&"delivery".to_string()) && names.contains(&"paper".to_string()), "{names:?}");
}
