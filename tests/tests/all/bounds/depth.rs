//! However deep data, code and tasks nest, the stack of the program's own thread does not grow.

use rpl_lang::compile::NoFiles;
use rpl_runtime::robot::NoRobot;
use rpl_runtime::run::system::{Progress, System};
use rpl_tests::{library, run};
use std::thread;

/// A quarter of what a thread of a test has.
const STACK_BYTES: usize = 512 * 1024;

/// Data nested in the first halves, in both, and in other objects.
const DEEP: &str = "
(defun deep (n) (let ((x 1)) (dotimes (i n) (setq x (list x))) x))
(defun wrapped (head n x) (dotimes (i n) (setq x (list head x))) x)
(defvar million 1000000)
";

fn on_a_small_stack<T: Send + 'static>(act: impl FnOnce() -> T + Send + 'static) -> T {
    library();
    match thread::Builder::new().stack_size(STACK_BYTES).spawn(act).map(thread::JoinHandle::join) {
        Ok(Ok(result)) => result,
        Ok(Err(panic)) => std::panic::resume_unwind(panic),
        Err(error) => panic!("no thread: {error}"),
    }
}

#[track_caller]
fn check(text: &str, expected: &str) {
    let whole = format!("{DEEP}{text}");
    let result = on_a_small_stack(move || run(&whole));
    let shown: String = result.chars().take(500).collect();
    assert!(result.starts_with(expected), "{text}\n{shown}\ndoes not begin with\n{expected}");
}

/// r[limit.nesting]
#[test]
fn calls_of_natives_by_natives_nest_as_deep_as_data() {
    check("(let ((l (list + (list 1 2)))) (dotimes (i million) (setq l (list apply l))) (apply apply l))", "=> 3");
    check("(let ((l (list apply (list + (list 1 2))))) (apply (car l) apply (cdr l)))", "=> 3");
    check("(let ((l (list apply nil))) (setf (nth 1 l) l) (apply apply l))", "failed: runaway");
    check("(let ((l (list apply nil))) (setf (nth 1 l) l) (value (fluent (apply apply l))))", "failed: runaway");
    check("(map apply (list apply) (list (list + (list 1 2))))", "=> (3)");
}

/// r[limit.nesting]
#[test]
fn data_are_compared_printed_and_kept_however_deep_they_nest() {
    check("(equal (deep million) (deep million))", "=> t");
    check("(equal (deep million) (deep (- million 1)))", "=> nil");
    check("(length (write-to-string (deep million)))", "=> 1048");
    check("(print (deep million)) (format \"~a\" (deep million)) 'printed", "((((");
    check(
        "(let ((h (make-hash-table))) (setf (gethash (deep 100000) h) 'found) (gethash (deep 100000) h))",
        "=> found",
    );
    check("(length (remove-duplicates (list (deep 100000) (deep 100000) (deep million) (deep million))))", "=> 2");
    check("(length (flatten (deep million)))", "=> 1");
    check("(member (deep million) (list 1 (deep million)))", "=> ((((");
    check("(fail \"~a\" (deep million))", "failed: plan-failure: ((((");
}

#[test]
fn objects_in_objects_are_collected() {
    let churn = "(dotimes (i million) (list i i i))";
    check(
        &format!("(let ((x nil)) (dotimes (i million) (let ((y x)) (setq x (lambda () y)))) {churn} 'closures)"),
        "=> closures",
    );
    check(
        &format!(
            "(let ((x nil)) (dotimes (i 200000) (let ((h (make-hash-table))) (setf (gethash 1 h) x) (setq x h))) {churn} 'tables)"
        ),
        "=> tables",
    );
    check(
        &format!("(let ((x nil)) (dotimes (i 200000) (let ((y x)) (setq x (create-fluent y)))) {churn} 'fluents)"),
        "=> fluents",
    );
    check(
        &format!(
            "(let ((x nil)) (dotimes (i 100000) (with-failure-handling ((failure (f) (setq x f))) (fail-composite (list x)))) {churn} x)"
        ),
        "=> #<composite-failure",
    );
}

#[test]
fn equality_of_shared_and_circular_lists_is_decided() {
    let shared = "(defun tree (n) (let ((x (list 1))) (dotimes (i n) (setq x (cons x x))) x)) ";
    check(&format!("{shared} (equal (tree 200) (tree 200))"), "=> t");
    check(&format!("{shared} (equal (tree 200) (tree 199))"), "=> nil");
    let circle = "(defun circle (n) (let ((l (iota n))) (setf (cdr (last l)) l) l)) ";
    check(&format!("{circle} (equal (circle 3) (circle 3))"), "=> t");
    check(&format!("{circle} (equal (circle 3) (circle 4))"), "=> nil");
    check(&format!("{circle} (nth 1000000000000000000 (circle 3))"), "=> 1");
    check(&format!("{circle} (length (circle 3))"), "failed: type-error");
}

/// r[limit.nesting]
#[test]
fn a_datum_becomes_a_plan_however_deep_it_nests() {
    check("(equal (execute-plan (list 'quote (deep 400000))) (deep 400000))", "=> t");
    for head in ["'seq", "'progn", "'not", "'and", "'par", "'list", "'let nil", "'lambda nil"] {
        let deep = format!("(execute-plan (let ((x 1)) (dotimes (i N) (setq x (list {head} x))) x)) 'ran");
        let refused = run(&format!("{DEEP}{}", deep.replace('N', "10001")));
        assert!(refused.contains("these forms are nested more than 10000 levels deep"), "{head}: {refused:.300}");
        check(&deep.replace('N', "30000"), "failed: error: the datum cannot be executed");
    }
    check("(execute-plan (wrapped 'seq 9000 1))", "=> 1");
    check("(execute-plan (wrapped 'quasiquote 100 1)) 'ran", "=> ran");
    check("(execute-plan (list 'quasiquote (deep 30000)))", "failed: error: the datum cannot be executed");
}

/// r[limit.nesting]
#[test]
fn a_datum_that_is_no_plan_is_refused_at_once() {
    let circle = "(let ((l (list 'seq 1))) (setf (cdr (cdr l)) l) (execute-plan l))";
    check(circle, "failed: error: the datum is a circular list and cannot be a plan");
    let through_car = "(let ((l (list 'seq 1))) (setf (nth 1 l) l) (execute-plan l))";
    check(through_car, "failed: error: the datum is a circular list and cannot be a plan");
    let shared = "(let ((x (list 'seq 1))) (dotimes (i 60) (setq x (list 'seq x x))) (execute-plan x))";
    check(shared, "failed: error: the datum has more than 1000000 parts");
    let through_vector = "(let ((v (vector 1 2))) (setf (vref v 0) v) (execute-plan (list 'print v)))";
    check(through_vector, "failed: error: the datum is a circular list and cannot be a plan");
}

/// r[limit.nesting]
#[test]
fn macros_nest_what_they_make() {
    let expansion =
        |n: usize| format!("(defmacro m () (let ((x 1)) (dotimes (i {n}) (setq x (list 'progn x))) x)) (m)");
    check(&expansion(9_000), "=> 1");
    check(&expansion(50_000), "error[too-deep]");
    check(
        "(defmacro m () (let ((x 1)) (dotimes (i 100000) (setq x (list x))) (list 'length (list 'quote x)))) (m)",
        "=> 1",
    );
}

/// r[limit.frames]
#[test]
fn networks_that_make_networks_come_to_an_end() {
    check("(defun nest (n) (fluent (if (> n 0) (value (nest (- n 1))) 1))) (value (nest 20))", "=> 1");
    check(
        "(defun nest (n) (fluent (if (> n 0) (value (nest (- n 1))) 1))) (value (nest 100000))",
        "failed: stack-overflow: networks make networks",
    );
}

#[test]
fn classes_inherit_through_any_number_of_others() {
    let mut text = String::from("(def-failure c0 (failure) (slot))");
    for number in 1..5_000 {
        text += &format!("(def-failure c{number} (c{}))", number - 1);
    }
    check(&format!("{text} (with-failure-handling ((c0 (f) (failure-slot f 'slot))) (fail c4999 :slot 7))"), "=> 7");
}

/// r[limit.frames]
#[test]
fn every_construct_nests_by_recursion() {
    let constructs = [
        "(unwind-protect (nest (- n 1)) (incf done))",
        "(evap-protect (nest (- n 1)) (incf done))",
        "(with-failure-handling ((timeout (f) nil)) (nest (- n 1)))",
        "(with-failure-handling ((failure (f) (refail))) (nest (- n 1)))",
        "(par (nest (- n 1)))",
        "(try-all (nest (- n 1)))",
        "(pursue (nest (- n 1)))",
        "(with-priority 1 (nest (- n 1)))",
        "(with-policy (wait-for f) (nest (- n 1)))",
        "(with-timeout 99 (nest (- n 1)))",
        "(block b (nest (- n 1)))",
        "(with-valve v (nest (- n 1)))",
        "(called (- n 1))",
        "(let ((g (lambda () (nest (- n 1))))) (g))",
        "(funcall nest (- n 1))",
        "(apply nest (list (- n 1)))",
        "(map nest (list (- n 1)))",
        "(:tag a (nest (- n 1)))",
        "(plan ((nest (- n 1))))",
        "(par-map (m (list (- n 1))) (nest m))",
    ];
    for construct in constructs {
        let text = |end: &str, around: &str| {
            format!(
                "(def-fluent f nil) (def-valve v) (defvar done 0) (def-plan called (n) (nest n))
                 (defun nest (n) (if (= n 0) {end} (progn {construct} 1)))
                 {}",
                around.replace("NEST", "(nest 3000)")
            )
        };
        check(&text("(wait-time 1)", "NEST (now)"), "=> 1.0");
        check(&text("(wait-time 9)", "(pursue NEST (wait-time 1)) (now)"), "=> 1.0");
        check(&text("(fail \"deep\")", "(ignore-failures (failure) NEST) 'failed"), "=> failed");
    }
}

/// r[determinism.value]
#[test]
fn deep_states_are_saved_and_loaded() {
    let text = format!(
        "{DEEP} (defvar kept (list (deep million) (execute-plan (list 'quote (deep 400000)))))
         (wait-time 1) (equal (car (deep 400001)) (nth 1 kept))"
    );
    let ended = on_a_small_stack(move || {
        let library = library();
        let Ok(loaded) = library.load("deep.rpl", &text, &mut NoFiles) else { panic!("the text compiles") };
        let mut system = System::new(library.clone(), loaded.clone(), NoRobot, 0);
        system.settle();
        let saved = system.save();
        let mut again = match System::load(&saved, library.clone(), loaded, NoRobot) {
            Ok(again) => again,
            Err(error) => panic!("{error}"),
        };
        assert!(again.save() == saved && system.difference(&again).is_none(), "what is loaded is what was saved");
        while again.advance() == Progress::Running {}
        rpl_tests::transcript(&mut again)
    });
    assert_eq!(ended, "=> t");
}
