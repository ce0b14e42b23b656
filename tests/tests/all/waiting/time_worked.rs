//! Time worked: waits and deadlines with `:active` count only while their task is not suspended.

use rpl_lang::compile::NoFiles;
use rpl_runtime::robot::NoRobot;
use rpl_runtime::run::system::System;
use rpl_tests::{library, run, system, transcript};

fn prints(text: &str, expected: &str) {
    let ended = run(text);
    let (printed, _) = ended.rsplit_once('\n').unwrap_or(("", &ended));
    assert_eq!(printed, expected, "{text}\n{ended}");
}

/// r[wait.active] r[suspend.keeps]
#[test]
fn a_wait_for_time_worked_stands_still_while_its_task_is_suspended() {
    let suspended = |wait: &str| {
        format!(
            "(par (:tag worker {wait} (print (now)))
                  (seq (wait-time 2) (suspend worker) (wait-time 10) (resume worker)))"
        )
    };
    prints(&suspended("(wait-time 5)"), "12.0");
    prints(&suspended("(wait-time 5 :active)"), "15.0");
    prints(&suspended("(wait-time 1 :active)"), "1.0");
    // Nothing is left of a time that is over at the very moment of the suspension.
    prints(&suspended("(wait-time 2 :active)"), "2.0");
    prints(&suspended("(wait-time 0 :active)"), "0.0");
}

/// r[wait.active]
#[test]
fn suspensions_nest_and_those_of_tasks_above_count() {
    prints(
        "(par (:tag outer (par (:tag inner (wait-time 5 :active) (print (now)))))
              (seq (wait-time 1) (suspend outer) (wait-time 1) (suspend inner)
                   (wait-time 1) (resume outer) (wait-time 1) (resume inner)
                   (wait-time 2) (with-task-suspended (outer) (wait-time 10))))",
        "18.0",
    );
    // Who is taken a valve from is suspended, hooks included.
    prints(
        "(def-valve wheels)
         (with-policy (seq (wait-time 2) (with-valve wheels (wait-time 7)))
           (with-valve wheels
             (on-interrupt (wait-time 1)
               (seq (wait-time 5 :active) (print (now))))))",
        "13.0",
    );
}

/// r[timeout.active]
#[test]
fn a_deadline_of_time_worked_stands_still_while_its_body_is_suspended() {
    let deadline = |time: &str, work: &str| {
        format!(
            "(par (:tag worker (print (with-failure-handling ((timeout (f) (list 'late (now))))
                                        (with-timeout {time} {work} (list 'done (now))))))
                  (seq (wait-time 2) (suspend worker) (wait-time 10) (resume worker)))"
        )
    };
    prints(&deadline("5", "(wait-time 3 :active)"), "(late 12.0)");
    prints(&deadline("5 :active", "(wait-time 3 :active)"), "(done 13.0)");
    prints(&deadline("5 :active", "(wait-time 9 :active)"), "(late 15.0)");
    prints(&deadline("5 :active", "(wait-time 14)"), "(done 14.0)");
    // Both kinds inside one another: whichever ends first.
    prints(&deadline("5 :active", "(with-timeout 13 (wait-time 9 :active))"), "(late 13.0)");
    prints(&deadline("14", "(with-timeout 3 :active (wait-time 9 :active))"), "(late 13.0)");
    // A task below the body is suspended, the body is not.
    prints(
        "(print (with-failure-handling ((timeout (f) (list 'late (now))))
                  (with-policy (seq (wait-time 1) (with-task-suspended (work) (wait-time 4)))
                    (with-timeout 3 :active (:tag work (wait-time 9 :active))))))",
        "(late 3.0)",
    );
}

/// r[timeout.active]
#[test]
fn a_clean_up_is_work_and_what_is_left_counts_when_it_is_over() {
    // The clean-up runs on through the suspension, which waits for its end at 4 and lasts from there to 14.
    prints(
        "(par (:tag worker (print (with-failure-handling ((timeout (f) (list 'late (now))))
                 (with-timeout 6 :active
                   (unwind-protect (wait-time 1) (wait-time 3))
                   (wait-time 9 :active)))))
              (seq (wait-time 2) (suspend worker) (wait-time 10) (resume worker)))",
        "(late 16.0)",
    );
}

/// r[wait.active]
#[test]
fn who_is_evaporated_or_never_resumed_leaves_no_timer_behind() {
    prints(
        "(seq (par (:tag worker (evap-protect (wait-time 5 :active) (print (now))))
                   (seq (wait-time 2) (suspend worker) (wait-time 10) (evaporate worker)))
              (print (now)))",
        "12.0\n12.0",
    );
    let ended = run("(par (:tag worker (wait-time 5 :active)) (seq (wait-time 2) (suspend worker)))");
    assert!(ended.contains("deadlock") && ended.contains("worker is suspended"), "{ended}");
}

/// r[wait.active]
#[test]
fn what_counts_is_saved_and_forked_with_the_run() {
    let text = "(par (:tag worker (with-timeout 8 :active (wait-time 5 :active)) (print (now)))
                     (seq (wait-time 2) (suspend worker) (wait-time 10) (resume worker)
                          (wait-time 1) (with-task-suspended (worker) (wait-time 1))))";
    let mut whole = system(text);
    let mut saved = system(text);
    while whole.outcome().is_none() {
        whole.advance();
        let bytes = saved.save();
        let loaded = library().load("test.rpl", text, &mut NoFiles).expect("it compiles");
        saved = System::load(&bytes, library().clone(), loaded, NoRobot).expect("the run can be loaded");
        saved.advance();
        assert_eq!(saved.machine.now_us, whole.machine.now_us);
        saved.machine.check_invariants().expect("the run is whole");
    }
    assert_eq!(transcript(&mut whole), "16.0\n=> nil");
    assert_eq!(transcript(&mut saved), "16.0\n=> nil");
}

#[test]
fn nothing_but_active_stands_behind_a_time() {
    let ended = run("(wait-time 5 :activ)");
    assert!(ended.contains("argument 2 of `wait-time` can only be `:active`, and it is the keyword :activ"), "{ended}");
    // A keyword that is no clock is the body.
    assert_eq!(run("(with-timeout 5 :done)"), "=> :done");
    assert_eq!(run("(with-timeout 5 :active)"), "=> nil");
}
