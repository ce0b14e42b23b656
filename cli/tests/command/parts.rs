//! `rpl experiment --shard`, `rpl experiment merge`: runs of many machines as one table; and experiments that are
//! interrupted.
#![cfg(unix)]

use crate::folder::{folder, put, text_in};
use crate::rpl::{Ended, run};
use crate::terminal::Terminal;
use pty_process::blocking::Command as CommandAtTerminal;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// An experiment in which some runs fail.
struct Tossing {
    folder: PathBuf,
    plan: String,
}

impl Tossing {
    fn new(name: &str) -> Self {
        let folder = folder(name);
        let plan = put(&folder, "toss.rpl", "(wait-time (random 10.0)) (when (< (now) 5) (fail \"too soon\"))");
        Self { folder, plan }
    }

    fn path(&self, name: &str) -> String {
        self.folder.join(name).to_string_lossy().into_owned()
    }

    /// The experiment with some options.
    fn runs(&self, options: &[&str]) -> Ended {
        run(&[&["experiment", &self.plan, "--runs", "20", "--seed", "3"], options].concat())
    }

    /// A part of it.
    fn part(&self, shard: &str) -> String {
        let part = self.path(&format!("{}.part", shard.replace('/', "-of-")));
        let found = self.runs(&["--shard", shard, "--out", &part]);
        assert_eq!(found.status, 0, "{}", found.errors);
        part
    }
}

fn merge(parts: &[&str], options: &[&str]) -> Ended {
    run(&[&["experiment", "merge"], parts, options].concat())
}

#[test]
fn the_table_is_the_same_whatever_the_shards() {
    let tossing = Tossing::new("parts-same");
    let (results, whole) = (tossing.path("results"), tossing.path("whole"));
    let alone = tossing.runs(&["--results", &whole]);
    let figures = tossing.runs(&["--json"]);
    for of in [1, 3, 7, 25] {
        let mut parts: Vec<String> = (1..=of).map(|number| tossing.part(&format!("{number}/{of}"))).collect();
        // In which order they come does not matter.
        parts.reverse();
        parts.rotate_left(of / 3);
        let parts: Vec<&str> = parts.iter().map(String::as_str).collect();
        let merged = merge(&parts, &["--results", &results]);
        assert_eq!((&merged.out, &merged.errors, merged.status), (&alone.out, &alone.errors, alone.status), "{of}");
        assert_eq!(merge(&parts, &["--json"]).out, figures.out, "{of}");
        for file in ["runs.csv", "success.svg"] {
            assert_eq!(text_in(Path::new(&results), file), text_in(Path::new(&whole), file), "{of}: {file}");
        }
    }
}

#[test]
fn parts_of_parts_are_parts() {
    let tossing = Tossing::new("parts-of-parts");
    let [first, second, third, fourth] = ["1/4", "2/4", "3/4", "4/4"].map(|shard| tossing.part(shard));
    let (ends, middle, left, all) =
        (tossing.path("ends"), tossing.path("middle"), tossing.path("left"), tossing.path("all"));
    for (parts, out) in [([&fourth, &first], &ends), ([&second, &third], &middle), ([&first, &second], &left)] {
        let found = merge(&parts.map(String::as_str), &["--out", out]);
        assert_eq!((found.out, found.status), (format!("10 runs written to {out}\n"), 0), "{}", found.errors);
    }
    let alone = tossing.runs(&[]);
    // Parts may have runs in common.
    for parts in [[&ends, &middle, &middle], [&left, &ends, &middle], [&ends, &second, &third]] {
        let merged = merge(&parts.map(String::as_str), &[]);
        assert_eq!((&merged.out, merged.status), (&alone.out, alone.status), "{}", merged.errors);
    }
    // Whatever was merged first, the part of all is the same, byte for byte.
    let texts = [[&ends, &middle], [&left, &tossing.path("right")]].map(|parts| {
        merge(&[&third, &fourth], &["--out", &tossing.path("right")]);
        assert_eq!(merge(&parts.map(String::as_str), &["--out", &all]).status, 0);
        text_in(&tossing.folder, "all")
    });
    assert_eq!(texts[0], texts[1]);
}

#[test]
fn a_doubled_shard_counts_once_and_a_missing_one_is_named() {
    let tossing = Tossing::new("parts-doubled");
    let [first, second, third] = ["1/3", "2/3", "3/3"].map(|shard| tossing.part(shard));
    let copy = put(&tossing.folder, "copy.part", fs::read(&second).expect("it is there"));
    let alone = tossing.runs(&[]);
    let merged = merge(&[&first, &second, &copy, &third], &[]);
    assert_eq!(merged.out, alone.out);
    assert!(merged.errors.contains("copy.part` has no run that the other parts do not have"), "{}", merged.errors);
    let lacking = merge(&[&first, &third], &["--json"]);
    assert_eq!(lacking.status, 1);
    assert!(lacking.errors.contains("toss.rpl: seeds 9 to 15 (shard 2/3)"), "{}", lacking.errors);
    assert!(lacking.out.contains("\"runs\":13,"), "{}", lacking.out);
}

/// The part with other lines, and the checksum of these.
fn forged(part: &str, changed: impl Fn(&str) -> String) -> String {
    let text = fs::read_to_string(part).expect("it is there");
    let (lines, end) = text.trim_end().rsplit_once('\n').expect("it has an end");
    let lines = changed(&format!("{lines}\n"));
    let mut end: serde_json::Value = serde_json::from_str(end).expect("an object");
    end["bytes"] = lines.len().into();
    end["crc32"] = crc32fast::hash(lines.as_bytes()).into();
    format!("{lines}{end}\n")
}

#[test]
fn what_is_no_whole_part_is_refused_with_its_reason() {
    let tossing = Tossing::new("parts-refused");
    let [first, second] = ["1/2", "2/2"].map(|shard| tossing.part(shard));
    let text = fs::read_to_string(&second).expect("it is there");
    let half = text[..text.len() / 2].to_string();
    let without_end = format!("{}\n", text.trim_end().rsplit_once('\n').expect("lines").0);
    let version = |text: &str| text.replacen("\"build\":\"", "\"build\":\"0.0.9 of ", 1);
    let form = |text: &str| text.replacen("\"rpl_part\":1", "\"rpl_part\":7", 1);
    let refused = [
        (half, "is cut: its end is not there"),
        (without_end, "is cut: its end is not there, after 10 runs; do its shard again"),
        (text.replacen("\"seed\":13", "\"seed\":14", 1), "is damaged: its checksum"),
        (forged(&second, version), "are no parts of one experiment: they have another build, "),
        (forged(&second, form), "has the form 7, and this rpl reads the form 1"),
        ("row,seed\n".to_string(), "is no part of an experiment: `rpl experiment NAME --shard I/K"),
        (String::new(), "is no part of an experiment"),
        (forged(&second, |text| text.replace("\"measures\"", "\"measured\"")), "has a line that is no run"),
        (forged(&first, |text| text.replacen("\"fault\":null", "\"fault\":\"none\"", 1)), "with different records"),
    ];
    for (text, reason) in refused {
        let wrong = put(&tossing.folder, "wrong.part", text);
        let found = merge(&[&first, &wrong], &[]);
        assert_eq!((found.status, found.out.as_str()), (2, ""), "{reason}");
        assert!(found.errors.contains(reason), "{reason}: {}", found.errors);
    }
    // Both of another build than this one.
    let others =
        [&first, &second].map(|part| put(&tossing.folder, &format!("{}-old", part.len()), forged(part, version)));
    let found = merge(&[&others[0]], &[]);
    assert!(found.errors.contains("were made by rpl 0.0.9 of "), "{}", found.errors);
}

#[test]
fn parts_of_other_experiments_are_refused_with_what_differs() {
    let tossing = Tossing::new("parts-others");
    let first = tossing.part("1/2");
    let other = tossing.path("other.part");
    let shard = ["--shard", "2/2", "--out", &other];
    let world =
        put(&tossing.folder, "room.toml", fs::read_to_string("../robot/worlds/test-room.toml").expect("a world"));
    for (options, reason) in [
        (&["--runs", "21"][..], "another number of runs, 20 and 21"),
        (&["--seed", "4"], "another first seed, 3 and 4"),
        (&["--until", "9s"], "another limit of time, 3600 s and 9 s"),
        (&["--world", &world], "another world, none and `"),
    ] {
        let asked = [&["experiment", &tossing.plan, "--runs", "20", "--seed", "3"], &shard[..]].concat();
        let without: Vec<&str> = match options[0] {
            "--runs" => asked.iter().copied().filter(|word| !["--runs", "20"].contains(word)).collect(),
            "--seed" => asked.iter().copied().filter(|word| !["--seed", "3"].contains(word)).collect(),
            _ => asked,
        };
        let made = run(&[&without[..], options].concat());
        assert_eq!(made.status, 0, "{}", made.errors);
        let found = merge(&[&first, &other], &[]);
        assert_eq!(found.status, 2);
        assert!(found.errors.contains(reason), "{reason}: {}", found.errors);
    }
    // The same name, and another text.
    put(&tossing.folder, "toss.rpl", "(wait-time (random 9.0))");
    tossing.part("2/2");
    let found = merge(&[&first, &tossing.path("2-of-2.part")], &[]);
    assert!(found.errors.contains("the plan `toss.rpl` was not the same"), "{}", found.errors);
}

#[test]
fn experiments_of_all_kinds_are_put_together_from_parts() {
    let folder = folder("parts-kinds");
    for (name, options) in [
        ("topological-global", &["--runs", "5"][..]),
        ("worlds", &["--row", "flat", "--runs", "2"]),
        ("calibration", &["--row", "undisturbed", "--runs", "2", "--until", "20s"]),
        ("count-openings", &["--row", "crowded, counter with class", "--runs", "2", "--until", "20s"]),
        ("office-delivery", &["--row", "wrong lists", "--runs", "2", "--until", "20s"]),
        ("hallway-features", &["--row", "with markers", "--runs", "2", "--until", "20s"]),
        ("sensing", &["--row", "sonars, random", "--runs", "2", "--until", "60s"]),
        ("crowd", &["--row", "20 people", "--runs", "2", "--until", "20s"]),
        ("barn", &["--row", "seen so far", "--runs", "3"]),
        ("routes", &["--row", "guided, learning", "--runs", "2"]),
        ("case-kinds", &["--row", "weighted", "--runs", "3"]),
        ("drive-times", &["--row", "small-office", "--runs", "3"]),
        ("grains", &["--row", "small-office", "--runs", "3"]),
        ("projections", &["--row", "fetch", "--runs", "3"]),
        ("foresight", &["--row", "bursts", "--runs", "2", "--until", "5min"]),
        ("rupart", &["--row", "near", "--runs", "2", "--until", "20s"]),
    ] {
        let asked = [&["experiment", name], options].concat();
        let alone = run(&[&asked[..], &["--json"]].concat());
        let parts = ["1/2", "2/2"].map(|shard| {
            let part = folder.join(format!("{name}-{}", shard.replace('/', "-"))).to_string_lossy().into_owned();
            let made = run(&[&asked[..], &["--shard", shard, "--out", &part]].concat());
            assert_eq!(made.status, 0, "{name}: {}", made.errors);
            part
        });
        let merged = merge(&[&parts[1], &parts[0]], &["--json"]);
        assert_eq!((merged.out, merged.status), (alone.out, alone.status), "{name}: {}", merged.errors);
    }
}

#[test]
fn shards_and_parts_are_asked_for_in_a_way_that_makes_sense() {
    let tossing = Tossing::new("parts-asked");
    let part = tossing.path("a.part");
    for (options, reason) in [
        (&["--shard", "1/2"][..], "--out"),
        (&["--shard", "0/2", "--out", &part], "such as 3/8"),
        (&["--out", &part, "--json"], "cannot be used with"),
        (&["--out", "nowhere/a.part"], "cannot write the part `nowhere/a.part`: there is no such file"),
        (&["--out", &tossing.plan], "which this command reads"),
    ] {
        let found = tossing.runs(options);
        assert_eq!(found.status, 2, "{options:?}");
        assert!(found.errors.contains(reason), "{reason}: {}", found.errors);
    }
    let unread = merge(&["nowhere.part"], &[]);
    assert!(unread.errors.contains("cannot read the part `nowhere.part`"), "{}", unread.errors);
}

#[test]
fn what_is_done_of_an_interrupted_experiment_is_kept() {
    let tossing = Tossing::new("parts-interrupted");
    let asked = ["experiment", &tossing.plan, "--runs", "5000000", "--seed", "3", "--jobs", "2"];
    let interrupted = |options: &[&str]| {
        let program = CommandAtTerminal::new(env!("CARGO_BIN_EXE_rpl")).args(asked).args(options);
        let mut terminal = Terminal::start(program, 60, 120);
        let is_under_way = |terminal: &Terminal| {
            let contents = terminal.contents();
            contents.contains("/5000000") && !contents.contains(" 0/5000000")
        };
        terminal.until("runs are done", is_under_way);
        terminal.keys("\u{3}");
        terminal.shows("of 5000000 runs are done");
        terminal.until("an end", |terminal| {
            let contents = terminal.contents();
            contents.contains("failed with seed") || contents.contains(" written to ")
        });
        let contents = terminal.contents();
        assert_eq!(terminal.end(), 130, "{contents}");
        let done = contents.split("interrupted: ").nth(1).and_then(|rest| rest.split(' ').next()).expect("a number");
        done.parse::<u64>().expect("a number")
    };
    assert!(interrupted(&[]) > 0);
    let part = tossing.path("some.part");
    let done = interrupted(&["--out", &part]);
    let merged = merge(&[&part], &[]);
    assert_eq!(merged.status, 1);
    assert!(merged.out.contains(&format!("{done} run")), "{}", merged.out);
    assert!(merged.errors.contains("missing: ") && merged.errors.contains(" to 5000002"), "{}", merged.errors);
}

/// A shell with `rpl` in its path, in a folder.
fn shell(folder: &Path, words: &[&str], variables: &[(&str, &str)]) -> Ended {
    let beside = Path::new(env!("CARGO_BIN_EXE_rpl")).parent().expect("a folder");
    let path = format!("{}:{}", beside.to_string_lossy(), std::env::var("PATH").unwrap_or_default());
    let mut command = Command::new(words[0]);
    command.args(&words[1..]).current_dir(folder).env("PATH", path).envs(variables.iter().copied());
    command.output().expect("it starts").into()
}

#[test]
fn the_files_for_batch_systems_do_their_shards() {
    let folder = folder("parts-batch");
    fs::create_dir(folder.join("parts")).expect("a folder");
    let files = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/many-machines");
    let slurm = files.join("slurm.sh").to_string_lossy().into_owned();
    for task in ["1", "2", "3"] {
        let words = ["bash", &slurm, "3", "topological-global", "--runs", "7"];
        let done = shell(&folder, &words, &[("SLURM_ARRAY_TASK_ID", task)]);
        assert_eq!(done.status, 0, "{}", done.errors);
    }
    let alone = run(&["experiment", "topological-global", "--runs", "7"]);
    let merged = shell(&folder, &["sh", "-c", "rpl experiment merge parts/*.part"], &[]);
    assert_eq!((merged.out, merged.status), (alone.out, 0), "{}", merged.errors);
    // What the pod of the last index runs, on a smaller experiment.
    let job = fs::read_to_string(files.join("kubernetes.yaml")).expect("it is there");
    let command = job.split(">-\n").nth(1).and_then(|rest| rest.split("resources:").next()).expect("a command");
    let smaller = command.replace("rotated --runs 10000", "topological-global --runs 100");
    let smaller = smaller.replace("/parts/", "parts/").split_whitespace().collect::<Vec<_>>().join(" ");
    let done = shell(&folder, &["sh", "-c", &smaller], &[("JOB_COMPLETION_INDEX", "49")]);
    assert_eq!((done.out.as_str(), done.status), ("6 runs written to parts/49.part\n", 0), "{}", done.errors);
}
