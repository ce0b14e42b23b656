//! What texts read as.

use proptest::prelude::*;
use rpl_lang::diagnostic::Diagnostic;
use rpl_lang::lexer::{Token, lex};
use rpl_lang::pretty::print;
use rpl_lang::reader::{Completeness, MAX_DEPTH, MAX_ERRORS, completeness, read};
use rpl_lang::source::{SourceId, Span};
use rpl_lang::symbol::Symbols;
use rpl_lang::syntax::Tree;

const SOURCE: SourceId = SourceId(0);

const ESCAPE: char = '\u{1b}';

fn read_all(text: &str) -> (Vec<String>, Vec<Diagnostic>) {
    let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
    let (roots, found) = read(text, SOURCE, &mut symbols, &mut tree);
    (roots.into_iter().map(|root| print(&tree, &symbols, root)).collect(), found)
}

fn reads_as(text: &str, data: &[&str]) {
    let (read, found) = read_all(text);
    assert_eq!(found, [], "{text}");
    assert_eq!(read, data, "{text}");
}

fn codes(text: &str) -> Vec<&'static str> {
    read_all(text).1.iter().map(|diagnostic| diagnostic.code).collect()
}

/// r[read.text]
#[test]
fn names_fold_to_lower_case() {
    reads_as("WITH-POLICY :GOAL Ünï-Ä", &["with-policy", ":goal", "ünï-ä"]);
    reads_as("(≤ a B) a≥b ≠", &["(<= a b)", "a>=b", "/="]);
}

#[test]
fn a_plan_as_printed_in_the_papers_reads_as_it_stands() {
    let plan = "(DEF-INTERP-PROC RELOCALIZE-WHEN-NECESSARY ()
  (WHENEVER (≤ POS-CERTAINTY* 0.8)
    (WITH-VALVE WHEELS
      (UNWIND-PROTECT (SEQ (ACTIVATE ACTIVE-LOCALIZATION)
                           (WAIT-FOR (> POS-CERTAINTY* 0.8)))
        (DEACTIVATE ACTIVE-LOCALIZATION)))))";
    reads_as(
        plan,
        &["(def-interp-proc relocalize-when-necessary () (whenever (<= pos-certainty* 0.8) \
                      (with-valve wheels (unwind-protect (seq (activate active-localization) \
                      (wait-for (> pos-certainty* 0.8))) (deactivate active-localization)))))"],
    );
}

/// r[read.line]
#[test]
fn line_feed_carriage_return_and_both_end_a_line() {
    for end in ["\n", "\r\n", "\r"] {
        reads_as(&format!("; a{end}b ; c{end}d"), &["b", "d"]);
        reads_as(
            &format!("\"two{end}lines, of which the \\{end}second is broken\""),
            &["\"two\\nlines, of which the second is broken\""],
        );
    }
    for no_end in ['\u{b}', '\u{c}', '\u{85}', '\u{2028}', '\u{2029}'] {
        reads_as(&format!("a ; b{no_end} c"), &["a"]);
    }
}

/// r[read.invisible]
#[test]
fn what_cannot_be_seen_stands_in_strings_and_comments_only() {
    for invisible in
        ['\u{a0}', '\u{ad}', '\u{200b}', '\u{200e}', '\u{202e}', '\u{2028}', '\u{3000}', '\u{feff}', '\u{85}', ESCAPE]
    {
        let (read, found) = read_all(&format!("(a b{invisible}c d)"));
        assert_eq!(found.len(), 1, "{invisible:?}: {found:?}");
        assert_eq!((found[0].code, found[0].span.start, read.len()), ("invisible-character", 4, 1), "{invisible:?}");
        assert!(found[0].message.contains(&format!("U+{:04X}", invisible as u32)), "{found:?}");
        let within = format!("\"b{invisible}c\" ; b{invisible}c");
        let reorders = invisible == '\u{202e}';
        assert_eq!(read_all(&within).1.len(), if reorders { 2 } else { 0 }, "{invisible:?}");
        // What is read is written so that it is seen, and read again.
        reads_as(&format!("\"b\\u{{{:x}}}c\"", invisible as u32), &[&format!("\"b\\u{{{:x}}}c\"", invisible as u32)]);
    }
    reads_as("\u{feff}a", &["a"]);
    reads_as("\u{c}a\u{b}b\tc", &["a", "b", "c"]);
}

/// r[read.comment]
#[test]
fn comments_are_no_data() {
    reads_as("a ; b\n#| c #| d |# e |# f", &["a", "f"]);
    reads_as("(a #;b c #;(d e)) #;x y", &["(a c)", "y"]);
    reads_as("#;#;a b c", &["c"]);
    reads_as("'#;a b", &["'b"]);
    reads_as("(a . #;b c)", &["(a . c)"]);
    reads_as("(a #;#;b c)", &["(a)"]);
}

/// r[read.quote]
#[test]
fn marks_stand_for_lists() {
    reads_as("(quote x) (function f) #'f ' x", &["'x", "(function f)", "f", "'x"]);
    reads_as("`(a ,b ,@c ,'d) (unquote @a)", &["`(a ,b ,@c ,'d)", ", @a"]);
    reads_as("(quote) (quote a b) (quote . a)", &["(quote)", "(quote a b)", "(quote . a)"]);
}

/// r[read.vector]
#[test]
fn a_mark_makes_a_vector_of_a_list() {
    reads_as("#(a 1 (b . c) #()) '#(x) `#(,y) #(a #;b c)", &["#(a 1 (b . c) #())", "'#(x)", "`#(,y)", "#(a c)"]);
    assert_eq!(codes("#(a . b)"), ["misplaced-dot"]);
    assert_eq!(codes("# (a)"), ["unknown-hash"]);
    assert_eq!(codes("#(a"), ["unclosed-list"]);
}

/// r[read.string]
#[test]
fn strings_and_their_escapes() {
    reads_as(
        r#""a\n\t\\\"\u{e4}\0" "two
lines""#,
        &[r#""a\n\t\\\"ä\0""#, r#""two\nlines""#],
    );
}

/// r[read.bars]
#[test]
fn a_name_of_any_characters_stands_between_bars() {
    reads_as(
        r"(|two words| |Foo| |foo| || |a\|b\\c| |\u{200b}\n| |.5| |(| :|a b| :|| '|x y| ,@|;|) |nil|",
        &[r"(|two words| |Foo| foo || |a\|b\\c| |\u{200b}\n| |.5| |(| :|a b| :|| '|x y| ,@|;|)", "nil"],
    );
    reads_as("(|library:car| |global:a b|)", &["(library:car |global:a b|)"]);
}

/// r[read.bars]
#[test]
fn what_is_wrong_about_a_name_between_bars_is_told_where_it_stands() {
    for (text, code, start) in [
        ("(a |two words) (b)", "unterminated-name", 3),
        ("(a |two\nwords|)", "unterminated-name", 3),
        ("(a |b\\q|)", "bad-escape", 5),
        ("(a |b\u{200b}|)", "invisible-character", 5),
        ("(a |b\t|)", "invisible-character", 5),
        ("(a |#:b|)", "unknown-hash", 4),
        ("(a b|c|)", "joined-name", 4),
        ("(a |b|c)", "joined-name", 6),
        ("(a |b||c|)", "joined-name", 6),
        ("(a library:|b|)", "joined-name", 11),
        ("(a 5|b|)", "joined-name", 4),
        ("(a |b|é)", "joined-name", 6),
    ] {
        let (data, found) = read_all(text);
        let Span { start: from, end, .. } = found[0].span;
        assert!(text.get(from as usize..end as usize).is_some(), "{text}: it is told in the midst of a character");
        let found: Vec<_> = found.iter().map(|found| (found.code, found.span.start)).collect();
        assert_eq!(found[0], (code, start), "{text}");
        assert!(data.len() == if text.contains("(b)") { 2 } else { 1 }, "{text}: {data:?}");
    }
    assert_eq!(codes("(a |two words) (b)"), ["unterminated-name"]);
}

#[test]
fn a_byte_order_mark_is_skipped() {
    let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
    let (roots, found) = read("\u{feff}(a)", SOURCE, &mut symbols, &mut tree);
    assert!(found.is_empty());
    assert_eq!(tree.span(roots[0]).start, 3);
}

#[test]
fn the_first_column_does_not_matter_where_all_is_closed() {
    reads_as("(seq\n(look)\n(drive))", &["(seq (look) (drive))"]);
    assert_eq!(codes("(seq\n(look)\n(drive)"), ["unclosed-list"]);
}

/// r[read.recovery]
#[test]
fn every_independent_error_is_told_at_once() {
    let text = "(def-plan a ()\n  (drive 3d)\n(def-plan b ()\n  (print \"\\q\" ')))\n)\n(c . )\n(d #x)\n(stop";
    assert_eq!(
        codes(text),
        [
            "unclosed-list",
            "bad-number",
            "bad-escape",
            "bare-prefix",
            "stray-close",
            "misplaced-dot",
            "unknown-hash",
            "unclosed-list"
        ]
    );
    assert_eq!(read_all(text).0.len(), 5);
}

#[test]
fn a_text_that_ends_in_a_string_is_one_error() {
    assert_eq!(codes("(a (b 'c \"d) e)"), ["unterminated-string"]);
    assert_eq!(codes("(a '#| b) c)"), ["unterminated-comment"]);
}

#[test]
fn errors_are_counted_after_the_twentieth() {
    let (_, found) = read_all(&"3d ".repeat(50));
    assert_eq!(found.len(), MAX_ERRORS + 1);
    assert_eq!(found[MAX_ERRORS].message, "and 30 more errors");
}

/// Runs on a stack of the size of a thread's, whatever runs the tests.
fn on_a_thread_stack(work: impl FnOnce() + Send + 'static) {
    let thread = std::thread::Builder::new().stack_size(2 << 20).spawn(work);
    thread.expect("a thread").join().expect("no panic");
}

#[test]
fn the_deepest_text_allowed_is_read_and_a_deeper_one_refused() {
    on_a_thread_stack(|| {
        for (opener, levels, closer) in [("(", 1, ")"), ("'", 1, ""), ("(a '", 2, ")"), ("#;(", 2, ")"), ("#;`", 2, "")]
        {
            let nested = |times: usize| format!("({}x{}) y", opener.repeat(times), closer.repeat(times));
            let fits = (MAX_DEPTH - 1) / levels;
            assert!(!codes(&nested(fits)).contains(&"too-deep"), "{opener}");
            let refused = nested(fits + 1);
            let (data, found) = read_all(&refused);
            assert_eq!((data, found.len()), (vec!["y".to_string()], 1), "{opener}");
            assert_eq!(found[0].code, "too-deep");
        }
        for opener in ["(", "'", "#;", "#;(", "(#;", ",@(", "(a . "] {
            let (_, found) = read_all(&opener.repeat(100_000));
            assert_eq!(found[0].code, "too-deep", "{opener}");
        }
        // Marks that are still waiting after a datum that was commented out.
        let waiting = format!("{}{}(", "#;".repeat(600), "a ".repeat(100)).repeat(3);
        assert_eq!(codes(&waiting), ["too-deep"]);
        let balanced = "(".repeat(100_000) + &")".repeat(100_000);
        assert_eq!(codes(&balanced), ["too-deep"]);
        assert_eq!(codes(&")".repeat(100_000)), ["stray-close"]);
    });
}

#[test]
fn a_prompt_asks_for_more_while_something_is_open() {
    for text in ["(", "(a (b)", "\"a", "'", "(a)\n(b", "#| a", "#;", "(a\n(b)", "`(a ,", "#;#;a", "'#;a", "(a \"b\\\""]
    {
        assert_eq!(completeness(text), Completeness::Incomplete, "{text}");
    }
    for text in ["", "a", "(a)", "(a))", "\"a\"", "'a", "; (", "#|(|#", "#;(a)", "3d", "\0", ")("] {
        assert_eq!(completeness(text), Completeness::Complete, "{text}");
    }
}

#[test]
fn tokens_cover_comments() {
    let kinds: Vec<_> = lex("(a ;b\n#|c|# 1.5)", SOURCE).0.into_iter().map(|(token, _)| token).collect();
    assert_eq!(
        kinds,
        [Token::Open, Token::Symbol, Token::LineComment, Token::BlockComment, Token::Float(1.5), Token::Close]
    );
}

/// Texts made of what the reader knows, in any order.
fn scraps() -> impl Strategy<Value = String> {
    let scrap = prop::sample::select(vec![
        "(", ")", "'", "`", ",", ",@", "#'", "#;", "#|", "|#", "\"", "\\", ";", "\n", "\n(", " ", ".", "a", "Def", "1",
        "3d", "1+", ":k", ":", "#", "≤", "\u{1}", "[", "|", "\u{2028}", "\r", "\\u{41}", "ä",
    ]);
    prop::collection::vec(scrap, 0..60).prop_map(|scraps| scraps.concat())
}

fn check_reading(text: &str) -> Result<(), TestCaseError> {
    let mut sources = rpl_lang::source::Sources::default();
    let source = sources.add("scraps", text);
    let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
    let (_, found) = read(text, source, &mut symbols, &mut tree);
    for node in &tree.nodes {
        prop_assert!(node.span.start <= node.span.end && node.span.end as usize <= text.len());
        prop_assert!(text.is_char_boundary(node.span.start as usize) && text.is_char_boundary(node.span.end as usize));
    }
    let drawn = rpl_lang::diagnostic::render(&found, &sources, false);
    prop_assert!(!drawn.contains(ESCAPE));
    let heads = drawn.lines().filter(|line| line.starts_with("error[")).count();
    prop_assert_eq!(heads, found.len());
    for (token, span) in lex(text, source).0 {
        prop_assert!(span.start < span.end, "{:?}", token);
    }
    if found.is_empty() {
        prop_assert_eq!(completeness(text), Completeness::Complete);
    }
    Ok(())
}

proptest! {
    #[test]
    fn reading_and_rendering_never_panic(text in "\\PC*") {
        check_reading(&text)?;
    }

    #[test]
    fn nor_on_scraps_of_the_language(text in scraps()) {
        check_reading(&text)?;
    }

    #[test]
    fn nor_on_any_characters(text in any::<String>()) {
        check_reading(&text)?;
    }
}
