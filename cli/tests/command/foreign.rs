//! What somebody else may have put there: projects that are found, journals, and what lies where a journal writes.

use crate::folder::{folder, put, text_in};
use crate::rpl::{Ended, rpl, run_in};
use crate::terminal::{ENTER, Terminal};
use rpl_link::journal::frames;
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

/// A journal `j` of a run that stands still after 1 s, with a trace `j.jsonl`; and `whole.jsonl`, the trace of all of it.
fn standing(name: &str) -> PathBuf {
    let folder = folder(name);
    put(&folder, "count.rpl", "(dotimes (n 4) (print n) (wait-time 0.5))\n");
    assert_eq!(run_in(&folder, &["run", "count.rpl", "--trace", "whole.jsonl"]).status, 0);
    again(&folder);
    folder
}

fn again(folder: &Path) {
    fs::remove_dir_all(folder.join("j")).ok();
    fs::remove_file(folder.join("j.jsonl")).ok();
    let begun = ["run", "count.rpl", "--journal", "j", "--trace", "j.jsonl", "--until", "1s"];
    let Ended { errors, status, .. } = run_in(folder, &begun);
    assert_eq!(status, 3, "{errors}");
}

#[test]
fn what_is_no_trace_of_a_run_is_not_overwritten() {
    let folder = standing("foreign-trace");
    let trace = folder.join("j.jsonl");
    let other = text_in(&folder, "whole.jsonl").replacen("\"seed\":1", "\"seed\":2", 1);
    for (text, without_checkpoints) in [("mine\n", false), ("mine\n", true), (&*other, false), ("{", false)] {
        again(&folder);
        fs::write(&trace, text).expect("it can be written");
        if without_checkpoints {
            fs::remove_file(folder.join("j/checkpoint-000000")).expect("it is there");
        }
        let Ended { errors, status, .. } = run_in(&folder, &["resume", "j"]);
        if text == "{" {
            // The beginning of its first line is what a torn write leaves.
            assert_eq!((status, text_in(&folder, "j.jsonl")), (0, text_in(&folder, "whole.jsonl")), "{errors}");
            continue;
        }
        let advice = "`rpl resume j --trace FILE`";
        assert!(status == 2 && errors.contains("is no trace of this run") && errors.contains(advice), "{errors}");
        assert_eq!(text_in(&folder, "j.jsonl"), text);
    }
    again(&folder);
    fs::write(&trace, "mine\n").expect("it can be written");
    let Ended { errors, status, .. } = run_in(&folder, &["resume", "j", "--trace", "j/output.txt"]);
    assert!(status == 2 && errors.contains("cannot go into the folder of the journal"), "{errors}");
    let Ended { errors, status, .. } = run_in(&folder, &["resume", "j", "--trace", "new.jsonl"]);
    assert!(status == 0 && errors.contains("the trace is computed anew"), "{errors}");
    assert_eq!(
        (text_in(&folder, "j.jsonl"), text_in(&folder, "new.jsonl")),
        ("mine\n".into(), text_in(&folder, "whole.jsonl"))
    );

    // Neither is what would never end read, nor is anything made behind a link that leads nowhere.
    for place in ["/dev/zero", "nowhere", "j"] {
        again(&folder);
        fs::remove_file(&trace).expect("it is there");
        symlink(place, &trace).expect("it can be made");
        let Ended { errors, status, .. } = run_in(&folder, &["resume", "j"]);
        assert!(status == 2 && errors.contains("j.jsonl"), "{place}: {errors}");
        assert!(!folder.join("nowhere").exists());
    }
}

#[test]
fn no_link_in_the_folder_of_a_journal_is_followed() {
    let folder = standing("foreign-link");
    let mine = put(&folder, "mine", "mine\n");
    for name in ["output.txt", "log.txt", "lock", "run", "end", "checkpoint-000000", "goes-on", "changes"] {
        again(&folder);
        let path = folder.join("j").join(name);
        fs::remove_file(&path).ok();
        symlink(&mine, &path).expect("it can be made");
        let Ended { errors, .. } = run_in(&folder, &["resume", "j"]);
        assert!(errors.contains("it is a link, and a journal has none"), "{name}: {errors}");
        assert_eq!(text_in(&folder, "mine"), "mine\n", "{name}");
    }
    // Nor one that stands where a file is about to be written beside.
    again(&folder);
    for name in ["end.new", "goes-on.new", "checkpoint-000001.new"] {
        symlink(&mine, folder.join("j").join(name)).expect("it can be made");
    }
    assert_eq!(run_in(&folder, &["resume", "j"]).status, 0);
    assert_eq!(
        (text_in(&folder, "mine"), text_in(&folder, "j.jsonl")),
        ("mine\n".into(), text_in(&folder, "whole.jsonl"))
    );
    fs::create_dir(folder.join("new")).expect("it can be made");
    symlink(&mine, folder.join("new/output.txt")).expect("it can be made");
    let Ended { errors, status, .. } = run_in(&folder, &["run", "count.rpl", "--journal", "new"]);
    assert!(status == 2 && text_in(&folder, "mine") == "mine\n", "{errors}");
}

#[test]
fn a_journal_of_others_goes_on_when_that_was_said() {
    let folder = standing("foreign-journal");
    let journal = folder.join("j");
    let before = text_in(&folder, "j.jsonl");
    allow(&journal, 0o777);
    let Ended { out, errors, status } = run_in(&folder, &["resume", "j"]);
    assert!(status == 2 && out.is_empty() && errors.contains("everybody may write the folder"), "{errors}");
    assert!(errors.contains("writes the trace `") && errors.contains("`rpl resume j --foreign`"), "{errors}");
    assert_eq!(text_in(&folder, "j.jsonl"), before);
    for (answer, status) in [("n", 2), ("y", 0)] {
        let program = pty_process::blocking::Command::new(env!("CARGO_BIN_EXE_rpl"));
        let program = program.args(["resume", "j"]).current_dir(&folder);
        let mut terminal = Terminal::start(program, 24, 100);
        terminal.shows("is it to go on? (y/n)");
        terminal.keys(answer);
        terminal.keys(ENTER);
        assert_eq!(terminal.end(), status);
    }
    assert_eq!(text_in(&folder, "j.jsonl"), text_in(&folder, "whole.jsonl"));
    again(&folder);
    allow(&journal, 0o777);
    let Ended { errors, status, .. } = run_in(&folder, &["resume", "j", "--foreign"]);
    assert_eq!((status, text_in(&folder, "j.jsonl")), (0, text_in(&folder, "whole.jsonl")), "{errors}");
}

#[test]
fn the_journal_of_a_session_starts_nothing() {
    let folder = project("foreign-session");
    let begun =
        crate::rpl::feed(rpl(&["repl", "--world", "test-room", "--journal", "j"]).current_dir(&folder), "(print 1)\n");
    assert_eq!(begun.status, 0, "{}", begun.errors);
    let written = fs::read(folder.join("j/run")).expect("it is there");
    let parts = frames::read(&written[8..]).whole;
    let head = String::from_utf8(parts[0].to_vec()).expect("JSON");
    let module = folder.join("marking.toml");
    let named = "\"modules\":[{\"name\":\"marking.toml\",\"checksum\":0}]";
    let path = format!("\"modules\":[\"{}\"]", module.to_string_lossy());
    let [before, between, after] = head.split("\"modules\":[]").collect::<Vec<_>>()[..] else { panic!("{head}") };
    let mut forged = written[..8].to_vec();
    let head = format!("{before}{named}{between}{path}{after}");
    frames::push(&mut forged, head.as_bytes());
    frames::push(&mut forged, parts[1]);
    fs::write(folder.join("j/run"), forged).expect("it can be written");
    for arguments in [&["repl", "j"][..], &["repl", "--journal", "j"]] {
        let ended = crate::rpl::feed(rpl(arguments).current_dir(&folder), "");
        assert!(ended.status == 2 && ended.errors.contains("no session's"), "{}", ended.errors);
        assert!(!folder.join("started").exists());
    }
}
