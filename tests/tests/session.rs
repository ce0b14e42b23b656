//! Forms handed to a running program one after the other.

use rpl_lang::compile::NoFiles;
use rpl_runtime::behaviour::NoRobot;
use rpl_runtime::session::Answer;
use rpl_runtime::system::System;
use rpl_runtime::value::Value;
use rpl_tests::library;

fn session() -> System<NoRobot> {
    System::session(library(), NoRobot).unwrap_or_else(|found| panic!("{}", found.render(false)))
}

fn run(system: &mut System<NoRobot>, text: &str) -> Answer {
    system.submit("form", text, &mut NoFiles).unwrap_or_else(|found| panic!("{}", found.render(false)));
    while system.answer().is_none() {
        system.settle();
        if system.answer().is_none() {
            system.next_instant();
        }
    }
    system.answer().expect("the form has ended")
}

#[test]
fn forms_see_what_earlier_ones_defined() {
    let mut system = session();
    assert!(matches!(run(&mut system, "(defun twice (x) (+ x x))"), Answer::Succeeded(_)));
    assert_eq!(run(&mut system, "(twice 4)"), Answer::Succeeded(Value::Int(8)));
    assert_eq!(run(&mut system, "(+ _ 1)"), Answer::Succeeded(Value::Int(9)));
}

#[test]
fn a_failure_leaves_the_session_usable() {
    let mut system = session();
    assert!(matches!(run(&mut system, "(par (+ 1 nil))"), Answer::Failed(_)));
    assert!(matches!(run(&mut system, "(wait-for (create-fluent nil))"), Answer::Failed(_)));
    assert_eq!(run(&mut system, "7"), Answer::Succeeded(Value::Int(7)));
}

#[test]
fn a_wrong_text_changes_nothing() {
    let mut system = session();
    let before = system.machine.clone();
    assert!(system.submit("form", "(no-such-thing 1)", &mut NoFiles).is_err());
    assert_eq!(system.machine, before);
}

#[test]
fn a_form_given_up_cleans_up() {
    let mut system = session();
    run(&mut system, "(defvar cleaned nil)");
    let text = "(unwind-protect (wait-time 100) (progn (wait-time 1) (setq cleaned t)))";
    system.submit("form", text, &mut NoFiles).unwrap_or_else(|found| panic!("{}", found.render(false)));
    system.settle();
    system.give_up_form();
    while system.answer().is_none() {
        system.advance();
    }
    assert_eq!(system.answer(), Some(Answer::GivenUp));
    assert_eq!(run(&mut system, "cleaned"), Answer::Succeeded(Value::True));
}

#[test]
fn what_runs_in_an_old_text_is_told() {
    let mut system = session();
    run(&mut system, "(def-plan tick () (wait-time 10) 'old)");
    run(&mut system, "(defvar ticking (spawn (tick)))");
    run(&mut system, "(wait-time 1)");
    let submitted = system.submit("form", "(def-plan tick () 'new)", &mut NoFiles).expect("the text is right");
    let [redefined] = &submitted.redefined[..] else { panic!("one plan was redefined: {submitted:?}") };
    assert_eq!(redefined.still_running.len(), 1);
}
