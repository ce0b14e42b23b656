//! Where plans come from: files, files they load, folders, standard input; and their lines.

use crate::folder::{folder, put};
use crate::rpl::{feed, rpl, run, run_in};
use serde_json::Value;
use std::fs;
use std::path::PathBuf;

/// r[eval.load]
#[test]
fn a_file_that_loads_itself_is_an_error_of_the_text() {
    let folder = folder("circle");
    let first = put(&folder, "first.rpl", "(load \"second.rpl\")");
    put(&folder, "second.rpl", "(load \"first.rpl\")");
    let found = run(&["run", &first]);
    assert!(found.errors.contains("loads itself"), "{}", found.errors);
    assert_eq!(found.status, 2);
}

#[test]
fn missing_files_are_told_with_what_was_probably_meant() {
    let folder = folder("missing");
    put(&folder, "kitchen.rpl", "(print 1)");
    let found = run_in(&folder, &["run", "kitchn.rpl"]);
    assert_eq!(found.status, 2);
    assert!(found.errors.contains("did you mean `kitchen.rpl`?"), "{}", found.errors);
    let found = run(&["run", "first-stps.rpl"]);
    assert!(found.errors.contains("did you mean `first-steps.rpl`?"), "{}", found.errors);
    let found = run(&["run", "first-steps", "--world", "dpt"]);
    assert!(found.errors.contains("did you mean `dept`?"), "{}", found.errors);
    let found = run(&["run", &folder.to_string_lossy()]);
    assert!(found.errors.contains("it is a folder"), "{}", found.errors);
    assert_eq!(found.status, 2);
}

/// r[eval.load]
#[test]
fn a_plan_loads_files_beside_it_and_none_outside() {
    let folder = folder("load");
    fs::create_dir_all(folder.join("main/parts")).expect("the folder can be made");
    put(&folder, "secret.rpl", "(print 'secret)");
    put(&folder, "main/parts/two.rpl", "(defvar two 2) (load \"three.rpl\")");
    put(&folder, "main/parts/three.rpl", "(load \"../four.rpl\") (defvar three 3)");
    put(&folder, "main/four.rpl", "(defvar four 4)");
    let good = put(&folder, "main/good.rpl", "(load \"parts/two.rpl\") (print (list two three four))");
    let found = run(&["run", &good]);
    assert_eq!((found.out.as_str(), found.errors.as_str()), ("(2 3 4)\n", "value: (2 3 4)\n"));
    let here = run_in(&folder.join("main"), &["run", "good.rpl"]);
    assert_eq!(here.out, "(2 3 4)\n");
    let absolute = folder.join("secret.rpl").to_string_lossy().into_owned();
    for outside in ["../secret.rpl", "parts/../../secret.rpl", "../nothing-there.rpl", absolute.as_str()] {
        let bad = put(&folder, "main/bad.rpl", format!("(load {outside:?})"));
        let found = run(&["run", &bad]);
        assert_eq!((found.out.as_str(), found.status), ("", 2));
        assert!(found.errors.contains("outside the folder of the main file"), "{}", found.errors);
    }
}

#[test]
fn deep_nesting_is_an_error_of_the_text() {
    let folder = folder("nesting");
    let deep = put(&folder, "deep.rpl", format!("{}{}", "(".repeat(100_000), ")".repeat(100_000)));
    let open = put(&folder, "open.rpl", "(".repeat(100_000));
    for plan in [deep, open] {
        let found = run(&["run", &plan]);
        assert_eq!(found.status, 2, "{}", found.errors);
        assert!(found.errors.starts_with("error["), "{}", found.errors);
    }
}

#[test]
fn a_plan_comes_from_standard_input() {
    let folder = folder("stdin");
    put(&folder, "loaded.rpl", "(defvar loaded 'beside)");
    let found = feed(&mut rpl(&["run", "-"]), "(print (+ 1 2))");
    assert_eq!((found.out.as_str(), found.errors.as_str(), found.status), ("3\n", "value: 3\n", 0));
    let found = feed(&mut rpl(&["run", "-", "--json"]), "(fail \"no\")");
    assert_eq!(found.status, 1);
    assert!(found.out.contains("\"file\":\"<stdin>\""), "{}", found.out);
    let found = feed(&mut rpl(&["run", "-"]), "(print");
    assert!(found.errors.contains("<stdin>:1:1") && found.status == 2, "{}", found.errors);
    assert!(feed(&mut rpl(&["check", "-"]), "(print 1)").out.contains("<stdin>: no findings"));
    assert!(feed(&mut rpl(&["test", "-"]), "(deftest a (assert (= 1 1)))").out.contains("1 test, all ok"));
    assert!(feed(&mut rpl(&["experiment", "-", "--runs", "2"]), "(wait-time 3)").out.contains("succeeded 2 of 2"));
    // Files beside are reached from the working folder.
    let found = feed(rpl(&["run", "-"]).current_dir(&folder), "(load \"loaded.rpl\") (print loaded)");
    assert_eq!(found.out, "beside\n");
    // What is read once cannot be read again, and the prompt reads its lines there.
    let found = feed(&mut rpl(&["check", "-", "-"]), "(print 1)");
    assert!(found.errors.contains("`-` stands for it in two places"), "{}", found.errors);
    assert_eq!(found.status, 2);
    let found = feed(&mut rpl(&["repl", "-"]), "(print 1)");
    assert!(found.errors.contains("`rpl run -` runs a plan from there"), "{}", found.errors);
    assert_eq!(found.status, 2);
}

/// A folder with plans in folders, and with what is none.
fn folder_of_plans(name: &str) -> PathBuf {
    let folder = folder(name);
    fs::remove_dir_all(&folder).expect("the folder of the last time can go");
    for inner in ["b/deep", ".hidden", "target", "empty"] {
        fs::create_dir_all(folder.join(inner)).expect("the folder can be made");
    }
    let text = "(deftest works\n  (assert (= 1 1)))\n";
    for file in ["z.rpl", "b/a.rpl", "b/deep/c.rpl"] {
        put(&folder, file, text);
    }
    for file in [".hidden/x.rpl", "target/x.rpl", "b/.x.rpl", "b/x.txt"] {
        put(&folder, file, "(not a plan");
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&folder, folder.join("b/up")).expect("links can be made");
        std::os::unix::fs::symlink(folder.join("b"), folder.join("empty/around")).expect("links can be made");
        std::os::unix::fs::symlink("nowhere.rpl", folder.join("b/dangling.rpl")).expect("links can be made");
    }
    folder
}

#[test]
fn a_folder_stands_for_the_plans_below_it() {
    let folder = folder_of_plans("folders");
    let in_folder = |arguments: &[&str]| run_in(&folder, arguments);
    let found = in_folder(&["check", "."]);
    assert_eq!(found.out, "b/a.rpl: no findings\nb/deep/c.rpl: no findings\nz.rpl: no findings\n");
    assert_eq!((found.errors.as_str(), found.status), ("", 0));
    // Each file once, however it is named; files that are named themselves are checked in any case.
    let found = in_folder(&["check", "z.rpl", "b", "."]);
    assert_eq!(found.out, "z.rpl: no findings\nb/a.rpl: no findings\nb/deep/c.rpl: no findings\n");
    assert_eq!(in_folder(&["check", "b/.x.rpl"]).status, 2);
    let found = in_folder(&["test", "."]);
    assert!(found.out.starts_with("b/a.rpl\nok "), "{}", found.out);
    assert!(found.out.contains("3 tests, all ok"), "{}", found.out);
    let found = in_folder(&["fmt", "--check", "b"]);
    assert_eq!((found.out.as_str(), found.status), ("", 0));
    put(&folder, "b/ugly.rpl", "( print   1)\n");
    let found = in_folder(&["fmt", "--check", "."]);
    assert_eq!((found.out.as_str(), found.status), ("b/ugly.rpl\n", 1));
    #[cfg(target_os = "linux")]
    {
        use std::os::unix::ffi::OsStrExt;
        let name = std::ffi::OsStr::from_bytes(b"\xff.rpl");
        fs::write(folder.join(name), "(print 1)").expect("the file can be written");
        let found = in_folder(&["check", "."]);
        assert!(found.errors.contains(".rpl` is not UTF-8") && found.out.contains("z.rpl"), "{}", found.errors);
        assert_eq!(found.status, 2);
        fs::remove_file(folder.join(name)).expect("the file can go");
    }
    for command in ["check", "test", "fmt"] {
        let found = in_folder(&[command, "empty", "z.rpl"]);
        assert!(found.errors.contains("there is no plan in the folder `empty`"), "{}", found.errors);
        assert_eq!(found.status, 2, "{command}");
    }
}

/// The line of a finding as it is drawn.
fn drawn_line(told: &str) -> &str {
    let place = told.split("╭─[ ").nth(1).expect("a place is drawn").split(" ]").next().expect("it ends");
    place.rsplit(':').nth(1).expect("it has a line")
}

#[test]
fn a_line_has_one_number_wherever_it_is_told() {
    let folder = folder("lines");
    // Only line feeds and carriage returns end lines; the failing form stands in the seventh.
    let text =
        "; a\u{b}b\u{c}c\u{85}d\u{2028}e\u{2029}f\r; g\r\n(defvar x 1)\u{c}\n\u{b}\r\r\n; h\n(/ x 0) ; the seventh\r";
    let plan = put(&folder, "lines.rpl", text);
    let told = run(&["run", &plan]);
    let json = run(&["run", "--json", &plan]);
    let record: Value = serde_json::from_str(json.out.lines().last().expect("a record")).expect("it is JSON");
    assert_eq!((drawn_line(&told.errors), record["failure"]["line"].as_u64()), ("7", Some(7)), "{}", told.errors);
    let fault = put(&folder, "fault.rpl", text.replace("(/ x 0)", "(/ y 0)"));
    assert_eq!(drawn_line(&run(&["run", &fault]).errors), "7");
    let trace = folder.join("lines.jsonl");
    let trace = trace.to_str().expect("a path");
    fs::remove_file(trace).ok();
    run(&["run", "--trace", trace, &plan]);
    assert!(fs::read_to_string(trace).expect("the trace is there").contains("lines.rpl:7:1"));
    let formatted = run(&["fmt", &plan]);
    assert_eq!(formatted.status, 0, "{}", formatted.errors);
    let formatted = fs::read_to_string(&plan).expect("the plan is there");
    assert!(!formatted.contains('\r') && formatted.contains("; g\n(defvar x 1)\n"), "{formatted:?}");
}
