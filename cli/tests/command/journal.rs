//! Journals: runs that stand still, are killed, damaged and stopped, and go on as if nothing had been.

use crate::folder::{folder, put, text_in};
use crate::pipes::wait_for_line;
use crate::rpl::{Ended, feed, rpl, run, run_in, start};
use rpl_link::journal::frames;
use serde_json::Value;
use std::fs;
use std::io::Read;
use std::path::Path;

/// Drives, prints, logs, fails on the way, and takes numbers from the seed.
const DRIVE: &str = "(load \"part.rpl\")\n\
    (print (list 'begun (random 1000)))\n\
    (unwind-protect (go-to 'corner) (print 'cleaned))\n\
    (ignore-failures (failure) (go-to 'nowhere))\n\
    (go-to 'table-side)\n\
    (print (list (at-destination? 'table-side) (random 1000) (part 3)))\n";

const PART: &str = "(defun part (n) (log \"part\") (* n n))\n";

/// Prints a line every 50 ms of its time, and computes in between.
pub const COUNT: &str =
    "(defvar n 0)\n(while (< n 400) (setq n (+ n 1)) (print (list n (random 100))) (wait-time 0.05))\n'counted\n";

const SITE: [&str; 6] = ["--world", "test-room", "--grid", "coarse", "--seed", "7"];

/// A run without a journal: what the others are to be like.
fn undisturbed(folder: &Path, plan: &str) -> Ended {
    let more: &[&str] = if plan == "drive.rpl" { &SITE } else { &["--seed", "7"] };
    let found = run_in(folder, &[&["run", plan, "--json", "--trace", "whole.jsonl"], more].concat());
    assert_eq!(found.status, 0, "{}", found.errors);
    found
}

/// A folder with the plans.
pub fn plans(name: &str) -> std::path::PathBuf {
    let folder = folder(name);
    put(&folder, "drive.rpl", DRIVE);
    put(&folder, "part.rpl", PART);
    put(&folder, "count.rpl", COUNT);
    folder
}

/// A run of `drive.rpl` that stands still after 2 s and, with another checkpoint, after 4 s.
fn standing(folder: &Path) {
    fs::remove_dir_all(folder.join("j")).ok();
    let begun = ["run", "drive.rpl", "--journal", "j", "--trace", "j.jsonl", "--until", "2s"];
    let found = run_in(folder, &[&begun[..], &SITE].concat());
    assert_eq!(found.status, 3, "{}", found.errors);
    let found = run_in(folder, &["resume", "j", "--until", "4s"]);
    assert_eq!((found.out.as_str(), found.status), ("", 3), "{}", found.errors);
}

/// What it prints, without the summary, and the summary without what the clock has a part in.
pub fn parts(out: &str) -> (String, Value) {
    let (printed, summary) = match out.trim_end().rsplit_once('\n') {
        Some((printed, summary)) => (format!("{printed}\n"), summary),
        None => (String::new(), out.trim_end()),
    };
    let mut summary: Value = serde_json::from_str(summary).expect("one JSON object");
    summary.as_object_mut().expect("an object").remove("wall_s");
    (printed, summary)
}

#[test]
fn a_run_that_stood_still_goes_on_as_if_it_had_not() {
    let folder = plans("journal-still");
    let (printed, summary) = parts(&undisturbed(&folder, "drive.rpl").out);
    standing(&folder);
    let found = run_in(&folder, &["resume", "j", "--json"]);
    assert_eq!(found.status, 0, "{}", found.errors);
    assert!(found.errors.contains("goes on from the checkpoint at 4.0 s"), "{}", found.errors);
    assert_eq!(parts(&found.out).1, summary);
    assert_eq!(text_in(&folder, "j/output.txt"), printed);
    assert_eq!(text_in(&folder, "j.jsonl"), text_in(&folder, "whole.jsonl"));

    let over = run_in(&folder, &["resume", "j", "--json"]);
    assert_eq!((over.status, parts(&over.out)), (0, (String::new(), summary)), "{}", over.errors);
    assert!(over.errors.contains("the run is over: it succeeded"), "{}", over.errors);
}

/// Kills a command after `lines` lines of its output; all that it has written.
fn killed_after(lines: usize, arguments: &[&str], folder: &Path) -> String {
    let mut child = rpl(arguments)
        .current_dir(folder)
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::null())
        .spawn()
        .expect("it starts");
    let mut out = Vec::new();
    let mut pipe = child.stdout.take().expect("the output is piped");
    let mut byte = [0];
    while out.iter().filter(|&&byte| byte == b'\n').count() < lines && pipe.read(&mut byte).expect("it is read") == 1 {
        out.push(byte[0]);
    }
    child.kill().expect("it can be killed");
    pipe.read_to_end(&mut out).expect("the rest is read");
    child.wait().expect("it is dead");
    String::from_utf8(out).expect("it writes text")
}

#[test]
fn a_run_that_is_killed_again_and_again_prints_and_traces_everything_once() {
    let folder = plans("journal-killed");
    let (printed, _) = parts(&undisturbed(&folder, "count.rpl").out);
    for step in [7, 37, 150] {
        fs::remove_dir_all(folder.join("j")).ok();
        let begun = ["run", "count.rpl", "--seed", "7", "--journal", "j", "--trace", "j.jsonl"];
        let mut out = killed_after(step, &begun, &folder);
        let mut lives = 1;
        while !folder.join("j/end").exists() {
            let next = killed_after(step, &["resume", "j"], &folder);
            // The one instant that was written and not yet noted may come again, and nothing is left out.
            let repeated = (0..=next.len()).find(|&at| printed.starts_with(&format!("{out}{}", &next[at..])));
            let repeated = repeated.unwrap_or_else(|| panic!("{out}\nand then\n{next}"));
            assert!(next[..repeated].lines().count() <= 1, "{}", &next[..repeated]);
            out.push_str(&next[repeated..]);
            lives += 1;
        }
        assert_eq!(out, printed);
        assert_eq!(text_in(&folder, "j/output.txt"), printed);
        assert_eq!(text_in(&folder, "j.jsonl"), text_in(&folder, "whole.jsonl"), "{lives} lives");
    }
}

#[test]
fn a_run_that_is_killed_behind_its_stop_goes_on_behind_it() {
    let folder = plans("journal-behind");
    let (printed, _) = parts(&undisturbed(&folder, "count.rpl").out);
    let found = run_in(&folder, &["run", "count.rpl", "--seed", "7", "--journal", "j", "--until", "1s"]);
    assert_eq!(found.status, 3, "{}", found.errors);
    killed_after(5, &["resume", "j", "--until", "1h"], &folder);
    let found = run_in(&folder, &["resume", "j"]);
    assert_eq!(found.status, 0, "{}", found.errors);
    assert_eq!(text_in(&folder, "j/output.txt"), printed);
}

/// The checkpoints of a journal, the oldest first.
fn checkpoints(journal: &Path) -> Vec<std::path::PathBuf> {
    let entries = fs::read_dir(journal).expect("a folder").flatten().map(|entry| entry.path());
    let mut found: Vec<_> = entries.filter(|path| path.to_string_lossy().contains("checkpoint-")).collect();
    found.sort();
    found
}

#[test]
fn what_is_damaged_is_told_and_computed_again() {
    let folder = plans("journal-damaged");
    let (printed, _) = parts(&undisturbed(&folder, "drive.rpl").out);
    let flip = |path: &Path, at: usize| {
        let mut bytes = fs::read(path).expect("it is there");
        let at = at % bytes.len();
        bytes[at] ^= 4;
        fs::write(path, bytes).expect("it can be written");
    };
    let cut = |path: &Path, by: usize| {
        let bytes = fs::read(path).expect("it is there");
        fs::write(path, &bytes[..bytes.len().saturating_sub(by)]).expect("it can be written");
    };
    type Damage<'d> = &'d dyn Fn(&Path);
    let cases: [(&str, Damage<'_>, &str); 8] = [
        ("a bit of the newest", &|j| flip(&checkpoints(j)[1], 70_000), "from the checkpoint at 2.0 s"),
        ("its end", &|j| cut(&checkpoints(j)[1], 1), "from the checkpoint at 2.0 s"),
        ("all of it", &|j| cut(&checkpoints(j)[1], usize::MAX), "from the checkpoint at 2.0 s"),
        ("both", &|j| checkpoints(j).iter().for_each(|path| flip(path, 300)), "from its start"),
        ("there are none", &|j| checkpoints(j).iter().for_each(|path| fs::remove_file(path).expect("gone")), "start"),
        ("the end of the trace", &|j| cut(&j.with_file_name("j.jsonl"), 3), "the run goes on from"),
        ("a bit of the trace", &|j| flip(&j.with_file_name("j.jsonl"), 200), "from its start"),
        ("the log", &|j| fs::remove_file(j.join("log.txt")).expect("it was there"), "from its start"),
    ];
    for (what, damage, expected) in cases {
        standing(&folder);
        damage(&folder.join("j"));
        let found = run_in(&folder, &["resume", "j"]);
        assert_eq!(found.status, 0, "{what}: {}", found.errors);
        assert!(found.errors.contains(expected), "{what}: {}", found.errors);
        assert_eq!(text_in(&folder, "j/output.txt"), printed, "{what}");
        assert_eq!(text_in(&folder, "j.jsonl"), text_in(&folder, "whole.jsonl"), "{what}");
    }
    standing(&folder);
    for (at, expected) in [(0, "is no journal"), (8, "is damaged"), (100, "is damaged"), (5_000, "is damaged")] {
        let head = folder.join("j/run");
        let whole = fs::read(&head).expect("it is there");
        flip(&head, at);
        let found = run_in(&folder, &["resume", "j"]);
        assert!(found.status == 2 && found.errors.contains(expected), "{at}: {}", found.errors);
        fs::write(&head, whole).expect("it can be written");
    }
}

#[test]
fn what_a_run_belongs_to_must_be_what_it_was() {
    let folder = plans("journal-changed");
    standing(&folder);
    for (file, text, now) in [("drive.rpl", DRIVE, "(print 'other)"), ("part.rpl", PART, "(defun part (n) n)")] {
        put(&folder, file, now);
        let found = run_in(&folder, &["resume", "j"]);
        assert_eq!(found.status, 2, "{}", found.errors);
        assert!(
            found.errors.contains(file) && found.errors.contains("changed since the run began"),
            "{}",
            found.errors
        );
        let kept = run_in(&folder, &["journal", "j", "--text", file]);
        assert_eq!((kept.status, kept.out.as_str()), (0, text), "{}", kept.errors);
        put(&folder, file, text);
    }
    let written = fs::read(folder.join("j/run")).expect("it is there");
    let frames = frames::read(&written[8..]).whole;
    let head = String::from_utf8(frames[0].to_vec()).expect("JSON");
    let mut other = written[..8].to_vec();
    frames::push(&mut other, head.replacen("\"build\":\"", "\"build\":\"7.7.7-", 1).as_bytes());
    frames::push(&mut other, frames[1]);
    fs::write(folder.join("j/run"), other).expect("it can be written");
    let found = run_in(&folder, &["resume", "j"]);
    assert!(found.status == 2 && found.errors.contains("was written by rpl 7.7.7-"), "{}", found.errors);
    // Without the files it goes on with what it has.
    standing(&folder);
    let (printed, _) = parts(&undisturbed(&folder, "drive.rpl").out);
    let away = folder.join("away");
    fs::create_dir(&away).expect("it can be made");
    for file in ["drive.rpl", "part.rpl"] {
        fs::rename(folder.join(file), away.join(file)).expect("it can be moved");
    }
    assert_eq!(run_in(&folder, &["resume", "j"]).status, 0);
    assert_eq!(text_in(&folder, "j/output.txt"), printed);
}

#[test]
fn new_definitions_are_taken_by_later_calls() {
    let folder = folder("journal-definitions");
    let plan = "(defun shown (n) (list 'old n))\n(defvar top 9)\n(dotimes (n 6) (print (shown n)) (wait-time 1))\n";
    put(&folder, "plan.rpl", plan);
    let found = run_in(&folder, &["run", "plan.rpl", "--journal", "j", "--until", "2500ms"]);
    assert_eq!((found.out.as_str(), found.status), ("(old 0)\n(old 1)\n(old 2)\n", 3), "{}", found.errors);
    put(&folder, "plan.rpl", plan.replace("'old", "(wrong)"));
    let found = run_in(&folder, &["resume", "j", "--changed"]);
    assert!(found.status == 2 && found.errors.contains("cannot be taken"), "{}", found.errors);
    put(&folder, "plan.rpl", plan.replace("'old", "'new").replace("top 9", "top 8"));
    let found = run_in(&folder, &["resume", "j", "--until", "4500ms"]);
    assert!(found.status == 2 && found.errors.contains("with `--changed`"), "{}", found.errors);
    let found = run_in(&folder, &["resume", "j", "--changed", "--until", "4500ms"]);
    assert_eq!((found.out.as_str(), found.status), ("(new 3)\n(new 4)\n", 3), "{}", found.errors);
    assert!(found.errors.contains("(defvar top 8): only definitions"), "{}", found.errors);
    // From the start it takes them again where it took them first.
    checkpoints(&folder.join("j")).iter().for_each(|path| fs::remove_file(path).expect("it was there"));
    let found = run_in(&folder, &["resume", "j"]);
    assert_eq!((found.out.as_str(), found.status), ("(new 5)\n", 0), "{}", found.errors);
    assert_eq!(text_in(&folder, "j/output.txt"), "(old 0)\n(old 1)\n(old 2)\n(new 3)\n(new 4)\n(new 5)\n");
}

#[test]
fn the_prompt_stands_anywhere_in_a_journal() {
    let folder = plans("journal-prompt");
    standing(&folder);
    let before = fs::read(folder.join("j/run")).expect("it is there");
    for (arguments, time) in
        [(&["step", "j"][..], "0"), (&["step", "j", "--at", "1500ms"], "1.5"), (&["repl", "j"], "4")]
    {
        let found = feed(rpl(arguments).current_dir(&folder), "(now)\n");
        let told: f64 = found
            .out
            .lines()
            .last()
            .and_then(|line| line.trim_start_matches("=> ").parse().ok())
            .unwrap_or_else(|| panic!("{arguments:?}: {}{}", found.out, found.errors));
        assert!((told - time.parse::<f64>().expect("a number")).abs() < 0.06, "{arguments:?}: {told}");
    }
    assert_eq!(fs::read(folder.join("j/run")).expect("it is there"), before);
    assert_eq!(run_in(&folder, &["resume", "j"]).status, 0);
}

#[test]
fn a_journal_has_one_writer_and_one_run() {
    let folder = plans("journal-writer");
    let waiting = put(&folder, "waiting.rpl", "(print 'begun) (wait-time 1000) (print 'done)");
    let journal = folder.join("j").to_string_lossy().into_owned();
    let mut child = start(&["run", &waiting, "--journal", &journal, "--realtime"]);
    wait_for_line(&mut child);
    let found = run(&["resume", &journal]);
    let taken = format!("process {} has it", child.id());
    assert!(found.status == 2 && found.errors.contains(&taken), "{}", found.errors);
    let told = run(&["journal", &journal]).out;
    assert!(told.contains(&format!("process {} writes it", child.id())), "{told}");
    child.kill().expect("it can be killed");
    child.wait().expect("it is dead");
    let told = run(&["journal", &journal]).out;
    assert!(told.contains("it was killed") && told.contains("waiting.rpl"), "{told}");
    let found = run(&["run", &waiting, "--journal", &journal]);
    assert!(found.status == 2 && found.errors.contains("has a journal already"), "{}", found.errors);
    let found = run(&["resume", &journal, "--realtime", "100000"]);
    assert_eq!((found.out.as_str(), found.status), ("done\n", 0), "{}", found.errors);
}

#[test]
fn what_is_no_journal_is_told() {
    let folder = plans("journal-none");
    put(&folder, "file", "no folder");
    fs::create_dir(folder.join("full")).expect("it can be made");
    put(&folder.join("full"), "notes.txt", "mine");
    for (arguments, expected) in [
        (&["resume", "nowhere"][..], "`nowhere` is no journal"),
        (&["journal", "full"], "`full` is no journal: it has no file `run`"),
        (&["run", "count.rpl", "--journal", "file"], "cannot write the journal `file`"),
        (&["run", "count.rpl", "--journal", "full"], "has files that are none of a journal"),
        (&["run", "count.rpl", "--journal", "new/j", "--trace", "nowhere/t"], "there is no folder `nowhere`"),
        (&["run", "count.rpl", "--journal", "j", "--trace", "/dev/null"], "is a file, and `/dev/null` is none"),
        (&["run", "count.rpl", "--journal", "j", "--figures", "f"], "the same run without `--journal`"),
        (&["run", "count.rpl", "--sync", "never"], "--journal"),
    ] {
        let found = run_in(&folder, arguments);
        assert!(found.status == 2 && found.errors.contains(expected), "{arguments:?}: {}", found.errors);
        assert!(!folder.join("j/run").exists() && !folder.join("full/lock").exists(), "{arguments:?}");
    }
}

/// Runs it with files of at most `blocks` blocks of 512 bytes: every further write fails, as on a full disk.
#[cfg(unix)]
fn with_little_disk(blocks: u32, folder: &Path, arguments: &[&str]) -> Ended {
    let shell = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$@\"");
    let mut command = std::process::Command::new("sh");
    command.args(["-c", &shell, "sh", env!("CARGO_BIN_EXE_rpl")]).args(arguments).current_dir(folder);
    command.output().expect("it starts").into()
}

#[cfg(unix)]
#[test]
fn a_run_outlives_a_full_disk_or_stops_if_it_must_not() {
    let folder = plans("journal-full");
    let (printed, _) = parts(&undisturbed(&folder, "count.rpl").out);
    let begun = ["run", "count.rpl", "--seed", "7", "--journal", "j", "--trace", "j.jsonl"];
    for blocks in [4, 5, 6, 7, 8, 20] {
        // What fails on the way is told there, and whatever has failed at the end.
        fs::remove_dir_all(folder.join("j")).ok();
        let found = with_little_disk(blocks, &folder, &begun);
        assert_eq!((found.status, &found.out), (0, &printed), "{blocks}: {}", found.errors);
        assert!(found.errors.contains("could not be written from"), "{blocks}: {}", found.errors);
        let found = run_in(&folder, &["resume", "j"]);
        assert_eq!(found.status, 0, "{blocks}: {}", found.errors);
        assert_eq!(text_in(&folder, "j/output.txt"), printed, "{blocks}");
        assert_eq!(text_in(&folder, "j.jsonl"), text_in(&folder, "whole.jsonl"), "{blocks}");
    }
    fs::remove_dir_all(folder.join("j")).ok();
    let found = with_little_disk(1, &folder, &begun);
    assert!(found.status == 2 && found.errors.contains("cannot write the journal `j`"), "{}", found.errors);

    fs::remove_dir_all(folder.join("j")).ok();
    let must = [&begun[..], &["--journal-must"]].concat();
    let found = with_little_disk(5, &folder, &must);
    assert_eq!(found.status, 2, "{}", found.errors);
    assert!(found.errors.contains("the run is stopped") && found.errors.contains("clean-ups done"), "{}", found.errors);
    assert!(printed.starts_with(&found.out) && found.out.len() < printed.len(), "{}", found.out);
    assert_eq!(run_in(&folder, &["resume", "j"]).status, 0);
    assert_eq!(text_in(&folder, "j/output.txt"), printed);
}

#[cfg(unix)]
#[test]
fn one_signal_ends_a_run_for_good_and_its_journal_says_so() {
    let folder = plans("journal-signal");
    let plan = put(&folder, "plan.rpl", "(unwind-protect (seq (print 'going) (wait-time 1000)) (print 'clean))");
    let journal = folder.join("j").to_string_lossy().into_owned();
    let mut child = start(&["run", &plan, "--journal", &journal, "--realtime"]);
    wait_for_line(&mut child);
    let id = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &id]).status().expect("kill runs").success());
    let found = Ended::of(child);
    assert_eq!((found.out.as_str(), found.status), ("clean\n", 130), "{}", found.errors);
    let again = run(&["resume", &journal]);
    assert_eq!((again.out.as_str(), again.status), ("", 130), "{}", again.errors);
    assert!(again.errors.contains("it was interrupted"), "{}", again.errors);
}
