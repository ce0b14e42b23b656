//! Evaporating at every step: clean-ups run exactly once and the machine stays whole.

use rpl_runtime::run::system::{Progress, System};
use rpl_tests::{system, transcript};

const PROGRAMS: &[&str] = &[
    "(unwind-protect (par (wait-time 1) (seq (wait-time 2) (print (quote x)))) (seq (print 'clean) (wait-time 1) (print 'cleaned)))",
    "(unwind-protect (try-all (unwind-protect (wait-time 1) (print 'clean-a)) (seq (print 'b) (fail \"b\")))
                     (par (wait-time 1) (seq (print 'clean) (wait-time 2))))",
    "(pursue-first-n 2 (unwind-protect (wait-time 3) (seq (wait-time 1) (print 'clean-a)))
                       (unwind-protect (seq (wait-time 1) 'b) (print 'clean-b)) (seq (print 'c) (fail \"c\"))
                       (quorum :all 2 (wait-time 2) (unwind-protect (wait-time 2) (print 'clean-d)) (fail \"d\")))",
    "(def-plan p () (spawn (unwind-protect (wait-time 5) (seq (wait-time 1) (print 'clean-spawned)))) (wait-time 1))
     (p) (unwind-protect (p) (print 'clean))",
    "(def-valve v)
     (par (with-valve v (unwind-protect (wait-time 3) (seq (wait-time 1) (print 'clean-owner))))
          (with-priority 1 (wait-time 1) (with-valve v (unwind-protect (wait-time 1) (print 'clean-other))))
          (with-priority 2 (wait-time 1.5) (with-valve v (wait-time 1))))",
    "(def-valve v)
     (par (with-valve v (on-interrupt (wait-time 1) (on-resume (wait-time 1)
            (par (with-valve v (wait-time 2)) (with-valve v (wait-time 2))))))
          (with-priority 1 (wait-time 1) (with-valve v (unwind-protect (wait-time 1) (print 'clean)))))",
    "(def-fluent f nil)
     (with-policy (whenever f (unwind-protect (wait-time 1) (print 'clean-policy)))
       (unwind-protect (seq (wait-time 1) (setf (value f) t) (wait-time 3) (pulse f) (wait-time 3)) (print 'clean)))",
    "(with-retry-counters ((c 2))
       (with-failure-handling ((plan-failure () (do-retry c (retry))))
         (unwind-protect (par (wait-time 1) (seq (wait-time 1) (fail \"x\"))) (seq (print 'clean) (wait-time 1)))))",
    "(par (:tag a (unwind-protect (wait-time 9) (seq (wait-time 1) (print 'clean))))
          (seq (wait-time 1) (with-task-suspended (a) (wait-time 1)) (evaporate a))
          (whenever (fluent (eq (status a) 'suspended)) (print 'suspended) (return nil)))",
    "(with-timeout 3 (unwind-protect (par-map (x '(1 2)) (ignore-failures (timeout) (with-timeout x (wait-time 5))))
                                     (with-timeout 9 (print 'clean) (wait-time 1))))",
];

fn finish(mut system: System<rpl_runtime::robot::NoRobot>, what: &str) -> String {
    for _ in 0..1_000 {
        let progress = system.advance();
        if let Err(broken) = system.machine.check_invariants() {
            panic!("{what}: {broken}");
        }
        if progress == Progress::Ended {
            return transcript(&mut system);
        }
    }
    panic!("{what}: does not end");
}

fn evaporated_at_every_step(text: &str) -> Vec<String> {
    let mut results = Vec::new();
    let mut live = system(text);
    let mut step = 0;
    while live.outcome().is_none() {
        let mut cut = live.clone();
        cut.stop();
        let what = format!("{text}\nevaporated at step {step}");
        if let Err(broken) = cut.machine.check_invariants() {
            panic!("{what}: {broken}");
        }
        results.push(finish(cut, &what));
        if !live.step_task() {
            live.next_instant();
        }
        if let Err(broken) = live.machine.check_invariants() {
            panic!("{text}\nafter step {step}: {broken}");
        }
        step += 1;
    }
    results
}

#[test]
fn programs_are_clean_wherever_they_are_cut() {
    for text in PROGRAMS {
        for result in evaporated_at_every_step(text) {
            let lines: Vec<&str> = result.lines().collect();
            for clean in lines.iter().filter(|line| line.starts_with("clean") && !line.contains("policy")) {
                let count = lines.iter().filter(|line| line == &clean).count();
                let most = if text.contains("do-retry") {
                    3
                } else if text.contains("(p) (unwind") {
                    2
                } else {
                    1
                };
                assert!(count <= most, "{text}\n{result}");
            }
        }
    }
}

#[test]
fn what_is_entered_is_cleaned_up() {
    let text = "(unwind-protect (seq (print 'in) (wait-time 1) (par (wait-time 1) (unwind-protect (seq (print 'in) (wait-time 1)) (print 'out))))
                                (seq (wait-time 1) (print 'out)))";
    for result in evaporated_at_every_step(text) {
        let count = |word| result.lines().filter(|line| *line == word).count();
        assert_eq!(count("in"), count("out"), "{result}");
    }
}
