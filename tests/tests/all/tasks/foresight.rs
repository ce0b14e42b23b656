//! Plans that are revised by what is projected of them.

use rpl_runtime::run::system::Progress;
use rpl_runtime::state::trace::EventKind;
use rpl_tests::{check, detail, run, system, traced, transcript};

const PLANS: &str = "
    (def-plan slow () (wait-time 100) (fail \"too slow\"))
    (def-plan quick () (wait-time 10) 'done)
    (def-revision quickly (projection plan)
      (when (< (first (projection-success projection)) 0.5))
      (plan-replace '(slow) '(quick) plan)
      \"Does it quickly.\")
    (def-revision slowly (projection plan)
      (when t)
      (plan-replace '(quick) '(slow) plan)
      \"Does it slowly.\")
    ";

/// r[foresight.form], r[foresight.better]
#[test]
fn a_plan_that_would_fail_is_revised_and_one_that_would_not_is_kept() {
    let text = |form: &str| format!("{PLANS}{form}");
    check(&text("(print (with-foresight (:rules (quickly)) (slow))) (< (abs (- (now) 10)) 1)"), "done\n=> t");
    check(&text("(with-foresight (:rules (slowly quickly) :horizon 10min :margin 0.05) (quick)) (< (now) 11)"), "=> t");
    // What it carries in, and what happens later.
    check(
        &text(
            "(def-fluent late nil)
             (def-plan work (seconds) (wait-time seconds) (when (value late) (wait-time 90) (fail \"late\")))
             (def-revision give-up (projection plan)
               (when (value late))
               '(wait-time 1)
               \"Gives up in time.\")
             (let ((seconds 20))
               (par (with-foresight (:rules (give-up) :when late) (work ,seconds))
                    (seq (wait-time 5) (setf (value late) t))))
             (< (now) 7)",
        ),
        "=> t",
    );
}

/// r[foresight.form]
#[test]
fn in_what_is_projected_it_only_runs_the_forms() {
    check(
        &format!(
            "{PLANS} (first (projection-success (project '(with-foresight (:rules (quickly)) (slow)) :horizon 600)))"
        ),
        "=> 0.03125",
    );
    for text in ["(with-foresight () 1)", "(with-foresight (:rules) 1)", "(with-foresight (:rule (car)) 1)"] {
        assert!(run(text).contains("(with-foresight (:rules (RULE...)"), "{}", run(text));
    }
}

/// r[project.chance-of-failure]
#[test]
fn what_goes_on_longer_has_not_failed() {
    let text = |horizon: &str| {
        format!(
            "(ignore-failures (failure)
               (par (:tag errand (wait-time 40) (fail)) (print (chance-of-failure {horizon} :task errand))))"
        )
    };
    check(&text("30s"), "0\n=> nil");
    check(&text("1min"), "1.0\n=> nil");
}

/// r[foresight.trace]
#[test]
fn each_decision_is_told_with_its_figures() {
    let mut system = traced(&format!("{PLANS} (with-foresight (:rules (quickly)) (slow))"));
    while system.advance() == Progress::Running {}
    let events = system.machine.trace.take();
    let told: Vec<(EventKind, &str)> = events
        .iter()
        .filter(|event| matches!(event.kind, EventKind::Decided | EventKind::Swapped))
        .map(|event| (event.kind, detail(event, "what")))
        .collect();
    assert_eq!(
        told,
        [
            (EventKind::Decided, "looks ahead"),
            (EventKind::Decided, "better"),
            (EventKind::Decided, "takes another plan"),
            (EventKind::Swapped, "")
        ]
    );
    let better = events.iter().find(|event| detail(event, "what") == "better").expect("a plan is better");
    let share = |name| detail(better, name).parse::<f64>().expect("a share");
    assert!(share("success") < 0.5 && share("would-succeed") > 0.5, "{better}");
}

/// r[rule.library]
#[test]
fn rules_of_the_library_go_on_where_the_old_plan_was_left() {
    let resumed = "(plan-resumed '(seq (:tag a 1) (x)))";
    check(resumed, "=> (seq (:tag a (library:unless (library:finished? a) 1)) (x))");
    check(&format!("(plan-resumed {resumed})"), "=> (seq (:tag a (library:unless (library:finished? a) 1)) (x))");
    check(
        "(plan-resumed '(plan ((:tag a 1) (:tag b 2)) (:order b a)))",
        "=> (plan ((:tag a (library:unless (library:finished? a) 1)) (:tag b (library:unless (library:finished? b) 2))) (:order b a))",
    );
    // What is done when the danger is seen is not done again.
    check(
        "(def-fluent closes nil)
         (def-plan post () (if (> (now) 100) (fail \"closed\") (wait-time 10)))
         (with-foresight (:rules (last-step-first) :horizon 10min :when closes)
           (seq (:tag first (print 'first) (setf (value closes) t))
                (:tag stroll (wait-time 120) (print 'strolled))
                (:tag mail (post) (print 'posted))))
         (< (now) 135)",
        "first\nposted\nstrolled\n=> t",
    );
    check(
        "(defvar tries 0)
         (def-plan flaky () (wait-time 1) (incf tries) (when (= tries 1) (fail \"flaky\")))
         (with-foresight (:rules (try-once-more)) (seq (:tag a (print 'a)) (:tag b (flaky))))
         tries",
        "a\n=> 2",
    );
    let rule = |rule: &str, plan: &str| run(&format!("({rule} (make-projection) '{plan})"));
    assert_eq!(
        rule("first-step-last", "(seq (:tag a 1) (:tag b 2))"),
        "=> (seq (:tag b (library:unless (library:finished? b) 2)) (:tag a (library:unless (library:finished? a) 1)))"
    );
    assert_eq!(rule("side-by-side", "(seq 1 2)"), "=> nil");
    assert_eq!(
        rule("one-after-the-other", "(par (:tag a 1) (:tag b 2))"),
        "=> (seq (:tag a (library:unless (library:finished? a) 1)) (:tag b (library:unless (library:finished? b) 2)))"
    );
    assert_eq!(rule("other-way-first", "(try-in-order 1 2 3)"), "=> (try-in-order 2 3 1)");
}

/// r[project.memory]
#[test]
fn projections_count_against_the_memory_of_the_run() {
    let limited = |text: &str| {
        let mut system = system(text);
        system.machine.limits.bytes = 1 << 24;
        while system.advance() == Progress::Running {}
        transcript(&mut system)
    };
    let much = "(project '(let ((l nil)) (loop (push 1 l))) :runs 2)";
    assert_eq!(limited(&format!("(map second (projection-failures {much}))")), "=> (out-of-memory)");
    let large = limited("(defvar l (iota 300000)) (project '(wait-time 1) :runs 2)");
    assert!(large.starts_with("failed: out-of-memory"), "{large}");
    // What was only left over is given back first.
    let garbage =
        limited("(dotimes (i 100) (iota 10000)) (first (projection-success (project '(wait-time 1) :runs 2)))");
    assert_eq!(garbage, "=> 0.75");
}
