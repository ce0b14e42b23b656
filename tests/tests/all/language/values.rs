//! Values: what a text can write down, how values compare and print, the library around them.

use rpl_runtime::run::system::Progress;
use rpl_tests::{check, run, system};

/// r[read.number], r[read.one-plus]
#[test]
fn numbers_are_read() {
    check(
        "(list 9223372036854775807 -9223372036854775808 1e3 .5 5. -2)",
        "=> (9223372036854775807 -9223372036854775808 1000.0 0.5 5.0 -2)",
    );
    check("(list (1+ 1) (1- 1) (map 1+ '(1 2)))", "=> (2 0 (2 3))");
    for text in ["9223372036854775808", "1x", "1/2", "0x10", "1e999"] {
        let found = run(text);
        assert!(found.starts_with("error[bad-number]"), "{text}\n{found}");
    }
}

/// r[read.unit], r[read.unknown-unit]
#[test]
fn a_number_with_a_unit_is_a_float_in_si() {
    check(
        "(list 15cm 2.5m 2km 3mm 90deg 0.5rad 250ms 2s 3min 8h 0.3m/s 36km/h 30deg/s 500g 50% -2cm)",
        "=> (0.15 2.5 2000.0 0.003 1.5707963267948966 0.5 0.25 2.0 180.0 28800.0 0.3 10.0 0.5235987755982988 0.5 0.5 -0.02)",
    );
    let unknown = run("(wait-time 3d)");
    assert!(unknown.contains("1:12") && unknown.contains("the known units are m cm mm km deg"), "{unknown}");
}

/// r[read.truth], r[read.comment]
#[test]
fn truth_and_what_stands_for_itself() {
    check(
        "(list (if nil 1 2) (if () 1 2) (if 0 1 2) (if \"\" 1 2) (eq nil '()) t :goal (eq :A ':a))",
        "=> (2 2 1 1 t t :goal t)",
    );
    check(";#||##;\n(list 1 #;(2 #;3 4) #| #| 5 |# |# 6)", "=> (1 6)");
}

/// r[read.recovery]
#[test]
fn what_cannot_be_read_is_told_once() {
    let found = run("(defun f (x) (1x x))\n(print ')\n(f 1)");
    let codes: Vec<&str> = found.lines().filter_map(|line| line.strip_prefix("error[")).collect();
    assert_eq!(codes.len(), 2, "{found}");
    assert!(codes[0].starts_with("bad-number") && codes[1].starts_with("bare-prefix"), "{found}");
    assert!(found.contains("test.rpl:1:15") && found.contains("test.rpl:2:8"), "{found}");
}

/// r[value.numbers], r[value.division], r[value.overflow]
#[test]
fn comparing_and_computing() {
    check(
        "(list (= 1 1.0) (equal 1 1.0) (equal '(1 (\"a\")) '(1 (\"a\"))) (eq \"a\" \"a\") (eq 'a 'a))",
        "=> (t nil t nil t)",
    );
    check("(list (/ 6 3) (/ 6 4) (/ 6 4.0) (floor 7 2) (mod -7 3))", "=> (2 1.5 1.5 3 2)");
    for (text, class) in [
        ("(= 'a 1)", "type-error"),
        ("(/ 1 0)", "arithmetic-error"),
        ("(+ 9223372036854775807 1)", "arithmetic-error"),
        ("(- -9223372036854775808)", "arithmetic-error"),
        ("(abs -9223372036854775808)", "arithmetic-error"),
        ("(let ((n 9223372036854775807)) (incf n))", "arithmetic-error"),
    ] {
        let found = run(text);
        assert!(found.starts_with(&format!("failed: {class}")), "{text}\n{found}");
    }
}

/// r[value.print]
#[test]
fn print_writes_a_line_and_returns_its_argument() {
    check(
        "(list (print \"a \\\"b\\\"\") (print '(\"a\" 1.0 :k x nil t)))",
        "a \"b\"\n(\"a\" 1.0 :k x nil t)\n=> (\"a \\\"b\\\"\" (\"a\" 1.0 :k x nil t))",
    );
    check(
        "(print (list 0.1 100.0 1e23 1e-7 (/ 1 3.0) -0.0))",
        "(0.1 100.0 1.0e23 1.0e-7 0.3333333333333333 -0.0)\n=> (0.1 100.0 1.0e23 1.0e-7 0.3333333333333333 -0.0)",
    );
}

/// r[value.format]
#[test]
fn format_returns_a_string() {
    check("(format \"~a|~s|~d|~,2f|~%|~~\" \"x\" \"x\" 42 3.14159)", "=> \"x|\\\"x\\\"|42|3.14|\\n|~\"");
    for text in ["(format \"~a\")", "(format \"~q\" 1)", "(format \"~,2f\" 'a)"] {
        let found = run(text);
        assert!(found.starts_with("failed: type-error"), "{text}\n{found}");
    }
}

/// r[value.log]
#[test]
fn log_writes_elsewhere_and_returns_its_argument() {
    check("(list (log \"seen\") (log '(1 \"b\")))", "log: seen\nlog: (1 \"b\")\n=> (\"seen\" (1 \"b\"))");
}

/// r[value.measure]
#[test]
fn the_last_measure_of_a_name_counts_and_a_run_has_a_hundred() {
    let mut measured = system("(measure 'rooms 1) (measure 'way 2.5) (measure 'rooms 4)");
    while measured.advance() == Progress::Running {}
    let machine = &measured.machine;
    let found: Vec<(&str, f64)> =
        machine.measures.iter().map(|(name, number)| (machine.symbols.name(name), number)).collect();
    assert_eq!(found, [("rooms", 4.0), ("way", 2.5)]);
    check("(measure 'rooms 4)", "=> 4");
    let many = |count: usize| format!("(dotimes (i {count}) (measure (intern (format \"m~a\" i)) i))");
    check(&many(100), "=> nil");
    let failure = run(&many(101));
    assert!(failure.contains("a run has at most 100 measures, and `m100` would be one more"), "{failure}");
    for (wrong, why) in [("\"a\" 1", "a symbol"), ("'a nil", "a number"), ("'a +inf.0", "must be finite")] {
        let failure = run(&format!("(measure {wrong})"));
        assert!(failure.contains(why), "{failure}");
    }
}

/// r[value.random]
#[test]
fn random_numbers_are_below_their_bound_and_the_same_in_every_run() {
    let text = "(let ((seen nil)) (dotimes (i 200) (push (list (random 6) (random 0.5)) seen)) seen)";
    assert_eq!(run(text), run(text));
    check(
        "(every (lambda (n) (and (<= 0 (random 6) 5) (<= 0.0 (random 0.5)) (< (random 0.5) 0.5))) (range 0 500))",
        "=> t",
    );
}

/// r[value.order], r[value.nth], r[value.lists]
#[test]
fn lists() {
    check(
        "(list (map 1+ '(1 2)) (map + '(1 2) '(10 20)) (filter evenp '(1 2 4)) (reduce + '(1 2 3)) (find evenp '(1 2)) (every evenp '(2 4)) (some evenp '(1 3)))",
        "=> ((2 3) (11 22) (2 4) 6 2 t nil)",
    );
    // `sort` keeps the order of equals and leaves its argument alone.
    check(
        "(let ((l (list '(2 a) '(1 b) '(2 c) '(1 d)))) (list (sort (lambda (x y) (< (car x) (car y))) l) (length l) (car l)))",
        "=> (((1 b) (1 d) (2 a) (2 c)) 4 (2 a))",
    );
    check(
        "(list (nth 5 '(1)) (append '(1) '(2 3) nil) (reverse '(1 2)) (last '(1 2)) (butlast '(1 2)) (member 2 '(1 2 3)) (count 1 '(1 2 1)))",
        "=> (nil (1 2 3) (2 1) (2) (1) (2 3) 2)",
    );
    check("(with-failure-handling ((index-error () 'index)) (setf (nth 3 (list 1)) 2))", "=> index");
}

/// r[value.alists], r[value.tables], r[value.strings]
#[test]
fn association_lists_tables_and_strings() {
    check(
        "(let ((a '((x . 1) (\"y\" . 2)))) (list (assoc \"y\" a) (assoc-value 'x a) (assoc-value 'z a) (alist-keys a) (rassoc 1 a) (acons 'w 0 nil)))",
        "=> ((\"y\" . 2) 1 nil (x \"y\") (x . 1) ((w . 0)))",
    );
    check(
        "(let ((h (make-hash-table)))
           (setf (gethash 3 h) 'c (gethash \"a\" h) 2 (gethash '(1) h) 3 (gethash 1 h) 'a)
           (remhash \"a\" h)
           (let ((first-two (subseq (hash-table-keys h) 0 2)) (sum 0))
             (maphash (lambda (key value) (incf sum)) h)
             (list first-two sum (hash-table-count h) (gethash '(1) h) (gethash 'none h 'default))))",
        "=> ((1 3) 3 3 3 default)",
    );
    check(
        "(list (string-append \"a\" \"b\") (length \"abc\") (elt \"abc\" 1) (subseq \"abc\" 1) (string-upcase \"a\") (string-split \"a,b\" \",\") (string-search \"c\" \"abc\"))",
        "=> (\"ab\" 3 \"b\" \"bc\" \"A\" (\"a\" \"b\") 2)",
    );
}
