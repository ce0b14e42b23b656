//! Plans as data.

use rpl_tests::{check, run, system};

/// r[data.execute]
#[test]
fn a_datum_runs_in_this_task() {
    check("(execute-plan '(seq (print (task-path (this-task))) 3))", "main\n=> 3");
    check("(defvar x 4) (execute-plan '(+ x 1))", "=> 5");
    check("(with-failure-handling ((failure (f) (failure-message f))) (execute-plan '(fail \"in\")))", "=> \"in\"");
    check("(def-plan go (x) (print x)) (execute-plan (list 'par (list 'go 1) (list 'go 2)))", "1\n2\n=> 2");
}

/// r[data.place]
#[test]
fn an_error_points_into_the_printed_datum() {
    let result = run("(execute-plan '(seq (nowhere 1)))");
    assert!(result.contains("plan#") && result.contains("nowhere"), "{result}");
    check("(with-failure-handling ((error () 'caught)) (execute-plan '(nowhere)))", "=> caught");
}

/// r[data.shared]
#[test]
fn equal_data_share_a_unit() {
    let mut system = system("(dotimes (i 50) (execute-plan (list 'seq 1 \"two\")))");
    while system.advance() == rpl_runtime::run::system::Progress::Running {}
    let before = system.program.codes.len();
    let mut other = self::system("(dotimes (i 2) (execute-plan (list 'seq 1 \"two\")))");
    while other.advance() == rpl_runtime::run::system::Progress::Running {}
    assert_eq!(before, other.program.codes.len());
}

#[test]
fn objects_pass_through_macros() {
    check("(let ((f (create-fluent 3))) (execute-plan `(when ,f (prog1 (value ,f) (setf (value ,f) 4)))))", "=> 3");
    check("(par (:tag a (wait-time 9)) (execute-plan `(when t (evaporate ,a)))) (now)", "=> 0.0");
}

#[test]
fn objects_are_embedded() {
    check("(def-fluent f 1) (let ((g (create-fluent 5))) (execute-plan (list 'value g)))", "=> 5");
    check("(execute-plan (list (lambda (x) (+ x 1)) 2))", "=> 3");
}

/// r[data.visible]
#[test]
fn its_tasks_are_those_of_the_tree() {
    check(
        "(def-plan p ()
           (par (execute-plan '(par (:tag inner (evap-protect (wait-time 9) (print 'cut)))))
                (seq (wait-time 1) (evaporate (task \"main/p/par[0]/inner\")) (now))))
         (p)",
        "cut\n=> 1.0",
    );
    check("(execute-plan '(defvar made 3)) (execute-plan '(def-plan go () (+ made 1))) (execute-plan '(go))", "=> 4");
}

/// r[data.execute], r[data.place]
#[test]
fn local_names_are_not_known_in_it() {
    let local = run("(let ((y 3)) (execute-plan '(print y)))");
    assert!(local.starts_with("failed: error") && local.contains("`y` is not defined anywhere"), "{local}");
    let mut system = system("(execute-plan '(seq (wait-time 1) (+ 1 'a)))");
    while system.advance() == rpl_runtime::run::system::Progress::Running {}
    let Some(rpl_runtime::run::system::Outcome::Failed(rpl_runtime::state::value::Value::Failure(failure))) =
        system.outcome()
    else {
        panic!("it does not fail");
    };
    let span = system.machine.heap.failures[failure].span.expect("a failure has a place");
    let source = system.program.sources.get(span.source);
    assert!(source.name.starts_with("plan#"), "{}", source.name);
    assert_eq!(&source.text[span.start as usize..span.end as usize], "(+ 1 'a)");
}
