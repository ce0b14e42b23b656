//! The prelude's macros.

use crate::evaluate::{check, check_failures, evaluate};

/// r[control.conditions]
#[test]
fn conditions() {
    check(&[
        ("(list (when t 1 2) (when nil 1) (unless nil 1 2) (unless t 1) (when t))", "(2 nil 2 nil nil)"),
        ("(defun f (x) (cond ((< x 0) 'negative) ((= x 0)) ((= x 1) 'x 'one) (t 'many))) (map f '(-1 0 1 2))", "(negative t one many)"),
        ("(list (cond) (cond (nil 1)) (cond (nil 1) (else 2)) (cond (5)) (cond (nil) (t)))", "(nil nil 2 5 t)"),
        ("(defun f (x) (case x (a 1) ((b 2) 'two) (\"s\" 'string) (1.5 'float) (nil 'never) ((nil) 'empty) (otherwise 'other)))
          (list (f 'a) (f 'b) (f 2) (f \"s\") (f 1.5) (f nil) (f 2.0))", "(1 two two string float empty other)"),
        ("(list (case 1 (2 3)) (case 1 (t 5)) (case 1) (case 1 (1)))", "(nil 5 nil nil)"),
        ("(let ((n 0)) (case (incf n) (2 'two) (1 (list 'one n))))", "(one 1)"),
        ("(when t (let () 1))", "1"),
        // An empty list passes through a macro.
        ("(when t ((lambda () 2)))", "2"),
        ("(when t (with-failure-handling ((failure () 3)) (fail)))", "3"),
        ("(when t (with-failure-handling () 4))", "4"),
    ]);
    check_failures(&[
        ("(cond (t 1) (nil 2))", "only the last test may be `t` or `else`"),
        ("(cond 5)", "this is not of the form `(cond (TEST FORM...)...)`"),
        ("(case 1 (otherwise 1) (2 3))", "only the last clause may be `otherwise`"),
    ]);
}

#[test]
fn loops() {
    check(&[
        ("(let ((n 0)) (while (< n 5) (incf n)) n)", "5"),
        ("(let ((n 0)) (while t (incf n) (when (= n 3) (return n))))", "3"),
        ("(let ((sum 0)) (dolist (x '(1 2 3)) (incf sum x)) sum)", "6"),
        ("(dolist (x '(1 2 3)) x)", "nil"),
        ("(let ((sum 0)) (dolist (x '(1 2 3) (list sum x)) (incf sum x)))", "(6 nil)"),
        ("(dolist (x '(1 2 3) 'none) (when (evenp x) (return x)))", "2"),
        (
            "(map (lambda (f) (f)) (let ((all nil)) (dolist (x '(1 2 3) (reverse all)) (push (lambda () x) all))))",
            "(1 2 3)",
        ),
        ("(let ((l nil)) (dotimes (i 3) (push i l)) l)", "(2 1 0)"),
        ("(let ((n 2) (l nil)) (dotimes (i (incf n) (list i l n)) (push i l)))", "(3 (2 1 0) 3)"),
        ("(dotimes (i 10 'none) (when (= i 4) (return i)))", "4"),
        ("(dotimes (i -1 'done))", "done"),
        ("(let ((n 0)) (list (dotimes (i 32768 i) (incf n)) (dotimes (i 32767 i) (incf n)) n))", "(32768 32767 65535)"),
        ("(dotimes (i 9000000000000 'never) (when (= i 3) (return i)))", "3"),
        ("(dotimes (i -9223372036854775808 'none))", "none"),
        (
            "(map (lambda (f) (f)) (let ((all nil)) (dotimes (i 3 all) (push (lambda () (incf i 10)) all))))",
            "(12 11 10)",
        ),
        ("(dotimes (i 3))", "nil"),
        ("(let ((n 0)) (dotimes (i 2.5) (incf n)) n)", "3"),
        ("(let ((i 0.5)) (loop while (< i 3) (setq i (+ i 1))) i)", "3.5"),
        ("(let ((i 0) (end 2.5)) (loop while (< i end) (setq i (+ i 1))) i)", "3"),
        (
            "(let ((i 0) (n 0)) (loop while (< i 9) (incf n) (if (= i 3) (setq i 7) (setq i (+ i 1)))) (list i n))",
            "(9 6)",
        ),
        ("(let ((n 0)) (n-times 4 (incf n)) n)", "4"),
        ("(let ((n 0)) (n-times 4 (incf n) until (= n 2)) n)", "2"),
        ("(let ((rest '(1 2)) (list 'x) (n 0)) (dolist (e rest n) (incf n e)))", "3"),
    ]);
    check_failures(&[
        ("(dolist (x) x)", "this is not of the form `(dolist (NAME LIST [RESULT]) FORM...)`"),
        ("(dotimes 5 1)", "this is not of the form `(dotimes (NAME COUNT [RESULT]) FORM...)`"),
        ("(dolist (x 5) x)", "type-error"),
        ("(let ((i 9223372036854775807)) (loop while (< i 1.0e19) (setq i (+ i 1))))", "integer overflow in +"),
        ("(let ((i 0) (end 5)) (loop while (< i end) (setq end 'a) (setq i (+ i 1))))", "an operand of a comparison"),
        // A macro that fails does not keep the next one from being expanded.
        ("(dolist 5) (dotimes 5)", "`(dotimes (NAME COUNT [RESULT]) FORM...)`"),
    ]);
}

/// r[setf.places]
#[test]
fn changing_places() {
    check(&[
        ("(let ((x 1)) (list (incf x) (incf x 5) (decf x) (decf x 2.5) x))", "(2 7 6 3.5 3.5)"),
        ("(let ((n 0) (l (list 1 2 3))) (incf (nth (incf n) l) 10) (list n l))", "(1 (1 12 3))"),
        ("(let ((f (create-fluent 1))) (incf (value f)) (decf (value f) 5) (value f))", "-3"),
        ("(let ((l nil)) (list (push 1 l) (push 2 l) (pop l) l (pop l) (pop l) l))", "((1) (2 1) 2 (1) 1 nil nil)"),
        ("(let ((n 0) (l (list nil nil))) (push 'x (nth (incf n) l)) (list n l))", "(1 (nil (x)))"),
        ("(let ((n -1) (l (list (list 1 2)))) (list (pop (nth (incf n) l)) n l))", "(1 0 ((2)))"),
        ("(let ((l '(1))) (pushnew 1 l) (pushnew 2 l) l)", "(2 1)"),
        ("(let ((n 0)) (list (prog1 n (incf n)) n))", "(0 1)"),
        ("(destructuring-bind (a &optional (b 9) &rest more) '(1 2 3 4) (list a b more))", "(1 2 (3 4))"),
        ("(destructuring-bind (a &optional (b 9)) '(1) (list a b))", "(1 9)"),
    ]);
}

/// r[propagate.together]
#[test]
fn several_fluents_are_assigned_as_one() {
    check(&[
        (
            "(def-fluent left 1) (def-fluent right 0) (defvar seen nil)
             (with-policy (whenever (/= (+ left right) 1) (push (list (value left) (value right)) seen))
               (seq (wait-time 1) (setf-together (value left) 0 (value right) 1) (wait-time 1)))
             (list seen (value left) (value right))",
            "(nil 0 1)",
        ),
        // What is assigned one after the other is seen one after the other.
        (
            "(def-fluent left 1) (def-fluent right 0) (defvar seen nil)
             (with-policy (whenever (/= (+ left right) 1) (push (list (value left) (value right)) seen))
               (seq (wait-time 1) (setf (value left) 0 (value right) 1) (wait-time 1)))
             seen",
            "((0 0))",
        ),
        // All values are computed first; of a fluent that is named twice the last one counts.
        (
            "(let ((a (create-fluent 1)) (b (create-fluent 2)))
               (list (setf-together (value a) (value b) (value b) (value a)) (value a) (value b)))",
            "(1 2 1)",
        ),
        ("(let ((a (create-fluent 1))) (setf-together (value a) 2 (value a) 3) (value a))", "3"),
        (
            "(def-fluent a nil) (def-fluent b nil)
             (par (seq (wait-for a) (list 'a (value b))) (seq (wait-time 1) (setf-together (value a) t (value b) 'there)) (wait-for b))",
            "there",
        ),
    ]);
    check_failures(&[
        ("(let ((x 1)) (setf-together x 2))", "this is not of the form `(setf-together (value FLUENT) VALUE...)`"),
        ("(setf-together)", "this is not of the form `(setf-together (value FLUENT) VALUE...)`"),
        ("(setf-together (value 5) 2)", "type-error: what is assigned must be a fluent"),
        ("(def-fluent f 1) (setf-together (value f) 2 (value (fluent (+ f 1))) 2)", "a network cannot be assigned"),
    ]);
}

/// r[handle.parts]
#[test]
fn parts_of_a_failure_are_handled_by_their_classes() {
    let text = |clauses: &str, failures: &str| {
        format!(
            "(def-failure slipped (plan-failure) (item)) (def-failure lost (plan-failure) ())
             (with-failure-handling ((composite-failure (f) (list (failure-message f) (map failure-message (failure-parts f)))))
               (with-parts-handled ({clauses}) {failures}))"
        )
    };
    let two = "(try-all (seq (wait-time 2) (fail slipped \"b\")) (seq (wait-time 1) (fail slipped \"a\")))";
    let mixed = "(try-all (fail slipped \"a\") (fail lost \"b\") (try-all (fail slipped \"c\") (fail timeout \"d\")))";
    let clause = "(slipped (all) (map failure-message all))";
    for (clauses, failures, expected) in [
        // All of the class are taken at once, in their order.
        (clause, two, "(\"a\" \"b\")"),
        // The rest goes on; parts of parts are parts.
        (clause, mixed, "(\"2 left of its parts\" (\"b\" \"d\"))"),
        ("(slipped () 1) ((lost timeout) (all) (length all))", mixed, "2"),
        // The first clause that fits takes a part, and one without parts is not run.
        ("(plan-failure (all) (list 'first (length all))) (slipped () 'second) (timeout () nil)", mixed, "nil"),
        ("(timeout () 'never)", two, "(\"all 2 ways failed\" (\"a\" \"b\"))"),
        // One failure is one part; what is no part of anything goes on as it is.
        (clause, "(fail slipped \"a\")", "(\"a\")"),
        (clause, "(with-failure-handling ((timeout () 'late)) (fail timeout \"t\"))", "late"),
        (clause, "'well", "well"),
        // A clause that fails adds its failure to what is left.
        ("(slipped () (fail \"again\")) (lost () 'lost)", mixed, "(\"2 left of its parts\" (\"d\" \"again\"))"),
        ("(slipped () (/ 1 0))", "(fail slipped)", "(\"1 left of its parts\" (\"division by zero\"))"),
    ] {
        let text = text(clauses, failures);
        check(&[(text.as_str(), expected)]);
    }
    check(&[(
        // The clauses may start the forms again.
        "(let ((n 0)) (with-parts-handled ((timeout () (if (< n 3) (retry) n))) (incf n) (try-all (fail timeout) (fail timeout))))",
        "3",
    )]);
    check_failures(&[
        ("(with-parts-handled ((timeout () 1)) (fail \"other\"))", "plan-failure: other"),
        ("(with-parts-handled ((no-such-class () 1)) 2)", "there is no failure class `no-such-class`"),
        ("(with-parts-handled (timeout) 2)", "this is not of the form `(with-parts-handled"),
    ]);
}

/// r[goal.words]
#[test]
fn goals_have_words() {
    let goals = "(def-goal (achieve (the ?object on ?place)) (list ?object 'lies ?place))
                 (def-goal (achieve (the ?object in ?place)) (list ?object 'within ?place))
                 (def-goal (achieve (the ?object on floor)) (list ?object 'fell))
                 (def-goal (achieve (in room)) (list 'at room))
                 (def-goal (achieve (in ?room quickly)) (fail \"no\"))
                 (def-goal (achieve (in ?place quickly)) (list 'ran ?place))";
    let check = |goal: &str, expected: &str| {
        // Goals may stand above and below what achieves them.
        assert_eq!(evaluate(&format!("{goals} (let ((table 't1) (on 'never)) {goal})")).as_deref(), Ok(expected));
        assert_eq!(
            evaluate(&format!("(def-plan all () (let ((table 't1) (on 'never)) {goal})) {goals} (all)")).as_deref(),
            Ok(expected)
        );
    };
    check("(achieve (the 'cup on table))", "(cup lies t1)");
    check("(achieve (the (car '(cup)) in (list 'the table)))", "(cup within (the t1))");
    // The goal with most words is meant.
    check("(achieve (the 'cup on floor))", "(cup fell)");
    check("(achieve (in 'hall))", "(at hall)");
    check("(achieve (in 'hall quickly))", "(ran hall)");
    check("(execute-plan '(achieve (the 'cup on 'shelf)))", "(cup lies shelf)");
    let failures = [
        ("(achieve (the 'cup under table))", "no goal is like `(the 'cup under table)`"),
        ("(achieve (the 'cup under table))", "there is `(the ? on ?)`, `(the ? in ?)`, `(the ? on floor)`"),
        ("(achieve (the 'cup))", "no goal is like `(the 'cup)`"),
        ("(achieve (the 'cup onn table))", "did you mean `on` for `onn`? there is `(the ? on ?)`"),
        ("(def-goal (achieve (the ?a |on top|)) 1)", "where names are words among parameters"),
        ("(achieve)", "this is not of the form `(achieve (NAME ARGUMENT...))`"),
        ("(def-goal (achieve (the ?a 5)) 1)", "where names are words among parameters that begin with `?`"),
        ("(def-goal (achieve (the ?a on &optional ?b)) 1)", "where names are words among parameters"),
    ];
    for (text, part) in failures {
        let text = format!("{goals} {text}");
        check_failures(&[(text.as_str(), part)]);
    }
}

/// r[goal.undefined]
#[test]
fn a_goal_that_nothing_defines_is_one_error() {
    let told = |text: &str| {
        let fault = evaluate(text).expect_err(text);
        (fault.matches("error[").count(), fault)
    };
    let goals = "(def-goal (achieve (clean room)) room)";
    for (text, parts) in [
        (
            "(achieve (the cup on table))",
            &[
                "error[unknown-goal]: no goal is like `(the cup on table)`",
                "`(def-goal (achieve (the PARAMETER...)) FORM...)`",
            ][..],
        ),
        ("(def-plan p () (achieve (the cup on table))) (p)", &["no goal is like `(the cup on table)`"]),
        ("(achieve (claen hall))", &["no goal is like `(claen hall)`", "did you mean `clean`?"]),
        ("(achieve (shut))", &["no goal is like `(shut)`"]),
    ] {
        let (count, fault) = told(&format!("{goals}\n{text}"));
        assert_eq!(count, 1, "{fault}");
        assert!(parts.iter().all(|part| fault.contains(part)), "{fault}");
    }
    // What is no element by itself is told.
    assert_eq!(told("(achieve (the (cup) on table))").0, 2);
    assert_eq!(told("(achieve (the cup)) (print cop)").0, 2);
    // The plan may be there otherwise.
    assert_eq!(evaluate("(def-plan achieve-order (x) x) (achieve (order 1))").as_deref(), Ok("1"));
}

/// r[valve.timeout]
#[test]
fn a_valve_is_waited_for_so_long() {
    check(&[
        (
            "(def-valve arm)
             (par (with-valve arm (wait-time 10))
                  (with-failure-handling ((timeout (f) (list (failure-message f) (failure-slot f 'seconds) (now))))
                    (with-valve arm :timeout 3 'never)))",
            "(\"the valve `arm` was not given within 3 s\" 3.0 3.0)",
        ),
        // The forms take as long as they take.
        (
            "(def-valve arm) (par (with-valve arm (wait-time 2)) (with-valve arm :timeout 3 (wait-time 10) (now)))",
            "12.0",
        ),
        ("(def-valve arm) (with-valve arm :timeout 0 (wait-time 1) (now))", "1.0"),
        // Given in the very instant, it is given in time.
        ("(def-valve arm) (par (with-valve arm (wait-time 3)) (with-valve arm :timeout 3 (now)))", "3.0"),
        (
            "(def-valve arm) (par (seq (wait-time 0) (with-valve arm :timeout 3 (now))) (with-valve arm (wait-time 3)))",
            "nil",
        ),
        // The line moves up, and nothing is held.
        (
            "(def-valve arm)
             (par (with-valve arm (wait-time 5))
                  (ignore-failures (timeout) (with-valve arm :timeout 2 nil))
                  (seq (wait-time 1) (with-valve arm (now))))",
            "5.0",
        ),
        (
            "(def-valve arm)
             (list (par (with-valve arm (wait-time 5)) (ignore-failures (timeout) (with-valve arm :timeout 2 nil)))
                   (holds-valve? arm) (with-valve arm :timeout 1 'free))",
            "(nil nil free)",
        ),
        // Whoever already has it does not wait.
        ("(def-valve arm) (with-valve arm (with-valve arm :timeout 0 'borrowed))", "borrowed"),
    ]);
    check_failures(&[
        (
            "(def-valve arm) (with-valve arm :timeout 'soon nil)",
            "`:timeout` of `with-valve` must be a number of seconds",
        ),
        ("(def-valve arm) (with-valve arm :timeout)", "(with-valve VALVE [:timeout SECONDS] FORM...)"),
        (
            "(def-valve arm) (par (with-valve arm (wait-time 9)) (with-valve arm :timeout 1 nil))",
            "timeout: the valve `arm` was not given within 1 s",
        ),
    ]);
}

#[test]
fn failing() {
    check(&[
        ("(assert (= 1 1))", "nil"),
        ("(with-failure-handling ((plan-failure (f) (list (failure-class f) (failure-message f)))) (fail \"~a left\" 3))", "(plan-failure \"3 left\")"),
        ("(def-failure lost () (place))
          (with-failure-handling ((lost (f) (list (failure-message f) (failure-slot f 'place)))) (fail lost \"at ~a ~s\" 1 \"x\" :place 'hall))",
         "(\"at 1 \\\"x\\\"\" hall)"),
        ("(with-failure-handling ((unreachable (f) (failure-slot f 'destination))) (fail unreachable :destination 5))", "5"),
        ("(let ((format 1)) (ignore-failures (timeout) (fail timeout \"~a\" format)))", "nil"),
        ("(let ((m \"message ~a\")) (with-failure-handling ((failure (f) (failure-message f))) (fail plan-failure m 1)))", "\"message 1\""),
        ("(ignore-failures (arithmetic-error) 5)", "5"),
        ("(ignore-failures (arithmetic-error) (/ 1 0))", "nil"),
        ("(ignore-failures (timeout error) (/ 1 0))", "nil"),
        ("(ignore-failures () 1 2)", "2"),
        // r[handle.persist]
        ("(let ((n 0)) (persist (> n 2) () (incf n)) n)", "3"),
        ("(persist 'held () (fail \"it is held already\"))", "held"),
        ("(let ((n 0)) (persist (> n 2) (arithmetic-error) (incf n) (/ 1 0)) n)", "3"),
        ("(let ((n 0)) (persist (> n 1) (error) (incf n) (try-in-order (/ 1 0) (car 1))) n)", "2"),
    ]);
    check_failures(&[
        ("(assert (= 1 2))", "plan-failure: this should be true: (= 1 2)"),
        ("(assert nil \"~a is wrong\" 5)", "plan-failure: 5 is wrong"),
        ("(fail)", "plan-failure: failed"),
        ("(fail timeout \"late\")", "timeout: late"),
        ("(fail no-such-class \"x\")", "there is no failure class `no-such-class`"),
        ("(fail timeout \"late\" :colour 1)", "the class `timeout` has no slot `colour`"),
        ("(ignore-failures (timeout) (/ 1 0))", "arithmetic-error"),
        ("(persist nil (timeout) (/ 1 0))", "arithmetic-error"),
        ("(persist nil (arithmetic-error) (try-in-order (/ 1 0) (fail \"no\")))", "composite-failure"),
    ]);
}

#[test]
fn trying() {
    check(&[
        ("(try-in-order (fail \"a\") 2 (fail \"c\"))", "2"),
        ("(try-in-order nil 2)", "nil"),
        (
            "(with-failure-handling ((composite-failure (f) (map failure-message (failure-parts f)))) (try-in-order (fail \"a\") (/ 1 0)))",
            "(\"a\" \"division by zero\")",
        ),
        ("(with-failure-handling ((composite-failure (f) (failure-parts f))) (try-in-order))", "nil"),
        ("(try-each-in-order (x '(1 2 3)) (if (evenp x) (* x 10) (fail \"odd\")))", "20"),
        (
            "(with-failure-handling ((composite-failure (f) (map failure-message (failure-parts f))))
            (try-each-in-order (x '(1 2)) (fail \"not ~a\" x)))",
            "(\"not 1\" \"not 2\")",
        ),
        ("(with-failure-handling ((composite-failure (f) (failure-parts f))) (try-each-in-order (x nil) x))", "nil"),
        ("(let ((tries 0)) (dolist (y '(1)) (try-each-in-order (x '(1 2 3)) (incf tries) (return))) tries)", "1"),
        // `retry` inside an alternative belongs to the handler around the whole.
        (
            "(let ((n 0))
            (with-failure-handling ((timeout (f) (try-in-order (if (< (incf n) 3) (retry) (list 'done n)))))
              (fail timeout \"x\")))",
            "(done 3)",
        ),
        ("(let ((clean nil)) (list (try-in-order (unwind-protect (fail \"a\") (push 'x clean)) 2) clean))", "(2 (x))"),
    ]);
}

#[test]
fn retrying() {
    check(&[
        // Three retries are four tries.
        (
            "(let ((tries 0))
            (with-retry-counters ((again 3))
              (with-failure-handling ((plan-failure (f) (do-retry again (retry)) (list 'gave-up tries)))
                (incf tries)
                (fail \"no\"))))",
            "(gave-up 4)",
        ),
        (
            "(let ((tries 0))
            (with-retry-counters ((again 3))
              (with-failure-handling ((plan-failure (f) (do-retry again (retry))))
                (when (< (incf tries) 3) (fail \"no\"))
                tries)))",
            "3",
        ),
        ("(with-retry-counters ((c 0)) (do-retry c 5))", "nil"),
        ("(with-retry-counters ((c 1)) (list (do-retry c 5) (do-retry c 5)))", "(5 nil)"),
    ]);
}

#[test]
fn policies() {
    check(&[
        // The first policy ranks highest and starts first.
        ("(let ((l nil)) (with-policies ((push 'a l) (push 'b l)) (push 'c l)) (reverse l))", "(a b c)"),
        ("(with-policies () 1 2)", "2"),
        ("(with-policies ((wait-time 100)) (wait-time 1) 'done)", "done"),
    ]);
    check_failures(&[("(with-policies ((fail \"policy\")) 5)", "plan-failure: policy")]);
}

/// r[def.goal]
#[test]
fn goals() {
    check(&[(
        "(def-goal (achieve (at-place ?robot ?place)) \"Drives.\" (list ?robot 'at ?place)) (achieve (at-place 'r1 (+ 1 2)))",
        "(r1 at 3)",
    )]);
    check_failures(&[
        ("(achieve (no-such-goal 1))", "no goal is like `(no-such-goal 1)`"),
        ("(def-goal wrong 1)", "this is not of the form `(def-goal (achieve (NAME PARAMETER...)) FORM...)`"),
    ]);
}

#[test]
fn networks_use_the_library() {
    check(&[
        (
            "(let ((a (create-fluent 1)) (b (create-fluent -1)))
            (par (wait-for (every plusp (list a b)))
                 (seq (wait-time 1) (setf (value b) 2)))
            (now))",
            "1.0",
        ),
        (
            "(let ((f (create-fluent 'off)))
            (par (wait-for (case f ((on half) t) (otherwise nil))) (seq (wait-time 2) (setf (value f) 'on)))
            (now))",
            "2.0",
        ),
        (
            "(let ((f (create-fluent nil)))
            (par (wait-for (equal (sort < (map abs f)) '(1 2))) (seq (wait-time 1) (setf (value f) '(-2 1))))
            (now))",
            "1.0",
        ),
        // A network that fails does so for those that wait for it, each time.
        (
            "(let ((f (create-fluent 0)))
            (list (ignore-failures (error) (wait-for (/ 1 f)))
                  (ignore-failures (error) (wait-for (/ 2 f)))
                  (progn (setf (value f) 2) (wait-for (/ 4 f)))))",
            "(nil nil 2)",
        ),
    ]);
    check_failures(&[
        ("(let ((f (create-fluent 0))) (wait-for (let ((x f)) (incf x))))", "a fluent network cannot assign"),
        (
            "(let ((f (create-fluent 0)) (h (make-hash-table))) (wait-for (remhash f h)))",
            "`remhash` cannot stand in a fluent network",
        ),
    ]);
}

/// r[eval.redefine]
#[test]
fn the_library_keeps_its_own_meaning() {
    check(&[
        (
            "(defun filter (l) 'mine) (defun reverse (l) 'mine) (list (filter 1) (remove-if-not evenp '(1 2)) (cond (nil 1) (t 2)))",
            "(mine (2) 2)",
        ),
        // Names of plans that are functions elsewhere do not reach into expansions.
        (
            "(let ((list '(1)) (reverse 1) (first 2) (length 3) (append 4) (format 5))
            (push 5 list)
            (dolist (x list) (incf length (cond ((= x 1) first) (t 0))))
            (ignore-failures (plan-failure) (fail plan-failure \"~a\" format))
            (cons length list))",
            "(5 5 1)",
        ),
    ]);
}

/// r[loop.words]
#[test]
fn a_loop_is_left_at_its_first_test_whatever_that_looks_at() {
    check(&[
        ("(let ((i 0)) (loop while (and (< i 10) (<= (* i i) 20)) (setq i (+ i 1))) i)", "5"),
        ("(let ((i 0)) (loop while (and (< i 3) (<= (* i i) 20)) (setq i (+ i 1))) i)", "3"),
        ("(let ((i 0)) (loop while (< 10 i) (setq i (+ i 1))) i)", "0"),
        ("(let ((i 9)) (loop while (> i 2) (setq i (- i 3))) i)", "0"),
        ("(let ((i 9)) (loop while (>= i 3) (setq i (- i 3))) i)", "0"),
        ("(let ((i 9) (n 4)) (loop while (<= n i) (setq i (- i 1.5))) i)", "3.0"),
        ("(let ((i 0)) (loop while (/= i 4) (setq i (+ i 1))) i)", "4"),
        ("(let ((at '(1 2 3)) (sum 0)) (loop while at (setq sum (+ sum (pop at)))) sum)", "6"),
        ("(let ((is-done nil) (n 0)) (loop while (not is-done) (incf n) (when (> n 3) (setq is-done t))) n)", "4"),
        ("(let ((n 0) (m 0)) (loop while (< n 5) (incf n) until (= n 3) (incf m)) (list n m))", "(3 2)"),
        ("(let ((n 0)) (loop while (< n 5) (incf n) (when (= n 2) (return 'early))))", "early"),
        // A captured variable lives in a cell, and is looked at anew.
        ("(let ((n 0)) (let ((more (lambda () (incf n)))) (loop while (< n 5) (more))) n)", "5"),
        ("(let ((n 0) (turns 0)) (loop while (< n (- +inf.0 +inf.0)) (incf turns)) turns)", "0"),
    ]);
    check_failures(&[
        (
            "(let ((i 0)) (loop while (< i 3) (setq i 'three)))",
            "an operand of a comparison must be a number, and it is the symbol three",
        ),
        (
            "(let ((i 0)) (loop while (/= i 3) (setq i 'three)))",
            "an operand of `/=` must be a number, and it is the symbol three",
        ),
        (
            "(let ((i 9)) (loop while (>= i 3) (setq i nil)))",
            "an operand of a comparison must be a number, and it is nil",
        ),
    ]);
}

/// r[eval.tail], r[eval.scope]
#[test]
fn local_functions_call_one_another_and_themselves() {
    check(&[
        (
            "(labels ((even? (n) (if (= n 0) t (odd? (- n 1)))) (odd? (n) (if (= n 0) nil (even? (- n 1))))) (list (even? 200000) (odd? 7)))",
            "(t t)",
        ),
        // What is around them, before them and behind them.
        (
            "(let ((a 1) (b 2) (c 3)) (labels ((f (n) (if (= n 0) (list a b c) (g (- n 1)))) (g (n) (setq a (+ a n)) (h n)) (h (n) (f n))) (f 3)))",
            "(4 2 3)",
        ),
        // One that is assigned anew is called anew by the others.
        (
            "(labels ((f (n) (if (= n 0) 'old (g (- n 1)))) (g (n) (f n))) (let ((before (f 2))) (setq f (lambda (n) (list 'new n))) (list before (g 5))))",
            "(old (new 5))",
        ),
        // They outlive the form, and each run of it makes its own.
        (
            "(defun counter (n) (labels ((next () (setq n (+ n 1)) (self)) (self () n)) next)) (let ((one (counter 0)) (other (counter 10))) (one) (list (one) (other)))",
            "(2 11)",
        ),
        ("(letrec ((f (lambda (n) (if (= n 0) x (f (- n 1))))) (x 7)) (f 3))", "7"),
        (
            "(let ((down (labels ((down (n) (if (= n 0) 'done (funcall down (- n 1))))) down))) (funcall down 1000000))",
            "done",
        ),
    ]);
    // They are found by the collector through one another.
    check(&[(
        "(let ((f (labels ((a (n) (if (= n 0) 'kept (b (- n 1)))) (b (n) (c n)) (c (n) (a n))) c))) (dotimes (i 400000) (list i i i)) (f 5))",
        "kept",
    )]);
}

/// r[eval.arguments]
#[test]
fn operands_of_a_comparison_are_evaluated_in_their_order() {
    for operator in ["<", "<=", ">", ">=", "=", "/=", "eq"] {
        let seen = format!(
            "(let ((seen nil)) (flet ((see (n) (push n seen) n)) (if ({operator} (see 1) (see 2)) 1 2) (let ((value ({operator} (see 3) (see 4)))) seen)))"
        );
        check(&[(&seen, "(4 3 2 1)")]);
    }
    // What stands in a variable is read before the other operand changes it.
    check(&[
        ("(let ((a 3)) (> a (progn (setq a 1) 2)))", "t"),
        ("(let ((a 3)) (if (>= 2 (progn (setq a 1) a)) 'yes 'no))", "yes"),
        ("(let ((a 1)) (if (> a (progn (setq a 3) 2)) 'yes 'no))", "no"),
        ("(let ((a 'x) (b 'x)) (list (if (eq a b) 1 2) (if (eq a (progn (setq b 'y) b)) 1 2)))", "(1 2)"),
        (
            "(let ((a 2) (b 1.5)) (list (> a b) (>= b a) (if (> b a) 1 2) (if (>= a 2) 1 2) (if (> 3 a) 1 2)))",
            "(t nil 2 1 1)",
        ),
    ]);
    check_failures(&[
        (
            "(let ((a 'x) (b 2)) (if (> a b) 1 2))",
            "an operand of a comparison must be a number, and it is the symbol x",
        ),
        ("(let ((a 'x)) (> 2 a))", "an operand of a comparison must be a number, and it is the symbol x"),
    ]);
}

/// r[def.parameters]
#[test]
fn what_stands_where_a_keyword_is_wanted_is_named() {
    let with = |call: &str| format!("(defun wash (cups &key soap water) (list cups soap water)) {call}");
    check_failures(&[
        (
            &with("(wash 3 'green 'cold)"),
            "`wash` takes only keywords with values after its other arguments (`:soap`, `:water`), and here stands the symbol green",
        ),
        (&with("(wash 3 :soop 'green)"), "`wash` has no parameter `:soop`; did you mean `:soap`?"),
        (&with("(wash 3 :heat 40)"), "`wash` has no parameter `:heat`; it has `:soap`, `:water`"),
        (&with("(wash 3 :soap)"), "`:soap` has no value"),
        ("(defun f (&key a) a) (f 1 2)", "`f` takes only keywords with values (`:a`), and here stands the integer 1"),
    ]);
}
