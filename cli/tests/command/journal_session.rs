//! Journals of sessions at the prompt, and of runs that have taken new definitions, looked at there.

use crate::folder::{folder, put, text_in};
use crate::rpl::{feed, rpl, run_in};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::Stdio;

/// Types lines into a session with a journal, reads as many, and ends it by force.
fn typed_and_killed(folder: &Path, arguments: &[&str], text: &str, lines: usize) -> Vec<String> {
    let mut command = rpl(arguments);
    command.current_dir(folder).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut child = command.spawn().expect("it starts");
    // What stands in a file is read to its end first: it is closed, and the last form goes on for ever.
    child.stdin.take().expect("its input is a pipe").write_all(text.as_bytes()).expect("it reads");
    let out = BufReader::new(child.stdout.take().expect("the output is piped")).lines();
    let read = out.take(lines).collect::<Result<Vec<String>, _>>().expect("it is text");
    child.kill().expect("it can be killed");
    child.wait().expect("it is dead");
    read
}

#[test]
fn a_session_that_was_killed_goes_on_where_it_was() {
    let folder = folder("journal-session");
    put(&folder, "part.rpl", "(defun part (n) (* n 10))\n");
    put(&folder, "more.rpl", "(load \"part.rpl\")\n(defvar top 5)\n");
    let begun = ["repl", "--journal", "j", "--seed", "4"];
    let text = "(defvar n (random 1000000))\n:load more.rpl\n(progn (wait-time 2) (print (list (quote number) n)) nil)\n(load \"part.rpl\")\n";
    let first = feed(rpl(&begun).current_dir(&folder), text);
    assert_eq!(first.status, 0, "{}", first.errors);
    let number = first.out.lines().find(|line| line.starts_with("(number ")).expect("it prints").to_string();
    // What it had loaded is in the journal.
    put(&folder, "part.rpl", "(defun part (n) 'other)\n");
    put(&folder, "more.rpl", "(fail)\n");
    let endless = "(setq top (part top))\n(loop (print (list top (now))) (wait-time 1))\n";
    let read = typed_and_killed(&folder, &["repl", "--journal", "j"], endless, 6);
    assert!(read.iter().any(|line| line == "(50 4.0)"), "{read:?}");

    let told = run_in(&folder, &["journal", "j"]).out;
    assert!(told.contains("typed       at 2.0 s: (setq top (part top))"), "{told}");
    let refused = run_in(&folder, &["resume", "j"]);
    assert!(refused.status == 2 && refused.errors.contains("`rpl repl --journal j` goes on"), "{}", refused.errors);
    let refused = run_in(&folder, &["repl", "other.rpl", "--journal", "j"]);
    assert!(refused.status == 2 && refused.errors.contains("of another session"), "{}", refused.errors);
    // Looked at from a copy, in which the endless form was not typed.
    let copy = folder.join("k");
    std::fs::create_dir(&copy).expect("it can be made");
    std::fs::copy(folder.join("j/run"), copy.join("run")).expect("it can be copied");
    let whole = std::fs::read(folder.join("j/typed")).expect("it is there");
    let endless = whole.windows(6).position(|word| word == b"(loop ").expect("it was typed");
    std::fs::write(copy.join("typed"), &whole[..endless]).expect("it can be written");
    let again =
        feed(rpl(&["repl", "--journal", "k"]).current_dir(&folder), "(list (list (quote number) n) top (now))\n");
    assert_eq!(again.status, 0, "{}", again.errors);
    assert_eq!(again.out.lines().last(), Some(&*format!("({number} 50 2.0)")), "{}", again.out);
    // What was shown before stays where it was shown.
    assert_eq!(again.out.matches(&number).count(), 1, "{}", again.out);
}

#[test]
fn a_session_with_a_robot_goes_on_where_that_stands() {
    let folder = folder("journal-session-robot");
    let site = ["--world", "test-room", "--grid", "coarse", "--seed", "5"];
    let text = "(go-to 'corner)\n(list (value x*) (now))\n";
    let whole = feed(rpl(&[&["repl"][..], &site].concat()).current_dir(&folder), text);
    let typed: Vec<&str> = text.lines().collect();
    let begun = [&["repl", "--journal", "j"][..], &site].concat();
    assert_eq!(feed(rpl(&begun).current_dir(&folder), format!("{}\n", typed[0])).status, 0);
    let again = feed(rpl(&begun).current_dir(&folder), format!("{}\n", typed[1]));
    assert_eq!(again.out.lines().last(), whole.out.lines().last(), "{}", again.errors);
    let host = feed(&mut rpl(&["repl", "--journal", "h", "--world", "test-room", "--host", "127.0.0.1:1"]), "");
    assert!(host.status == 2 && host.errors.contains("`--record FILE` writes it down"), "{}", host.errors);
}

#[test]
fn a_run_with_new_definitions_is_repeated_with_them() {
    let folder = folder("journal-changed-prompt");
    let plan = "(defun shown (n) (list 'old n))\n(dotimes (n 6) (print (shown n)) (wait-time 1))\n";
    put(&folder, "plan.rpl", plan);
    assert_eq!(run_in(&folder, &["run", "plan.rpl", "--journal", "j", "--until", "2500ms"]).status, 3);
    put(&folder, "plan.rpl", plan.replace("'old", "'new"));
    let found = run_in(&folder, &["resume", "j", "--changed"]);
    assert_eq!(found.status, 0, "{}", found.errors);
    let printed = text_in(&folder, "j/output.txt");
    assert!(printed.contains("(old 2)\n(new 3)\n"), "{printed}");
    let found = feed(rpl(&["repl", "j"]).current_dir(&folder), ":back 5s\n(shown 1)\n:continue\n(shown 1)\n");
    assert_eq!(found.status, 0, "{}", found.errors);
    assert!(found.out.starts_with(&printed), "{}", found.out);
    let after: Vec<&str> = found.out[printed.len()..].lines().collect();
    assert!(after.contains(&"(old 1)") && after.contains(&"(new 3)") && after.last() == Some(&"(new 1)"), "{after:?}");
}
