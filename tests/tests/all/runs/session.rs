//! Forms handed to a running program one after the other.

use rpl_lang::compile::NoFiles;
use rpl_runtime::robot::NoRobot;
use rpl_runtime::run::beside::Beside;
use rpl_runtime::run::session::Answer;
use rpl_runtime::run::stepping::{Stepped, Stop};
use rpl_runtime::run::system::System;
use rpl_runtime::state::value::Value;
use rpl_tests::session;

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

/// r[limit.form]
#[test]
fn each_form_has_all_steps_of_an_instant() {
    let mut system = session();
    system.machine.limits.steps = 1_000;
    for _ in 0..5 {
        assert_eq!(run(&mut system, "(dotimes (i 600) nil) 'done"), run(&mut system, "'done"));
    }
    assert!(matches!(run(&mut system, "(dotimes (i 6000) nil)"), Answer::Failed(_)));
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

/// Steps the form to the first stop at this text.
fn stop_at(system: &mut System<NoRobot>, form: &str, text: &str) -> Stop {
    system.submit("form", form, &mut NoFiles).unwrap_or_else(|found| panic!("{}", found.render(false)));
    loop {
        match system.step_form() {
            Stepped::Before(stop) if system.program.sources.text_of(stop.span) == text => return stop,
            Stepped::Before(_) | Stepped::Ran => {}
            Stepped::Settled => system.next_instant(),
        }
    }
}

/// Hands in forms beside the one that runs, runs them as far as they come at once, and tells how
/// they ended if they have.
fn beside(system: &mut System<NoRobot>, text: &str, stop: Option<&Stop>) -> (Beside, Option<Answer>) {
    let (_, beside) = system
        .submit_beside("beside", text, stop, &mut NoFiles)
        .unwrap_or_else(|found| panic!("{}", found.render(false)));
    while system.step_beside(&beside) {}
    let answer = system.take_beside_answers().pop();
    if let Some(answer) = &answer {
        system.assign_seen(&beside, answer);
    }
    (beside, answer.map(|answer| answer.answer))
}

fn end(system: &mut System<NoRobot>) -> Answer {
    while system.answer().is_none() {
        system.advance();
    }
    system.answer().expect("the form has ended")
}

#[test]
fn forms_beside_assign_what_the_stopped_call_sees() {
    let mut system = session();
    run(&mut system, "(def-fluent level 1)");
    let text = "(let ((x 1) (y 2)) (wait-time 1) (push y captured) (list x y (value level)))";
    run(&mut system, "(defvar captured nil)");
    let stop = stop_at(&mut system, text, "(wait-time 1)");
    let (_, answer) = beside(&mut system, "(setf x (+ x 40)) (setf (value level) 7) (+ x y)", Some(&stop));
    assert_eq!(answer, Some(Answer::Succeeded(Value::Int(43))));
    let Answer::Succeeded(value) = end(&mut system) else { panic!("the form succeeds") };
    assert_eq!(system.machine.write(&system.program, value), "(41 2 7)");
    assert_eq!(run(&mut system, "_"), Answer::Succeeded(value));
}

#[test]
fn captured_variables_are_assigned_for_all_that_share_them() {
    let mut system = session();
    let text = "(let* ((n 1) (read (lambda () n))) (wait-time 1) (setq n (+ n 1)) (funcall read))";
    let stop = stop_at(&mut system, text, "(wait-time 1)");
    beside(&mut system, "(setq n 10)", Some(&stop));
    assert_eq!(end(&mut system), Answer::Succeeded(Value::Int(11)));
}

#[test]
fn forms_beside_that_wait_go_on_with_the_run() {
    let mut system = session();
    run(&mut system, "(defvar log nil)");
    let stop = stop_at(&mut system, "(progn (wait-time 5) (reverse log))", "(wait-time 5)");
    let (waits, answer) = beside(&mut system, "(wait-time 2) (push (now) log) 'done", Some(&stop));
    assert_eq!(answer, None);
    assert_eq!(system.machine.path(waits.task.index), "main/typed");
    let Answer::Succeeded(value) = end(&mut system) else { panic!("the form succeeds") };
    assert_eq!(system.machine.write(&system.program, value), "(2.0)");
    let answers = system.take_beside_answers();
    assert_eq!(answers.iter().map(|answer| answer.number).collect::<Vec<_>>(), [waits.number]);
}

#[test]
fn a_failure_beside_fails_nothing_else() {
    let mut system = session();
    let stop = stop_at(&mut system, "(progn (wait-time 1) 'whole)", "(wait-time 1)");
    assert!(matches!(beside(&mut system, "(car 5)", Some(&stop)).1, Some(Answer::Failed(_))));
    assert!(system.submit_beside("beside", "(no-such-thing)", Some(&stop), &mut NoFiles).is_err());
    let (_, answer) = beside(&mut system, "(def-plan later () 5)", Some(&stop));
    assert!(matches!(answer, Some(Answer::Succeeded(Value::Symbol(_)))));
    assert!(matches!(end(&mut system), Answer::Succeeded(Value::Symbol(_))));
    assert_eq!(run(&mut system, "(later)"), Answer::Succeeded(Value::Int(5)));
}

/// r[def.struct]
#[test]
fn a_slot_that_is_defined_anew_is_read_as_it_is_defined_now() {
    let mut system = session();
    run(&mut system, "(defstruct cup size) (defun size-of (c) (list (cup-size c))) (defvar mine (make-cup :size 3))");
    assert_eq!(run(&mut system, "(car (size-of mine))"), Answer::Succeeded(Value::Int(3)));
    run(&mut system, "(defun cup-size (c) (+ 4 (length c)))");
    assert_eq!(run(&mut system, "(car (size-of mine))"), Answer::Succeeded(Value::Int(6)));
}

/// r[def.value]
#[test]
fn a_definition_has_its_name_as_its_value() {
    let mut system = session();
    for (text, name) in [
        ("(def-plan tick () 1)", "tick"),
        ("(defun tock () 1)", "tock"),
        ("(defmacro twice (form) `(progn ,form ,form))", "twice"),
        ("(def-valve arm)", "arm"),
        ("(def-failure slipped (plan-failure) ())", "slipped"),
        ("(defstruct cup size)", "cup"),
        ("(deftest adding (assert (= 2 (+ 1 1))))", "adding"),
        ("(print 1) (def-plan last () 1)", "last"),
        ("(def-goal (achieve (clean room)) room)", "achieve-clean"),
    ] {
        let Answer::Succeeded(Value::Symbol(value)) = run(&mut system, text) else { panic!("{text} has no name") };
        assert_eq!(system.machine.symbols.name(value), name, "{text}");
    }
    assert_eq!(run(&mut system, "(def-plan first () 1) 7"), Answer::Succeeded(Value::Int(7)));
    assert_eq!(run(&mut system, "(defvar seven 7)"), Answer::Succeeded(Value::Int(7)));
}
