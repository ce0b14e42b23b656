//! All small programs of tasks that share two valves, the first of them with one place or more.
//!
//! A program is `(par CHILD...)`. A child begins after 0, 1 or 2 seconds at priority 0, 1 or 2 and has
//! one of the `shapes`. Programs that differ only in the order of their children count once.

use std::fmt::Write;

/// How a construct ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// `par`.
    Par,
    /// `with-priority`: one child.
    One,
}

/// A child of a construct.
#[derive(Clone, Debug)]
pub struct Child {
    /// The number it appends to its parent's priority.
    pub priority: Option<i64>,
    /// What it does.
    pub acts: Vec<Act>,
}

/// Something a task does.
#[derive(Clone, Debug)]
pub enum Act {
    /// It waits for this number of seconds.
    Wait(u64),
    /// It does this holding a valve.
    With(usize, Vec<Act>),
    /// It waits for children.
    Children(Rule, Vec<Child>),
    /// It does this and then cleans up.
    Protect(Vec<Act>, Vec<Act>),
    /// It fails.
    Fail,
}

/// A program.
#[derive(Clone, Debug)]
pub struct Program {
    /// How many places each of the two valves has.
    pub places: [usize; 2],
    /// What main does.
    pub acts: Vec<Act>,
}

impl Program {
    /// The program as a text.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for (valve, places) in self.places.iter().enumerate() {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "(def-valve v{valve} {places})");
        }
        write_acts(&mut text, &self.acts);
        text
    }

    /// How many tasks there are below main.
    pub fn tasks(&self) -> usize {
        count(&self.acts)
    }
}

fn count(acts: &[Act]) -> usize {
    let one = |act: &Act| match act {
        Act::Wait(_) | Act::Fail => 0,
        Act::With(_, acts) => count(acts),
        Act::Children(_, children) => children.iter().map(|child| 1 + count(&child.acts)).sum(),
        Act::Protect(acts, clean_up) => count(acts) + count(clean_up),
    };
    acts.iter().map(one).sum()
}

fn write_acts(text: &mut String, acts: &[Act]) {
    for (at, act) in acts.iter().enumerate() {
        text.push_str(if at == 0 { "" } else { " " });
        write_act(text, act);
    }
}

fn write_act(text: &mut String, act: &Act) {
    // Writing to a string cannot fail.
    let _ = match act {
        Act::Wait(seconds) => write!(text, "(wait-time {seconds})"),
        Act::Fail => write!(text, "(fail \"x\")"),
        Act::With(valve, acts) => {
            let _ = write!(text, "(with-valve v{valve} ");
            write_acts(text, acts);
            write!(text, ")")
        }
        Act::Children(rule, children) => {
            let priority = children.first().and_then(|child| child.priority);
            let _ = match (rule, priority) {
                (Rule::One, Some(priority)) => write!(text, "(with-priority {priority} "),
                (Rule::One, None) | (Rule::Par, _) => write!(text, "(par"),
            };
            for child in children {
                text.push_str(if *rule == Rule::Par { " (seq " } else { "" });
                write_acts(text, &child.acts);
                text.push_str(if *rule == Rule::Par { ")" } else { "" });
            }
            write!(text, ")")
        }
        Act::Protect(acts, clean_up) => {
            let _ = write!(text, "(unwind-protect (seq ");
            write_acts(text, acts);
            let _ = write!(text, ") ");
            write_acts(text, clean_up);
            write!(text, ")")
        }
    };
}

fn wait(seconds: u64) -> Vec<Act> {
    vec![Act::Wait(seconds)]
}

fn with(valve: usize, acts: Vec<Act>) -> Vec<Act> {
    vec![Act::With(valve, acts)]
}

fn par(children: Vec<Vec<Act>>) -> Vec<Act> {
    let child = |acts| Child { priority: None, acts };
    vec![Act::Children(Rule::Par, children.into_iter().map(child).collect())]
}

fn at_priority(priority: i64, acts: Vec<Act>) -> Vec<Act> {
    if priority == 0 {
        return acts;
    }
    vec![Act::Children(Rule::One, vec![Child { priority: Some(priority), acts }])]
}

fn then(mut first: Vec<Act>, second: Vec<Act>) -> Vec<Act> {
    first.extend(second);
    first
}

fn protect(acts: Vec<Act>, clean_up: Vec<Act>) -> Vec<Act> {
    vec![Act::Protect(acts, clean_up)]
}

/// What a child can do with the valves.
fn shapes() -> Vec<Vec<Act>> {
    vec![
        with(0, wait(3)),
        with(0, par(vec![with(0, wait(3)), with(0, wait(1))])),
        with(0, par(vec![with(0, wait(3)), at_priority(1, then(wait(1), with(0, wait(1))))])),
        with(0, par(vec![with(0, par(vec![with(0, wait(1)), with(0, wait(1))])), with(0, wait(1))])),
        with(0, par(vec![with(0, wait(2)), wait(3)])),
        with(0, protect(wait(3), wait(1))),
        with(0, protect(wait(3), with(0, wait(1)))),
        protect(with(0, wait(3)), with(0, wait(1))),
        with(0, par(vec![protect(wait(1), wait(2)), with(0, wait(2))])),
        with(0, then(wait(1), vec![Act::Fail])),
        with(0, par(vec![with(0, then(wait(2), vec![Act::Fail])), protect(wait(4), wait(1))])),
        with(1, then(wait(1), with(0, wait(1)))),
        with(1, protect(wait(1), with(0, wait(2)))),
        then(with(0, wait(1)), with(1, wait(1))),
    ]
}

/// All children.
fn children() -> Vec<Vec<Act>> {
    let mut children = Vec::new();
    for shape in shapes() {
        for priority in 0..3 {
            for delay in 0..3 {
                let acts = if delay == 0 { shape.clone() } else { then(wait(delay), shape.clone()) };
                children.push(at_priority(priority, acts));
            }
        }
    }
    children
}

/// Every nth (`every`) of the programs with `width` children, as far as it has at most `most` tasks; the first valve
/// has `places` places.
pub fn programs(width: usize, places: usize, most: usize, every: usize) -> impl Iterator<Item = Program> {
    let children = children();
    let mut chosen = vec![0; width];
    let mut is_over = false;
    let mut number = 0;
    std::iter::from_fn(move || {
        while !is_over {
            let is_meant = number % every == 0;
            number += 1;
            let acts = || par(chosen.iter().map(|&child| children[child].clone()).collect());
            let program = is_meant.then(|| Program { places: [places, 1], acts: acts() });
            // The next choice, not descending.
            match chosen.iter().rposition(|&child| child + 1 < children.len()) {
                Some(at) => {
                    let next = chosen[at] + 1;
                    chosen[at..].fill(next);
                }
                None => is_over = true,
            }
            if let Some(program) = program.filter(|program| program.tasks() <= most) {
                return Some(program);
            }
        }
        None
    })
}
