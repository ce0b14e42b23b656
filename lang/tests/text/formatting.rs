//! The formatter: what it makes of each construct, and what it never changes.

use proptest::prelude::*;
use rpl_lang::formatter::format;
use rpl_lang::lexer::{Token, lex};
use rpl_lang::pretty::print;
use rpl_lang::reader::read;
use rpl_lang::source::SourceId;
use rpl_lang::symbol::Symbols;
use rpl_lang::syntax::Tree;

fn formatted(text: &str) -> String {
    match format(text, SourceId(0)) {
        Ok(formatted) => formatted,
        Err(faults) => panic!("{text}\n{faults:?}"),
    }
}

/// The data of a text, one a line, and its comments.
fn content(text: &str) -> (String, Vec<String>) {
    let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
    let (roots, faults) = read(text, SourceId(0), &mut symbols, &mut tree);
    assert!(faults.is_empty(), "{text}\n{faults:?}");
    let data = roots.iter().map(|&root| print(&tree, &symbols, root) + "\n").collect();
    let (tokens, _) = lex(text, SourceId(0));
    let is_comment = |token: &Token| token.is_comment() || *token == Token::DatumComment;
    let comments = tokens.iter().filter(|(token, _)| is_comment(token));
    let text_of = |start: u32, end: u32| text[start as usize..end as usize].trim_end().to_string();
    (data, comments.map(|(_, span)| text_of(span.start, span.end)).collect())
}

/// Formats a text and holds what must be true of every text.
fn check(text: &str) -> String {
    let once = formatted(text);
    assert_eq!(content(&once), content(text), "{text}");
    let twice = formatted(&once);
    assert_eq!(twice, once, "formatting is not at rest after one time:\n{text}");
    for line in once.lines().filter(|_| !text.contains(['"', '|'])) {
        assert_eq!(line.trim_end(), line, "{text}");
    }
    once
}

/// Both texts, of which the second is what the formatter makes of the first and of itself.
fn becomes(text: &str, expected: &str) {
    assert_eq!(check(text), expected);
    assert_eq!(check(expected), expected);
}

/// r[eval.qualified]
#[test]
fn a_qualifier_changes_nothing_about_the_layout() {
    let long = "(a-rather-long-form with some arguments)";
    for form in [
        format!("(loop while (is-there-more-to-do?) {long} {long} {long})"),
        format!("(n-times 3 {long} {long} {long})"),
        format!("(with-timeout 30 :active {long} {long} {long})"),
        format!("(defmacro twice (times &body body) {long} {long} {long})"),
    ] {
        let plain = check(&form);
        for qualifier in ["library:", "global:"] {
            let qualified = check(&form.replacen('(', &format!("({qualifier}"), 1));
            assert_eq!(qualified, plain.replacen('(', &format!("({qualifier}"), 1));
        }
    }
    let own = "(library:defmacro twice (times &body body) (list times body))\n";
    let body = |head: &str| format!("({head} 3\n  {long}\n  {long}\n  {long})\n");
    let call = |head: &str| format!("{own}({head} 3 {long} {long} {long})\n");
    becomes(&call("twice"), &format!("{own}{}", body("twice")));
    becomes(&call("global:twice"), &format!("{own}{}", body("global:twice")));
    assert_ne!(check(&call("library:twice")), format!("{own}{}", body("library:twice")));
}

#[test]
fn lines_end_in_line_feeds() {
    for end in ["\r\n", "\r"] {
        let text = ["(seq ; first", "   (print \"two", "lines\")", "", "", "#| a", "b |#", "(look))"].join(end);
        let laid_out = "(seq ; first\n  (print \"two\nlines\")\n\n  #| a\nb |#\n  (look))\n";
        assert_eq!(formatted(&text), laid_out);
        assert_eq!(content(&text).0, content(&check(laid_out)).0);
    }
}

#[test]
fn what_is_formatted_stays_as_it_is() {
    for text in [
        "",
        "; only a comment\n",
        "(def-plan go (to)\n  \"Drives.\"\n  (activate navigation\n            :targets (list to)\n            :speed 0.3))\n",
        "(let ((a 1)\n      (plan (compute 1\n                     2)))\n  (foo a\n       plan))\n",
        "(if (ready)\n    (go)\n    (stop))\n",
        "(cond ((a) 1)\n      ((b)\n       (foo)\n       2)\n      (t\n       3))\n",
        "(case x\n  ((a b) 1)\n  (otherwise\n   (foo)\n   2))\n",
        "(loop while (more?)\n  (step)\n  until (done?))\n",
        "(loop\n  (step)\n  until (done?))\n",
        "(with-policies ((keep-charged)\n                (keep-localized))\n  (deliver))\n",
        "(with-valve wheels\n  (drive))\n",
        "(with-failure-handling\n    ((timeout (f)\n       (refail))\n     ((blocked unreachable) (f)\n       nil))\n  (go))\n",
        "(par (a)\n     (b))\n",
        "(par\n  (a)\n  (b))\n",
        "(plan ((:tag a\n         (foo))\n       (:tag b (bar)))\n  (:order a b))\n",
        "(whenever (< battery 30)\n  (charge))\n",
        "(evap-protect\n  (work)\n  (clean))\n",
        "(unwind-protect (work)\n  (clean))\n",
        "(map (lambda (x)\n       (foo x))\n     list)\n",
        "(defvar rooms '(hall\n                (kitchen 1)\n                office))\n",
        "(execute-plan '(seq (a)\n                    (b)))\n",
        "(defmacro twice (&rest forms)\n  `(progn ,@forms\n          ,@forms))\n",
        "(print\n  (compute))\n",
        "(deftest a-name\n  \"Doc.\"\n  :seed 3\n  (assert (= 1 1)))\n",
    ] {
        becomes(text, text);
    }
}

#[test]
fn atoms_stay_as_they_are_written() {
    becomes("(WAIT-TIME   15cm)\n(≤ 1 2)(foo  1.50 #'Bar 'X)", "(WAIT-TIME 15cm)\n(≤ 1 2)\n(foo 1.50 #'Bar 'X)\n");
    becomes("`( a , @b ,@c . d )", "`(a , @b ,@c . d)\n");
    becomes("(print \"two\n  lines  \"\n 3)", "(print \"two\n  lines  \"\n       3)\n");
}

#[test]
fn closers_go_to_the_line_before_and_blank_lines_become_one() {
    becomes("\n\n(seq\n  (a)\n\n\n  (b)\n  )\n\n\n(c)\n\n", "(seq\n  (a)\n\n  (b))\n\n(c)\n");
    becomes("(\n  foo\n  1)", "(foo\n  1)\n");
}

#[test]
fn comments_stay_where_they_are() {
    becomes("(seq ; why\n (a) ; a\n (bcd) ; b\n)", "(seq     ; why\n  (a)    ; a\n  (bcd)) ; b\n");
    becomes("(seq (a)\n; last\n)", "(seq (a)\n     ; last\n     )\n");
    becomes(
        "(let ((a 1) ; one\n (b 2)) ; two\n ; body\n (c))",
        "(let ((a 1)  ; one\n      (b 2)) ; two\n  ; body\n  (c))\n",
    );
    becomes("(foo #| x |#   1 #;(a  b) 2)", "(foo #| x |# 1 #;(a b) 2)\n");
    becomes("' ; odd\n x", "' ; odd\n x\n");
    becomes("(a ; x\n) ; y", "(a) ; x\n; y\n");
    becomes("(a) (b) ; both\n#| c |# (d)", "(a)\n(b) ; both\n#| c |# (d)\n");
}

#[test]
fn a_macro_of_the_text_with_a_body_is_indented_by_its_parameters() {
    let definition = "(defmacro near (place distance &body body)\n  `(if (near? ,place ,distance) (progn ,@body)))\n";
    becomes(
        &format!("{definition}(near 'a\n3\n(go)\n(stop))"),
        &format!("{definition}(near 'a\n    3\n  (go)\n  (stop))\n"),
    );
}

#[test]
fn what_is_too_long_is_broken_where_its_rule_says() {
    let long = "(compute-something-of-some-length 1 2 3)";
    becomes(
        &format!("(when (ready?) {long} {long} {long})"),
        &format!("(when (ready?)\n  {long}\n  {long}\n  {long})\n"),
    );
    becomes(
        &format!("(setf where {long} when {long} why {long})"),
        &format!("(setf where\n      {long}\n      when\n      {long}\n      why\n      {long})\n"),
    );
    becomes(
        &format!("(go-to :targets {long} :speed {long} :mode {long})"),
        &format!("(go-to :targets {long}\n       :speed {long}\n       :mode {long})\n"),
    );
    let words = "words ".repeat(30);
    let filled = check(&format!("(list {words})"));
    assert_eq!(filled.lines().count(), 2, "{filled}");
}

#[test]
fn a_text_with_faults_is_refused() {
    assert!(format("(print 1", SourceId(0)).is_err());
    assert!(format("3d", SourceId(0)).is_err());
}

#[test]
fn deep_texts_are_formatted() {
    let deep = |open: &str| format!("{}x{}", open.repeat(450), ")".repeat(450));
    for open in ["(", "(seq a ", "(f ", "'(", "(let ((a 1)) b "] {
        check(&deep(open));
    }
}

/// A program with its spaces, breaks and comments.
fn program() -> impl Strategy<Value = String> {
    let gap = prop_oneof![
        8 => Just(" ".to_string()),
        4 => "\n {0,12}",
        1 => "\n\n\n?",
        1 => " ?; [a-z]{0,8}\n",
        1 => "\n; [a-z]{0,60}\n {0,4}",
        1 => Just(" #| x |# ".to_string()),
        1 => Just(" #| x\ny |# ".to_string()),
        1 => Just(" #;(a 1)".to_string()),
    ];
    let head = prop::sample::select(vec![
        "seq",
        "par",
        "let",
        "let*",
        "if",
        "cond",
        "case",
        "loop",
        "n-times",
        "when",
        "with-policy",
        "with-policies",
        "with-failure-handling",
        "plan",
        ":tag",
        ":order",
        "lambda",
        "def-plan",
        "defmacro",
        "defun",
        "foo",
        "LOOP",
        "a-function-with-a-name-that-is-rather-long",
        "quote",
        "with-anything",
        "deftest",
        "until",
        "evap-protect",
    ]);
    let atom = prop_oneof![
        "[a-z][a-z0-9*?-]{0,14}",
        ":[a-z]{1,8}",
        Just("15cm".to_string()),
        Just("until".to_string()),
        Just("while".to_string()),
        Just("&rest".to_string()),
        Just("\"a string; no comment\"".to_string()),
        Just("\"two\n lines\"".to_string()),
        Just("()".to_string()),
    ];
    let leaf = (gap.clone(), atom).prop_map(|(gap, atom)| gap + &atom);
    let form = leaf.prop_recursive(6, 120, 8, move |inner| {
        let mark = prop::sample::select(vec!["", "", "", "", "'", "`", ",", ",@", "#'", "' "]);
        let items = prop::collection::vec(inner, 0..8);
        (gap.clone(), mark, prop::option::weighted(0.8, head.clone()), items, gap.clone()).prop_map(
            |(before, mark, head, items, last)| {
                format!("{before}{mark}({}{}{last})", head.unwrap_or(""), items.concat())
            },
        )
    });
    prop::collection::vec(form, 0..4).prop_map(|forms| forms.concat())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, ..ProptestConfig::default() })]

    #[test]
    fn formatting_is_at_rest_after_one_time_and_keeps_data_and_comments(text in program()) {
        // A definition at the margin may not stand inside a list.
        prop_assume!(read(&text, SourceId(0), &mut Symbols::default(), &mut Tree::default()).1.is_empty());
        check(&text);
    }
}
