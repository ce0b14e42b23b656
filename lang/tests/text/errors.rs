//! Every reading error, with its text: the text, what is said of it, what is read nevertheless.

use rpl_lang::diagnostic::render;
use rpl_lang::pretty::print;
use rpl_lang::reader::read;
use rpl_lang::source::Sources;
use rpl_lang::symbol::Symbols;
use rpl_lang::syntax::Tree;

fn shown(text: &str) -> String {
    let mut sources = Sources::default();
    let source = sources.add("plan.rpl", text);
    let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
    let (roots, found) = read(text, source, &mut symbols, &mut tree);
    let mut shown = format!("{text}\n---- is answered by\n{}---- and read as\n", render(&found, &sources, false));
    for root in roots {
        shown += &print(&tree, &symbols, root);
        shown.push('\n');
    }
    shown
}

macro_rules! cases {
    ($($name:ident: $text:expr;)*) => {
        $(
            #[test]
            fn $name() {
                insta::assert_snapshot!(stringify!($name), shown($text));
            }
        )*
    };
}

cases! {
    unclosed_at_the_end: "(def-plan go ()\n  (seq (look)\n       (drive))";
    several_unclosed_at_the_end: "(def-plan go ()\n  (seq (look)\n       (drive";
    unclosed_before_a_definition: "(def-plan go ()\n  (seq (look)\n\n(def-plan stay ()\n  (wait-time 1s))";
    unclosed_within_by_indentation: "(def-plan go ()\n  (let ((speed 0.3m/s)\n    (drive speed)))\n(go)";
    unclosed_and_a_stray_that_would_balance_it: "(def-plan go ()\n  (look)\n(def-plan stay ()\n  (wait-time 1s)))";
    stray_closer: "(look))\n(drive)";
    stray_closers_in_a_row: "(look)))) (drive)";
    nothing_to_quote: "(print ')";
    nothing_to_unquote_at_the_end: "`(a ,b) ,";
    nothing_to_comment_out: "(seq (look) #;)";
    dot_first: "(. a)";
    dot_last: "(a .)";
    dot_before_several: "(a . b c)";
    dot_twice: "(a . b . c)";
    dot_outside: "a . b";
    dot_in_a_vector: "(print #(a . b))";
    unknown_unit: "(wait-time 3d)";
    near_unit: "(turn 90degs)";
    ratio: "(drive 1/2)";
    integer_out_of_range: "(drive 9223372036854775808)";
    float_out_of_range: "(drive 1e400)";
    unknown_escape: r#"(print "C:\dir")"#;
    no_such_character: r#"(print "\u{d800} \u{1234567} \u12")"#;
    unterminated_string: "(print \"hello)\n(drive)";
    quote_missing_further_up: "(defun f ()\n  \"says hello\n  (print 1))\n(defun g ()\n  \"drives\"\n  (drive)))\n(print \"x";
    string_with_code_in_it: "(print \"hello)\n(drive)\n(print \"bye\")";
    unterminated_comment: "(look)\n#| not #| nested |# enough\n(drive)";
    unterminated_comment_twice: "#| #| ";
    unknown_hash: "(seq #t #\\a)";
    object: "(print #<object 3>)";
    gensym: "(print #:x12)";
    brackets: "(let [x 1] x)";
    bars: "|a name|";
    control_characters: "(look \u{1}\u{2} \u{7f})";
    lone_colon: "(drive : fast)";
    binary: "ELF\u{0}\u{0}\u{1}(";
    wide_characters_before_the_place: "(print \"Fußgänger 机器人\" 3d)";
    several_independent: "(seq 3d 'ok (. x) \"\\q\")\n(par (look)\n(drive))\n) (stop";
    windows_line_ends: "(look)\r\n(drive 3d)\r\n";
    no_break_space: "(look\u{a0}here)";
    zero_width_space_in_a_name: "(look)\n(dri\u{200b}ve 3)";
    byte_order_mark_within: "\u{feff}(look)\n(\u{feff}drive)";
    direction_marks: "(print \"a\u{202e}b\") ; \u{2066} (stop)\n(look \u{200f}left)";
    lines_of_old_files: "(look)\r(drive 3d)\r; more\r(drive 4d)";
    form_feed_is_no_line_end: "(look)\u{c}\n\u{b}(drive 3d) ; a\u{2028}b\n(drive 4d)";
    empty_in_parentheses_only: "(";
}

#[test]
fn one_line_of_great_length_is_cut_around_the_place() {
    insta::assert_snapshot!(shown(&format!("(a{} 3d)", " b".repeat(200))));
}
