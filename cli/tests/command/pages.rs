//! The sessions of the page about the prompt and of the tour run as they are printed.

use crate::folder::{folder, put};
use crate::rpl::{rpl, run_in};
use std::io::{Read, Write};
use std::path::Path;
use std::process::Stdio;

/// What is typed in a session of a page, and what is shown.
struct Told {
    /// What stands behind `rpl`.
    arguments: String,
    typed: String,
    shown: Vec<String>,
}

/// The sessions of a page: blocks that follow each other with the same arguments are one.
fn sessions(page: &str) -> Vec<Told> {
    let mut sessions: Vec<Told> = Vec::new();
    let mut is_inside = false;
    for line in page.lines() {
        if let Some(info) = line.strip_prefix("```") {
            is_inside = info.starts_with("session");
            let arguments = info.trim_start_matches("session").trim();
            if is_inside && sessions.last().is_none_or(|last| last.arguments != arguments) {
                let arguments = arguments.to_string();
                sessions.push(Told { arguments, typed: String::new(), shown: Vec::new() });
            }
        } else if let (true, Some(session)) = (is_inside, sessions.last_mut()) {
            match line.strip_prefix("> ") {
                Some(typed) => session.typed += &format!("{typed}\n"),
                None => session.shown.push(line.to_string()),
            }
        }
    }
    sessions
}

/// What a session writes, as a terminal would show it: results and notes in their order.
fn transcript(told: &Told, folder: &Path) -> Vec<String> {
    let (mut reader, writer) = std::io::pipe().expect("there are pipes");
    let arguments: Vec<&str> = told.arguments.split_whitespace().collect();
    let mut child = rpl(&arguments)
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(writer.try_clone().expect("a pipe has copies"))
        .stderr(writer)
        .spawn()
        .expect("it starts");
    child.stdin.take().expect("it reads").write_all(told.typed.as_bytes()).expect("it takes the lines");
    let mut shown = String::new();
    reader.read_to_string(&mut shown).expect("it writes text");
    child.wait().expect("it ends");
    shown.lines().map(str::to_string).collect()
}

/// The line with every number that has a point as `#`: how long a robot takes is not the point of a
/// session.
fn without_decimals(line: &str) -> String {
    let mut words: Vec<String> = Vec::new();
    for word in line.split_inclusive([' ', ',', '`', '(', ')']) {
        let (text, end) = word.split_at(word.trim_end_matches([' ', ',', '`', '(', ')']).len());
        let is_decimal = text.contains('.') && text.parse::<f64>().is_ok();
        words.push(if is_decimal { format!("#{end}") } else { word.to_string() });
    }
    words.concat()
}

/// Whether a transcript is as told; a line `...` stands for any lines.
fn is_as_told(shown: &[String], told: &[String], equal: &dyn Fn(&str, &str) -> bool) -> bool {
    match told.split_first() {
        None => shown.is_empty(),
        Some((line, rest)) if line == "..." => {
            (0..=shown.len()).any(|skipped| is_as_told(&shown[skipped..], rest, equal))
        }
        Some((line, rest)) => match shown.split_first() {
            Some((first, others)) => equal(first, line) && is_as_told(others, rest, equal),
            None => false,
        },
    }
}

/// Runs the sessions of a page in a folder.
fn run_sessions(page: &str, folder: &Path) {
    for told in sessions(page) {
        let shown = transcript(&told, folder);
        let has_robot = told.arguments.contains("--world");
        let equal = |shown: &str, told: &str| match has_robot {
            true => without_decimals(shown) == without_decimals(told),
            false => shown == told,
        };
        let (is, expected) = (shown.join("\n"), told.shown.join("\n"));
        assert!(is_as_told(&shown, &told.shown, &equal), "`rpl {}` shows\n{is}\n\nand not\n{expected}", told.arguments);
    }
}

#[test]
fn the_sessions_of_the_page_about_the_prompt_run_as_printed() {
    run_sessions(include_str!("../../../docs/prompt.md"), Path::new("."));
}

#[test]
fn the_tour_runs_as_printed() {
    let tour = include_str!("../../../docs/tour.md");
    let folder = folder("tour");
    // The plan that the tour lets a reader save, whole, is its last one.
    let plan = tour.split("```lisp robot\n").last().and_then(|rest| rest.split("```").next());
    put(&folder, "rounds.rpl", plan.expect("the tour has a plan"));
    run_sessions(tour, &folder);
    for arguments in tour.lines().filter_map(|line| line.strip_prefix("rpl ")).filter(|line| line.contains("rounds")) {
        let found = run_in(&folder, &arguments.split_whitespace().collect::<Vec<_>>());
        assert_eq!(found.status, 0, "rpl {arguments}: {}", found.errors);
    }
}
