//! Plans as data.

use rpl_tests::{run, system};

#[track_caller]
fn check(text: &str, expected: &str) {
    assert_eq!(run(text), expected, "{text}");
}

#[test]
fn a_datum_runs_in_this_task() {
    check("(execute-plan '(seq (print (task-path (this-task))) 3))", "main\n=> 3");
    check("(defvar x 4) (execute-plan '(+ x 1))", "=> 5");
    check("(with-failure-handling ((failure (f) (failure-message f))) (execute-plan '(fail \"in\")))", "=> \"in\"");
    check("(def-plan go (x) (print x)) (execute-plan (list 'par (list 'go 1) (list 'go 2)))", "1\n2\n=> 2");
}

#[test]
fn an_error_points_into_the_printed_datum() {
    let result = run("(execute-plan '(seq (nowhere 1)))");
    assert!(result.contains("plan#") && result.contains("nowhere"), "{result}");
    check("(with-failure-handling ((error () 'caught)) (execute-plan '(nowhere)))", "=> caught");
}

#[test]
fn equal_data_share_a_unit() {
    let mut system = system("(dotimes (i 50) (execute-plan (list 'seq 1 \"two\")))");
    while system.advance() == rpl_runtime::system::Progress::Running {}
    let before = system.program.codes.len();
    let mut other = self::system("(dotimes (i 2) (execute-plan (list 'seq 1 \"two\")))");
    while other.advance() == rpl_runtime::system::Progress::Running {}
    assert_eq!(before, other.program.codes.len());
}

#[test]
fn objects_are_embedded() {
    check("(def-fluent f 1) (let ((g (create-fluent 5))) (execute-plan (list 'value g)))", "=> 5");
    check("(execute-plan (list (lambda (x) (+ x 1)) 2))", "=> 3");
}
