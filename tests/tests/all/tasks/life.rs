//! Tasks: tags, status, evaporation, suspension, paths.

use rpl_tests::{check, run, system};

/// r[tag.scope]
#[test]
fn a_tag_is_bound_before_it_is_reached() {
    check(
        "(def-plan p ()
           (par (seq (print (value (status b))) (wait-for (end-task b)) (value (result b)))
                (seq (wait-time 1) (:tag b 'made))))
         (p)",
        "created\n=> made",
    );
}

/// r[tag.newest]
#[test]
fn a_tag_run_twice_means_the_newest_run() {
    check("(def-plan p () (dotimes (i 3) (:tag a (* i 10))) (value (result a))) (p)", "=> 20");
}

/// r[tag.scope]
#[test]
fn a_tag_never_reached_is_evaporated_when_the_plan_ends() {
    check("(def-plan p (go) (if go (:tag a 1)) a) (value (status (p nil)))", "=> evaporated");
    check(
        "(defvar waiter nil)
         (def-plan p () (setq waiter a) (wait-time 1) (if nil (:tag a 1)))
         (par (p) (seq (wait-time 0.5) (wait-for (end-task waiter)) (print (now))))",
        "1.0\n=> 1.0",
    );
}

/// r[tag.child]
#[test]
fn a_tag_in_child_position_is_the_child() {
    check("(par (:tag a (print (task-path a))))", "main/a\n=> \"main/a\"");
}

/// r[act.fluents], r[task.states]
#[test]
fn status_follows_the_task() {
    check(
        "(def-plan p ()
           (par (seq (print (value (status a))) (wait-for (eq (status a) 'blocked)) (print (now))
                     (wait-for (end-task a)) (print (value (status a))))
                (seq (wait-time 1) (:tag a (wait-time 1)))))
         (p) (now)",
        "created\n1.0\nsucceeded\n=> 2.0",
    );
    check(
        "(def-plan p () (par (seq (wait-for (eq (status a) 'blocked)) (now)) (:tag a (wait-time 1)))) (p) (now)",
        "=> 1.0",
    );
    check("(:tag a (print (value (status a))))", "running\n=> running");
}

/// r[act.fluents]
#[test]
fn begin_and_end() {
    check(
        "(def-plan p () (par (seq (print (list (value (begin-task a)) (value (end-task a)) (value (result a))))
                                  (wait-for (begin-task a)) (print (now))
                                  (wait-for (end-task a)) (print (now)))
                             (seq (wait-time 1) (:tag a (wait-time 1) 'v))))
         (p)",
        "(nil nil nil)\n1.0\n2.0\n=> v",
    );
    check(
        "(def-plan p () (ignore-failures (failure) (:tag a (fail \"x\"))) (failure-message (value (result a)))) (p)",
        "=> \"x\"",
    );
}

/// r[act.subtree], r[act.dead]
#[test]
fn evaporate_returns_when_the_subtree_is_clean() {
    check(
        "(def-plan p () (par (:tag a (par (unwind-protect (wait-time 9) (wait-time 2))))
                             (seq (wait-time 1) (evaporate a) (list (now) (value (status a))))))
         (p)",
        "=> (3.0 evaporated)",
    );
    check("(def-plan p () (:tag a 1) (evaporate a) (value (status a))) (p)", "=> succeeded");
}

/// r[act.self]
#[test]
fn evaporating_oneself_or_an_ancestor_is_at_once() {
    check("(seq (:tag a (print 1) (evaporate a) (print 2)) 'after)", "1\n=> after");
    check("(seq (:tag a (par (seq (print 1) (evaporate a) (print 2)) (print 3))) 'after)", "1\n=> after");
    check("(evaporate (this-task)) (print 1)", "evaporated");
}

/// r[cleanup.protected]
#[test]
fn evaporation_during_a_clean_up_waits_for_it() {
    check(
        "(par (:tag a (unwind-protect (seq) (seq (wait-time 2) (print 'cleaned))) (print 'not-reached))
              (seq (wait-time 1) (evaporate a) (print (now))))",
        "cleaned\n2.0\n=> 2.0",
    );
    check(
        "(seq (:tag a (unwind-protect (seq) (seq (evaporate a) (print 'still))) (print 'no)) 'after)",
        "still\n=> after",
    );
}

/// r[cleanup.inside]
#[test]
fn what_names_a_task_inside_a_clean_up_acts_on_that_task() {
    check(
        "(par (unwind-protect nil (:tag c (wait-time 2) (print 'never)) (print (list 'done (now))))
              (seq (wait-time 1) (evaporate c) (print (list 'evaporated (now)))))",
        "(evaporated 1.0)\n(done 1.0)\n=> (evaporated 1.0)",
    );
}

/// r[tag.dead], r[task.states]
#[test]
fn a_task_that_is_evaporated_before_its_tag_is_reached_never_runs() {
    let late = |form: &str| format!("(def-plan p () (par (evaporate late) (seq (wait-time 1) {form}))) (p) (now)");
    for form in [
        "(:tag late (print 'runs))",
        "(process late (print 'runs))",
        "(par (:tag late (print 'runs)) nil)",
        "(with-policy (:tag late (print 'runs)) nil)",
        "(plan ((:tag late (print 'runs)) (:tag next nil)) (:order late next))",
        "(plan ((:tag first nil) (:tag late (print 'runs))) (:order first late))",
        "(spawn (:tag late (print 'runs)))",
        "(let ((i 1)) (loop (:tag late (print 'runs)) until (= i 1)))",
    ] {
        check(&late(form), "=> 1.0");
    }
    check(
        "(def-plan p () (par (seq (suspend late) (evaporate late)) (seq (wait-time 1) (:tag late (print 'runs))))) (p)",
        "=> nil",
    );
    check(
        "(def-plan p ()
           (par (evaporate late)
                (seq (wait-time 1) (pursue (:tag late (wait-time 9)) (seq (wait-time 1) (value (status late)))))))
         (p)",
        "=> evaporated",
    );
    // Reached once more, it means a new task.
    check(
        "(def-plan p () (par (evaporate late) (n-times 2 (wait-time 1) (:tag late (print (now)))))) (p)",
        "2.0\n=> nil",
    );
    // A quorum that needs it cannot be met.
    let starved = run("(def-plan p () (par (evaporate late) (seq (wait-time 1) (quorum 2 :all (:tag late 1) 2)))) (p)");
    assert!(starved.starts_with("failed: composite-failure: only 1 of 2"), "{starved}");
}

/// r[act.death]
#[test]
fn who_waits_for_a_death_wakes_in_a_fixed_order() {
    check(
        "(def-plan p ()
           (par (seq (pursue (:tag a (evap-protect (wait-time 50) (wait-time 1))) (wait-time 2)) (print 'around))
                (seq (wait-time 1) (evaporate a) (print 'evaporated))
                (seq (wait-time 1.5) (suspend a) (print 'at-rest))
                (seq (wait-for (end-task a)) (print 'fluent))))
         (p) nil",
        "fluent\nat-rest\nevaporated\naround\n=> nil",
    );
}

/// r[suspend.count]
#[test]
fn suspensions_count() {
    check(
        "(par (:tag a (wait-time 1) (print (now)))
              (seq (suspend a) (suspend a) (wait-time 2) (resume a) (wait-time 2) (resume a) (resume a) (suspend a) (resume a)))",
        "4.0\n=> nil",
    );
}

/// r[suspend.count]
#[test]
fn suspensions_of_ancestors_count_too() {
    check(
        "(def-plan p () (par (:tag a (par (:tag b (wait-time 1) (print (now)))))
              (seq (wait-time 0) (suspend b) (suspend a) (wait-time 2) (resume b) (print 'b-resumed) (wait-time 2) (resume a))))
         (p)",
        "b-resumed\n4.0\n=> nil",
    );
}

/// r[act.subtree], r[cleanup.protected]
#[test]
fn a_child_of_a_suspended_task_is_suspended_and_a_clean_up_is_not() {
    check(
        "(par (:tag a (unwind-protect (wait-time 9) (par (seq (wait-time 1) (print 'cleaned)))))
              (seq (wait-time 1) (suspend a) (evaporate a) (now)))",
        "cleaned\n=> 2.0",
    );
}

/// r[suspend.created]
#[test]
fn a_created_task_starts_suspended() {
    check(
        "(def-plan p () (suspend b) (par (:tag b (print 'ran)) (seq (wait-time 2) (print (value (status b))) (resume b))))
         (p)",
        "suspended\nran\n=> nil",
    );
    check(
        "(par (seq (suspend b) (wait-time 1) (print 'resume) (resume b)) (:tag b (print 'ran)))",
        "resume\nran\n=> ran",
    );
}

/// r[act.self]
#[test]
fn suspending_oneself_is_at_once() {
    check(
        "(par (:tag a (print 1) (suspend a) (print 2)) (seq (wait-time 1) (print (value (status a))) (resume a)))",
        "1\nsuspended\n2\n=> nil",
    );
}

/// r[act.subtree]
#[test]
fn suspend_returns_at_rest() {
    check(
        "(par (:tag b (unwind-protect (wait-time 1) (wait-time 2)) (print (list 'b (now))))
              (seq (wait-time 2) (suspend b) (print (now)) (wait-time 5) (resume b)))",
        "3.0\n(b 8.0)\n=> nil",
    );
}

/// r[suspend.keeps], r[wait-for.kept]
#[test]
fn a_suspended_task_keeps_its_first_wake_up() {
    check(
        "(def-fluent f nil)
         (par (:tag a (print (wait-for f :timeout 3)) (print (now)))
              (seq (wait-time 1) (suspend a) (setf (value f) 'yes) (setf (value f) nil) (wait-time 5) (resume a)))",
        "yes\n6.0\n=> nil",
    );
    check(
        "(def-fluent f nil)
         (par (:tag a (print (wait-for f :timeout 3)))
              (seq (wait-time 1) (suspend a) (wait-time 5) (setf (value f) 'late) (resume a)))",
        "nil\n=> nil",
    );
}

/// r[timeout.suspended]
#[test]
fn a_deadline_counts_while_suspended_and_takes_effect_at_the_resume() {
    check(
        "(par (:tag a (with-failure-handling ((timeout () (print (now))))
                        (with-timeout 2 (evap-protect (wait-time 9) (print 'clean)))))
              (seq (wait-time 1) (suspend a) (wait-time 4) (print 'resume) (resume a)))",
        "resume\nclean\n5.0\n=> nil",
    );
}

/// r[suspend.form]
#[test]
fn with_task_suspended() {
    check(
        "(par (:tag a (wait-time 1) (print (list 'a (now))))
              (seq (with-task-suspended (a) (wait-time 2) (resume a) (wait-time 1)) (print (now))))",
        "3.0\n(a 3.0)\n=> 3.0",
    );
    check("(def-plan p () (:tag a 1) (with-task-suspended (a) 'ran)) (p)", "=> ran");
    check(
        "(par (:tag a (wait-time 1) (print (now)))
              (ignore-failures (timeout) (with-timeout 2 (with-task-suspended (a) (wait-time 9)))))",
        "2.0\n=> nil",
    );
}

/// r[task.path]
#[test]
fn paths_are_stable() {
    let mut system = system(
        "(def-plan deliver () (try-all (process navigate (wait-time 1)) (fail \"x\")))
         (deliver) (deliver) (par (seq) (with-timeout 1 (deliver)))",
    );
    system.machine.trace.enabled = true;
    while system.advance() == rpl_runtime::run::system::Progress::Running {}
    let begun: Vec<String> = system
        .machine
        .trace
        .events
        .iter()
        .filter(|event| event.kind == rpl_runtime::state::trace::EventKind::Begin)
        .map(|event| event.path.clone())
        .collect();
    assert_eq!(
        begun,
        [
            "main/deliver/navigate",
            "main/deliver/try-all[1]",
            "main/deliver.2/navigate",
            "main/deliver.2/try-all[1]",
            "main/par[0]",
            "main/par[1]",
            "main/par[1]/with-timeout",
            "main/par[1]/with-timeout/deliver/navigate",
            "main/par[1]/with-timeout/deliver/try-all[1]",
        ]
    );
}

/// r[task.tree]
#[test]
fn a_task_is_found_by_its_path() {
    check("(par (:tag a (wait-time 5)) (evaporate (task \"main/a\"))) (now)", "=> 0.0");
    check("(task \"main/nobody\")", "=> nil");
}

/// r[task.is]
#[test]
fn what_makes_a_task_and_what_does_not() {
    check(
        "(def-fluent f t)
         (defun here () (task-path (this-task)))
         (def-plan called () (here))
         (list (seq (here)) (loop (return (here))) (dolist (x '(1)) (return (here)))
               (with-failure-handling ((failure () 1)) (here))
               (with-failure-handling ((failure () (here))) (fail \"x\"))
               (unwind-protect (here)) (try-in-order (here)) (whenever f (return (here)))
               (execute-plan '(here)))",
        &format!("=> ({})", ["\"main\""; 9].join(" ")),
    );
    check(
        "(list (task-path (this-task)) (with-timeout 1 (task-path (this-task))) (with-priority 1 (task-path (this-task))))",
        "=> (\"main\" \"main/with-timeout\" \"main/with-priority\")",
    );
    check(
        "(def-plan p () (with-policy (print (task-path (this-task))) (print (task-path (this-task))))
                        (process named (task-path named)))
         (p)",
        "main/p/with-policy[0]\nmain/p/with-policy[1]\n=> \"main/p/named\"",
    );
}

/// r[task.states], r[act.fluents]
#[test]
fn a_task_goes_through_its_states() {
    let mut seen = Vec::new();
    for (what, at) in [("(wait-time 1)", 0.5), ("(suspend (this-task))", 0.5), ("1", 0.5), ("(fail \"x\")", 0.5)] {
        seen.push(run(&format!(
            "(def-plan p ()
               (par (ignore-failures (failure) (:tag a {what}))
                    (seq (wait-time {at}) (prog1 (value (status a)) (evaporate a)))))
             (p)"
        )));
    }
    assert_eq!(seen, ["=> blocked", "=> suspended", "=> succeeded", "=> failed"]);
    check("(def-plan p () (par (seq (wait-time 1) (:tag a 1)) (value (status a)))) (p)", "=> created");
}

/// r[act.dead], r[suspend.form]
#[test]
fn a_dead_task_never_changes() {
    check(
        "(def-plan p ()
           (:tag a 'v)
           (suspend a) (resume a) (evaporate a)
           (list (with-task-suspended (a) 'ran) (value (status a)) (value (result a)) (now)))
         (p)",
        "=> (ran succeeded v 0.0)",
    );
}

/// r[act.self]
#[test]
fn a_task_ends_itself_within_its_clean_ups() {
    check(
        "(list (seq (:tag a (unwind-protect (seq (evaporate a) (print 'not-reached)) (print 'clean))) 'after) (now))",
        "clean\n=> (after 0.0)",
    );
}

/// r[suspend.created]
#[test]
fn a_step_that_has_not_begun_is_suspended() {
    check(
        "(plan ((:tag a (wait-time 1))
                (:tag b (print (list 'b (now))))
                (seq (suspend b) (wait-time 3) (print (value (status b))) (resume b)))
           (:order a b))",
        "suspended\n(b 3.0)\n=> nil",
    );
}

/// r[suspend.keeps], r[valve.line]
#[test]
fn a_suspended_task_keeps_its_place_in_the_line_of_a_valve() {
    check(
        "(def-valve v)
         (par (with-valve v (wait-time 4))
              (:tag a (wait-time 0.5) (with-valve v (print (list 'a (now)))))
              (seq (wait-time 1) (with-valve v (print (list 'b (now)))))
              (seq (wait-time 2) (suspend a) (wait-time 1) (resume a)))",
        "(a 4.0)\n(b 4.0)\n=> nil",
    );
    // While it rests, the others do not wait for it.
    check(
        "(def-valve v)
         (par (with-valve v (wait-time 2))
              (:tag a (wait-time 0.5) (with-valve v (print (list 'a (now)))))
              (seq (wait-time 1) (with-valve v (print (list 'b (now)))))
              (seq (wait-time 1) (suspend a) (wait-time 4) (resume a)))",
        "(b 2.0)\n(a 5.0)\n=> nil",
    );
}

/// r[tag.scope], r[tag.child]
#[test]
fn a_tag_is_not_known_outside_its_plan() {
    let found = run("(def-plan p () (:tag x 1)) (def-plan q () (evaporate x)) (q)");
    assert!(found.starts_with("error[unbound-name]"), "{found}");
    check("(seq (:tag a (print (task-path a))) (process b (print (task-path b))))", "main/a\nmain/b\n=> \"main/b\"");
}

/// r[suspend.form-only]
#[test]
fn a_resume_does_not_take_back_what_a_form_suspends() {
    check(
        "(par (:tag a (wait-time 1) (print (list 'a (now))))
              (seq (with-task-suspended (a) (wait-time 3)) nil)
              (seq (wait-time 2) (resume a) (resume a)))",
        "(a 3.0)\n=> nil",
    );
}

/// r[resume.order]
#[test]
fn tasks_that_become_ready_in_one_resume_run_in_order_of_position() {
    check(
        "(par (:tag a (par (seq (wait-time 4) (print 1)) (seq (wait-time 2) (print 2)) (seq (wait-time 3) (print 3))))
              (seq (wait-time 1) (suspend a) (wait-time 5) (resume a)))",
        "1\n2\n3\n=> nil",
    );
}

/// r[tag.lone]
#[test]
fn where_a_lone_tag_is_the_child() {
    let is_child = |form: &str| {
        let told = run(&format!("(def-plan p () {form} nil) (p)"));
        let path = told.lines().next().unwrap_or_default().to_string();
        path.matches('/').count()
    };
    let tag = "(:tag a (print (task-path (this-task))))";
    for form in [
        format!("(par {tag})"),
        format!("(pursue {tag})"),
        format!("(try-all {tag})"),
        format!("(quorum 1 1 {tag})"),
        format!("(pursue-first-n 1 {tag})"),
        format!("(plan ({tag}))"),
        format!("(with-policy {tag} nil)"),
        format!("(with-policy nil {tag})"),
        format!("(spawn {tag})"),
        format!("(seq {tag})"),
    ] {
        let form = if form.starts_with("(spawn") { format!("(seq {form} (wait-time 1))") } else { form };
        assert_eq!(is_child(&form), 2, "{form}: main/p/a");
    }
    for form in [
        format!("(with-timeout 1 {tag})"),
        format!("(with-priority 1 {tag})"),
        format!("(par-map (x '(1)) {tag})"),
        format!("(par (seq {tag}))"),
        format!("(process b {tag})"),
        format!("(with-policy nil {tag} nil)"),
    ] {
        assert_eq!(is_child(&form), 3, "{form}: a task of its own below the form's");
    }
}
