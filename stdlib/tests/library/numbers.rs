//! Numbers: arithmetic, rounding, transcendental functions.

use crate::evaluate::{check, check_failures, evaluate};
use proptest::prelude::*;

/// r[value.overflow], r[value.division]
#[test]
fn arithmetic() {
    check(&[
        ("(+)", "0"),
        ("(*)", "1"),
        ("(+ 1 2 3)", "6"),
        ("(apply + '(1 2.5))", "3.5"),
        ("(- 5)", "-5"),
        ("(- 10 1 2 3)", "4"),
        ("(* 2 3 4)", "24"),
        ("(/ 6 3)", "2"),
        ("(/ 7 2)", "3.5"),
        ("(let ((a 7.0) (b 2) (c 3)) (list (/ a b) (/ 6 c) (/ 7 c) (/ -6 c)))", "(3.5 2 2.3333333333333335 -2)"),
        ("(/ 4)", "0.25"),
        ("(/ 24 2 3)", "4"),
        ("(/ 1.0 4)", "0.25"),
        ("(map 1+ '(1 2.5))", "(2 3.5)"),
        ("(map 1- '(1 2.5))", "(0 1.5)"),
        ("(abs -3)", "3"),
        ("(abs -3.5)", "3.5"),
        ("(map signum '(-7 0 7 -0.5 0.5))", "(-1 0 1 -1.0 1.0)"),
        ("(min 3 1 2)", "1"),
        ("(max 3 1.5 4)", "4"),
        ("(max 1 2.0)", "2.0"),
        ("(clamp 5 0 3)", "3"),
        ("(clamp -1 0 3)", "0"),
        ("(clamp 2.5 0 3)", "2.5"),
        ("(gcd 12 18)", "6"),
        ("(gcd)", "0"),
        ("(gcd -4 6)", "2"),
        ("(lcm 4 6)", "12"),
        ("(lcm 0 3)", "0"),
    ]);
}

/// r[value.numbers]
#[test]
fn comparison() {
    check(&[
        ("(= 1 1.0)", "t"),
        ("(= 1 1 1)", "t"),
        ("(= 1 1 2)", "nil"),
        ("(/= 1 2 3)", "t"),
        (
            "(list (/= 1 2) (/= 1 1) (/= 1 1.0) (/= 0.5 1) (if (/= 3 4) 'differ 'same) (if (/= 3 3) 'differ 'same))",
            "(t nil nil t differ same)",
        ),
        ("(let ((a 2) (b 2)) (list (/= a b) (if (/= a b) 1 2) (if (/= 2 a) 1 2) (not (/= a b))))", "(nil 2 2 t)"),
        ("(/= 1 2 1)", "nil"),
        ("(< 1 2 3)", "t"),
        ("(< 1 3 2)", "nil"),
        ("(<= 1 1 2)", "t"),
        ("(> 3 2 1)", "t"),
        ("(>= 3 3 1)", "t"),
        ("(apply >= '(3 4))", "nil"),
        ("(list (evenp 4) (oddp 4) (evenp -3) (oddp -3))", "(t nil nil t)"),
        ("(list (zerop 0.0) (plusp 1) (minusp -1.5) (plusp 0))", "(t t t nil)"),
    ]);
}

#[test]
fn rounding() {
    check(&[
        ("(map floor '(2.7 -2.7 3))", "(2 -3 3)"),
        ("(map ceiling '(2.2 -2.2 3))", "(3 -2 3)"),
        ("(map truncate '(2.7 -2.7 3))", "(2 -2 3)"),
        ("(map round '(2.5 3.5 -2.5 2.6))", "(2 4 -2 3)"),
        ("(map int '(2.7 -2.7))", "(2 -2)"),
        ("(list (floor 7 2) (floor -7 2) (floor 7 -2) (floor -7 -2))", "(3 -4 -4 3)"),
        ("(list (ceiling 7 2) (ceiling -7 2) (ceiling 7 -2) (ceiling -7 -2))", "(4 -3 -3 4)"),
        ("(list (truncate 7 2) (truncate -7 2))", "(3 -3)"),
        ("(list (round 7 2) (round 5 2) (round -5 2) (round 8 3) (round 7 3))", "(4 2 -2 3 2)"),
        ("(floor 7.5 2)", "3"),
        ("(list (mod 7 3) (mod -7 3) (mod 7 -3) (mod -7 -3))", "(1 2 -2 -1)"),
        ("(list (rem 7 3) (rem -7 3) (rem 7 -3) (rem -7 -3))", "(1 -1 1 -1)"),
        ("(mod 5.5 2)", "1.5"),
        ("(mod -5.5 2)", "0.5"),
        ("(list (isqrt 15) (isqrt 16))", "(3 4)"),
        ("(float 2)", "2.0"),
        (
            "(map parse-number '(\"12\" \" -1.5 \" \"90deg\" \"abc\" \"12x\" \"\"))",
            "(12 -1.5 1.5707963267948966 nil nil nil)",
        ),
        ("(number->string 2.0)", "\"2.0\""),
    ]);
}

#[test]
fn powers_and_angles() {
    check(&[
        ("(sqrt 16)", "4.0"),
        ("(expt 2 10)", "1024"),
        ("(expt 2 -2)", "0.25"),
        ("(expt 2.0 3)", "8.0"),
        ("(expt 4 0.5)", "2.0"),
        ("(expt -1 4294967297)", "-1"),
        ("(expt 0 0)", "1"),
        ("(exp 0)", "1.0"),
        ("(ln 1)", "0.0"),
        ("(ln 8 2)", "3.0"),
        ("(list (sin 0) (cos 0) (tan 0))", "(0.0 1.0 0.0)"),
        ("(= (asin 1) (acos 0) 90deg)", "t"),
        ("(= (atan 1) 45deg)", "t"),
        ("(= (atan 1 -1) 135deg)", "t"),
        ("(hypot 3 4)", "5.0"),
        ("(= (deg->rad 180) 180deg)", "t"),
        ("(rad->deg 180deg)", "180.0"),
        ("(< (abs (- (normalize-angle 270deg) -90deg)) 0.000001)", "t"),
        ("(list (- 0.0) (/ 1.0 2) (/ 2))", "(-0.0 0.5 0.5)"),
        ("(= 9007199254740993 9007199254740992.0)", "nil"),
        ("(< 9007199254740992.0 9007199254740993)", "t"),
        ("(funcall #'< 9007199254740992.0 9007199254740993)", "t"),
        ("(list (< 1 +nan.0) (= 1 +nan.0) (/= 1 +nan.0))", "(nil nil t)"),
        ("(= (normalize-angle -180deg) 180deg)", "t"),
    ]);
}

#[test]
fn what_has_no_value_fails() {
    check_failures(&[
        ("(/ 1 0)", "arithmetic-error: division by zero"),
        ("(/ 1.0 0.0)", "arithmetic-error: division by zero"),
        ("(/= 1 (car '(a)))", "type-error: an operand of `/=` must be a number, and it is the symbol a"),
        ("(/ (car '(a)) 2)", "type-error: an operand of `/` must be a number, and it is the symbol a"),
        ("(mod 1 0)", "arithmetic-error: division by zero"),
        ("(floor 1 0)", "arithmetic-error: division by zero"),
        ("(expt 0 -1)", "arithmetic-error: division by zero"),
        ("(apply + '(9223372036854775807 1))", "arithmetic-error"),
        ("(* 9223372036854775807 2)", "arithmetic-error"),
        ("(- -9223372036854775807 2)", "arithmetic-error"),
        ("(/ -9223372036854775808 -1)", "arithmetic-error"),
        ("(floor -9223372036854775808 -1)", "arithmetic-error"),
        ("(abs -9223372036854775808)", "arithmetic-error"),
        ("(- -9223372036854775808)", "arithmetic-error"),
        ("(expt 10 19)", "arithmetic-error: the power does not fit in a 64-bit integer"),
        ("(floor 1e300)", "arithmetic-error"),
        ("(sqrt -1)", "arithmetic-error: -1.0 has no real square root: it is negative"),
        ("(ln 0)", "arithmetic-error: 0.0 has no logarithm"),
        ("(asin 2)", "arithmetic-error: 2.0 has no arc sine"),
        ("(expt -8 0.5)", "arithmetic-error: -8.0 to the power 0.5 is no real number"),
        ("(clamp 1 3 2)", "arithmetic-error: the range from 3 to 2 is empty"),
        ("(apply + '(1 x))", "type-error: argument 2 of `+` must be a number, and it is the symbol x"),
        ("(max 1 \"a\")", "type-error: argument 2 of `max` must be a number, and it is the string \"a\""),
        ("(evenp 1.5)", "type-error: argument 1 of `evenp` must be an integer, and it is the float 1.5"),
        ("(= 1 'a 2)", "type-error"),
    ]);
}

proptest! {
    /// Quotient and remainder belong together, for both pairs of operations.
    #[test]
    fn division_with_remainder(a in -1000i64..1000, b in prop_oneof![-50i64..-1, 1i64..50]) {
        let text = format!(
            "(list (= {a} (+ (* {b} (floor {a} {b})) (mod {a} {b})))
                   (= {a} (+ (* {b} (truncate {a} {b})) (rem {a} {b})))
                   (<= (abs (- (* {b} (round {a} {b})) {a})) (/ (abs {b}) 2)))"
        );
        prop_assert_eq!(evaluate(&text), Ok("(t t t)".to_string()));
    }

    /// Division of integers by the rules of exact arithmetic.
    #[test]
    fn two_argument_rounding_is_that_of_the_exact_quotient(a in -1000i64..1000, b in prop_oneof![-50i64..-1, 1i64..50]) {
        let exact = a as f64 / b as f64;
        let expected = format!("({} {} {} {})", exact.floor(), exact.ceil(), exact.trunc(), exact.round_ties_even())
            .replace("-0 ", "0 ").replace("-0)", "0)");
        let text = format!("(list (floor {a} {b}) (ceiling {a} {b}) (truncate {a} {b}) (round {a} {b}))");
        prop_assert_eq!(evaluate(&text), Ok(expected));
    }
}
