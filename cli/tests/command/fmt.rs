//! `rpl fmt`: files, standard input, differences.

use crate::folder::{folder, put, text_in};
use crate::rpl::{feed, rpl, run};
use std::fs;

#[test]
fn fmt_shows_what_it_would_change() {
    let folder = folder("fmt-diff");
    let ugly = put(&folder, "ugly.rpl", "(print 1)\n(print 2)\n(print 3)\n(print 4)\n( print 5)\n(print 6)");
    let good = put(&folder, "good.rpl", "(print 1)\n");
    let found = run(&["fmt", "--diff", &ugly, &good]);
    let expected = format!(
        "--- {ugly}\n+++ {ugly}\n@@ -2,5 +2,5 @@\n (print 2)\n (print 3)\n (print 4)\n-( print 5)\n-(print 6)\n\\ No newline at end of file\n+(print 5)\n+(print 6)\n"
    );
    assert_eq!((found.out.as_str(), found.errors.as_str(), found.status), (expected.as_str(), "", 1));
    assert!(text_in(&folder, "ugly.rpl").contains("( print 5)"));
    let found = run(&["fmt", "--diff", &good]);
    assert_eq!((found.out.as_str(), found.status), ("", 0));
    let found = feed(&mut rpl(&["fmt", "--diff", "-"]), "( print 1)\n");
    assert!(found.out.ends_with("-( print 1)\n+(print 1)\n"), "{}", found.out);
    assert_eq!(found.status, 1);
    assert_eq!(run(&["fmt", "--diff", "--check", &good]).status, 2);
}

#[test]
fn fmt_formats_files_in_place_and_check_only_lists_them() {
    let folder = folder("fmt");
    let ugly = put(&folder, "ugly.rpl", "(par (wait-time 1)\n(wait-time   2) ; long\n)\n");
    let good = put(&folder, "good.rpl", "(print 1)\n");
    let wrong = put(&folder, "wrong.rpl", "(print  (1)");
    let found = run(&["fmt", "--check", &ugly, &good]);
    assert_eq!((found.out.as_str(), found.status), (format!("{ugly}\n").as_str(), 1));
    let found = run(&["fmt", &wrong, &ugly, &good]);
    assert_eq!(found.status, 2);
    assert!(found.errors.contains("never closed") && found.errors.contains("left as it is"), "{}", found.errors);
    assert_eq!(fs::read_to_string(&wrong).expect("it is there"), "(print  (1)");
    let formatted = "(par (wait-time 1)\n     (wait-time 2)) ; long\n";
    assert_eq!(fs::read_to_string(&ugly).expect("it is there"), formatted);
    let found = run(&["fmt", "--check", &ugly, &good]);
    assert_eq!((found.out.as_str(), found.errors.as_str(), found.status), ("", "", 0));
    let left: Vec<_> = fs::read_dir(&folder).expect("it is a folder").collect();
    assert_eq!(left.len(), 3, "{left:?}");
}

#[test]
fn fmt_formats_standard_input() {
    assert_eq!(feed(&mut rpl(&["fmt", "-"]), "( print\n1 )").out, "(print\n  1)\n");
}
