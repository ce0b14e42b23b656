//! `deftest` and what is asserted in it: r[test.*], r[assert.*].

use rpl_runtime::robot::NoRobot;
use rpl_runtime::run::system::{Progress, System};

/// The names of the tests of a text, each with what it does when it runs alone.
fn outcomes(text: &str) -> Vec<(String, String)> {
    let loaded = rpl_tests::library().load("test.rpl", text, &mut rpl_lang::compile::NoFiles);
    let loaded = loaded.unwrap_or_else(|rejected| panic!("{}", rejected.render(false)));
    let tests = loaded.tests.clone();
    let run = |test: rpl_lang::compile::Test| {
        let mut loaded = loaded.clone();
        loaded.main = test.code;
        let mut system = System::new(rpl_tests::library().clone(), loaded, NoRobot, 0);
        while system.advance() != Progress::Ended {}
        (test.name.to_string(), rpl_tests::transcript(&mut system))
    };
    tests.into_iter().map(run).collect()
}

/// What the only test of a text does.
fn outcome(body: &str) -> String {
    let found = outcomes(&format!("(deftest it {body})"));
    found.into_iter().map(|(_, outcome)| outcome).collect()
}

/// r[test.definitions], r[test.fresh]
#[test]
fn a_test_runs_the_definitions_and_no_other_form_each_time_anew() {
    let found = outcomes(
        "(defvar count (progn (print \"defined\") 1))
         (print \"the main task\")
         (deftest adds (incf count) (assert (= count 2)))
         (deftest adds-again (incf count) (print count))
         (def-fluent level 7)
         (deftest sees-what-stands-below (assert (= (value level) 7)))",
    );
    let expected = [
        ("adds", "defined\n=> nil"),
        ("adds-again", "defined\n2\n=> 2"),
        ("sees-what-stands-below", "defined\n=> nil"),
    ];
    assert_eq!(found, expected.map(|(name, outcome)| (name.to_string(), outcome.to_string())));
}

/// r[test.ignored]
#[test]
fn a_run_ignores_tests_but_their_faults_are_found() {
    assert_eq!(rpl_tests::run("(deftest never (print \"no\")) (print \"yes\")"), "yes\n=> \"yes\"");
    assert!(rpl_tests::run("(deftest never (prnt 1))").contains("did you mean `print`?"));
    assert!(rpl_tests::run("(deftest)").contains("this is not of the form `(deftest NAME"));
    assert!(rpl_tests::run("(seq (print 1) (let () (deftest a 1)))").contains("can only stand at top level"));
}

/// r[test.form], r[test.options]
#[test]
fn options_stand_before_the_body_and_are_checked() {
    let text = "(deftest a \"Doc.\" :world \"dept\" :scenario \"s.rpl\" :seed 3 :until 2min (print 1) :done)";
    let loaded = rpl_tests::library().load("test.rpl", text, &mut rpl_lang::compile::NoFiles);
    let loaded = loaded.unwrap_or_else(|rejected| panic!("{}", rejected.render(false)));
    let test = &loaded.tests[0];
    assert_eq!((&*test.name, test.doc.as_deref()), ("a", Some("Doc.")));
    assert_eq!((test.options.world.as_deref(), test.options.scenario.as_deref()), (Some("dept"), Some("s.rpl")));
    assert_eq!((test.options.seed, test.options.until_s), (Some(3), Some(120.0)));
    assert!(rpl_tests::run("(deftest a :sed 3 1)").contains("did you mean `:seed`?"));
    assert!(rpl_tests::run("(deftest a :seed -3 1)").contains("the value of `:seed` is an integer from 0 on"));
    assert!(rpl_tests::run("(deftest a 1) (deftest a 2)").contains("two tests are called `a`"));
}

/// r[test.pass]
#[test]
fn a_test_fails_with_the_failure_of_its_body() {
    assert_eq!(outcome("(wait-time 3) (print (now))"), "3.0\n=> 3.0");
    assert!(outcome("(wait-time 3) (fail timeout \"late\")").starts_with("failed: "));
}

/// r[assert.message], r[assert.values]
#[test]
fn assert_tells_the_values_of_the_arguments_of_a_call() {
    let message = |text: &str| {
        rpl_tests::run(&format!(
            "(defun double (n) (* 2 n))
         (print (failure-message (with-failure-handling ((failure (f) f)) {text} (fail \"it succeeded\"))))"
        ))
    };
    let starts = |text: &str, expected: &str| {
        let found = message(text);
        assert_eq!(found.lines().next(), Some(expected), "{text}");
    };
    starts("(let ((a 1)) (assert (= a (+ 1 1) 3)))", "this should be true: (= a (+ 1 1) 3); a is 1, (+ 1 1) is 2");
    starts("(assert (equal (double 2) \"x\"))", "this should be true: (equal (double 2) \"x\"); (double 2) is 4");
    starts("(assert (member 3 '(1 2)))", "this should be true: (member 3 (quote (1 2)))");
    starts(
        "(let ((words '(\"a~b\"))) (assert (every integerp words)))",
        "this should be true: (every integerp words); words is (\"a~b\")",
    );
    // Nothing is evaluated that would not be.
    starts("(assert (and nil (fail \"evaluated\")))", "this should be true: (and nil (fail \"evaluated\"))");
    starts("(assert (= 1 2) \"one is ~a\" 2)", "one is 2");
}

/// r[assert.values]
#[test]
fn assert_evaluates_each_argument_once() {
    assert_eq!(rpl_tests::run("(let ((n 0)) (assert (= (incf n) 1)) (assert (< n (incf n))) n)"), "=> 2");
}

/// r[assert.fails]
#[test]
fn assert_fails_gives_the_failure_that_should_come() {
    assert_eq!(outcome("(failure-message (assert-fails plan-failure (fail \"no\")))"), "=> \"no\"");
    assert_eq!(outcome("(failure-class (assert-fails (timeout error) (/ 1 0)))"), "=> arithmetic-error");
    assert!(outcome("(assert-fails timeout (+ 1 1))").contains("this should fail with timeout; its value is 2"));
    assert!(outcome("(assert-fails timeout (fail \"other\"))").contains("other"));
}
