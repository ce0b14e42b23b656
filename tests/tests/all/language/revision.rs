//! Plans as data: matched, changed, and made by rules.

use rpl_tests::{check, run};

/// r[match.pattern]
#[test]
fn a_pattern_tells_what_its_variables_stand_for() {
    check(
        "(plan-match '(deliver ?item ?to) '(deliver letter room-3))",
        "=> ((?to . room-3) (?item . letter) (? deliver letter room-3))",
    );
    check("(plan-match '(deliver ? ?) '(deliver letter room-3))", "=> ((? deliver letter room-3))");
    check("(plan-match '(deliver ?a ?a) '(deliver x x))", "=> ((?a . x) (? deliver x x))");
    check(
        "(list (plan-match '(deliver ?a ?a) '(deliver x y)) (plan-match '(deliver ?a) '(deliver x y)) (plan-match '(a) 7))",
        "=> (nil nil nil)",
    );
    check("(assoc-value '?*steps (plan-match '(seq ?*steps (last ?)) '(seq a (b 1) (last x))))", "=> (a (b 1))");
    check("(plan-match '(seq ?*steps) '(seq))", "=> ((?*steps) (? seq))");
    check("(plan-match '(seq ?first ?*) '(seq))", "=> nil");
    check("(plan-match '(a nil t :k 1.5 \"s\") '(a nil t :k 1.5 \"s\"))", "=> ((? a nil t :k 1.5 \"s\"))");
    assert!(run("(plan-match '(seq ?*a x ?*b) '(seq x))").contains("one `?*` in a list at most"));
}

/// r[match.replace]
#[test]
fn what_is_like_a_pattern_is_replaced() {
    check(
        "(plan-replace '(go-to ?place) '(seq (open-door ?place) (go-to ?place)) '(par (go-to a) (seq (go-to b))))",
        "=> (par (seq (open-door a) (go-to a)) (seq (seq (open-door b) (go-to b))))",
    );
    check("(plan-replace '(seq ?*steps) '(par first ?*steps last) '(seq a b))", "=> (par first a b last)");
    check(
        "(plan-replace '(f ?x) (lambda (found) (list 'g (assoc-value '?x found))) '(seq (f 1) '(f 2)))",
        "=> (seq (g 1) (quote (f 2)))",
    );
    check("(plan-replace '(none) 'x '(seq (a . b) nil))", "=> (seq (a . b) nil)");
}

/// r[match.steps]
#[test]
fn the_steps_of_a_plan_and_their_order() {
    check(
        "(defvar p '(plan ((:tag a 1) (:tag b 2)) (:order b a))) (list (plan-steps p) (plan-order p))",
        "=> (((:tag a 1) (:tag b 2)) ((b a)))",
    );
    check(
        "(defvar p '(seq (:tag a 1) (x) (process b 2) (:tag c 3))) (list (plan-steps p) (plan-order p))",
        "=> (((:tag a 1) (x) (process b 2) (:tag c 3)) ((a b) (b c)))",
    );
    check(
        "(list (plan-steps '(deliver x)) (plan-order '(deliver x)) (plan-order '(par (:tag a 1) (:tag b 2))))",
        "=> (((deliver x)) nil nil)",
    );
}

const RULES: &str = "
    (defun far (x) x)
    (defun near (x) x)
    (def-revision nearest-first (projection plan)
      (when (plan-match '(seq (far ?x) (near ?y)) plan))
      (plan-replace '(seq ?a ?b) '(seq ?b ?a) plan)
      \"Goes to what is near before it goes to what is far.\")
    (def-revision two-at-once (projection plan)
      (when (and (eq (car plan) 'seq) (> projection 1)))
      `(par ,@(plan-steps plan))
      \"Does all at once.\")
    (def-revision one-after-the-other (projection plan)
      (when (eq (car plan) 'par))
      `(seq ,@(plan-steps plan))
      \"Does one after the other.\")
    (defun names (revisions) (map (lambda (made) (cons (length (car made)) (cdr made))) revisions))
    ";

/// r[rule.form], r[rule.all]
#[test]
fn rules_make_plans_of_plans_and_come_to_an_end() {
    let text = |form: &str| format!("{RULES}{form}");
    check(&text("(nearest-first 1 '(seq (near 2) (far 1)))"), "=> nil");
    check(&text("(nearest-first 1 '(seq (far 1) (near 2)))"), "=> (seq (near 2) (far 1))");
    check(
        &text(
            "(names (plan-revisions (list nearest-first two-at-once one-after-the-other) 2 '(seq (far 1) (near 2))))",
        ),
        "=> ((1 seq (near 2) (far 1)) (1 par (far 1) (near 2)) (2 par (near 2) (far 1)))",
    );
    // Nothing is made again that was left before.
    check(
        &text(
            "(names (plan-revisions (list nearest-first two-at-once) 2 '(seq (far 1) (near 2)) :left '((seq (near 2) (far 1)))))",
        ),
        "=> ((1 par (far 1) (near 2)))",
    );
}

/// r[rule.wrong]
#[test]
fn a_rule_that_makes_no_plan_is_told() {
    let told =
        |plan: &str| run(&format!("(def-revision r (projection plan) (when t) {plan} \"is wrong\") (r 1 '(seq 1))"));
    assert!(
        told("3").contains("the rule `r` applies and gives no plan: a new plan is a form, and this is 3"),
        "{}",
        told("3")
    );
    assert!(told("plan").contains("the rule `r` gives the plan it was given"), "{}", told("plan"));
    assert!(
        told("'(nowhere)").contains("the new plan of the rule `r` is none: the datum cannot be executed"),
        "{}",
        told("'(nowhere)")
    );
    let circle = "(let ((new (list 'seq 1))) (setf (cdr new) new) new)";
    assert!(told(circle).contains("the datum is a circular list"), "{}", told(circle));
    for text in [
        "(def-revision r (plan) (when t) 1 \"\")",
        "(def-revision r (a b) t 1 \"\")",
        "(def-revision r (a b) (when t) 1 2)",
    ] {
        assert!(run(text).contains("(def-revision NAME (PROJECTION PLAN) (when CONDITION)"), "{}", run(text));
    }
}
