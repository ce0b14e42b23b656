//! Valves that several tasks may have at a time.

use rpl_lang::compile::NoFiles;
use rpl_tests::{check, run};

/// r[valve.places], r[valve.places-line]
#[test]
fn as_many_tasks_have_a_valve_as_it_has_places_and_the_others_stand_in_one_line() {
    check(
        "(def-valve docks 2 \"Where robots are charged.\")
         (par (with-valve docks (wait-time 1) (print (list 1 (now))))
              (with-valve docks (wait-time 2) (print (list 2 (now))))
              (with-valve docks (wait-time 2) (print (list 3 (now))))
              (with-valve docks (wait-time 3) (print (list 4 (now)))))
         (holds-valve? docks)",
        "(1 1.0)\n(2 2.0)\n(3 3.0)\n(4 5.0)\n=> nil",
    );
    // By priority, then in the order of asking.
    check(
        "(def-valve docks 2)
         (def-plan use (name) (with-valve docks (wait-time 1) (print name)))
         (par (with-priority 2 (use 'a)) (with-priority 2 (use 'b))
              (with-priority -1 (use 'e)) (use 'd) (with-priority 1 (use 'c)))
         (now)",
        "a\nb\nc\nd\ne\n=> 3.0",
    );
}

/// r[valve.places]
#[test]
fn a_wrong_number_of_places_is_told_with_what_would_be_right() {
    for (text, message) in [
        ("(def-valve docks 0)", "a valve has from 1 to 100 places, and 0 are asked for"),
        ("(def-valve docks -2)", "a valve has from 1 to 100 places, and -2 are asked for"),
        ("(def-valve docks 101)", "a valve has from 1 to 100 places, and 101 are asked for"),
        ("(def-valve docks 2.5)", "the places of a valve are a whole number, written out"),
        ("(defconstant many 3) (def-valve docks many)", "a number from 1 to 100"),
        ("(def-valve docks 2 3)", "this is not of the form `(def-valve NAME [PLACES] [\"DOC\"])`"),
        ("(def-valve docks \"Where robots are charged.\" 2)", "this is not of the form"),
    ] {
        let told = run(text);
        assert!(told.contains(message), "{text}\n{told}");
    }
    // It is told once, and not of each use.
    let told = run("(def-valve docks 0) (with-valve docks nil) (with-valve docks nil)");
    assert_eq!(told.matches("error[").count(), 1, "{told}");
}

/// r[valve.places-kept]
#[test]
fn a_valve_keeps_its_places_as_long_as_the_run_goes_on() {
    let mut system = rpl_tests::session();
    let mut told = |text: &str| match system.submit("form", text, &mut NoFiles) {
        Ok(_) => {
            while system.answer().is_none() {
                system.settle();
            }
            String::new()
        }
        Err(found) => found.render(false),
    };
    assert_eq!(told("(def-valve docks 2)"), "");
    assert_eq!(told("(def-valve docks 2)"), "");
    let other = told("(def-valve docks 3)");
    assert!(other.contains("`docks` is a valve with 2 places") && other.contains("write 2"), "{other}");
    assert!(told("(def-valve docks)").contains("`docks` is a valve with 2 places"));
}

/// r[valve.places-borrow]
#[test]
fn below_an_owner_the_place_of_the_owner_is_borrowed_and_no_other() {
    check(
        "(def-valve docks 3)
         (with-valve docks
           (par (with-valve docks (wait-time 1) (print (now))) (with-valve docks (wait-time 1) (print (now)))))
         (holds-valve? docks)",
        "1.0\n2.0\n=> nil",
    );
    // The nearest above counts: the spawned task has a place of its own, and its children take turns there.
    check(
        "(def-valve docks 3)
         (def-plan p ()
           (spawn (with-valve docks
                    (wait-time 1)
                    (par (with-valve docks (wait-time 1) (print (list 'one (now))))
                         (with-valve docks (wait-time 1) (print (list 'two (now)))))))
           (wait-time 0.5)
           (with-valve docks (wait-time 5)))
         (p) nil",
        "(one 2.0)\n(two 3.0)\n=> nil",
    );
    // By hand a place is taken as often as it is asked for.
    check(
        "(def-valve docks 2)
         (request-valve docks) (request-valve docks) (release-valve docks)
         (print (holds-valve? docks))
         (release-valve docks)
         (print (holds-valve? docks))
         (ignore-failures (valve-error) (release-valve docks) (print 'never))
         nil",
        "t\nnil\n=> nil",
    );
}

/// r[valve.places-preempt], r[valve.places-return]
#[test]
fn the_least_important_holder_is_interrupted_and_goes_on_with_any_place() {
    let told = |first: &str, second: &str| {
        run(&format!(
            "(def-valve docks 2)
             (par {first} {second}
                  (with-priority 1 (wait-time 1) (with-valve docks (wait-time 4) (print (list 'urgent (now))))))
             nil"
        ))
    };
    let holds = |name: &str| format!("(with-valve docks (wait-time 3) (print (list '{name} (now))))");
    // Among equals the one that has had its place for the shortest time: it goes on when the other is done.
    assert_eq!(told(&holds("a"), &holds("b")), "(a 3.0)\n(b 3.0)\n(urgent 5.0)\n=> nil");
    let low = format!("(with-priority -1 {})", holds("low"));
    assert_eq!(told(&low, &holds("b")), "(b 3.0)\n(low 3.0)\n(urgent 5.0)\n=> nil");
    // Nobody interrupts a clean-up: then it is the next.
    let cleans_up = "(with-priority -1 (with-valve docks
                       (unwind-protect nil (wait-time 3) (print (list 'clean (now))))))";
    assert_eq!(told(cleans_up, &holds("b")), "(clean 3.0)\n(b 3.0)\n(urgent 5.0)\n=> nil");
    // If clean-ups keep all places, the first to end gives its place.
    let cleans_up_longer = "(with-valve docks (unwind-protect nil (wait-time 6) (print (list 'later (now)))))";
    assert_eq!(told(cleans_up, cleans_up_longer), "(clean 3.0)\n(later 6.0)\n(urgent 7.0)\n=> nil");
}

/// r[valve.places-return]
#[test]
fn of_three_holders_two_are_interrupted_and_go_on_in_their_order() {
    check(
        "(def-valve docks 3)
         (def-plan hold (name)
           (with-valve docks
             (on-interrupt (print (list name 'stops (now)))
               (on-resume (print (list name 'goes-on (now)))
                 (wait-time 9)
                 (print (list name 'ends (now)))))))
         (par (hold 'a) (hold 'b) (hold 'c)
              (with-priority 1 (wait-time 1) (with-valve docks (wait-time 3)))
              (with-priority 1 (wait-time 2) (with-valve docks (wait-time 4))))
         nil",
        "(c stops 1.0)\n(b stops 2.0)\n(b goes-on 4.0)\n(c goes-on 6.0)\n(a ends 9.0)\n(b ends 9.0)\n(c ends 9.0)\n=> nil",
    );
    // The most important first, and before them who stands in line and is more important still.
    check(
        "(def-valve docks 2)
         (def-plan hold (name) (with-valve docks (wait-time 9) (print name)))
         (par (with-priority 1 (hold 'middle)) (hold 'low)
              (with-priority 3 (wait-time 1) (with-valve docks (wait-time 4) (print (list 'first (now)))))
              (with-priority 3 (wait-time 2) (with-valve docks (wait-time 4) (print (list 'second (now)))))
              (with-priority 2 (wait-time 3) (with-valve docks (wait-time 2) (print (list 'waited (now))))))
         (now)",
        "(first 5.0)\n(second 6.0)\n(waited 7.0)\nmiddle\nlow\n=> 9.0",
    );
}

/// r[valve.places-return]
#[test]
fn a_borrower_that_was_interrupted_waits_for_its_owner_and_takes_no_other_place() {
    check(
        "(def-valve docks 2)
         (with-valve docks
           (par (with-valve docks (wait-time 2) (print (list 'branch (now))))
                (with-priority 1 (wait-time 1) (with-valve docks (wait-time 4) (print (list 'inside (now)))))))
         nil",
        "(inside 5.0)\n(branch 5.0)\n=> nil",
    );
    // The owner goes to another place with all that is below it.
    check(
        "(def-valve docks 2)
         (par (with-valve docks (wait-time 4) (print (list 'other (now))))
              (with-valve docks
                (par (with-valve docks (wait-time 3) (print (list 'branch (now))))
                     (with-priority 1 (wait-time 1) (with-valve docks (wait-time 5) (print (list 'inside (now))))))
                (print (list 'owner (now))))
              (with-priority 5 (wait-time 2) (with-valve docks (wait-time 9) (print (list 'urgent (now))))))
         nil",
        "(inside 6.0)\n(branch 6.0)\n(owner 6.0)\n(other 6.0)\n(urgent 11.0)\n=> nil",
    );
}

/// r[valve.hooks], r[valve.places-preempt]
#[test]
fn whoever_waits_for_hooks_takes_no_second_place() {
    check(
        "(def-valve docks 2)
         (def-plan hold (name)
           (with-valve docks
             (on-interrupt (seq (print (list name 'stops)) (wait-time 1)) (wait-time 5))
             (print (list name (now)))))
         (par (hold 'a) (hold 'b)
              (with-priority 1 (wait-time 1) (with-valve docks (print (list 'urgent (now))) (wait-time 1))))
         nil",
        "(b stops)\n(urgent 2.0)\n(a 5.0)\n(b 5.0)\n=> nil",
    );
    // A place that becomes free meanwhile is taken at once, and the interrupted goes on with its own.
    check(
        "(def-valve docks 2)
         (par (with-valve docks (wait-time 2))
              (with-valve docks
                (on-interrupt (wait-time 4) (on-resume (print (list 'goes-on (now))) (wait-time 9))))
              (with-priority 1 (wait-time 1) (with-valve docks (print (list 'urgent (now))) (wait-time 9))))
         (now)",
        "(urgent 2.0)\n(goes-on 5.0)\n=> 11.0",
    );
    // Two that are urgent interrupt two.
    check(
        "(def-valve docks 2)
         (def-plan hold (name)
           (with-valve docks (on-interrupt (seq (print (list name 'stops)) (wait-time 1)) (wait-time 5))))
         (def-plan take (name) (with-priority 1 (wait-time 1) (with-valve docks (print (list name (now))) (wait-time 1))))
         (par (hold 'a) (hold 'b) (take 'c) (take 'd))
         (now)",
        "(b stops)\n(a stops)\n(c 2.0)\n(d 2.0)\n=> 5.0",
    );
}

/// r[valve.places-circle]
#[test]
fn a_circle_is_told_only_if_no_place_can_be_given_back() {
    check(
        "(def-valve docks 2) (def-valve arm)
         (par (with-valve arm (wait-time 1) (with-valve docks (print (list 'both (now)))))
              (with-valve docks (wait-time 1) (with-valve arm (print (list 'arm (now)))))
              (with-valve docks (wait-time 3)))
         nil",
        "(both 3.0)\n(arm 3.0)\n=> nil",
    );
    check(
        "(def-valve docks 2) (def-valve arm)
         (with-failure-handling ((deadlock () (print (list 'deadlock (now)))))
           (par (loop (wait-time 1))
                (with-valve arm (wait-time 2) (with-valve docks nil))
                (with-valve docks (wait-time 1) (with-valve arm nil))
                (with-valve docks (wait-time 1) (with-valve arm nil))))
         nil",
        "(deadlock 2.0)\n=> nil",
    );
    // An owner that was interrupted goes on with another place.
    let interrupted = |other: &str| {
        run(&format!(
            "(def-valve docks 2) (def-valve arm)
             (with-failure-handling ((deadlock () (print (list 'deadlock (now)))))
               (par (with-valve docks {other})
                    (with-valve docks (with-priority 1 (with-valve arm (wait-time 2))) (print (list 'low (now))))
                    (with-priority 1 (wait-time 1) (with-valve docks (with-valve arm (print (list 'both (now))))))))
             nil"
        ))
    };
    assert_eq!(interrupted("(wait-time 3)"), "(both 3.0)\n(low 3.0)\n=> nil");
    assert_eq!(interrupted("(wait-time 0.5) (with-priority 1 (with-valve arm nil))"), "(deadlock 1.0)\n=> nil");
}

/// r[valve.timeout], r[valve.dead], r[valve.places]
#[test]
fn a_place_is_waited_for_so_long_and_given_back_however_its_owner_ends() {
    check(
        "(def-valve docks 2)
         (par (with-valve docks (wait-time 3)) (with-valve docks (wait-time 2))
              (ignore-failures (timeout) (with-valve docks :timeout 1 (print 'never)))
              (with-valve docks :timeout 2 (print (list 'in-time (now)))))
         nil",
        "(in-time 2.0)\n=> nil",
    );
    check(
        "(def-valve docks 2)
         (def-plan p ()
           (par (:tag one (with-valve docks (evap-protect (wait-time 9) (wait-time 1) (print 'cleaned))))
                (with-valve docks (wait-time 9))
                (with-valve docks (print (list 'next (now))))
                (seq (wait-time 1) (evaporate one))))
         (p) nil",
        "cleaned\n(next 2.0)\n=> nil",
    );
}

/// r[swap.valves], r[valve.places-borrow]
#[test]
fn a_task_with_another_plan_keeps_the_place_it_had() {
    check(
        "(def-valve docks 2)
         (def-plan p ()
           (par (:tag worker (with-valve docks (wait-time 9)))
                (with-valve docks (wait-time 4))
                (seq (wait-time 2) (with-valve docks (print (list 'waited (now)))))
                (seq (wait-time 1)
                     (swap-plan worker '(seq (print (holds-valve? docks)) (wait-time 5)) :keep (docks)))))
         (p) (now)",
        "t\n(waited 4.0)\n=> 6.0",
    );
}
