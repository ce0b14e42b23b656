//! Where values are kept while a form is evaluated: no part of a form overwrites what another part
//! still needs.

use rpl_tests::run;

/// A form and its value, worked out by hand.
const CASES: &[(&str, &str)] = &[
    ("(let ((x 1)) (setq x (- 10 x 2)) x)", "7"),
    ("(defun f (a b) (- a b)) (let ((x 1)) (setq x (f 2 x)) x)", "1"),
    ("(defun f (a b) (- a b)) (let ((x 5)) (setq x (f x (setq x 2))) x)", "3"),
    ("(defun f (a b c) (list a b c)) (f 1 (f 2 3 4) (f 5 (f 6 7 8) 9))", "(1 (2 3 4) (5 (6 7 8) 9))"),
    ("(defun f (a b) (+ a b)) (let ((x 1) (y 2)) (f x (f y (f x y))))", "6"),
    ("(defun f (a b) (list a b)) (block out (f 1 (if t (return-from out 5) 2)))", "5"),
    ("(defun f (a b) (list a b)) (let ((g f)) (g 1 (g 2 (f 3 4))))", "(1 (2 (3 4)))"),
    ("(defun f (n) (if (< n 3) n (if (< n 5) (f (- n 1)) (* 2 (f (- n 2)))))) (list (f 2) (f 4) (f 7))", "(2 2 8)"),
    ("(defun f (n) (let ((m (+ n 1))) (if (< m 10) m n))) (list (f 1) (f 20))", "(2 20)"),
    (
        "(let ((i 0) (seen nil)) (loop (setq i (+ i 1)) (push i seen) until (>= i 3) (push 'more seen)) (reverse seen))",
        "(1 more 2 more 3)",
    ),
    ("(let ((i 0)) (list (loop while (< i 3) (setq i (+ i 1))) i))", "(nil 3)"),
    ("(let ((i 0)) (list (loop (if (< i 3) nil (return (* i 10))) (setq i (+ i 1))) i))", "(30 3)"),
    ("(let ((i 0) (odd 0)) (loop while (< i 10) (if (= (mod i 2) 1) (setq odd (+ odd 1))) (setq i (+ i 1))) odd)", "5"),
    ("(let ((i 0)) (loop (unwind-protect (if (< i 2) nil (return i)) (setq i (+ i 1)))))", "2"),
    ("(let ((x 1)) (let ((y (setq x 2))) (list x y (setq x (+ x y)) x)))", "(2 2 4 4)"),
    ("(let ((x 1)) (setq x (if (= x 1) (progn (setq x 5) (+ x 1)) x)) x)", "6"),
    ("(let ((x 3)) (list (and x (setq x nil)) x (or x 4)))", "(nil nil 4)"),
    ("(let ((f (lambda (n) (lambda (m) (setq n (+ n m)) n)))) (let ((g (f 1))) (g 2) (list (g 3) (g 4))))", "(6 10)"),
    ("(map (lambda (a &optional (b 2) &rest c) (list a b c)) '(1))", "((1 2 nil))"),
    ("(let ((sum 0)) (dotimes (i 4) (dotimes (j i) (setq sum (+ sum (* i j))))) sum)", "11"),
    ("(def-plan p (n) (if (< n 1) n (p (- n 1)))) (p 3)", "0"),
    ("(with-failure-handling ((error (f) (list 'caught 1))) (list 1 (+ 1 'a)))", "(caught 1)"),
];

#[test]
fn no_part_of_a_form_overwrites_another() {
    for (text, value) in CASES {
        assert_eq!(run(text), format!("=> {value}"), "{text}");
    }
}
