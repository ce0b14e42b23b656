//! `rpl new`, and what `run`, `test` and `check` do in a project.

use crate::folder::{folder, put};
use crate::rpl::{Ended, run_in};
use std::fs;

#[test]
fn a_new_project_runs_and_its_test_passes() {
    let folder = folder("new-project");
    let Ended { out, errors, status } = run_in(&folder, &["new", "rounds"]);
    assert!(status == 0 && out.contains("rpl test"), "{out}{errors}");
    let project = folder.join("rounds");
    let Ended { out, errors, status } = run_in(&project, &["run"]);
    assert!(status == 0 && out.contains("at corner after"), "{out}{errors}");
    let Ended { out, errors, status } = run_in(&project, &["test"]);
    assert!(status == 0 && out.contains("the-robot-arrives"), "{out}{errors}");
    // From a folder of the project, too; and its texts have no fault and are laid out as they should be.
    fs::create_dir(project.join("below")).expect("it can be made");
    let Ended { out, errors, status } = run_in(&project.join("below"), &["check"]);
    assert_eq!(status, 0, "{out}{errors}");
    let Ended { out, errors, status } = run_in(&project, &["fmt", "--check", "."]);
    assert_eq!(status, 0, "{out}{errors}");
}

#[test]
fn a_project_has_a_copy_of_a_world_that_is_a_file() {
    let folder = folder("new-project-world");
    assert_eq!(run_in(&folder, &["worlds", "test-room", "--toml", "mine.toml"]).status, 0);
    let Ended { errors, status, .. } = run_in(&folder, &["new", "rounds", "--world", "mine.toml"]);
    assert_eq!(status, 0, "{errors}");
    fs::remove_file(folder.join("mine.toml")).expect("it is there");
    let Ended { out, errors, status } = run_in(&folder.join("rounds"), &["test"]);
    assert_eq!(status, 0, "{out}{errors}");
}

#[test]
fn nothing_that_is_there_is_overwritten() {
    let folder = folder("new-project-twice");
    fs::create_dir(folder.join("rounds")).expect("it can be made");
    put(&folder.join("rounds"), "main.rpl", "(print 1)");
    let Ended { errors, status, .. } = run_in(&folder, &["new", "rounds"]);
    assert!(status == 2 && errors.contains("`rounds` is there already"), "{errors}");
    assert_eq!(fs::read_to_string(folder.join("rounds/main.rpl")).expect("it is there"), "(print 1)");
    let Ended { errors, status, .. } = run_in(&folder, &["new", "other", "--world", "nowhere"]);
    assert!(status == 2 && !folder.join("other").exists(), "{errors}");
}

#[test]
fn without_a_project_it_is_said_what_to_type() {
    let folder = folder("no-project");
    for command in ["run", "test", "check", "experiment"] {
        let Ended { errors, status, .. } = run_in(&folder, &[command]);
        assert!(status == 2 && errors.contains("rpl new NAME"), "{command}: {errors}");
    }
    put(&folder, "rpl.toml", "world = \"test-room\"\n");
    let Ended { errors, status, .. } = run_in(&folder, &["run"]);
    assert!(status == 2 && errors.contains("plan = \"main.rpl\""), "{errors}");
}

#[test]
fn a_project_says_the_seeds_of_its_runs_and_what_is_typed_holds_before_it() {
    let folder = folder("project-seeds");
    put(&folder, "main.rpl", "(print (random 1000000))");
    put(&folder, "rpl.toml", "plan = \"main.rpl\"\nseed = 7\nruns = 3\n");
    let printed = |words: &[&str]| run_in(&folder, words).out;
    assert_eq!(printed(&["run", "-q"]), printed(&["run", "-q", "main.rpl", "--seed", "7"]));
    assert_eq!(printed(&["run", "-q", "--seed", "8"]), printed(&["run", "-q", "main.rpl", "--seed", "8"]));
    let same = ["experiment", "main.rpl", "--seed", "7", "--runs", "3", "--json"];
    assert_eq!(printed(&["experiment", "--json"]), printed(&same));
    put(&folder, "rpl.toml", "plan = \"main.rpl\"\nruns = 0\n");
    let Ended { errors, status, .. } = run_in(&folder, &["experiment"]);
    assert!(status == 2 && errors.contains("runs = 0"), "{errors}");
}
