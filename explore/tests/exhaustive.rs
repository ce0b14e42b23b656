//! Generated programs: the search, which looks at no state twice, comes to the same ends as all orders one by one.

mod plans;

use plans::{BOUNDS, searched, started};
use rpl_random::Stream;
use rpl_runtime::robot::NoRobot;
use rpl_runtime::run::system::{Outcome, System};
use rpl_runtime::state::schedule::Schedule;
use std::collections::BTreeSet;

/// Programs, and orders of each, at most: those that have more are passed over.
const PROGRAMS: usize = 300;
const MAX_ORDERS: usize = 500;

/// Turns of all orders of a program: one that never ends has no orders to compare.
const MAX_TURNS: usize = 5_000;

/// The end of a run: its value, or the beginning of its failure's text.
type End = Result<String, String>;

/// The ends of all orders, without looking whether a state was seen; none if there are too many orders.
fn all_ends(start: &System<NoRobot>) -> Option<BTreeSet<End>> {
    let mut start = start.fork();
    start.machine.schedule = Some(Box::new(Schedule::default()));
    let (mut waiting, mut ends, mut orders) = (vec![start], BTreeSet::new(), 0);
    let mut turns = 0;
    while let Some(mut run) = waiting.pop() {
        loop {
            turns += 1;
            if let Some(outcome) = run.outcome() {
                orders += 1;
                ends.insert(match outcome {
                    Outcome::Succeeded(value) => Ok(run.machine.show(&run.program, value)),
                    Outcome::Failed(failure) => {
                        let text = run.machine.show(&run.program, failure);
                        Err(text.split(':').next().unwrap_or_default().to_string())
                    }
                    Outcome::Evaporated => Err("evaporated".into()),
                });
                break;
            }
            let tasks = run.eligible_tasks().len();
            let choices = if tasks == 0 { run.eligible_timeouts().len() } else { tasks };
            // At the choice where it deviates the others were laid aside before.
            let deviates = run.machine.schedule.as_ref().is_some_and(|schedule| schedule.left().count() > 0);
            let others = if deviates { 1 } else { choices as u32 };
            for taken in 1..others {
                let mut other = run.fork();
                other.machine.schedule.as_mut()?.deviate(taken);
                waiting.push(other);
            }
            if orders + waiting.len() > MAX_ORDERS || turns > MAX_TURNS {
                return None;
            }
            if tasks > 0 {
                run.step_task();
            } else {
                run.next_instant();
            }
        }
    }
    Some(ends)
}

/// A statement of a task.
fn statement(draw: &mut Stream, depth: usize) -> String {
    let one = |draw: &mut Stream, of: &[&'static str]| of[draw.index(of.len())];
    let variable = one(draw, &["a", "b"]);
    let fluent = one(draw, &["f", "g"]);
    match draw.index(if depth == 0 { 8 } else { 14 }) {
        0 => format!("(setq {variable} (+ {variable} 1))"),
        1 => format!("(setq {variable} (* 2 {variable}))"),
        2 => "(setq a b)".into(),
        3 => "(wait-time 0)".into(),
        4 => "(wait-time 1)".into(),
        5 => format!("(setf (value {fluent}) t)"),
        6 => format!("(pulse {fluent})"),
        7 => format!("(ignore-failures (timeout) (wait-for {fluent} :timeout 1))"),
        8 => format!("(let ((old {variable})) {} (setq {variable} (+ old 3)))", statement(draw, 0)),
        9 => format!("(with-valve door {} {})", statement(draw, 0), statement(draw, 0)),
        10 => format!("(ignore-failures (timeout) (with-timeout 1 {} {}))", statement(draw, 0), statement(draw, 0)),
        11 => format!("(try-all {} {})", statement(draw, 0), statement(draw, 0)),
        12 => format!("(unwind-protect {} {})", statement(draw, 0), statement(draw, 0)),
        _ => format!("(with-policy (whenever {fluent} {}) {})", statement(draw, 0), statement(draw, 0)),
    }
}

fn program(draw: &mut Stream) -> String {
    let task = |draw: &mut Stream| {
        let statements: Vec<String> = (0..1 + draw.index(3)).map(|_| statement(draw, 1)).collect();
        format!("(seq {})", statements.join(" "))
    };
    let tasks: Vec<String> = (0..2 + draw.index(2)).map(|_| task(draw)).collect();
    format!(
        "(defvar a 1) (defvar b 2) (def-fluent f nil) (def-fluent g nil) (def-valve door)\n(par {})\n",
        tasks.join(" ")
    )
}

#[test]
fn the_search_comes_to_all_ends_and_no_others() {
    let mut draw = Stream::new(51_001, "programs");
    let (mut compared, mut ends_in_all) = (0, 0);
    while compared < PROGRAMS {
        let text = program(&mut draw);
        let (start, _) = started(&format!("{text}(list a b)"), false);
        let Some(ends) = all_ends(&start) else { continue };
        compared += 1;
        ends_in_all += ends.len();
        let fails = ends.iter().any(Result::is_err);
        let found = searched(&format!("{text}(list a b)"), BOUNDS);
        assert_eq!(found.finding.is_some(), fails, "{text}{ends:?}\n{found:?}");
        if fails {
            continue;
        }
        for end in ends.iter().flatten() {
            let found = searched(&format!("{text}(assert (not (equal (list a b) '{end})))"), BOUNDS);
            assert!(found.finding.is_some(), "{text}{end} is an end of {ends:?}\n{found:?}");
        }
    }
    // Otherwise there was nothing to compare.
    assert!(ends_in_all > PROGRAMS * 4 / 3, "{ends_in_all} ends of {compared} programs");
}
