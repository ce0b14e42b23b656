//! What somebody else may have put there: projects that are found.

use crate::folder::{folder, put};
use crate::rpl::{Ended, rpl, run_in};
use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};

/// A module that leaves a mark when it is started, and ends.
const MARKING: &str = "name = \"marking\"\ndoc = \"Leaves a mark.\"\ncommand = [\"sh\", \"-c\", \"touch started\"]\n\
                       [[fluent]]\nname = \"mark*\"\ndoc = \"None.\"\ntype = \"number\"\n";

/// A project with that module.
fn project(name: &str) -> PathBuf {
    let folder = folder(name);
    put(&folder, "rpl.toml", "plan = \"main.rpl\"\nworld = \"test-room\"\nmodules = [\"marking.toml\"]\n");
    put(&folder, "marking.toml", MARKING);
    put(&folder, "main.rpl", "(print 'runs)\n(deftest it-is (print 'is))\n");
    folder
}

fn allow(path: &Path, mode: u32) {
    fs::set_permissions(path, fs::Permissions::from_mode(mode)).expect("it is there");
}

#[test]
fn a_project_that_others_may_have_written_is_used_by_its_name_alone() {
    let folder = project("foreign-project");
    let file = folder.join("rpl.toml");
    let refused = |why: &str| {
        for command in ["run", "test", "check", "experiment"] {
            let Ended { errors, status, .. } = run_in(&folder, &[command]);
            let advice = format!("`rpl {command} rpl.toml`");
            assert!(status == 2 && errors.contains(why) && errors.contains(&advice), "{command}: {errors}");
        }
        assert!(!folder.join("started").exists(), "{why}");
    };
    for mode in [0o777, 0o1777] {
        allow(&folder, mode);
        refused("everybody may write the folder");
    }
    allow(&folder, 0o755);
    allow(&file, 0o666);
    refused("everybody may write the file");
    // A link is looked at where it leads to.
    allow(&file, 0o644);
    fs::create_dir(folder.join("open")).expect("it can be made");
    fs::rename(&file, folder.join("open/rpl.toml")).expect("it can be moved");
    allow(&folder.join("open"), 0o777);
    symlink("open/rpl.toml", &file).expect("it can be made");
    refused("open`");
    let Ended { errors, status, .. } = run_in(&folder, &["run", "rpl.toml"]);
    assert!(status == 2 && errors.contains("the module `marking`") && folder.join("started").exists(), "{errors}");
    let Ended { out, errors, status } = run_in(&folder, &["check", "./rpl.toml"]);
    assert_eq!(status, 0, "{out}{errors}");
}

#[test]
fn a_project_above_the_home_folder_is_nobodys() {
    let folder = project("foreign-home");
    let home = folder.join("home");
    fs::create_dir_all(home.join("plans")).expect("it can be made");
    let checked = |within: &str| -> Ended {
        let mut check = rpl(&["check"]);
        check.env("HOME", &home).current_dir(folder.join(within)).output().expect("it starts").into()
    };
    for within in ["home/plans", "home", "."] {
        let Ended { errors, status, .. } = checked(within);
        assert!(status == 2 && errors.contains("it lies above the home folder"), "{within}: {errors}");
    }
    put(&home, "rpl.toml", "");
    put(&home, "main.rpl", "(print 1)");
    let Ended { errors, status, .. } = checked("home/plans");
    assert!(status == 0 && errors.contains("the project is `"), "{errors}");
}

#[test]
fn modules_of_a_project_are_told_and_started_when_all_texts_are_right() {
    let folder = project("foreign-modules");
    let in_a_world = "(deftest in-a-world :world \"test-room\" (print 1))\n";
    put(&folder, "tests.rpl", in_a_world);
    put(&folder, "main.rpl", "(print (foo");
    for command in ["run", "test"] {
        let Ended { errors, status, .. } = run_in(&folder, &[command]);
        assert!(
            status == 2 && !folder.join("started").exists() && !errors.contains("is started"),
            "{command}: {errors}"
        );
    }
    let Ended { out, .. } = run_in(&folder, &["test"]);
    assert!(out.contains("its modules are not started while there are texts with errors"), "{out}");
    put(&folder, "main.rpl", "(print 1)");
    fs::create_dir(folder.join("below")).expect("it can be made");
    for command in ["run", "test"] {
        let Ended { errors, .. } = run_in(&folder.join("below"), &[command]);
        assert!(errors.contains("the project is `/"), "{command}: {errors}");
        let started = "the module `marking` is started: `sh -c touch started`, in `";
        assert!(errors.contains(started) && folder.join("started").exists(), "{command}: {errors}");
        fs::remove_file(folder.join("started")).expect("it is there");
    }
}
