//! Circles of waiting.

use rpl_tests::{check, run};

/// r[valve.circle]
#[test]
fn a_circle_of_waiting_is_a_deadlock() {
    let result = run("(def-valve v) (def-valve w)
         (par (with-valve v (wait-time 1) (with-valve w 1)) (with-valve w (wait-time 1) (with-valve v 1)))");
    assert!(
        result.starts_with("failed: deadlock") && result.contains("valve v") && result.contains("valve w"),
        "{result}"
    );
    let evaporating = run("(def-valve v)
         (par (:tag a (unwind-protect (wait-time 9) (with-valve v 1)))
              (with-valve v (wait-time 1) (evaporate a)))");
    assert!(evaporating.contains("deadlock: this would close a circle"), "{evaporating}");
}

/// r[valve.circle]
#[test]
fn the_circle_is_told_with_tasks_and_valves() {
    let result = run("(def-valve left) (def-valve right)
         (par (:tag one (with-valve left (wait-time 1) (with-valve right 1)))
              (:tag two (with-valve right (wait-time 1) (with-valve left 1))))");
    for part in ["failed: deadlock", "main/one waits for valve right", "main/two waits for valve left"] {
        assert!(result.contains(part), "{result}");
    }
    let joined = run("(def-valve v) (with-valve v (par (with-priority -1 (wait-time 1)) (with-valve v 1)) 'through)");
    assert_eq!(joined, "=> through");
    let evaporating = run("(def-valve v)
         (par (:tag a (unwind-protect (wait-time 9) (with-valve v 1)))
              (with-valve v (wait-time 1) (evaporate a)))");
    assert!(evaporating.contains("waits for the end of main/a"), "{evaporating}");
}

/// r[valve.circle]
#[test]
fn a_circle_through_what_is_suspended_is_told() {
    check(
        "(def-valve v1) (def-valve v3)
         (with-timeout 60
           (pursue (loop (wait-time 1))
             (par (seq (wait-time 1)
                       (with-priority 1
                         (with-failure-handling ((deadlock () (print (list 'deadlock (now)))))
                           (with-valve v1 (with-valve v3 (print 'both))))))
                  (with-valve v1 (with-priority 1 (with-valve v3 (wait-time 2)))))))
         (now)",
        "(deadlock 1.0)\n=> 2.0",
    );
    let told = run("(def-valve v)
         (def-plan p ()
           (with-timeout 60
             (par (loop (wait-time 1))
                  (:tag held (with-valve v (wait-time 5)))
                  (seq (wait-time 1) (with-task-suspended (held) (with-valve v (print 'both)))))))
         (p)");
    for part in ["failed: deadlock", "waits for valve v", "held is suspended by main/p"] {
        assert!(told.contains(part), "{told}");
    }
    // Whoever is only interrupted has the valve again when the other is done.
    check(
        "(def-valve v1) (def-valve v3)
         (par (with-valve v1 (with-valve v3 (wait-time 2)) (print (now)))
              (with-priority 1 (wait-time 1) (with-valve v1 (wait-time 5)))
              (seq (wait-time 2) (with-valve v3 (print 'last))))
         nil",
        "6.0\nlast\n=> nil",
    );
}
