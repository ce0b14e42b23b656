//! Stepping through a run: where it stops, what is seen there, and that it changes nothing.

use rpl_runtime::robot::NoRobot;
use rpl_runtime::run::stepping::{Stepped, Stop};
use rpl_runtime::run::system::{Outcome, Progress, System};
use rpl_runtime::state::value::Value;
use rpl_tests::system;

const PROGRAM: &str = "
(def-fluent done? nil)
(def-valve arm)
(def-plan work (count)
  (let ((total 0))
    (dotimes (i count) (setq total (+ total i)) (wait-time 1))
    (setf (value done?) t)
    total))
(with-policy (whenever done? (print \"seen\"))
  (par (with-valve arm (work 3))
       (seq (wait-for done?) (try-all (wait-time 5) (work 2)))))";

fn stepped_to_the_end(system: &mut System<NoRobot>) -> Vec<Stop> {
    let mut stops = Vec::new();
    loop {
        match system.step_form() {
            Stepped::Before(stop) => stops.push(stop),
            Stepped::Ran => {}
            Stepped::Settled if system.outcome().is_some() => return stops,
            Stepped::Settled => system.next_instant(),
        }
    }
}

#[test]
fn stepping_does_not_change_the_run() {
    let (mut whole, mut stepped) = (system(PROGRAM), system(PROGRAM));
    whole.machine.trace.enabled = true;
    stepped.machine.trace.enabled = true;
    while whole.advance() == Progress::Running {}
    let stops = stepped_to_the_end(&mut stepped);
    assert!(stops.len() >= 15, "{} stops", stops.len());
    assert_eq!(whole.machine.trace.events, stepped.machine.trace.events);
    assert_eq!(whole.machine.output, stepped.machine.output);
}

#[test]
fn a_slice_that_ends_is_no_stop() {
    let (mut whole, mut sliced) = (system(PROGRAM), system(PROGRAM));
    sliced.slice_steps = 1;
    assert_eq!(stepped_to_the_end(&mut whole), stepped_to_the_end(&mut sliced));
    // Where nothing is stopped at, control comes back all the same.
    let mut busy = system("(loop)");
    assert!((0..5).all(|_| busy.step_form() == Stepped::Ran));
}

#[test]
fn it_stops_before_each_call_in_the_order_of_evaluation() {
    let mut system = system("(defun double (x) (* 2 x)) (print (list (double 1) (double 2)))");
    let texts: Vec<String> =
        stepped_to_the_end(&mut system).iter().map(|stop| system.program.sources.text_of(stop.span).into()).collect();
    assert_eq!(
        texts,
        ["(double 1)", "(double 2)", "(list (double 1) (double 2))", "(print (list (double 1) (double 2)))"]
    );
}

#[test]
fn variables_and_values_are_seen_where_a_task_stands() {
    let mut system = system("(defun weigh (x y) (let ((sum (+ x y))) (list sum x))) (weigh 3 4)");
    let stop = loop {
        match system.step_form() {
            Stepped::Before(stop) if system.program.sources.text_of(stop.span) == "(list sum x)" => break stop,
            Stepped::Before(_) | Stepped::Ran => {}
            Stepped::Settled => panic!("the form is never reached"),
        }
    };
    let task = system.machine.tasks.find_alive(stop.task).expect("the task stands there");
    let variables = system.machine.variables(&system.program, task);
    let (function, seen) = &variables[0];
    assert_eq!(system.machine.symbols.name(*function), "weigh");
    let named: Vec<(&str, Value)> =
        seen.iter().map(|&(name, value)| (system.machine.symbols.name(name), value)).collect();
    assert_eq!(named, [("x", Value::Int(3)), ("y", Value::Int(4)), ("sum", Value::Int(7))]);
    system.want_value(&stop);
    while system.outcome().is_none() {
        system.step_form();
    }
    assert_eq!(system.wanted_value().as_deref(), Some("(7 3)"));
    assert!(matches!(system.outcome(), Some(Outcome::Succeeded(_))));
}
