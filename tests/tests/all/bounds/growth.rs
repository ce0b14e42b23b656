//! What is done twice as often costs about twice as much: told by counted turns of the runtime's own
//! loops, and by the steps of the plan, never by time.

use rpl_runtime::run::system::Progress;
use rpl_tests::{run, system, transcript};

/// Turns of the runtime's loops in a run of a text with `N` in it.
fn work(text: &str, n: usize) -> u64 {
    let text = text.replace('N', &n.to_string());
    let mut system = system(&text);
    while system.advance() == Progress::Running {}
    let result = transcript(&mut system);
    assert!(result.ends_with("=> done"), "{text}\n{result:.300}");
    system.machine.work()
}

/// How many times as much four times the work may cost; twice the logarithm has room in it.
const MOST: u64 = 6;

#[track_caller]
fn grows_slowly(text: &str) {
    let (few, many) = (work(text, 500), work(text, 2_000));
    assert!(many <= few.max(2_000) * MOST, "{text}\n500: {few} turns, 2,000: {many} turns");
}

#[test]
fn clean_ups_that_nest() {
    grows_slowly(
        "(defun nest (n) (if (= n 0) (fail \"x\") (unwind-protect (nest (- n 1)) (seq 1)))) (ignore-failures (failure) (nest N)) 'done",
    );
    grows_slowly(
        "(defun nest (n) (if (= n 0) (wait-time 9) (unwind-protect (nest (- n 1)) (seq 1)))) (pursue (nest N) (wait-time 1)) 'done",
    );
    grows_slowly(
        "(defun nest (n) (if (= n 0) (fail \"x\") (evap-protect (par (nest (- n 1))) (seq 1)))) (ignore-failures (failure) (nest N)) 'done",
    );
}

/// r[value.vectors]
#[test]
fn vectors_and_what_is_sorted_by_a_function() {
    let mixed = "(map (lambda (i) (mod (* i 7919) 10007)) (iota N))";
    grows_slowly(&format!("(sort (lambda (a b) (< a b)) {mixed}) 'done"));
    grows_slowly(&format!("(sort (lambda (a b) (< a b)) (list->vector {mixed}) :key -) 'done"));
    grows_slowly("(let ((v (make-vector N 0))) (dotimes (i N) (setf (vref v i) i)) (dotimes (i N) (vref v i)) 'done)");
    grows_slowly("(let ((v #())) (dotimes (i N) (setq v (vector v))) (equal v v) (format \"~a\" v) 'done)");
}

#[test]
fn plans_that_call_themselves() {
    grows_slowly("(def-plan p (n) (if (> n 0) (p (- n 1)) (par 1))) (p N) 'done");
    grows_slowly("(def-plan p (n) (if (> n 0) (seq (spawn (p (- n 1))) (wait-time 1)) (wait-time 1))) (p N) 'done");
    grows_slowly("(def-plan p (n) (spawn (wait-time 9)) (if (> n 0) (p (- n 1)) 1)) (p N) 'done");
    grows_slowly("(def-plan p (n) (if (> n 0) (execute-plan (list 'p (- n 1))) 1)) (p N) 'done");
    grows_slowly("(defun p (n) (if (> n 0) (execute-plan (list 'seq n (list 'p (- n 1)))) 1)) (p N) 'done");
    grows_slowly(
        "(def-plan p (n) (if (> n 0) (ignore-failures (error) (with-failure-handling ((failure (f) (refail))) (p (- n 1)))) (fail \"x\"))) (ignore-failures (failure) (p N)) 'done",
    );
}

#[test]
fn tasks_that_wait_for_one_thing() {
    let waiters = |condition: &str| {
        format!(
            "(def-fluent f nil) (def-plan p () (dotimes (i N) (spawn (wait-for {condition}))) (wait-time 1) (pulse f) (wait-time 1)) (p) 'done"
        )
    };
    let evaporated = |condition: &str| {
        format!(
            "(def-fluent f nil) (def-plan p () (dotimes (i N) (spawn (wait-for {condition}))) (wait-time 1)) (p) 'done"
        )
    };
    let watching = |condition: &str| {
        format!(
            "(def-fluent f nil) (def-plan p () (dotimes (i N) (spawn (whenever {condition} 1))) (wait-time 1) (pulse f) (wait-time 1)) (p) 'done"
        )
    };
    for condition in ["f", "(pulsed f)", "(changed f)", "(not (not f))", "(> (count-pulses f) 0)"] {
        grows_slowly(&waiters(condition).replace("(pulse f)", "(dotimes (i 10) (pulse f) (wait-time 1))"));
        grows_slowly(&waiters(condition));
        grows_slowly(&evaporated(condition));
        grows_slowly(&watching(condition));
    }
    grows_slowly(
        "(def-plan p () (let ((one (spawn (evap-protect (wait-time 99) (wait-time 1)))))
           (dotimes (i N) (spawn (evaporate one))) (wait-time 0.5)))
         (p) 'done",
    );
    grows_slowly(
        "(def-plan p () (let ((one (spawn (unwind-protect nil (wait-time 2)))))
           (wait-time 0.1) (dotimes (i N) (spawn (suspend one) (resume one))) (wait-time 0.5)))
         (p) 'done",
    );
}

/// r[limit.priorities]
#[test]
fn priorities_that_nest_and_that_are_many() {
    grows_slowly(
        "(defun nest (n) (if (= n 0) (wait-time 1) (with-policy (wait-time 9) (nest (- n 1))))) (nest N) 'done",
    );
    grows_slowly("(defun nest (n) (if (= n 0) (wait-time 1) (with-priority 1 (nest (- n 1))))) (nest N) 'done");
    grows_slowly("(defun nest (n) (if (= n 0) (wait-time 1) (with-priority -1 (nest (- n 1))))) (nest N) 'done");
    grows_slowly("(par-map (n (iota N)) (with-priority n (wait-time 1))) 'done");
    grows_slowly("(dotimes (n N) (with-priority n (wait-time 0.1))) 'done");
    let deep = run("(defun nest (n) (if (= n 0) 1 (with-priority 1 (nest (- n 1))))) (nest 70000)");
    assert!(deep.starts_with("failed: stack-overflow: policies and priorities"), "{deep:.300}");
}

#[test]
fn priorities_that_nobody_has_are_forgotten() {
    let mut system =
        system("(dotimes (n 20000) (with-priority n 1) (list 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20))");
    while system.advance() == Progress::Running {}
    system.machine.collect();
    assert!(system.machine.priorities.len() < 10, "{} priorities are kept", system.machine.priorities.len());
}

/// Steps a text takes, to a thousand.
fn steps(text: &str) -> u32 {
    let enough = |steps: u32| {
        let mut system = system(text);
        system.machine.limits.steps = steps;
        while system.advance() == Progress::Running {}
        !transcript(&mut system).contains("runaway")
    };
    let (mut low, mut high) = (0, 1 << 24);
    while high - low > 1_000 {
        let middle = low + (high - low) / 2;
        if enough(middle) { high = middle } else { low = middle }
    }
    high
}

/// r[limit.steps]
#[test]
fn natives_take_steps_for_what_they_look_at() {
    let with = |n: usize, form: &str| {
        format!(
            "(let ((l (iota {n})) (s (string-repeat \"abcdefgh\" {n})) (h (alist->hash-table (map (lambda (i) (cons (list i) i)) (iota 100))))) (dotimes (i 50) {form}))"
        )
    };
    for form in [
        "(length l)",
        "(member 'x l)",
        "(position 'x l)",
        "(nth 1000000 l)",
        "(last l)",
        "(assoc 'x (map list l))",
        "(remove 1 l)",
        "(substitute 1 2 l)",
        "(reverse l)",
        "(equal l (copy-list l))",
        "(gethash l h)",
        "(adjoin 'x l)",
        "(remove-duplicates l)",
        "(length s)",
        "(string= s s)",
        "(string-search \"x\" s)",
        "(elt s 1)",
        "(string-split s \"x\")",
        "(setf (nth 0 (last l)) 1)",
        "(union l nil)",
        "(flatten l)",
        "(format \"~a\" l)",
        "(print l)",
    ] {
        let (few, many) = (steps(&with(1_000, form)), steps(&with(4_000, form)));
        assert!(many > few * 2, "{form} takes {few} steps for 1,000 elements, {many} for 4,000");
    }
}

#[test]
fn what_is_in_the_way_of_a_plan_ends_one_after_the_other() {
    // The first fence ends first, or last; each begins another one once.
    for ends in ["(+ i 2)", "(- (+ N 2) i)"] {
        grows_slowly(&format!(
            "(def-plan fenced (i) (spawn (seq (no-revision (wait-time i)) (no-revision (wait-time 1)) (wait-time 9))))
             (def-plan p () (dotimes (i N) (fenced {ends})) (wait-time 99999))
             (pursue (:tag job (p)) (seq (wait-time 1) (swap-plan job ''swapped) (wait-time 1)))
             'done"
        ));
    }
}
