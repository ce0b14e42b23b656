//! Vectors, and sorting by any predicate.

use crate::evaluate::{check, check_failures, library};
use rpl_lang::compile::NoFiles;
use rpl_runtime::robot::NoRobot;
use rpl_runtime::run::system::{Progress, System};

/// r[value.vectors]
#[test]
fn vectors_are_made_read_and_set() {
    check(&[
        (
            "(list (vector) (vector 1 \"a\" 'b) (make-vector 2) (make-vector 2 'x))",
            "(#() #(1 \"a\" b) #(nil nil) #(x x))",
        ),
        ("(list (vref #(a b c) 0) (vref #(a b c) 2) (length #(a b c)) (elt #(a b) 1))", "(a c 3 b)"),
        ("(let ((v (make-vector 3 0))) (setf (vref v 1) 'x (elt v 2) 'y) (incf (vref v 0) 5) v)", "#(5 x y)"),
        ("(let ((v (vector 1 2))) (list (setf (vref v 0) 9) v))", "(9 #(9 2))"),
        ("(let ((v (vector 1 2))) (setq v (setf (vref v 0) 9)) v)", "9"),
        ("(let ((v (vector 1 2)) (set %set-vref)) (set v 1 'z) v)", "#(1 z)"),
        ("(let ((i 0) (v (vector 1 2))) (setf (vref v i) (setq i 1)) (list i v))", "(1 #(1 2))"),
        ("(list (vectorp #(1)) (vectorp '(1)) (listp #(1)) (atom #(1)))", "(t nil nil t)"),
        (
            "(list (list->vector '(1 2)) (vector->list #(1 2)) (list->vector nil) (vector->list #()))",
            "(#(1 2) (1 2) #() nil)",
        ),
        ("(list (reverse #(1 2 3)) (subseq #(1 2 3) 1) (subseq #(1 2 3) 1 2))", "(#(3 2 1) #(2 3) #(2))"),
        ("(let ((v #(1 2))) (let ((copy (subseq v 0))) (setf (vref copy 0) 'x) (list v copy)))", "(#(1 2) #(x 2))"),
    ]);
}

/// r[value.vectors]
#[test]
fn positions_outside_and_arguments_of_other_kinds_are_refused() {
    check_failures(&[
        ("(vref #(1 2) 2)", "index-error: there is no element 2: the vector has the positions 0 to 1"),
        ("(vref #(1 2) -1)", "index-error: there is no element -1: the vector has the positions 0 to 1"),
        ("(vref #() 0)", "index-error: there is no element 0: the vector is empty"),
        ("(setf (vref (vector 1) 1) 0)", "index-error: there is no element 1: the vector has the positions 0 to 0"),
        ("(setf (elt (vector 1) 1) 0)", "index-error: there is no element 1"),
        ("(elt #(1) 1)", "index-error: there is no element 1"),
        ("(let ((l '(1))) (vref l 0))", "type-error: argument 1 of `vref` must be a vector, and it is a list"),
        (
            "(let ((i 1.0)) (vref #(1 2) i))",
            "type-error: argument 2 of `vref` must be an integer, and it is the float 1.0",
        ),
        ("(let ((i \"0\")) (setf (vref (vector 1) i) 2))", "argument 2 of `(setf vref)` must be an integer"),
        ("(let ((n -1)) (make-vector n))", "index-error"),
        ("(make-vector 1000000000000)", "out-of-memory"),
        ("(subseq #(1 2) 1 3)", "index-error"),
    ]);
}

/// r[value.vectors]
#[test]
fn vectors_are_compared_by_content() {
    check(&[
        (
            "(list (equal #(1 (a) \"x\") (vector 1 '(a) \"x\")) (equal #(1) #(1 2)) (equal #(1) '(1)) (equal #(0.0) #(-0.0)))",
            "(t nil nil t)",
        ),
        ("(list (eq #(1) #(1)) (let ((v #(1))) (eq v v)))", "(nil t)"),
        ("(let ((a (vector 1 2)) (b (vector 1 2))) (setf (vref a 1) a (vref b 1) b) (equal a b))", "t"),
        (
            "(let ((h (make-hash-table))) (setf (gethash #(1 (2)) h) 'a (gethash '(1 (2)) h) 'b) (list (gethash (vector 1 (list 2)) h) (gethash '(1 (2)) h)))",
            "(a b)",
        ),
        (
            "(let ((h (make-hash-table))) (setf (gethash #(1 2) h) 'flat) (list (gethash #(#(1) 2) h) (gethash #(1) h) (gethash #(1 2 3) h)))",
            "(nil nil nil)",
        ),
        ("(member #(2) (list 1 #(2) 3))", "(#(2) 3)"),
        (
            "(let ((x #(1))) (dotimes (i 60) (setq x (vector x x))) (equal x (let ((y #(1))) (dotimes (i 60) (setq y (vector y y))) y)))",
            "t",
        ),
    ]);
}

/// r[value.vectors]
#[test]
fn functions_over_elements_take_vectors_and_make_the_like() {
    check(&[
        (
            "(list (map 1+ #(1 2)) (filter evenp #(1 2 4)) (remove-if evenp #(1 2 4)) (partition evenp #(1 2)))",
            "(#(2 3) #(2 4) #(1) (#(2) #(1)))",
        ),
        ("(list (map + #(1 2) '(10 20)) (map + '(1 2) #(10 20)))", "(#(11 22) (11 22))"),
        (
            "(list (reduce + #(1 2 3)) (find evenp #(1 2)) (every evenp #(2)) (some evenp #(1)) (count 1 #(1 1)) (max-by abs #(1 -3)))",
            "(6 2 t nil 2 -3)",
        ),
        (
            "(list (sort < #(3 1 2)) (sort (lambda (a b) (> a b)) #(3 1 2)) (sort < #((2) (1)) :key car))",
            "(#(1 2 3) #(3 2 1) #((1) (2)))",
        ),
        ("(let ((sum 0)) (dolist (x #(1 2 3) sum) (incf sum x)))", "6"),
        ("(let ((sum 0)) (for-each (lambda (x) (incf sum x)) #(1 2)) sum)", "3"),
    ]);
    check_failures(&[(
        "(let ((x 5)) (map 1+ x))",
        "argument 2 of `map` must be a list or a vector, and it is the integer 5",
    )]);
}

/// r[read.vector]
#[test]
fn vectors_written_out() {
    check(&[
        ("(list #(a (b) #(c)) '(1 #(2)) '#(x) #())", "(#(a (b) #(c)) (1 #(2)) #(x) #())"),
        ("(let ((x 5)) `#(1 ,x ,@(list 6 7) (y ,x)))", "#(1 5 6 7 (y 5))"),
        ("(defmacro twice (v) (list 'list v v)) (twice #(1 a))", "(#(1 a) #(1 a))"),
        ("(defmacro same (datum) (list 'quote datum)) (same (a #(1 (b . 2)) . #(c)))", "(a #(1 (b . 2)) . #(c))"),
        ("(defmacro made () (vector 'a (list 1))) (made)", "#(a (1))"),
        ("(execute-plan (list 'vref (vector 1 2) 1))", "2"),
        ("(let ((v (vector 1 2))) (setf (vref v 0) v) (length (format \"~a\" v)))", "1048579"),
    ]);
}

/// Numbers without order, many of them twice.
fn numbers(count: u64) -> Vec<u64> {
    (0..count).map(|at| at * 7919 % 613).collect()
}

/// r[value.order]
#[test]
fn any_number_of_elements_is_sorted_and_equal_ones_stay_in_order() {
    for count in (0..40).chain([100, 255, 256, 257, 1000]) {
        let mut pairs: Vec<(u64, usize)> = numbers(count).into_iter().map(|number| number % 50).zip(0..).collect();
        let written: String = pairs.iter().map(|(key, at)| format!("({key} {at})")).collect();
        pairs.sort_by_key(|&(key, _)| key);
        let expected: Vec<String> = pairs.iter().map(|(key, at)| format!("({key} {at})")).collect();
        let expected = if expected.is_empty() { "nil".to_string() } else { format!("({})", expected.join(" ")) };
        let by_function = format!("(sort (lambda (a b) (< (car a) (car b))) '({written}))");
        let by_key = format!("(sort (lambda (a b) (< a b)) '({written}) :key car)");
        check(&[(&by_function, &expected), (&by_key, &expected)]);
    }
}

/// What a run has printed and how it has ended, when it is over.
fn ending(mut system: System<NoRobot>) -> String {
    while system.advance() == Progress::Running {}
    system.with_machine(|machine, around| machine.write(around.program, *machine.tasks[machine.main].value()))
}

/// r[value.vectors] r[value.order]
#[test]
fn a_sort_and_its_vectors_can_be_forked_and_saved_between_two_comparisons() {
    let text = "(let ((v (list->vector (map (lambda (i) (mod (* i 7919) 31)) (iota 20)))) (asked 0))
        (let ((sorted (sort (lambda (a b) (incf asked) (setf (vref v 0) asked) (wait-time 0.1) (< a b)) v)))
          (list asked sorted v)))";
    let Ok(mut system) = System::without_robot(library(), "test", text, 0) else { panic!("the text is whole") };
    let expected = ending(system.clone());
    assert!(expected.starts_with('(') && expected.contains("#("), "{expected}");
    loop {
        let mut fork = system.fork();
        fork.machine.heap.share_vectors();
        let other = fork.fork();
        assert_eq!(fork.machine, other.machine);
        assert_eq!(ending(other), expected);
        assert_eq!(ending(fork), expected);
        let saved = system.save();
        let Ok(program) = library().load("test", text, &mut NoFiles) else { panic!("the text is whole") };
        let loaded = System::load(&saved, library().clone(), program, NoRobot);
        let Ok(loaded) = loaded else { panic!("what was saved can be loaded") };
        assert_eq!(loaded.save(), saved);
        assert_eq!(ending(loaded), expected);
        if system.advance() != Progress::Running {
            return;
        }
    }
}
