//! What a macro of the library writes means the library's names, whatever a plan binds or defines.

use crate::evaluate::{check, check_failures, evaluate, library};
use rpl_lang::compile::special_forms;
use rpl_lang::syntax::mark_of;
use std::collections::BTreeSet;

/// Definitions that the uses need.
const DEFINITIONS: &str = "
(defstruct crate item (weight (+ 1 2)))
(def-goal (achieve (clean room)) (if (eq room 'attic) (fail \"dusty\") (list 'swept room)))
(def-goal (achieve (clean room)) (list 'wiped room))
(def-revision other-way (projection plan) (when (consp plan)) (cons 'seq plan) \"Another way.\")
(def-fluent light 0)
(defvar again 6)
(def-queue trays :most 2)
(def-plan shelve (item) (wait-time 1) (list 'shelved item))
";

/// At least one use of each macro of the library, with values that show what it did.
const USES: &[&str] = &[
    "(list (when t 1 2) (unless nil 3 4))",
    "(list (cond ((eq 1 2) 3) ((+ 1 1)) (else 4)) (cond (nil 1) (t 5)))",
    "(case (list 'b) ((a \"s\" 1.5) 1) (((b) c) (list 2)) (otherwise 3))",
    "(case 1.5 (a 1) ((\"s\" 1.5) 2))",
    "(let ((n 0)) (while (< n 3) (setq n (+ n 1))) n)",
    "(let ((s nil)) (list (dolist (e '(1 2 3) (list e s)) (setq s (cons e s))) (dolist (e #(4 5)) (setq s (cons e s))) s))",
    "(let ((s nil)) (list (dotimes (e (+ 1 2) e) (setq s (cons e s))) (dotimes (e 2) (setq s (cons e s))) s))",
    "(do ((j 0 (+ j 1)) (a nil (cons j a))) ((= j 3) (list j a)) (list j))",
    "(let ((s 0)) (n-times (+ 1 2) (setq s (+ s 2))) s)",
    "(let ((k 1) (l (list 1 2))) (list (incf k) (incf k 5) (decf k) (decf k 2) (incf (car l)) (decf (nth (- 2 1) l)) l))",
    "(let ((l (list (list 2) 1))) (list (push 9 l) (push 8 (nth (+ 0 1) l)) (pop l) (pop (car l)) l))",
    "(let ((l (list 1 2)) (k (list nil))) (list (pushnew 2 l) (pushnew 3 l) (pushnew 4 (car k))))",
    "(let ((c (make-crate :item 'cup))) (list (crate-p c) (crate-p 1) (crate-weight c) (setf (crate-item c) 'jug) (copy-crate c)))",
    "(prog1 1 2)",
    "(list (flet ((f (a) (+ a 1))) (f 1)) (labels ((f (a) (if (= a 0) 0 (f (- a 1))))) (f 3)))",
    "(destructuring-bind (a (b &optional (c (+ 1 1))) &rest d &key (e 6)) '(1 (2) :e 3) (list a b c d e))",
    "(with-failure-handling ((plan-failure (f) (failure-message f))) (fail \"no ~a\" 1))",
    "(with-failure-handling ((plan-failure (f) (failure-message f))) (fail plan-failure \"no\"))",
    "(let ((k 4)) (with-failure-handling ((plan-failure (f) (failure-message f))) (assert (= k 4)) (assert (= k (+ 2 3)))))",
    "(with-failure-handling ((plan-failure (f) (failure-message f))) (assert nil \"~a left\" 2))",
    "(with-failure-handling ((plan-failure (f) (failure-message f))) (assert (or nil nil)))",
    "(failure-message (assert-fails plan-failure (fail \"as it should\")))",
    "(with-failure-handling ((plan-failure (f) (failure-message f))) (assert-fails plan-failure 7))",
    "(with-policies ((wait-for (> light 5)) (whenever (> light 7) (fail \"bright\"))) (wait-time 1) 'dark)",
    "(list (pursue-first-n 1 7 8) (let ((n 2)) (pursue-first-n n 7 (fail \"x\") 9)))",
    "(list (try-in-order (fail \"a\") 2) (with-failure-handling ((composite-failure (f) 'all)) (try-in-order (fail \"a\") (fail \"b\"))))",
    "(list (try-each-in-order (e '(1 2)) (if (= e 1) (fail \"no\") e))
           (with-failure-handling ((composite-failure (f) 'all)) (try-each-in-order (e '(1 2)) (fail \"no\")))
           (with-failure-handling ((composite-failure (f) 'none)) (try-each-in-order (e nil) 1)))",
    "(list (ignore-failures (plan-failure) (fail \"x\")) (ignore-failures () 1))",
    "(let ((m 0)) (with-retry-counters ((c 2)) (with-failure-handling ((plan-failure () (do-retry c) m)) (setq m (+ m 1)) (fail \"x\"))))",
    "(let ((m 0)) (with-retry-counters ((c 1)) (do-retry c (setq m 'again))) m)",
    "(with-failure-handling ((error (f) 'no-behaviour)) (run-behaviour (list 1) :speed 2))",
    "(list (achieve (clean 'hall)) (achieve (clean 'attic)))",
    "(let ((job (create-fluent nil)))
       (par (seq (setf (value job) (this-task)) (wait-time 10))
            (seq (wait-time 1) (swap-plan (value job) '(shelve 'cup)))))",
    "(list (seq (:tag step 1) (finished? step)) (finished? step))",
    "(other-way nil '((shelve 1)))",
    "(let ((errand '(seq (:tag one (shelve 'cup)) (:tag two (shelve 'jug)))))
       (map (lambda (rule) (execute-plan (rule (make-projection :failures '((1.0 failure \"\" \"\"))) errand)))
            (list library:last-step-first library:first-step-last library:side-by-side library:try-once-more)))",
    "(execute-plan (plan-resumed '(par (:tag one (shelve 'cup)) (:tag two (shelve 'jug)))))",
    "(execute-plan (library:one-after-the-other nil '(par (:tag one (shelve 'cup)) (:tag two (shelve 'jug)))))",
    "(execute-plan (library:other-way-first nil '(try-in-order (fail \"no\") (shelve 'jug))))",
    "(execute-plan (library:try-once-more (make-projection :failures '((1.0 failure \"\" \"\"))) '(list again)))",
    "(let ((a (create-fluent 1)) (b (create-fluent 2))) (list (setf-together (value a) (value b) (value b) (value a)) (value a) (value b)))",
    "(par (list (dequeue trays) (dequeue trays :if (lambda (tray) (stringp tray)))) (seq (enqueue trays 1) (enqueue trays \"two\") (value (queue-length trays))))",
    "(let ((n 0)) (list (persist (> n 2) (plan-failure) (setq n (+ n 1)) (when (eq n 1) (fail \"a\"))) n))",
    "(with-parts-handled ((plan-failure (parts) (length parts))) (try-all (fail \"a\") (fail \"b\")))",
    "(with-foresight (:rules (library:last-step-first library:side-by-side) :horizon 60 :runs 2 :when (> light 3))
       (:tag one (shelve 'cup))
       (:tag two (shelve ',(+ 1 1))))",
];

/// Every name of the library that can be bound.
fn names() -> BTreeSet<String> {
    let (program, symbols) = library().names();
    let globals = program.names.keys().chain(program.macros.keys()).map(|&name| symbols.name(name));
    let natives = library().natives.iter().map(|native| native.name);
    let forms = special_forms().flat_map(|form| form.names.iter().copied());
    let known = globals.chain(natives).chain(forms);
    known.filter(|name| mark_of(name).is_none() && !name.starts_with(':')).map(str::to_string).collect()
}

/// The words of a text.
fn words(text: &str) -> BTreeSet<&str> {
    text.split(|character: char| character.is_whitespace() || "()'`,@#\"".contains(character)).collect()
}

/// A text in which all names of the library say that they are.
fn qualified(text: &str, names: &BTreeSet<String>) -> String {
    let heads = text.split('(').enumerate().map(|(at, piece)| {
        let word = piece.split(|character: char| character.is_whitespace() || "()'\"".contains(character)).next();
        match word {
            Some(word) if at > 0 && names.contains(word) => format!("library:{piece}"),
            _ => piece.to_string(),
        }
    });
    // A word of `def-revision`, which is no call.
    heads.collect::<Vec<_>>().join("(").replace("plan) (library:when", "plan) (when")
}

/// A form with names bound around it; a function has room for a limited number of variables.
fn bound(names: &[&str], form: &str) -> String {
    names.chunks(100).fold(form.to_string(), |form, names| {
        let bindings: Vec<String> = names.iter().map(|name| format!("({name} 'captured)")).collect();
        format!("((library:lambda () (library:let ({}) {form})))", bindings.join(" "))
    })
}

/// What a use gives where nothing is bound or defined.
fn undisturbed(form: &str) -> Result<String, String> {
    let value = evaluate(&format!("{DEFINITIONS}\n{form}"));
    assert!(value.is_ok(), "{form}\n{value:?}");
    value
}

/// A value or a failure, as `evaluate` tells it.
type Given = Result<String, String>;

/// Checks that each form gives what it gives undisturbed; messages show it as it is written.
#[track_caller]
fn all_are(found: Vec<(String, Given, Given)>) {
    let plain = |value: &Result<String, String>| value.as_ref().map(|value| value.replace("library:", "")).ok();
    let wrong = found.into_iter().filter(|(_, value, expected)| plain(value) != plain(expected));
    let wrong: Vec<String> =
        wrong.map(|(form, value, expected)| format!("{form}\n  gives {value:?}\n  not   {expected:?}")).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_macro_has_a_use() {
    let text = format!("{DEFINITIONS}{}", USES.concat());
    let used = words(&text);
    let (program, symbols) = library().names();
    let unused: Vec<&str> =
        program.macros.keys().map(|&name| symbols.name(name)).filter(|name| !used.contains(name)).collect();
    assert!(unused.is_empty(), "without a use: {unused:?}");
}

/// r[eval.macro-names]
#[test]
fn what_a_plan_binds_changes_nothing_in_a_macro() {
    let names = names();
    let others = |form: &str| {
        let own = words(form);
        let others: Vec<&str> = names.iter().map(String::as_str).filter(|name| !own.contains(name)).collect();
        bound(&others, form)
    };
    let found = USES.iter().map(|form| {
        let value = evaluate(&format!("{DEFINITIONS}\n{}", others(form)));
        (form.to_string(), value, undisturbed(form))
    });
    all_are(found.collect());
}

/// r[eval.library-name]
#[test]
fn a_name_of_the_library_can_be_said_where_it_is_bound() {
    let names = names();
    let all: Vec<&str> = names.iter().map(String::as_str).collect();
    let found = USES.iter().map(|form| {
        let value = evaluate(&format!("{DEFINITIONS}\n{}", bound(&all, &qualified(form, &names))));
        (form.to_string(), value, undisturbed(form))
    });
    all_are(found.collect());
}

/// r[eval.macro-names], r[eval.redefine], r[rule.names]
#[test]
fn what_a_text_defines_changes_nothing_in_a_macro() {
    let names = names();
    let forms: BTreeSet<&str> = special_forms().flat_map(|form| form.names.iter().copied()).collect();
    let own: Vec<String> = names
        .iter()
        .filter(|name| !forms.contains(name.as_str()))
        .map(|name| format!("(library:defun {name} (&rest ignored) 'captured)"))
        .collect();
    let own = own.join("\n");
    let definitions = qualified(DEFINITIONS, &names);
    let found = USES.iter().map(|form| {
        let value = evaluate(&format!("{own}\n{definitions}\n{}", qualified(form, &names)));
        (form.to_string(), value, undisturbed(form))
    });
    all_are(found.collect());
}

/// r[eval.library-name], r[eval.global-name], r[eval.qualified]
#[test]
fn a_name_says_where_it_is_looked_up() {
    check(&[
        (
            "(defun length (l) (if (= (library:length l) 2) 'two (library:length l))) (let ((length 5)) (list length (global:length '(a b)) (library:length '(a b))))",
            "(5 two 2)",
        ),
        ("(defvar n 1) (let ((n 2)) (setq global:n 3) (list n global:n))", "(2 3)"),
        ("(let ((car 1)) (map library:car '((2) (3))))", "(2 3)"),
        (
            "(defun push (a b) (list 'mine a b)) (let ((l nil)) (library:push 1 l) (list (push 1 l) l))",
            "((mine 1 (1)) (1))",
        ),
        ("(let ((l nil)) (library:dolist (e '(1 2)) (library:push e l)) l)", "(2 1)"),
        (
            "(defun later () (global:helper)) (defun helper () 4) (flet ((helper () 5)) (list (later) (helper)))",
            "(4 5)",
        ),
        ("(list 'library:car (eq 'library:car 'car) (symbol-name 'global:car))", "(library:car nil \"global:car\")"),
        ("(execute-plan '(library:list 1 (global:list 2)))", "(1 (2))"),
        (
            "(defmacro mine (form) `(library:when t ,form)) (let ((when 1) (if 2)) (mine (library:list when if)))",
            "(1 2)",
        ),
        (
            "(defmacro inner (x) `(library:list ,x)) (defmacro outer (x) `(inner ,x)) (let ((list 1)) (outer list))",
            "(1)",
        ),
    ]);
    check_failures(&[
        ("(library:lenght '(1))", "the library has no `lenght`"),
        ("(library:lenght '(1))", "did you mean `library:length`?"),
        ("(defun mine () 1) (library:mine)", "the program's own is `global:mine`"),
        ("(global:lenght '(1))", "did you mean `length`?"),
        ("(let ((library:car 1)) 1)", "`library:car` says where `car` is looked up, and cannot be bound or defined"),
        ("(defun global:f () 1)", "cannot be bound or defined"),
        ("(lambda (global:f) 1)", "cannot be bound or defined"),
        ("(dolist (library:f '(1)) 1)", "cannot be bound or defined"),
        ("(par-map (library:f '(1)) 1)", "cannot be bound or defined"),
        ("(list library:if)", "`if` is a form, not a function"),
    ]);
}

/// r[fluent.position]
#[test]
fn a_name_that_gives_a_fluent_means_what_is_bound() {
    check(&[
        ("(def-fluent f 3) (let ((status (lambda (x) (> x 2)))) (wait-for (status f)))", "t"),
        ("(def-fluent f 3) (flet ((changed (x) (> x 2))) (wait-for (changed f)))", "t"),
        ("(def-fluent f 3) (let ((fluent (lambda (x) (> x 2)))) (wait-for (fluent f)))", "t"),
        ("(def-fluent f 3) (defun result (x) (list x)) (wait-for (result f))", "(3)"),
        ("(def-fluent f 3) (defmacro end-task (x) `(> ,x 2)) (wait-for (end-task f))", "t"),
        ("(par (:tag w (wait-time 1)) (let ((status 1)) (wait-for (library:end-task w)) (now)))", "1.0"),
        (
            "(par (:tag w (wait-time 1)) (let ((end-task 1)) (wait-for (global:end-task w)) (list end-task (now))))",
            "(1 1.0)",
        ),
    ]);
}

/// r[eval.redefine]
#[test]
fn a_function_with_the_name_of_a_macro_is_meant_above_its_definition_too() {
    check(&[("(defun f () (push 1 2)) (defun push (a b) (list 'mine a b)) (f)", "(mine 1 2)")]);
}

/// r[eval.marks]
#[test]
fn what_marks_stand_for_cannot_be_bound() {
    check_failures(&[
        ("(let ((quote 1)) 'a)", "`quote` is what `'` stands for, and cannot be bound or defined"),
        ("(lambda (unquote) 1)", "`unquote` is what `,` stands for"),
        ("(letrec ((quasiquote (lambda () 1))) 1)", "cannot be bound or defined"),
        ("(defun unquote-splicing () 1)", "cannot be bound or defined"),
        ("(par-map (quote '(1)) 1)", "cannot be bound or defined"),
        ("(with-failure-handling ((failure (quote) 1)) 1)", "cannot be bound or defined"),
    ]);
}

#[test]
fn what_a_plan_reads_of_its_text_has_no_qualifiers() {
    check(&[
        (
            "(with-failure-handling ((failure (f) (failure-message f))) (let ((a 2)) (assert (> a 3))))",
            "\"this should be true: (> a 3); a is 2\"",
        ),
        (
            "(let ((got nil)) (with-failure-handling ((failure () nil)) (with-foresight (:rules ((lambda (projection plan) (setq got plan) nil)) :horizon 9 :runs 1) (print 1) 2)) got)",
            "(progn (print 1) 2)",
        ),
    ]);
}
