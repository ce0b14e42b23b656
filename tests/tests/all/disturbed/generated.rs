//! Some thousand generated runs, and what earlier ones found.

use rpl_runtime::run::system::Progress;
use rpl_runtime::state::trace::Event;
use rpl_tests::generated::drive::{Case, Tally};
use rpl_tests::generated::{forged, texts};
use rpl_tests::{run, system, traced, transcript};

/// Each run under disturbances, and once more forked, saved, or with collections.
#[test]
fn generated_runs_keep_what_every_run_must() {
    let mut tally = Tally::default();
    for seed in 0..300 {
        let case = Case::generated(seed);
        if let Err(finding) = case.judge(10, &mut tally) {
            panic!("seed {seed}: {finding}\n{}", case.text);
        }
    }
    assert_eq!(tally.rejected, 0, "the grammar writes what can run");
    assert!(tally.clean_ups > 300 && tally.succeeded > 500 && tally.failed > 500 && tally.stopped > 50, "{tally:?}");
}

/// r[swap.leaves], r[fence.form]: tasks are given other plans by others, by themselves and by tasks below,
/// among everything else that can happen.
#[test]
fn generated_runs_with_revisions_keep_what_every_run_must() {
    let mut tally = Tally::default();
    for seed in 0..150 {
        let case = Case::revised(seed);
        if let Err(finding) = case.judge(10, &mut tally) {
            panic!("seed {seed}: {finding}\n{}", case.text);
        }
    }
    assert_eq!(tally.rejected, 0, "the grammar writes what can run");
    assert!(tally.clean_ups > 150 && tally.succeeded > 250 && tally.failed > 250, "{tally:?}");
}

/// r[swap.leaves]
#[test]
fn some_task_is_given_another_plan_at_every_step() {
    let mut tally = Tally::default();
    for seed in 1000..1040 {
        let case = Case::generated(seed);
        if let Err(finding) = case.judge_swaps(&mut tally) {
            panic!("seed {seed}: {finding}\n{}", case.text);
        }
    }
    assert!(tally.runs > 300 && tally.clean_ups > 30, "{tally:?}");
}

#[test]
fn mangled_texts_are_compiled_or_refused() {
    let mut compiled = 0;
    for seed in 0..400 {
        compiled += usize::from(texts::judge(seed).unwrap_or_else(|finding| panic!("seed {seed}: {finding}")));
    }
    assert!(compiled > 5, "some mangled texts still compile: {compiled}");
}

#[test]
fn forged_runs_are_refused_or_run() {
    let mut tally = forged::Tally::default();
    for seed in 0..40 {
        forged::judge(seed, 20, &mut tally).unwrap_or_else(|finding| panic!("seed {seed}: {finding}"));
    }
    assert!(tally.refused > 200 && tally.ran > 50, "{tally:?}");
}

#[test]
fn a_task_that_ends_its_ancestor_ends_with_it() {
    assert_eq!(
        run("(pursue (process t1 (try-all (par (evaporate t1)))))"),
        "failed: composite-failure: there was nothing that could succeed"
    );
}

/// Each call tells how many steps it was given: the budget of a macro, until they have used up that of a text. Then
/// it is told once that nothing more is expanded.
#[test]
fn a_text_full_of_endless_macros_costs_little_more_than_its_budget() {
    const CALLS: usize = 10_000;
    let told = run(&format!("(defmacro endless () (loop nil))\n{}", "(endless)\n".repeat(CALLS)));
    let steps_of = |line: &str| line.split_once("cannot be expanded: runaway: ")?.1.split(' ').next()?.parse().ok();
    let steps: Vec<u64> = told.lines().filter_map(steps_of).collect();
    assert!((1..=6).contains(&steps.len()) && steps.iter().sum::<u64>() <= 120_000_000, "{steps:?}");
    assert_eq!(told.matches("error[too-much-expanded]").count(), 1, "{told:.300}");
    assert_eq!(told.matches("error[").count(), steps.len() + 1, "{told:.300}");
}

#[test]
fn a_tag_is_no_function() {
    assert_eq!(
        run("(par (:tag work (work)))"),
        "failed: type-error: what is called must be a function, and it is a task"
    );
}

#[test]
fn what_waits_on_networks_of_one_fluent_is_woken_in_the_order_of_waiting_whatever_was_collected() {
    let text = "(def-fluent go nil)
                (list (fluent go) (fluent (not go)) (fluent go))
                (wait-time 1)
                (par (whenever (and go t) (print 'first) (return nil)) (whenever (and go t) (print 'second) (return nil))
                     (seq (wait-time 1) (pulse go)))";
    let mut system = system(text);
    while system.advance() == Progress::Running {
        // The networks nobody names leave their slots to those of the waits, the last one first.
        system.machine.heap.threshold = 0;
    }
    assert_eq!(transcript(&mut system), "first\nsecond\n=> nil");
}

#[test]
fn a_suspension_that_a_clean_up_held_up_takes_effect_where_the_failure_is_handled() {
    let text = "(par (:tag a (with-failure-handling ((failure () (print 'handled)))
                       (unwind-protect (seq (wait-time 1) (fail)) (wait-time 1))))
                     (seq (wait-time 1.5) (suspend a) (print (now)) (wait-time 2) (print 'resumes) (resume a)))";
    assert_eq!(run(text), "2.0\nresumes\nhandled\n=> nil");
}

#[test]
fn a_deadlock_lists_tasks_in_the_order_of_the_tree() {
    let mut system = system(
        "(def-fluent f nil)
         (par (par (wait-time 0.1) (wait-time 0.1))
              (seq (wait-time 1) (par (wait-for f) (seq (wait-time 1) (with-policy (wait-for f) (wait-for f))))))",
    );
    while system.advance() == Progress::Running {
        // Every slot that is free is used again by another task.
        system.machine.heap.threshold = 0;
    }
    let told = transcript(&mut system);
    let waits: Vec<&str> =
        told.split("; ").filter_map(|wait| wait.split_once(" waits").map(|(path, _)| path)).collect();
    assert_eq!(waits.len(), 3, "{told}");
    assert!(waits[1].ends_with("with-policy[0]") && waits[2].ends_with("with-policy[1]"), "{told}");
}

#[test]
fn a_wait_that_goes_on_is_told_of_no_other_task() {
    let text = "(process t2 (with-priority -1 (wait-time 0.1 :active)) (spawn (with-policy nil)))
                (par (:tag a (wait-time 1 :active)) (seq (wait-time 0.5) (suspend a) (wait-time 1) (resume a) (par nil)))";
    let mut system = traced(text);
    while system.advance() == Progress::Running {}
    let told = system.machine.trace.take();
    let until = told.iter().filter(|event| event.details.iter().any(|(name, _)| name == "until"));
    let on = |event: &Event| event.details.iter().any(|(name, on)| name == "on" && on == "time");
    assert!(until.clone().count() == 4 && until.clone().all(on), "{told:?}");
}

/// What a plan call keeps of its tags once depended on the room its list had, which a fork has not.
#[test]
fn a_fork_meets_its_limit_of_memory_where_the_original_does() {
    assert_eq!(Case::generated(21_206_402_980).judge(10, &mut Tally::default()), Ok(()));
}
