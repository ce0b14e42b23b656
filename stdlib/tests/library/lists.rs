//! Lists: building, taking apart, searching, functions over functions.

use crate::evaluate::{check, check_failures, evaluate};
use proptest::prelude::*;

/// r[def.struct]
#[test]
fn a_record_that_is_changed_as_a_list_has_the_slots_of_that_list() {
    let with_point = |body: &str| {
        let slots = "(list p (point-x p) (point-y p) (point-z p))";
        evaluate(&format!("(defstruct point x y z) (let ((p (make-point :x 1 :y 2 :z 3))) {body} {slots})"))
    };
    for (body, value) in [
        ("nil", "((point 1 2 3) 1 2 3)"),
        ("(setf (third p) 9)", "((point 1 9 3) 1 9 3)"),
        ("(setf (cddr p) (list 9))", "((point 1 9) 1 9 nil)"),
        ("(setf (rest p) '(7 8))", "((point 7 8) 7 8 nil)"),
        ("(setf (cdr (last p)) (list 4))", "((point 1 2 3 4) 1 2 3)"),
        ("(setf (cdr (cddr p)) (cdr p)) (setf (cdr (cddr p)) nil)", "((point 1 2) 1 2 nil)"),
        ("(setf (cddr p) (list 9 8)) (setf (point-z p) 7)", "((point 1 9 7) 1 9 7)"),
        ("(setq p (append p '(5)))", "((point 1 2 3 5) 1 2 3)"),
        ("(setq p '(point 4 5 6))", "((point 4 5 6) 4 5 6)"),
    ] {
        assert_eq!(with_point(body).as_deref(), Ok(value), "{body}");
    }
}

/// r[def.struct], r[setf.places]
#[test]
fn the_record_whose_slot_is_assigned_is_the_one_before_its_value_is_known() {
    let with_points = |body: &str| {
        let (points, all) = ("(p (make-point :x 1)) (q (make-point :x 2))", "(list r (point-x p) (point-x q))");
        evaluate(&format!("(defstruct point x) (let ({points}) (let ((r p) (n 0)) {body} {all}))"))
    };
    for (body, value) in [
        ("(setf (point-x r) (progn (setq r q) 7))", "((point 2) 7 2)"),
        ("(setf (point-x r) (point-x q))", "((point 2) 2 2)"),
        ("(setq n (lambda () (setq r q) 8)) (setf (point-x r) (n))", "((point 2) 8 2)"),
        ("(setq r (point-x r))", "(1 1 2)"),
        ("(setq r (setf (point-x r) 5))", "(5 5 2)"),
    ] {
        assert_eq!(with_points(body).as_deref(), Ok(value), "{body}");
    }
    let wrong = with_points("(setq r '(line 1)) (setf (point-x r) 3)");
    assert!(wrong.is_err_and(|text| text.contains("this must be a `point`, and it is (line 1)")));
}

/// r[value.lists]
#[test]
fn building_and_taking_apart() {
    check(&[
        ("(cons 1 2)", "(1 . 2)"),
        ("(list* 1 2 '(3))", "(1 2 3)"),
        ("(list* 1)", "1"),
        ("(append)", "nil"),
        ("(append '(1) nil '(2 3) '(4))", "(1 2 3 4)"),
        ("(append '(1) 2)", "(1 . 2)"),
        (
            "(let ((l '((1 2) (3 4) 5 6 7))) (list (caar l) (cadr l) (cdar l) (cddr l) (caddr l) (cdddr l) (cadddr l)))",
            "(1 (3 4) (2) (5 6 7) 5 (6 7) 6)",
        ),
        (
            "(let ((l '(1 2 3 4 5))) (list (first l) (second l) (third l) (fourth l) (fifth l) (rest l)))",
            "(1 2 3 4 5 (2 3 4 5))",
        ),
        ("(list (car nil) (cdr nil) (third '(1 2)) (fifth nil))", "(nil nil nil nil)"),
        ("(map car '((1) (2)))", "(1 2)"),
        ("(list (nth 1 '(a b)) (nth 5 '(a b)) (nthcdr 1 '(a b)) (nthcdr 9 '(a)))", "(b nil (b) nil)"),
        ("(list (last '(1 2 3)) (last '(1 2 3) 2) (last nil) (last '(1) 5))", "((3) (2 3) nil (1))"),
        ("(list (butlast '(1 2 3)) (butlast '(1 2 3) 2) (butlast nil))", "((1 2) (1) nil)"),
        ("(make-list 2 'x)", "(x x)"),
        ("(acons 'a 1 '((b . 2)))", "((a . 1) (b . 2))"),
        ("(range 3)", "(0 1 2)"),
        ("(range 2 5)", "(2 3 4)"),
        ("(range 5 2)", "nil"),
        ("(range 5 0 -2)", "(5 3 1)"),
        ("(range 0 1 0.25)", "(0.0 0.25 0.5 0.75)"),
        ("(iota 3)", "(0 1 2)"),
        ("(iota 3 1 2)", "(1 3 5)"),
        ("(flatten '(1 (2 (3 nil)) . 4))", "(1 2 3 4)"),
        ("(list (getf '(:a 1 :b 2) :b) (getf '(:a 1) :c 9) (getf '(:a) :a))", "(2 9 nil)"),
        ("(let* ((l '(1 2 3)) (c (copy-list l))) (setf (car c) 9) (list l c))", "((1 2 3) (9 2 3))"),
    ]);
}

/// r[value.lists], r[value.alists]
#[test]
fn elements() {
    check(&[
        ("(list (length nil) (length '(1 2)) (length \"äb\"))", "(0 2 2)"),
        ("(list (reverse '(1 2 3)) (reverse \"aé\"))", "((3 2 1) \"éa\")"),
        (
            "(list (subseq '(1 2 3) 1) (subseq '(1 2 3) 0 2) (subseq \"hello\" 1 3) (subseq '(1) 1))",
            "((2 3) (1 2) \"el\" nil)",
        ),
        ("(list (elt '(1 2) 1) (elt \"éa\" 0))", "(2 \"é\")"),
        (
            "(list (member 2 '(1 2 3)) (member \"b\" '(\"a\" \"b\")) (member 9 '(1)) (member 1.0 '(1)))",
            "((2 3) (\"b\") nil nil)",
        ),
        ("(list (position 'b '(a b)) (position 'c '(a b)))", "(1 nil)"),
        (
            "(list (assoc 'b '((a . 1) (b . 2))) (assoc \"x\" '((\"x\" 1))) (assoc 1 nil) (rassoc 2 '((a . 1) (b . 2))))",
            "((b . 2) (\"x\" 1) nil (b . 2))",
        ),
        ("(list (assoc-value 'a '((a . 1))) (assoc-value 'b '((a . 1)) 7))", "(1 7)"),
        ("(list (alist-keys '((a . 1) (b . 2))) (alist-values '((a . 1) (b . 2))))", "((a b) (1 2))"),
        ("(remove 1 '(1 2 1 1.0))", "(2 1.0)"),
        ("(substitute 9 1 '(1 2 1))", "(9 2 9)"),
        ("(remove-duplicates '(1 2 1 \"a\" \"a\" (x) (x) 1.0))", "(1 2 \"a\" (x) 1.0)"),
        (
            "(list (union '(1 2) '(2 3)) (intersection '(1 2 3) '(3 1)) (set-difference '(1 2 3) '(2)))",
            "((1 2 3) (1 3) (1 3))",
        ),
        ("(list (subsetp '(1) '(2 1)) (subsetp '(3) '(1)) (adjoin 1 '(1)) (adjoin 2 '(1)))", "(t nil (1) (2 1))"),
    ]);
}

/// r[value.order]
#[test]
fn functions_over_functions() {
    check(&[
        ("(map (lambda (x) (* x x)) '(1 2 3))", "(1 4 9)"),
        ("(map + '(1 2 3) '(10 20))", "(11 22)"),
        ("(mapcar list '(1 2) '(a b) '(x y))", "((1 a x) (2 b y))"),
        ("(append-map (lambda (x) (list x x)) '(1 2))", "(1 1 2 2)"),
        ("(let ((sum 0)) (for-each (lambda (x) (incf sum x)) '(1 2 3)) sum)", "6"),
        ("(let ((sum 0)) (list (mapc (lambda (x y) (incf sum (* x y))) '(1 2) '(3 4)) sum))", "((1 2) 11)"),
        ("(filter evenp '(1 2 3 4))", "(2 4)"),
        ("(remove-if evenp '(1 2 3 4))", "(1 3)"),
        ("(remove-if-not evenp '(1 2 3 4))", "(2 4)"),
        ("(partition evenp '(1 2 3 4))", "((2 4) (1 3))"),
        ("(reduce + '(1 2 3))", "6"),
        ("(reduce + nil)", "0"),
        ("(reduce - '(1 2) :initial-value 10)", "7"),
        ("(reduce max nil :initial-value nil)", "nil"),
        ("(list (find evenp '(1 2 4)) (find evenp '(1)) (find-if oddp '(2 3)))", "(2 nil 3)"),
        ("(list (position-if evenp '(1 2)) (position-if evenp nil) (count-if evenp '(2 3 4)))", "(1 nil 2)"),
        ("(list (every plusp '(1 2)) (every plusp '(1 -2)) (every plusp nil) (every < '(1 2) '(2 3)))", "(t nil t t)"),
        (
            "(list (some plusp '(-1 2)) (some plusp nil) (some (lambda (x) (member x '(2 3))) '(1 2)) (some = '(1 2) '(3 2)))",
            "(t nil (2 3) t)",
        ),
        ("(list (notany plusp '(-1)) (notany plusp '(1)))", "(t nil)"),
        ("(list (min-by abs '(-3 2 -2)) (max-by abs '(-3 2 3)) (min-by abs nil))", "(2 -3 nil)"),
        ("(sort < '(3 1 2))", "(1 2 3)"),
        ("(sort > nil)", "nil"),
        ("(sort string< '(\"b\" \"a\"))", "(\"a\" \"b\")"),
        ("(sort < '((2 . a) (1 . b) (2 . c) (1 . d)) :key car)", "((1 . b) (1 . d) (2 . a) (2 . c))"),
        (
            "(sort (lambda (a b) (< (car a) (car b))) '((2 . a) (1 . b) (2 . c) (1 . d)))",
            "((1 . b) (1 . d) (2 . a) (2 . c))",
        ),
        ("(sort > '((2 . a) (1 . b) (2 . c)) :key car)", "((2 . a) (2 . c) (1 . b))"),
        (
            "(list (sort > '(1.5 -0.5 2.5)) (sort < '(2 1.5 1)) (sort string> '(\"a\" \"b\")) (sort string< '(b \"a\")))",
            "((2.5 1.5 -0.5) (1 1.5 2) (\"b\" \"a\") (\"a\" b))",
        ),
        ("(sort <= '((1 . a) (1 . b)) :key car)", "((1 . b) (1 . a))"),
        ("(let ((l (list 3 1 2))) (sort < l) l)", "(3 1 2)"),
        ("(group-by evenp '(1 2 3 4))", "((nil 1 3) (t 2 4))"),
        ("(list (identity 1) ((complement evenp) 1) ((constantly 7) 1 2) ((compose 1+ *) 2 3))", "(1 t 7 7)"),
    ]);
}

/// r[setf.places], r[value.nth]
#[test]
fn places() {
    check(&[
        (
            "(let ((l (list 1 2 3 4 5 6))) (setf (first l) 'a (second l) 'b (third l) 'c (fourth l) 'd (fifth l) 'e (nth 5 l) 'f) l)",
            "(a b c d e f)",
        ),
        (
            "(let ((l (list (list 1 2) 3 4))) (setf (caar l) 'x (cdar l) 'y (cadr l) 'z (caddr l) 'w) l)",
            "((x . y) z w)",
        ),
        ("(let ((l (list 1 2 3))) (setf (cddr l) '(9)) l)", "(1 2 9)"),
        ("(let ((l (list 1 2))) (setf (rest l) nil) l)", "(1)"),
        ("(let ((l (list 1 2))) (setf (elt l 1) 5))", "5"),
    ]);
    check_failures(&[
        ("(setf (nth 2 (list 1 2)) 0)", "index-error: there is no element 2 to set: the length is 2"),
        ("(setf (car nil) 0)", "index-error: the list is too short"),
        ("(setf (third (list 1 2)) 0)", "index-error: the list is too short"),
        ("(setf (nth 0 5) 0)", "type-error: argument 2 of `(setf nth)` must be a list, and it is the integer 5"),
        ("(setf (elt \"abc\" 0) \"x\")", "type-error: a string cannot be changed"),
    ]);
}

#[test]
fn what_is_no_list_fails() {
    check_failures(&[
        (
            "(length 5)",
            "type-error: argument 1 of `length` must be a list, a vector or a string, and it is the integer 5",
        ),
        (
            "(length '(1 . 2))",
            "type-error: argument 1 of `length` must be a list, a vector or a string, and it is a list that ends in the integer 2",
        ),
        (
            "(reverse 'x)",
            "type-error: argument 1 of `reverse` must be a list, a vector or a string, and it is the symbol x",
        ),
        (
            "(append '(1 . 2) nil)",
            "type-error: argument 1 of `append` must be a list, and it is a list that ends in the integer 2",
        ),
        ("(map 1+ 5)", "type-error: argument 2 of `map` must be a list or a vector, and it is the integer 5"),
        ("(sort < '(1 a))", "type-error"),
        ("(sort '(1 2) <)", "type-error: argument 1 of `sort` must be a function, and it is a list"),
        ("(nth -1 '(1))", "index-error: argument 1 of `nth` must not be negative, and it is -1"),
        ("(subseq '(1 2) 1 3)", "index-error: a part cannot reach up to 3: the length is 2"),
        ("(subseq '(1 2) 2 1)", "index-error: a part cannot begin at 2 and end at 1"),
        ("(elt '(1) 1)", "index-error: there is no element 1: the length is 1"),
        (
            "(assoc 1 '(1))",
            "type-error: argument 2 of `assoc` must be a list of pairs, and one of its elements is the integer 1",
        ),
        ("(range 0 1 0)", "index-error: the step of a range must not be 0"),
        ("(range 100000000000)", "out-of-memory"),
        ("(make-list 100000000000)", "out-of-memory"),
        (
            "(map + '(1) 2)",
            "type-error: each argument behind the function must be a list or a vector, and it is the integer 2",
        ),
    ]);
}

#[test]
fn a_circular_list_fails_and_does_not_hang() {
    for form in [
        "(length l)",
        "(reverse l)",
        "(append l nil)",
        "(member 9 l)",
        "(position 9 l)",
        "(assoc 9 l)",
        "(remove 1 l)",
        "(last l)",
        "(butlast l)",
        "(subseq l 0 1)",
        "(copy-list l)",
        "(remove-duplicates l)",
        "(getf l :a)",
        "(string-join l)",
        "(sort < l)",
        "(alist-keys l)",
    ] {
        let text = format!("(let ((l (list (cons 1 2)))) (setf (cdr l) l) {form})");
        let failure = evaluate(&text).expect_err(form);
        assert!(failure.contains("runs in a circle"), "{form}: {failure}");
    }
    // These stop at what they look for, which a circle has too.
    check(&[(
        "(let ((l (list 1 2))) (setf (cddr l) l) (list (nth 4 l) (car (nthcdr 5 l)) (car (member 2 l))))",
        "(1 2 2)",
    )]);
}

fn printed(items: &[i64]) -> String {
    let items: Vec<String> = items.iter().map(i64::to_string).collect();
    if items.is_empty() { "nil".into() } else { format!("({})", items.join(" ")) }
}

fn numbers() -> impl Strategy<Value = Vec<i64>> {
    prop::collection::vec(-20i64..20, 0..40)
}

proptest! {
    #[test]
    fn sorting_is_stable(items in numbers()) {
        // Pairs of a number and its position, sorted by the number alone.
        let pairs: Vec<String> = items.iter().enumerate().map(|(at, item)| format!("({item} {at})")).collect();
        let mut expected: Vec<(i64, usize)> = items.iter().copied().zip(0..).collect();
        expected.sort_by_key(|&(item, _)| item);
        let expected: Vec<String> = expected.iter().map(|(item, at)| format!("({item} {at})")).collect();
        let expected = if expected.is_empty() { "nil".to_string() } else { format!("({})", expected.join(" ")) };
        let text = format!("(sort (lambda (a b) (< (car a) (car b))) '({}))", pairs.join(" "));
        prop_assert_eq!(evaluate(&text), Ok(expected.clone()));
        for less in ["<", "(lambda (a b) (< a b))"] {
            let text = format!("(sort {less} '({}) :key car)", pairs.join(" "));
            prop_assert_eq!(evaluate(&text), Ok(expected.clone()));
        }
    }

    #[test]
    fn appending_and_reversing(left in numbers(), right in numbers()) {
        let (a, b) = (printed(&left), printed(&right));
        let joined = [left, right].concat();
        let reversed: Vec<i64> = joined.iter().rev().copied().collect();
        prop_assert_eq!(evaluate(&format!("(append '{a} '{b})")), Ok(printed(&joined)));
        prop_assert_eq!(evaluate(&format!("(reverse (append '{a} '{b}))")), Ok(printed(&reversed)));
        prop_assert_eq!(evaluate(&format!("(append (reverse '{b}) (reverse '{a}))")), Ok(printed(&reversed)));
    }

    #[test]
    fn a_filter_and_its_opposite_share_out_the_list(items in numbers()) {
        let list = printed(&items);
        let (even, odd): (Vec<i64>, Vec<i64>) = items.iter().partition(|&&item| item % 2 == 0);
        prop_assert_eq!(evaluate(&format!("(filter evenp '{list})")), Ok(printed(&even)));
        prop_assert_eq!(evaluate(&format!("(remove-if evenp '{list})")), Ok(printed(&odd)));
        prop_assert_eq!(evaluate(&format!("(count-if evenp '{list})")), Ok(even.len().to_string()));
    }

    #[test]
    fn a_range_holds_what_a_loop_counts(start in -20i64..20, end in -20i64..20, step in prop_oneof![-5i64..-1, 1i64..5]) {
        let mut expected = Vec::new();
        let mut at = start;
        while (step > 0 && at < end) || (step < 0 && at > end) {
            expected.push(at);
            at += step;
        }
        prop_assert_eq!(evaluate(&format!("(range {start} {end} {step})")), Ok(printed(&expected)));
    }
}
