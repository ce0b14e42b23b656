//! Strings, symbols, formats, predicates, hash tables.

use crate::evaluate::{check, check_failures, evaluate};
use proptest::prelude::*;
use rpl_lang::symbol::is_uninterned;
use rpl_lang::visible::quote_string;

/// r[value.strings]
#[test]
fn strings() {
    check(&[
        ("(string-append \"a\" \"b\" \"\")", "\"ab\""),
        ("(concat \"a\" 1 'x \"b\" nil)", "\"a1xbnil\""),
        ("(list (string 'abc) (string :key) (string \"s\") (string 1.0))", "(\"abc\" \"key\" \"s\" \"1.0\")"),
        ("(write-to-string '(\"a\" b))", "\"(\\\"a\\\" b)\""),
        ("(list (string= \"a\" \"a\") (string= \"a\" \"b\") (string= 'abc \"abc\"))", "(t nil t)"),
        (
            "(list (string< \"a\" \"b\" \"c\") (string> \"a\" \"b\") (string<= \"a\" \"a\") (string>= \"a\" \"b\"))",
            "(t nil t nil)",
        ),
        ("(list (string-upcase \"aé\") (string-downcase \"AÉ\"))", "(\"AÉ\" \"aé\")"),
        ("(list (substring \"hello\" 1) (substring \"héllo\" 1 3) (substring \"abc\" 3))", "(\"ello\" \"él\" \"\")"),
        (
            "(list (string-search \"l\" \"héllo\") (string-search \"l\" \"hello\" 3) (string-search \"l\" \"hello\" 9) (string-search \"\" \"\"))",
            "(2 3 nil 0)",
        ),
        ("(list (string-prefix-p \"he\" \"hello\") (string-suffix-p \"he\" \"hello\"))", "(t nil)"),
        ("(string-split \"a,b,,c\" \",\")", "(\"a\" \"b\" \"\" \"c\")"),
        ("(string-split \"aébéé\" \"é\")", "(\"a\" \"b\" \"\" \"\")"),
        ("(string-split \"a--b-c\" \"--\")", "(\"a\" \"b-c\")"),
        ("(string-split \"  two  words \")", "(\"two\" \"words\")"),
        ("(list (string-join '(\"a\" 1 b) \", \") (string-join nil))", "(\"a, 1, b\" \"\")"),
        ("(list (string-trim \"  a b \") (string-trim \"xy\" \"xyaxy\"))", "(\"a b\" \"a\")"),
        ("(string-replace \"aXbX\" \"X\" \"--\")", "\"a--b--\""),
        ("(list (string-repeat \"ab\" 3) (string-repeat \"\" 9000000000000))", "(\"ababab\" \"\")"),
        ("(string->list \"aé\")", "(\"a\" \"é\")"),
    ]);
    check_failures(&[
        (
            "(string-append \"a\" 1)",
            "type-error: argument 2 of `string-append` must be a string, and it is the integer 1",
        ),
        ("(substring \"abc\" 2 9)", "index-error: a part cannot reach up to 9: the length is 3"),
        ("(string-split \"a\" \"\")", "type-error: argument 2 of `string-split` must not be an empty string"),
        ("(string-repeat \"ab\" 10000000000)", "out-of-memory"),
    ]);
}

#[test]
fn symbols() {
    check(&[
        ("(list (symbol-name 'Abc) (symbol-name :k) (symbol-name nil))", "(\"abc\" \"k\" \"nil\")"),
        (
            "(list (intern \"ABC\") (eq (intern \"abc\") 'abc) (intern \"nil\") (intern \"T\") (make-keyword \"Goal\"))",
            "(abc t nil t :goal)",
        ),
        ("(eq (gensym) (gensym))", "nil"),
        ("(eq (intern (symbol-name 'x)) 'x)", "t"),
    ]);
    check_failures(&[
        ("(intern (symbol-name (gensym)))", "type-error: argument 1 of `intern` must be the name of a symbol"),
        ("(symbol-name 5)", "type-error: argument 1 of `symbol-name` must be a symbol, and it is the integer 5"),
    ]);
}

/// r[read.bars-written]
#[test]
fn names_are_written_so_that_they_read_back() {
    check(&[
        (
            "(map intern '(\"a b\" \".5\" \"-2\" \"nil\" \"(x)\" \"a;b\" \"x'y\" \":key\" \"1+\" \"|\" \"\" \"\\\\\" \"5m\" \"ÄÖ\" \"a\\nb\" \".\" \"...\" \"@\"))",
            r"(|a b| |.5| |-2| nil |(x)| |a;b| |x'y| |:key| 1+ |\|| || \ |5m| äö |a\nb| |.| ... @)",
        ),
        (
            "(list '|Foo| (eq '|foo| 'foo) (intern \"Foo\") (make-keyword \"a b\") (make-keyword \"12\"))",
            "(|Foo| t foo :|a b| :12)",
        ),
        ("(format \"~a ~s ~a ~s\" '|a b| '|a b| :|a b| :|a b|)", "\"a b |a b| :a b :|a b|\""),
        (
            "(list (string '|a\\nb|) (concat '|a b| '(|a b|)) (symbol-name '|library:a b|))",
            "(\"a\\nb\" \"a b(|a b|)\" \"library:a b\")",
        ),
        ("(let ((|the cup| 3)) (+ |the cup| 1))", "4"),
        ("(execute-plan (list 'let (list (list (intern \"a b\") 2)) (list 'list (intern \"a b\"))))", "(2)"),
        ("(list (|library:car| '(1)) (execute-plan '(|global:list| 2)))", "(1 (2))"),
    ]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// r[read.bars-written]
    #[test]
    fn what_is_written_of_a_symbol_is_read_as_the_same_symbol(names in prop::collection::vec(odd_name(), 1..30)) {
        let names: Vec<String> = names.iter().map(|name| quote_string(name)).collect();
        let names = names.join(" ");
        for of_name in ["intern", "make-keyword"] {
            let made = format!("(map {of_name} '({names}))");
            let written = evaluate(&made).expect("names of symbols");
            prop_assert_eq!(evaluate(&format!("(equal {made} '{written})")), Ok("t".to_string()), "{}", written);
        }
    }
}

/// Names of characters that mean something to the reader.
fn odd_name() -> impl Strategy<Value = String> {
    let scraps = vec![
        "", "a", "B", " ", "|", "\\", "(", ")", "'", "`", ",", "@", "\"", ";", "#", ":", ".", "-", "+", "1", "m", "e5",
        "\n", "\t", "\u{200b}", "\u{202e}", "ä", "İ", "≤", "nil", "t", "library:", "inf.0", "[", "{",
    ];
    prop::collection::vec(prop::sample::select(scraps), 0..5)
        .prop_map(|scraps| scraps.concat())
        .prop_filter("one that gensym has made", |name| !is_uninterned(name))
}

#[test]
fn predicates() {
    check(&[
        (
            "(list (eq 'a 'a) (eq \"a\" \"a\") (eql 1 1) (eql 1 1.0) (equal \"a\" \"a\") (equal '(1 (2)) '(1 (2))) (equal 1 1.0))",
            "(t nil t nil t t nil)",
        ),
        (
            "(list (not nil) (null '(1)) (consp nil) (consp '(1)) (listp nil) (listp 1) (atom nil) (atom '(1)))",
            "(t nil nil t t nil t nil)",
        ),
        ("(map symbolp '(a :a nil t \"a\" 1))", "(t t t t nil nil)"),
        ("(map keywordp '(a :a))", "(nil t)"),
        (
            "(list (numberp 1) (numberp 1.5) (numberp 'a) (integerp 1) (integerp 1.0) (floatp 1.0) (floatp 1))",
            "(t t nil t nil t nil)",
        ),
        (
            "(list (stringp \"a\") (stringp 'a) (functionp car) (functionp map) (functionp (lambda (x) x)) (functionp 'car))",
            "(t nil t t t nil)",
        ),
        (
            "(list (fluentp (create-fluent 1)) (fluentp 1) (taskp (this-task)) (taskp 1) (tablep (make-hash-table)) (tablep nil))",
            "(t nil t nil t nil)",
        ),
        ("(failurep (with-failure-handling ((failure (f) f)) (fail \"x\")))", "t"),
    ]);
}

/// r[value.tables] r[setf.places]
#[test]
fn entries_are_read_and_assigned_by_name_as_by_value() {
    check(&[
        // Called by name, and as values: the same.
        (
            "(let ((h (make-hash-table))) (setf (gethash '(1 #(2)) h) 'x) (list (gethash (list 1 #(2)) h) (apply gethash (list '(1 #(2)) h nil))))",
            "(x x)",
        ),
        (
            "(let ((h (make-hash-table)) (key (list 1 2))) (setf (gethash key h) 'old) (setf (car key) 5) (list (gethash '(1 2) h) (gethash key h)))",
            "(old nil)",
        ),
        (
            "(let ((h (make-hash-table)) (seen nil)) (gethash (progn (push 1 seen) 'k) (progn (push 2 seen) h) (push 3 seen)) seen)",
            "(3 2 1)",
        ),
        (
            "(let ((h (make-hash-table)) (seen nil)) (setf (gethash (progn (push 1 seen) 'k) (progn (push 2 seen) h) (push 3 seen)) (length seen)) (list seen (gethash 'k h)))",
            "((3 2 1) 3)",
        ),
        ("(let ((h (make-hash-table)) (k 'a)) (setf (gethash k h) (progn (setq k 'b) 1)) (hash-table-keys h))", "(a)"),
        (
            "(let ((h (make-hash-table))) (list (setf (gethash \"k\" h) 7) (gethash (string-append \"\" \"k\") h)))",
            "(7 7)",
        ),
        ("(list (mod 7 3) (mod -7 3) (mod 7 -3) (mod 7.5 2) (mod -7 2.0) (apply mod '(-7 3)))", "(1 2 -2 1.5 1.0 2)"),
    ]);
    check_failures(&[
        ("(gethash 'k '(1 2))", "argument 2 of `gethash` must be a hash table, and it is a list"),
        ("(setf (gethash 'k 3) 1)", "argument 2 of `(setf gethash)` must be a hash table, and it is the integer 3"),
        ("(mod 'a 3)", "argument 1 of `mod` must be a number, and it is the symbol a"),
        ("(mod 3 nil)", "argument 2 of `mod` must be a number, and it is nil"),
        ("(mod 3 0)", "division by zero"),
        (
            "(defvar h (make-hash-table)) (defun note () (setf (gethash 1 h) 2) t) (def-fluent f 1) (wait-for (and (note) f))",
            "an element or entry cannot be assigned while a fluent network",
        ),
    ]);
}

/// r[value.tables]
#[test]
fn hash_tables() {
    check(&[
        (
            "(let ((h (make-hash-table))) (setf (gethash \"k\" h) 1) (list (gethash \"k\" h) (gethash 'x h) (gethash 'x h 9) (hash-table-count h)))",
            "(1 nil 9 1)",
        ),
        (
            "(let ((h (make-hash-table))) (dolist (k '(5 3 9 1 7)) (setf (gethash k h) (* k k))) (remhash 5 h) (setf (gethash 4 h) 0) (list (hash-table-keys h) (hash-table-values h)))",
            "((1 3 4 7 9) (1 9 0 49 81))",
        ),
        ("(let ((h (make-hash-table :test equal))) (setf (gethash '(1 2) h) 'a) (gethash (list 1 2) h))", "a"),
        (
            "(let ((h (make-hash-table))) (setf (gethash 1 h) 'int (gethash 1.0 h) 'float) (list (gethash 1 h) (gethash 1.0 h)))",
            "(int float)",
        ),
        ("(let ((h (make-hash-table))) (setf (gethash 0.0 h) 'zero) (gethash -0.0 h))", "zero"),
        ("(let ((h (make-hash-table))) (incf (gethash 'a h 0)) (incf (gethash 'a h 0) 5) (gethash 'a h))", "6"),
        (
            "(let ((h (make-hash-table))) (push 1 (gethash 'a h)) (push 2 (gethash 'a h)) (list (pop (gethash 'a h)) (gethash 'a h)))",
            "(2 (1))",
        ),
        (
            "(let ((h (alist->hash-table '((b . 2) (a . 1) (b . 3))))) (list (sort string< (hash-table-keys h)) (gethash 'b h) (hash-table-count h)))",
            "((a b) 2 2)",
        ),
        (
            "(let ((h (alist->hash-table '((3 . c) (1 . a))))) (list (hash-table-keys h) (hash-table-values h) (hash-table->alist h)))",
            "((1 3) (a c) ((1 . a) (3 . c)))",
        ),
        (
            "(let ((h (alist->hash-table '((1 . a))))) (list (remhash 1 h) (remhash 1 h) (hash-table-contains-p 1 h)))",
            "(t nil nil)",
        ),
        (
            "(let ((h (alist->hash-table '((1 . nil))))) (list (hash-table-contains-p 1 h) (hash-table-count (clrhash h))))",
            "(t 0)",
        ),
        (
            "(let ((found nil)) (maphash (lambda (k v) (push (list k v) found)) (alist->hash-table '((1 . a) (2 . b)))) found)",
            "((2 b) (1 a))",
        ),
    ]);
    check_failures(&[
        ("(gethash 1 2)", "type-error: argument 2 of `gethash` must be a hash table, and it is the integer 2"),
        (
            "(setf (gethash (iota 100001) (make-hash-table)) 1)",
            "type-error: this has more than 100000 parts and is too large to be the key of a hash table",
        ),
        // Sixty pairs that make a tree of 2^60 leaves.
        (
            "(let ((x (list 1))) (dotimes (i 60) (setq x (cons x x))) (gethash x (make-hash-table)))",
            "type-error: this has more than 100000 parts",
        ),
        ("(make-hash-table :size 5)", "arity-error: `make-hash-table` takes no arguments"),
    ]);
}

/// r[value.format]
#[test]
fn formats() {
    check(&[
        ("(format \"plain\")", "\"plain\""),
        ("(format \"~a ~s\" \"x\" \"x\")", "\"x \\\"x\\\"\""),
        ("(format \"~A and ~S\" 'x '(1 \"b\"))", "\"x and (1 \\\"b\\\")\""),
        ("(format \"~d ~d\" 3 2.5)", "\"3 2.5\""),
        ("(format \"~,2f|~,0f|~f\" 3.14159 2.5 1)", "\"3.14|2|1.0\""),
        ("(format \"~5d|~8,2f|~4a|~1d\" 42 3.14159 'x 12345)", "\"   42|    3.14|x   |12345\""),
        ("(format \"a~%b~~\")", "\"a\\nb~\""),
        ("(format \"a~\n   é~a~3%\" \"~a\")", "\"aé~a\\n\\n\\n\""),
        ("(format \"~a~3a~a\" '(1 \"x\") #(2) (make-hash-table))", "\"(1 \\\"x\\\")#(2)#<hash-table of 0>\""),
    ]);
    check_failures(&[
        ("(format \"~a ~a\" 1)", "type-error: directive 2 of the format, `~a`, has no argument"),
        ("(format \"~a\" 1 2)", "type-error: the format has 1 directives, and there are 2 values for them"),
        ("(format \"~q\" 1)", "type-error: `~q` is no directive of a format"),
        ("(format \"x~\")", "type-error: the format ends in the middle of a directive"),
        ("(format \"~,2f\" 'x)", "type-error: the argument of `~f` must be a number, and it is the symbol x"),
        ("(format \"~99999999999d\" 1)", "type-error: a width or number of decimals in a format is at most 1000"),
        ("(format 5)", "type-error: argument 1 of `format` must be a string, and it is the integer 5"),
    ]);
}

proptest! {
    #[test]
    fn a_string_survives_splitting_and_joining(words in prop::collection::vec("[a-zé]{0,5}", 1..6)) {
        let text = words.join(",");
        prop_assert_eq!(
            evaluate(&format!("(string-join (string-split \"{text}\" \",\") \",\")")),
            Ok(format!("\"{text}\""))
        );
        prop_assert_eq!(
            evaluate(&format!("(length (string-split \"{text}\" \",\"))")),
            Ok(words.len().to_string())
        );
    }

    #[test]
    fn substrings_put_together_are_the_string(text in "[a-zé€]{0,12}", at in 0usize..12) {
        let at = at.min(text.chars().count());
        let form = format!("(string-append (substring \"{text}\" 0 {at}) (substring \"{text}\" {at}))");
        prop_assert_eq!(evaluate(&form), Ok(format!("\"{text}\"")));
    }

    #[test]
    fn fixed_decimals_are_within_half_a_unit(value in -1000.0f64..1000.0, decimals in 0usize..6) {
        let text = evaluate(&format!("(format \"~,{decimals}f\" {value:?})")).expect("formats");
        let text = text.trim_matches('"');
        prop_assert_eq!(text.split_once('.').map_or(0, |(_, digits)| digits.len()), decimals);
        let read: f64 = text.parse().expect("a number");
        prop_assert!((read - value).abs() <= 0.5000001 * std::iter::repeat_n(0.1, decimals).product::<f64>());
    }
}
