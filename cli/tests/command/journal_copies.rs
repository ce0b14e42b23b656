//! Copies of a journal, and the trace outside of it.

use crate::folder::{put, text_in};
use crate::journal::{COUNT, parts, plans};
use crate::pipes::wait_for_line;
use crate::rpl::{Ended, rpl, run, run_in, start};
use std::fs;
use std::path::Path;

/// Copies a journal.
fn copy_of(folder: &Path, name: &str) {
    fs::create_dir(folder.join(name)).expect("it can be made");
    for entry in fs::read_dir(folder.join("j")).expect("a folder").flatten() {
        fs::copy(entry.path(), folder.join(name).join(entry.file_name())).expect("it can be copied");
    }
}

#[test]
fn copies_of_a_journal_go_on_each_by_itself() {
    let folder = plans("journal-copies");
    put(
        &folder,
        "count.rpl",
        format!("(defun shown (n) (list n (random 100)))\n{}", COUNT.replace("(list n (random 100))", "(shown n)")),
    );
    let found = run_in(&folder, &["run", "count.rpl", "--seed", "7", "--json", "--trace", "whole.jsonl"]);
    let (printed, _) = parts(&found.out);
    let begun = ["run", "count.rpl", "--seed", "7", "--journal", "j", "--trace", "j.jsonl", "--until", "5s"];
    assert_eq!(run_in(&folder, &begun).status, 3);
    let names: Vec<String> = (0..10).map(|number| format!("j{number}")).collect();
    names.iter().for_each(|name| copy_of(&folder, name));
    // All at once, each up to another time, with a trace of its own.
    let children: Vec<_> = names
        .iter()
        .enumerate()
        .map(|(number, name)| {
            let (trace, until) = (format!("{name}.jsonl"), format!("{}s", 6 + number));
            let mut command = rpl(&["resume", name, "--trace", &trace, "--until", &until]);
            let silent = std::process::Stdio::null;
            command.current_dir(&folder).stdout(silent()).stderr(silent()).spawn().expect("it starts")
        })
        .collect();
    children.into_iter().for_each(|mut child| assert_eq!(child.wait().expect("it ends").code(), Some(3)));
    // Every third one takes a new definition from there on.
    let old = text_in(&folder, "count.rpl");
    for (number, name) in names.iter().enumerate() {
        let is_changed = number % 3 == 0;
        put(&folder, "count.rpl", if is_changed { old.replace("(list n ", "(list 'new n ") } else { old.clone() });
        let arguments = [&["resume", name][..], if is_changed { &["--changed"] } else { &[] }].concat();
        let found = run_in(&folder, &arguments);
        assert_eq!(found.status, 0, "{name}: {}", found.errors);
        let now = text_in(&folder, &format!("{name}/output.txt"));
        assert_eq!(now.replace("new ", ""), printed, "{name}");
        assert_eq!(now.contains("new "), is_changed, "{name}");
        // A plan's line is printed at the instant it stands for, so a copy has as many old ones as it had time for.
        let old_lines = now.lines().take_while(|line| !line.contains("new ")).count();
        assert!(!is_changed || old_lines == (6 + number) * 20 + 1, "{name}: {old_lines}");
        let trace = text_in(&folder, &format!("{name}.jsonl"));
        assert!(is_changed || trace == text_in(&folder, "whole.jsonl"), "{name}");
    }
    // The first is as it was.
    put(&folder, "count.rpl", old);
    assert_eq!(run_in(&folder, &["resume", "j"]).status, 0);
    assert_eq!(text_in(&folder, "j/output.txt"), printed);
    assert_eq!(text_in(&folder, "j.jsonl"), text_in(&folder, "whole.jsonl"));
}

#[test]
fn a_world_a_robot_and_a_scenario_must_be_what_they_were() {
    let folder = plans("journal-place");
    let built_in = |name: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robot").join(name);
        fs::read_to_string(path).expect("it is in the repository")
    };
    let texts = [
        ("w.toml", built_in("worlds/test-room.toml"), "# another"),
        ("r.toml", built_in("robots/b21.toml"), "# another"),
        ("s.rpl", "(wait-time 1)\n".to_string(), "; another"),
    ];
    texts.iter().for_each(|(name, text, _)| _ = put(&folder, name, text));
    put(&folder, "plan.rpl", "(wait-time 2)\n'done\n");
    let place = ["--world", "w.toml", "--robot", "r.toml", "--scenario", "s.rpl", "--grid", "coarse"];
    let begun = [&["run", "plan.rpl", "--journal", "j", "--until", "1s"][..], &place].concat();
    let found = run_in(&folder, &begun);
    assert_eq!(found.status, 3, "{}", found.errors);
    for (name, text, more) in &texts {
        put(&folder, name, format!("{text}{more}\n"));
        let found = run_in(&folder, &["resume", "j"]);
        let expected = format!("{name}` changed since the run began");
        assert!(found.status == 2 && found.errors.contains(&expected), "{name}: {}", found.errors);
        let found = run_in(&folder, &["resume", "j", "--changed"]);
        let expected = "only the texts of its plan may; put it back";
        assert!(found.status == 2 && found.errors.contains(expected), "{name}: {}", found.errors);
        put(&folder, name, text);
    }
    assert_eq!(run_in(&folder, &["resume", "j"]).status, 0);
}

#[test]
fn a_trace_has_one_writer_and_may_be_gone() {
    let folder = plans("journal-trace");
    let waiting = put(&folder, "waiting.rpl", "(print 'begun) (wait-time 1000) (print 'done)");
    let in_folder = |name: &str| folder.join(name).to_string_lossy().into_owned();
    let (journal, trace) = (in_folder("j"), in_folder("j.jsonl"));
    let mut child = start(&["run", &waiting, "--journal", &journal, "--trace", &trace, "--realtime"]);
    wait_for_line(&mut child);
    let before = text_in(&folder, "j.jsonl");
    let found = run(&["run", &waiting, "--journal", &in_folder("other"), "--trace", &trace]);
    assert!(found.status == 2 && found.errors.contains("another process writes it"), "{}", found.errors);
    copy_of(&folder, "k");
    let found = run(&["resume", &in_folder("k")]);
    assert!(found.status == 2 && found.errors.contains("another process writes it"), "{}", found.errors);
    assert_eq!(text_in(&folder, "j.jsonl"), before);
    child.kill().expect("it can be killed");
    child.wait().expect("it is dead");
    fs::remove_file(folder.join("j.jsonl")).expect("it was there");
    let found = run(&["resume", &journal, "--realtime", "100000"]);
    assert_eq!((found.out.as_str(), found.status), ("done\n", 0), "{}", found.errors);
    let whole = run(&["run", &waiting, "--trace", &in_folder("whole.jsonl")]);
    assert_eq!(whole.status, 0, "{}", whole.errors);
    assert_eq!(text_in(&folder, "j.jsonl"), text_in(&folder, "whole.jsonl"));
    let found = run(&["resume", &in_folder("k"), "--trace", &in_folder("k.jsonl"), "--realtime", "100000"]);
    assert_eq!(found.status, 0, "{}", found.errors);
    assert_eq!(text_in(&folder, "k.jsonl"), text_in(&folder, "whole.jsonl"));
}

#[test]
fn a_run_whose_journal_is_taken_away_goes_on_and_says_so() {
    let folder = plans("journal-away");
    let count = folder.join("count.rpl").to_string_lossy().into_owned();
    let (printed, _) = parts(&run(&["run", &count, "--seed", "7", "--json"]).out);
    let journal = folder.join("j");
    let begun = ["run", &count, "--seed", "7", "--journal", &journal.to_string_lossy(), "--realtime", "40"];
    for is_moved in [false, true] {
        let mut child = start(&begun);
        wait_for_line(&mut child);
        if is_moved {
            fs::rename(&journal, folder.join("k")).expect("it can be moved");
        } else {
            fs::remove_dir_all(&journal).expect("it was there");
        }
        let found = Ended::of(child);
        let (_, rest) = printed.split_once('\n').expect("it prints lines");
        assert_eq!((found.out.as_str(), found.status), (rest, 0), "{}", found.errors);
        assert!(found.errors.contains("could not be written from"), "{}", found.errors);
        assert!(!journal.exists());
    }
    // Where it was moved to it has what it had, and goes on.
    assert_eq!(run(&["resume", &folder.join("k").to_string_lossy()]).status, 0);
    assert_eq!(text_in(&folder, "k/output.txt"), printed);
}
