//! `rpl new`, and what `run`, `test` and `check` do in a project.

use crate::folder::{folder, put};
use crate::rpl::{Ended, feed, rpl, run_in};
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
    assert!(status == 0 && out.contains("the-robot-arrives") && out.contains("2 tests, all ok"), "{out}{errors}");
    // Its scenario is one, as its test says.
    let Ended { out, .. } = run_in(&project, &["check"]);
    assert!(out.contains("turned.rpl: no findings, as a scenario"), "{out}");
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
fn a_project_holds_for_a_plan_that_is_named_and_each_option_for_itself() {
    let folder = folder("project-named");
    let text = "(defvar far 1) (print (list 'far far)) (wait-time 1) (at-destination? 'corner)";
    put(&folder, "main.rpl", text);
    put(&folder, "other.rpl", text);
    put(&folder, "rpl.toml", "plan = \"main.rpl\"\nworld = \"test-room\"\nrobot = \"turtlebot\"\nset = { far = 5 }\n");
    assert_eq!(run_in(&folder, &["worlds", "test-room", "--toml", "flat.toml"]).status, 0);
    let robot = |words: &[&str]| {
        let trace = folder.join("trace.jsonl");
        let Ended { out, errors, status } = run_in(&folder, &[words, &["--trace", "trace.jsonl"]].concat());
        assert_eq!(status, 0, "{out}{errors}");
        let trace = fs::read_to_string(trace).expect("it is written");
        (trace.lines().next().expect("a head").contains("turtlebot"), out.contains(" 5)"))
    };
    assert_eq!(robot(&["run"]), (true, true));
    assert_eq!(robot(&["run", "main.rpl"]), (true, true));
    assert_eq!(robot(&["run", "main.rpl", "--world", "flat.toml"]), (true, true));
    // First values are those of the plan of the project; another one need not have such variables.
    assert_eq!(robot(&["run", "other.rpl"]), (true, false));
    assert_eq!(robot(&["run", "--set", "far=7"]), (true, false));
    assert_eq!(robot(&["run", "--robot", "b21"]), (false, true));
    let above = folder.parent().expect("a folder").to_path_buf();
    let named = format!("{}/main.rpl", folder.file_name().expect("a name").to_string_lossy());
    let Ended { errors, status, .. } = run_in(&above, &["run", &named]);
    assert!(status == 0 && errors.contains("the project is `"), "{errors}");
    // A prompt without a file is in the world of the project, too.
    let Ended { out, errors, .. } = feed(rpl(&["repl"]).current_dir(&folder), "(at-destination? 'corner)\n");
    assert!(!errors.contains("needs a robot") && out.contains("nil"), "{out}{errors}");
    let Ended { errors, status, .. } = run_in(&folder, &["project", "--horizon", "1s", "--runs", "2"]);
    assert_eq!(status, 0, "{errors}");
}

#[test]
fn scenarios_and_plans_of_modules_in_a_project_are_no_plans() {
    let folder = folder("project-roles");
    put(&folder, "rpl.toml", "world = \"test-room\"\nscenarios = [\"night.rpl\"]\nmodules = [\"nose.toml\"]\n");
    let manifest = "name = \"nose\"\ndoc = \"Smells.\"\ncommand = [\"false\"]\nvalves = [\"nose\"]\nplans = \"nose.rpl\"\n\
                    [[fluent]]\nname = \"gas*\"\ndoc = \"Gas.\"\ntype = \"number\"\n";
    put(&folder, "nose.toml", manifest);
    put(&folder, "nose.rpl", "(def-plan sniff-room () \"Smells.\" (with-valve wheels (print 'snuff)))\n");
    put(&folder, "night.rpl", "(wait-time 1) (close-door! 'bath)\n");
    put(&folder, "turn.rpl", "(rotate-robot! 70deg)\n");
    put(&folder, "tests.rpl", "(deftest quick :scenario \"turn.rpl\" (print 1))\n(deftest plain (print 2))\n");
    let Ended { out, errors, status } = run_in(&folder, &["check"]);
    assert_eq!(status, 0, "{out}{errors}");
    for told in [
        "night.rpl: no findings, as a scenario",
        "turn.rpl: no findings, as a scenario",
        "nose.rpl: no findings, as plans of",
    ] {
        assert!(out.contains(told), "{told}: {out}");
    }
    put(&folder, "rpl.toml", "world = \"test-room\"\nscenario = \"night.rpl\"\n");
    fs::remove_file(folder.join("nose.rpl")).expect("it is there");
    let Ended { out, errors, status } = run_in(&folder, &["test", "--filter", "plain"]);
    assert!(status == 0 && out.contains("1 test, all ok"), "{out}{errors}");
    put(&folder, "wrong.rpl", "(print (foo");
    let Ended { out, status, .. } = run_in(&folder, &["test", "--filter", "plain"]);
    assert!(status == 2 && out.contains("1 test, ok, but a file has errors"), "{out}");
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
