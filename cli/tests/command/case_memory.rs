//! Case memories as a user looks at them.

use crate::folder::{folder, put};
use crate::rpl::{Ended, run_in};
use std::path::Path;

/// The file that the book shows.
fn of_the_book() -> &'static str {
    let book = include_str!("../../../docs/cases.md");
    book.split("```text\n")
        .find(|text| text.starts_with("{\"rpl_cases\""))
        .and_then(|rest| rest.split("```").next())
        .expect("the book shows a file")
}

fn cases(folder: &Path, options: &[&str]) -> Ended {
    run_in(folder, &[&["cases", "robot.cases"], options].concat())
}

#[test]
fn a_memory_is_shown_explained_and_drawn() {
    let folder = folder("case-memory");
    put(&folder, "robot.cases", of_the_book());
    let shown = cases(&folder, &["--draw", "cases.svg"]);
    assert_eq!(shown.status, 0, "{}", shown.errors);
    let line = |start: &str| shown.out.lines().find(|line| line.trim_start().starts_with(start)).map(str::to_string);
    assert!(line("0").is_some_and(|line| line.contains("a-desk to ")), "{}", shown.out);
    assert!(line("1").is_some_and(|line| line.contains("localize-first")), "{}", shown.out);
    assert!(shown.out.contains("0 behaviours of at most 1000, 1 route of at most 1000"), "{}", shown.out);
    assert!(std::fs::read_to_string(folder.join("cases.svg")).expect("it is drawn").contains("true-path"));
    let situation = "{\"place_in_map\":[3.2,1.5],\"long_term_goal_in_map\":[8.0,2.0]}";
    let explained = cases(&folder, &["--explain", situation]).out;
    assert!(explained.starts_with("case 0 (route), distance 0.000"), "{explained}");
    assert!(
        explained.contains("then case 1 (meta-plan), distance 12.000: long-term-goal 8.000, place 4.000"),
        "{explained}"
    );
    let lost = cases(&folder, &["--explain", "{}"]).out;
    assert!(lost.starts_with("case 1 (meta-plan), distance 0.000"), "{lost}");
}

#[test]
fn what_is_wrong_with_a_memory_is_told_with_its_place() {
    let folder = folder("faulty-case-memory");
    put(&folder, "robot.cases", of_the_book().replace("\"a-desk\"", "\"a-dask\""));
    let Ended { errors, status, .. } = cases(&folder, &[]);
    assert!(status == 2 && errors.contains("there is no place `a-dask` in this world"), "{errors}");
    assert!(errors.contains("robot.cases:2:") && errors.contains("did you mean `a-desk`?"), "{errors}");
    put(&folder, "robot.cases", of_the_book().replace("\"rpl_cases\":1", "\"rpl_cases\":9"));
    assert!(cases(&folder, &[]).errors.contains("the file is of version 9, and this reads version 1"));
    put(&folder, "robot.cases", "nonsense");
    assert!(cases(&folder, &[]).errors.contains("robot.cases:1:1: this is no case file"));
    put(&folder, "robot.cases", of_the_book());
    let unknown = cases(&folder, &["--explain", "{\"plaice\":[1,2]}"]);
    assert!(unknown.status == 2 && unknown.errors.contains("unknown field `plaice`"), "{}", unknown.errors);
    // The stop at coordinates is left out: the two places do not see each other.
    put(&folder, "robot.cases", of_the_book().replace("[4.0,3.0],", "").replace("[4.5,null]", "[4.5]"));
    let checked = cases(&folder, &["--check"]);
    assert!(
        checked.status == 1 && checked.out.contains("a robot cannot drive straight from `a-desk`"),
        "{}",
        checked.out
    );
}

#[test]
fn a_world_without_places_has_no_routes() {
    let folder = folder("cases-without-places");
    let world = "name = \"bare\"\nsize = [4.0, 4.0]\nstart = [2.0, 2.0, 0]\n\
                 [[wall]]\nline = [[0.1, 0.1], [3.9, 0.1], [3.9, 3.9], [0.1, 3.9], [0.1, 0.1]]\n";
    put(&folder, "bare.toml", world);
    put(&folder, "errand.rpl", "(with-valve wheels (run-behaviour case-navigation :route '((3 3))))");
    put(&folder, "robot.cases", of_the_book());
    let run = run_in(&folder, &["run", "errand.rpl", "--world", "bare.toml", "--robot", "pioneer-2dx"]);
    assert!(run.status == 1 && run.errors.contains("add [[place]] with a name and a pose to it"), "{}", run.errors);
    let shown = cases(&folder, &["--world", "bare.toml"]);
    assert!(shown.status == 2 && shown.errors.contains("the world has no places"), "{}", shown.errors);
}

#[test]
fn a_run_reads_its_cases_at_the_start_and_writes_them_at_the_end() {
    let folder = folder("kept-cases");
    put(&folder, "errand.rpl", "(go-by-cases 'table-side)");
    put(&folder, "look.rpl", "(map #'third (cases))");
    let run = |plan: &str, more: &[&str]| {
        let robot = ["--world", "test-room", "--robot", "pioneer-2dx", "--cases", "robot.cases"];
        run_in(&folder, &[&["run", plan], &robot[..], more].concat())
    };
    let first = run("errand.rpl", &[]);
    assert_eq!(first.status, 0, "{}", first.errors);
    let kept = std::fs::read_to_string(folder.join("robot.cases")).expect("it is written");
    assert!(kept.contains("\"used\":1"), "{kept}");
    assert!(run("look.rpl", &[]).errors.contains("(1 0 0 0)"), "what was used is remembered in the next run");
    assert_eq!(std::fs::read_to_string(folder.join("robot.cases")).ok(), Some(kept.clone()), "nothing was learned");
    // A plan that fails has learned all the same; a text that cannot be run has not.
    put(&folder, "fails.rpl", "(retain-goal 'table-side) (fail \"no luck\")");
    assert_eq!(run("fails.rpl", &[]).status, 1);
    let with_goal = std::fs::read_to_string(folder.join("robot.cases")).expect("it is there");
    assert!(with_goal.contains("\"goal\""), "{with_goal}");
    put(&folder, "wrong.rpl", "(retain-goal");
    assert_eq!(run("wrong.rpl", &[]).status, 2);
    let refused = run("errand.rpl", &["--journal", "journal"]);
    assert!(refused.status == 2 && refused.errors.contains("leave `--cases` away"), "{}", refused.errors);
    put(&folder, "robot.cases", with_goal.replace("\"rpl_cases\":1", "\"rpl_cases\":9"));
    let faulty = run("errand.rpl", &[]);
    assert!(faulty.status == 2 && faulty.errors.contains("the file is of version 9"), "{}", faulty.errors);
    let left: Vec<_> =
        std::fs::read_dir(&folder).expect("it is there").flatten().map(|file| file.file_name()).collect();
    assert!(left.iter().all(|name| !name.to_string_lossy().contains("learned")), "{left:?}");
    assert!(std::fs::read_to_string(folder.join("robot.cases")).is_ok_and(|text| text.contains("\"rpl_cases\":9")));
}
