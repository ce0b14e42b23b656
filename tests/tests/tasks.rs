//! Tasks: tags, status, evaporation, suspension, paths.

use rpl_tests::{run, system};

#[track_caller]
fn check(text: &str, expected: &str) {
    assert_eq!(run(text), expected, "{text}");
}

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

#[test]
fn a_tag_run_twice_means_the_newest_run() {
    check("(def-plan p () (dotimes (i 3) (:tag a (* i 10))) (value (result a))) (p)", "=> 20");
}

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

#[test]
fn a_tag_in_child_position_is_the_child() {
    check("(par (:tag a (print (task-path a))))", "main/a\n=> \"main/a\"");
}

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

#[test]
fn evaporating_oneself_or_an_ancestor_is_at_once() {
    check("(seq (:tag a (print 1) (evaporate a) (print 2)) 'after)", "1\n=> after");
    check("(seq (:tag a (par (seq (print 1) (evaporate a) (print 2)) (print 3))) 'after)", "1\n=> after");
    check("(evaporate (this-task)) (print 1)", "evaporated");
}

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

#[test]
fn suspensions_count() {
    check(
        "(par (:tag a (wait-time 1) (print (now)))
              (seq (suspend a) (suspend a) (wait-time 2) (resume a) (wait-time 2) (resume a) (resume a) (suspend a) (resume a)))",
        "4.0\n=> nil",
    );
}

#[test]
fn suspensions_of_ancestors_count_too() {
    check(
        "(def-plan p () (par (:tag a (par (:tag b (wait-time 1) (print (now)))))
              (seq (wait-time 0) (suspend b) (suspend a) (wait-time 2) (resume b) (print 'b-resumed) (wait-time 2) (resume a))))
         (p)",
        "b-resumed\n4.0\n=> nil",
    );
}

#[test]
fn a_child_of_a_suspended_task_is_suspended_and_a_clean_up_is_not() {
    check(
        "(par (:tag a (unwind-protect (wait-time 9) (par (seq (wait-time 1) (print 'cleaned)))))
              (seq (wait-time 1) (suspend a) (evaporate a) (now)))",
        "cleaned\n=> 2.0",
    );
}

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

#[test]
fn suspending_oneself_is_at_once() {
    check(
        "(par (:tag a (print 1) (suspend a) (print 2)) (seq (wait-time 1) (print (value (status a))) (resume a)))",
        "1\nsuspended\n2\n=> nil",
    );
}

#[test]
fn suspend_returns_at_rest() {
    check(
        "(par (:tag b (unwind-protect (wait-time 1) (wait-time 2)) (print (list 'b (now))))
              (seq (wait-time 2) (suspend b) (print (now)) (wait-time 5) (resume b)))",
        "3.0\n(b 8.0)\n=> nil",
    );
}

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

#[test]
fn a_deadline_counts_while_suspended_and_takes_effect_at_the_resume() {
    check(
        "(par (:tag a (with-failure-handling ((timeout () (print (now))))
                        (with-timeout 2 (evap-protect (wait-time 9) (print 'clean)))))
              (seq (wait-time 1) (suspend a) (wait-time 4) (print 'resume) (resume a)))",
        "resume\nclean\n5.0\n=> nil",
    );
}

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

#[test]
fn paths_are_stable() {
    let mut system = system(
        "(def-plan deliver () (try-all (process navigate (wait-time 1)) (fail \"x\")))
         (deliver) (deliver) (par (seq) (with-timeout 1 (deliver)))",
    );
    system.machine.trace.enabled = true;
    while system.advance() == rpl_runtime::system::Progress::Running {}
    let begun: Vec<String> = system
        .machine
        .trace
        .events
        .iter()
        .filter(|event| event.kind == rpl_runtime::trace::EventKind::Begin)
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

#[test]
fn a_task_is_found_by_its_path() {
    check("(par (:tag a (wait-time 5)) (evaporate (task \"main/a\"))) (now)", "=> 0.0");
    check("(task \"main/nobody\")", "=> nil");
}
