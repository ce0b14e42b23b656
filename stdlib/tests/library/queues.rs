//! Queues: items that have one taker.

use crate::evaluate::{check, check_failures, evaluate};

/// r[queue.first]
#[test]
fn items_come_out_in_the_order_in_which_they_went_in() {
    check(&[
        ("(def-queue q) (dotimes (i 3) (enqueue q i)) (list (dequeue q) (dequeue q) (dequeue q))", "(0 1 2)"),
        (
            "(let ((q (make-queue))) (list (enqueue q 'x) (value (queue-length q)) (dequeue q) (value (queue-length q))))",
            "(x 1 x 0)",
        ),
        ("(def-queue q \"orders\") (enqueue q nil) (dequeue q)", "nil"),
        // Two queues are two, and one is the same wherever it is held.
        (
            "(let ((q (make-queue)) (r (make-queue))) (enqueue q 1) (list (equal q r) (equal q q) (value (queue-length r))))",
            "(nil t 0)",
        ),
    ]);
}

/// r[queue.wait], r[queue.one-taker]
#[test]
fn each_item_has_one_taker_and_the_first_who_came_is_served_first() {
    check(&[
        (
            "(def-queue q) (defvar got nil)
             (par (push (list 'a (dequeue q)) got) (push (list 'b (dequeue q)) got)
                  (seq (wait-time 1) (enqueue q 'x) (wait-time 1) (enqueue q 'y)))
             (reverse got)",
            "((a x) (b y))",
        ),
        // Whoever is more important, the place in line counts.
        (
            "(def-queue q) (defvar got nil)
             (par (push (list 'a (dequeue q)) got)
                  (seq (wait-time 1) (with-priority 5 (push (list 'b (dequeue q)) got)))
                  (seq (wait-time 2) (enqueue q 'x) (wait-time 1) (enqueue q 'y)))
             (reverse got)",
            "((a x) (b y))",
        ),
        // What is enqueued in one instant goes to as many takers.
        (
            "(def-queue q)
             (par-map (i (range 0 4)) (if (= i 3) (dotimes (n 3) (enqueue q n)) (assert (= (dequeue q) i))))
             (value (queue-length q))",
            "0",
        ),
    ]);
}

/// r[queue.if]
#[test]
fn a_predicate_takes_the_first_that_fits_and_leaves_the_others() {
    check(&[
        (
            "(def-queue q) (dolist (n '(1 2 3 4 5)) (enqueue q n))
             (list (dequeue q :if evenp) (dequeue q) (dequeue q :if evenp) (dequeue q) (dequeue q))",
            "(2 1 4 3 5)",
        ),
        (
            "(def-queue q) (defvar got nil)
             (par (push (list 'even (dequeue q :if evenp)) got) (push (list 'any (dequeue q)) got)
                  (seq (wait-time 1) (enqueue q 1) (wait-time 1) (enqueue q 3) (enqueue q 4)))
             (list (reverse got) (dequeue q))",
            "(((any 1) (even 4)) 3)",
        ),
        // A predicate that fails is the failure of whoever takes.
        (
            "(def-queue q)
             (par (seq (wait-time 1) (enqueue q 'x))
                  (with-failure-handling ((type-error () 'refused)) (dequeue q :if evenp)))",
            "refused",
        ),
        (
            "(def-queue q)
             (par (seq (wait-time 1) (enqueue q 'x) (dequeue q))
                  (with-failure-handling ((network-error () 'refused)) (dequeue q :if (lambda (x) (wait-time 1)))))",
            "refused",
        ),
    ]);
    check_failures(&[
        ("(dequeue (make-queue) :for 'x)", "behind the queue of `dequeue` stands `:if` and a function, or nothing"),
        ("(dequeue '(1 2))", "type-error"),
        ("(enqueue 5 1)", "type-error"),
    ]);
}

/// r[queue.bound]
#[test]
fn a_queue_that_is_full_lets_wait() {
    check(&[
        (
            "(def-queue q :most 2) (defvar put nil)
             (par (dotimes (i 5) (enqueue q i) (push (list i (now)) put))
                  (seq (wait-time 1) (dequeue q) (wait-time 1) (dequeue q) (wait-time 1) (dequeue q)))
             (list (reverse put) (value (queue-length q)) (dequeue q) (dequeue q))",
            "(((0 0.0) (1 0.0) (2 1.0) (3 2.0) (4 3.0)) 2 3 4)",
        ),
        // Who gives up waiting for room leaves nothing behind.
        (
            "(def-queue q :most 1) (enqueue q 1)
             (ignore-failures (timeout) (with-timeout 1 (enqueue q 2)))
             (list (dequeue q) (value (queue-length q)))",
            "(1 0)",
        ),
        // What somebody waits for needs no room, and what waits for room can be taken.
        (
            "(def-queue q :most 1) (enqueue q 1)
             (par (enqueue q 4) (enqueue q 3) (seq (wait-time 1) (list (dequeue q :if evenp) (dequeue q) (dequeue q))))",
            "(4 1 3)",
        ),
        (
            "(def-queue q :most 1) (enqueue q 1)
             (par (dequeue q :if evenp) (seq (wait-time 1) (enqueue q 2) (now)))",
            "1.0",
        ),
    ]);
    check_failures(&[
        ("(make-queue :most 0)", "`:most` of a queue must be an integer from 1 on, and it is 0"),
        ("(def-queue q :least 1)", "(def-queue NAME [:most N]"),
    ]);
}

/// r[queue.cut-short]
#[test]
fn a_taker_that_is_cut_short_takes_nothing() {
    check(&[
        // While it waits.
        (
            "(def-queue q)
             (ignore-failures (timeout) (with-timeout 1 (dequeue q)))
             (enqueue q 'x) (dequeue q)",
            "x",
        ),
        // Between being given the item and going on: it goes to the next in line, or back to its place.
        (
            "(def-queue q) (defvar got nil)
             (def-plan give () (par (:tag a (push (list 'a (dequeue q)) got)) (push (list 'b (dequeue q)) got)
                  (seq (wait-time 1) (with-priority 1 (enqueue q 'x) (evaporate a)))))
             (give)
             got",
            "((b x))",
        ),
        (
            "(def-queue q)
             (def-plan give () (par (:tag takers (par (dequeue q) (dequeue q)))
                  (seq (wait-time 1) (with-priority 1 (dotimes (i 4) (enqueue q i)) (evaporate takers)))))
             (give)
             (list (value (queue-length q)) (dequeue q) (dequeue q) (dequeue q) (dequeue q))",
            "(4 0 1 2 3)",
        ),
        // When taking it wakes somebody more important, who ends the taker.
        (
            "(def-queue q)
             (enqueue q 'x)
             (def-plan watched ()
               (with-policy (seq (wait-for (= (queue-length q) 0)) (evaporate a))
                 (par (:tag a (dequeue q)) nil)))
             (watched)
             (dequeue q)",
            "x",
        ),
    ]);
}

/// r[queue.suspended]
#[test]
fn a_taker_that_is_suspended_is_passed_over_and_keeps_its_place() {
    check(&[
        (
            "(def-queue q) (defvar got nil)
             (def-plan serve () (par (:tag a (push (list 'a (dequeue q) (now)) got)) (push (list 'b (dequeue q) (now)) got)
                  (seq (wait-time 1) (suspend a) (enqueue q 'x) (wait-time 1) (enqueue q 'y) (wait-time 1) (resume a))))
             (serve)
             (reverse got)",
            "((b x 1.0) (a y 3.0))",
        ),
        (
            "(def-queue q) (defvar got nil)
             (def-plan serve () (par (:tag a (push (list 'a (dequeue q) (now)) got))
                  (seq (wait-time 2) (push (list 'b (dequeue q) (now)) got))
                  (seq (wait-time 1) (suspend a) (enqueue q 'x) (wait-time 2) (resume a) (wait-time 1) (enqueue q 'y))))
             (serve)
             (reverse got)",
            "((b x 2.0) (a y 4.0))",
        ),
    ]);
}

/// r[queue.given], r[queue.cut-short]
#[test]
fn a_taker_that_is_suspended_with_an_item_keeps_it_until_it_goes_on_or_ends() {
    // A and B wait; A is given X and suspended in the same instant, and something happens to it 5 seconds later.
    let served = |then: &str| {
        let text = format!(
            "(def-queue q) (defvar got nil)
             (def-plan take (name) (let ((item (dequeue q))) (push (list name item (now)) got)))
             (def-plan serve ()
               (par (:tag a (with-failure-handling ((timeout () nil)) (with-timeout 4 :active (take 'a))))
                    (:tag b (seq (wait-time 0.5) (take 'b)))
                    (seq (wait-time 1)
                         (with-priority 1 (seq (enqueue q 'x) (suspend a)))
                         (push (list 'left (value (queue-length q))) got)
                         (wait-time 5)
                         {then})))
             (serve)
             (reverse got)"
        );
        evaluate(&text)
    };
    let is = |list: &str| Ok(list.to_string());
    assert_eq!(served("(resume a) (wait-time 1) (enqueue q 'y)"), is("((left 0) (a x 6.0) (b y 7.0))"));
    assert_eq!(served("(evaporate a)"), is("((left 0) (b x 6.0))"));
    assert_eq!(served("(swap-plan a '(push 'other-plan got)) (resume a)"), is("((left 0) (b x 6.0) other-plan)"));
    // The item goes back before what came later, if nobody else waits.
    check(&[(
        "(def-queue q)
         (def-plan serve ()
           (par (:tag a (ignore-failures (timeout) (with-timeout 3 (dequeue q))))
                (seq (wait-time 1)
                     (with-priority 1 (seq (enqueue q 'x) (enqueue q 'y) (suspend a)))
                     (wait-time 5)
                     (resume a))))
         (serve)
         (list (value (queue-length q)) (dequeue q) (dequeue q))",
        "(2 x y)",
    )]);
}

/// r[queue.length]
#[test]
fn the_length_is_a_fluent() {
    check(&[
        (
            "(def-queue q)
             (par (seq (wait-for (> (queue-length q) 2)) (now))
                  (dotimes (i 4) (wait-time 1) (enqueue q i)))
             (par (whenever (> (queue-length q) 3) (return (now))) nil)",
            "nil",
        ),
        // Nobody sees an item both in the queue and with a taker.
        (
            "(def-queue q) (def-fluent taken 0) (defvar seen nil)
             (pursue (whenever (changed (queue-length q)) :missed :always (push (value (queue-length q)) seen))
               (seq (par (dequeue q) (enqueue q 1)) (enqueue q 2) (wait-time 1)))
             seen",
            "(1)",
        ),
    ]);
    check_failures(&[("(def-queue orders) (dequeue orders)", "main waits for fluent item-of-orders")]);
}

/// r[queue.cost]
#[test]
fn many_items_takers_and_givers_are_no_trouble() {
    check(&[
        // If a turn looked at all items, this would be a runaway.
        (
            "(def-queue q) (dotimes (i 20000) (enqueue q i)) (let ((sum 0)) (dotimes (i 20000) (incf sum (dequeue q))) sum)",
            "199990000",
        ),
        (
            "(def-queue q) (enqueue q 'alarm) (dotimes (i 20000) (enqueue q i))
             (dotimes (i 20000) (dequeue q :if numberp)) (dequeue q)",
            "alarm",
        ),
        (
            "(def-queue q) (defvar sum 0)
             (par (par-map (i (range 0 2000)) (incf sum (dequeue q))) (dotimes (i 2000) (enqueue q i)))
             sum",
            "1999000",
        ),
        (
            "(def-queue q :most 1)
             (par (par-map (i (range 0 2000)) (enqueue q i)) (dotimes (i 2000) (dequeue q)))
             (value (queue-length q))",
            "0",
        ),
        // Given back by all takers.
        (
            "(def-queue q)
             (def-plan all () (par (:tag takers (par-map (i (range 0 2000)) (dequeue q)))
               (seq (wait-time 1) (with-priority 1 (dotimes (i 2000) (enqueue q i)) (evaporate takers)))))
             (all)
             (list (value (queue-length q)) (dequeue q) (dequeue q))",
            "(2000 0 1)",
        ),
    ]);
}
