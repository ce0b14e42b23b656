//! Printing, laying out, and the places laying out assigns.

use proptest::prelude::*;
use rpl_lang::diagnostic::{Diagnostic, render};
use rpl_lang::pretty::{pretty, print};
use rpl_lang::reader::read;
use rpl_lang::source::{SourceId, Sources, Span};
use rpl_lang::symbol::Symbols;
use rpl_lang::syntax::{NodeId, NodeKind, Tree};

const SOURCE: SourceId = SourceId(7);
const NOWHERE: Span = Span { source: SourceId(0), start: 0, end: 0 };

/// A datum apart from any arena, to be compared; floats by their bits.
#[derive(Clone, Debug, PartialEq)]
enum Datum {
    Symbol(String),
    Keyword(String),
    Int(i64),
    Float(u64),
    Str(String),
    List(Vec<Datum>, bool),
    Vector(Vec<Datum>),
}

fn add(datum: &Datum, symbols: &mut Symbols, tree: &mut Tree) -> NodeId {
    let kind = match datum {
        Datum::Symbol(name) => NodeKind::Symbol(symbols.intern(name)),
        Datum::Keyword(name) => NodeKind::Keyword(symbols.intern(name)),
        Datum::Int(value) => NodeKind::Int(*value),
        Datum::Float(bits) => NodeKind::Float(f64::from_bits(*bits)),
        Datum::Str(value) => NodeKind::Str(value.as_str().into()),
        Datum::List(items, dotted) => {
            let items: Vec<_> = items.iter().map(|item| add(item, symbols, tree)).collect();
            return tree.list_with_tail(&items, *dotted, NOWHERE);
        }
        Datum::Vector(items) => {
            let items: Vec<_> = items.iter().map(|item| add(item, symbols, tree)).collect();
            return tree.vector(&items, NOWHERE);
        }
    };
    tree.atom(kind, NOWHERE)
}

fn datum_of(node: NodeId, symbols: &Symbols, tree: &Tree) -> Datum {
    match &tree.get(node).kind {
        NodeKind::Symbol(symbol) | NodeKind::Qualified { written: symbol, .. } => {
            Datum::Symbol(symbols.name(*symbol).to_string())
        }
        NodeKind::Keyword(symbol) => Datum::Keyword(symbols.name(*symbol).to_string()),
        NodeKind::Int(value) => Datum::Int(*value),
        NodeKind::Float(value) => Datum::Float(value.to_bits()),
        NodeKind::Str(value) => Datum::Str(value.to_string()),
        NodeKind::List { dotted, .. } => {
            Datum::List(tree.items(node).iter().map(|&item| datum_of(item, symbols, tree)).collect(), *dotted)
        }
        NodeKind::Vector { .. } => {
            Datum::Vector(tree.elements(node).iter().map(|&item| datum_of(item, symbols, tree)).collect())
        }
        NodeKind::Object(_) | NodeKind::Hole => panic!("no text without faults reads as this"),
    }
}

fn read_one(text: &str, symbols: &mut Symbols) -> Datum {
    let mut tree = Tree::default();
    let (roots, found) = read(text, SOURCE, symbols, &mut tree);
    assert_eq!(found, [], "{text}");
    assert_eq!(roots.len(), 1, "{text}");
    datum_of(roots[0], symbols, &tree)
}

fn laid_out(text: &str, width: usize) -> String {
    let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
    let (roots, found) = read(text, SOURCE, &mut symbols, &mut tree);
    assert_eq!(found, []);
    pretty(&mut tree, &symbols, roots[0], width, SOURCE)
}

const PLAN: &str = "(def-plan go-to (dest) \"Drives to DEST.\" (with-policies ((relocalize-when-necessary) (notice-interruption))
        (process navigation-proc (with-valve wheels (evap-protect (loop (try-all (wait-for execution-interrupted? :timeout 2.5s)
        (execute-plan (generate-navigation-plan dest :speed 0.3m/s :keep-clear-of '(kitchen table-1 table-2) :report nil)))
        until (at-destination? dest)) (plan-remove-all-goals))))))";

#[test]
fn a_plan_is_laid_out_as_a_lisp_user_would() {
    insta::assert_snapshot!(laid_out(PLAN, 60));
}

#[test]
fn lines_keep_to_the_width_where_that_can_be_had() {
    for width in 55..130 {
        let text = laid_out(PLAN, width);
        assert!(text.lines().all(|line| line.chars().count() <= width), "{width}\n{text}");
    }
}

#[test]
fn data_and_long_calls_are_aligned() {
    let call = "(let ((rooms '(hall kitchen office-1 office-2 corridor-north)) (n 3)) (if (> n 2)
        (visit-every-room-in-order rooms :returning-home t) `(seq ,@(map (lambda (room) `(go-to ,room)) rooms))))";
    insta::assert_snapshot!(laid_out(call, 44));
}

#[test]
fn atoms_and_objects() {
    let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
    let gensym = symbols.uninterned("x");
    let items = [
        tree.atom(NodeKind::Float(1e21), NOWHERE),
        tree.atom(NodeKind::Float(-0.0), NOWHERE),
        tree.atom(NodeKind::Float(0.1), NOWHERE),
        tree.atom(NodeKind::Object(3), NOWHERE),
        tree.atom(NodeKind::Symbol(gensym), NOWHERE),
        tree.list(&[], NOWHERE),
    ];
    let list = tree.list(&items, NOWHERE);
    assert_eq!(print(&tree, &symbols, list), "(1.0e21 -0.0 0.1 #<object 3> #:x0 ())");
}

#[test]
fn depth_costs_no_stack_and_little_text() {
    let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
    let name = symbols.intern("seq");
    let mut node = tree.list(&[], NOWHERE);
    const DEPTH: usize = 100_000;
    for _ in 0..DEPTH {
        let head = tree.atom(NodeKind::Symbol(name), NOWHERE);
        node = tree.list(&[head, node], NOWHERE);
    }
    assert_eq!(print(&tree, &symbols, node).len(), DEPTH * "(seq )".len() + 2);
    let text = pretty(&mut tree, &symbols, node, 80, SOURCE);
    assert!(text.len() < DEPTH * 80);
    assert_eq!(tree.span(node), Span { source: SOURCE, start: 0, end: text.len() as u32 - 1 });
}

fn rendered(diagnostics: &[Diagnostic], texts: &[(&str, &str)]) -> String {
    let mut sources = Sources::default();
    for (name, text) in texts {
        sources.add(name, text);
    }
    render(diagnostics, &sources, false)
}

fn span(source: u32, start: u32, end: u32) -> Span {
    Span { source: SourceId(source), start, end }
}

#[test]
fn findings_are_drawn_in_order_of_place_over_several_texts() {
    let found = [
        Diagnostic::warning("shadowed", span(1, 7, 12), "`drive` hides a library name", "defined here"),
        Diagnostic::error("arity", span(0, 7, 16), "`go` takes 1 argument, 2 are given", "called here")
            .related(span(1, 19, 27), "defined here")
            .help("leave one out"),
    ];
    let texts = [("main.rpl", "(look)\n(go 1 2)\n"), ("lib.rpl", "(defun drive ())\n\n(defun go (x))\n")];
    insta::assert_snapshot!(rendered(&found, &texts));
}

#[test]
fn empty_texts_and_places_at_the_end_are_drawn() {
    for (text, start, end) in
        [("", 0, 0), ("a\n", 2, 2), ("a\n", 1, 2), ("a\n\n", 0, 3), ("a", 1, 1), ("ä", 1, 9), ("\r\n", 0, 1)]
    {
        let drawn = rendered(&[Diagnostic::error("x", span(0, start, end), "what", "here")], &[("t", text)]);
        assert!(drawn.starts_with("error[x]: what\n"), "{drawn}");
    }
}

proptest! {
    #[test]
    fn any_place_in_any_text_is_drawn(
        pieces in prop::collection::vec(prop::sample::select(vec!["a", "\n", "\r", "ä", "\u{2028}", "\u{b}", "\t", "机", " "]), 0..12),
        places in prop::collection::vec((0u32..30, 0u32..30), 1..4),
    ) {
        let text = pieces.concat();
        let mut spans = places.iter().map(|&(start, end)| span(0, start, end));
        let first = spans.next().unwrap_or(NOWHERE);
        let found = spans.fold(Diagnostic::error("x", first, "what", "here"), |found, place| found.related(place, "and here"));
        prop_assert!(rendered(&[found], &[("t", &text)]).starts_with("error[x]: what\n"));
    }
}

fn name() -> impl Strategy<Value = String> {
    let odd = [
        "nil",
        "t",
        "quote",
        "unquote",
        "quasiquote",
        "unquote-splicing",
        "@x",
        "@",
        "1+",
        "-",
        "...",
        "/=",
        "+x",
        "ünï",
        "a#",
    ];
    prop_oneof![4 => "[a-z*!?<>=/&%+-][a-z0-9*!?<>=/.&-]{0,14}", 1 => prop::sample::select(odd.to_vec()).prop_map(str::to_string)]
        .prop_filter("begins like a number", |name| !rpl_lang::number::begins_like_number(name))
}

/// Names of any characters, most of them such as mean something to the reader.
fn odd_name() -> impl Strategy<Value = String> {
    let scraps = vec![
        "", "a", "B", " ", "|", "\\", "(", ")", "'", "`", ",", "@", "\"", ";", "#", "#|", "|#", ":", ".", "-", "+",
        "1", "m", "e5", "\n", "\r", "\t", "\0", "\u{200b}", "\u{a0}", "\u{202e}", "ä", "Ä", "İ", "≤", "nil",
        "library:", "[", "{", "…",
    ];
    let scraps = prop::collection::vec(prop::sample::select(scraps), 0..5).prop_map(|scraps| scraps.concat());
    prop_oneof![3 => scraps, 1 => any::<String>()]
        .prop_filter("one that gensym has made", |name| !rpl_lang::symbol::is_uninterned(name))
}

fn datum() -> impl Strategy<Value = Datum> {
    let float = any::<f64>().prop_map(|value| Datum::Float(value.to_bits()));
    let leaf = prop_oneof![
        4 => name().prop_map(Datum::Symbol),
        2 => odd_name().prop_map(Datum::Symbol),
        1 => odd_name().prop_map(Datum::Keyword),
        1 => "[a-z-]{1,9}".prop_map(Datum::Keyword),
        1 => any::<i64>().prop_map(Datum::Int),
        1 => float.prop_filter("not a number", |datum| !matches!(datum, Datum::Float(bits) if f64::from_bits(*bits).is_nan())),
        1 => any::<String>().prop_map(Datum::Str),
    ];
    leaf.prop_recursive(6, 80, 8, |inner| {
        let mark = prop::sample::select(vec!["quote", "quasiquote", "unquote", "unquote-splicing"]);
        prop_oneof![
            6 => prop::collection::vec(inner.clone(), 0..8).prop_map(|items| Datum::List(items, false)),
            1 => prop::collection::vec(inner.clone(), 2..5).prop_map(|items| Datum::List(items, true)),
            1 => prop::collection::vec(inner.clone(), 0..8).prop_map(Datum::Vector),
            1 => (mark, inner).prop_map(|(mark, item)| Datum::List(vec![Datum::Symbol(mark.to_string()), item], false)),
        ]
    })
}

proptest! {
    #[test]
    fn what_is_printed_reads_back(datum in datum()) {
        let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
        let node = add(&datum, &mut symbols, &mut tree);
        let text = print(&tree, &symbols, node);
        prop_assert!(!text.contains('\n'));
        prop_assert_eq!(read_one(&text, &mut symbols), datum);
    }

    #[test]
    fn what_is_laid_out_reads_back_and_every_span_holds_its_node(datum in datum(), width in 0usize..100) {
        let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
        let root = add(&datum, &mut symbols, &mut tree);
        let text = pretty(&mut tree, &symbols, root, width, SOURCE);
        prop_assert_eq!(read_one(&text, &mut symbols), datum);
        for index in 0..tree.nodes.len() {
            let node = NodeId(index as u32);
            let Span { source, start, end } = tree.span(node);
            prop_assert_eq!(source, SOURCE);
            let covered = &text[start as usize..end as usize];
            // The head of a quoted datum stands for its mark.
            if ["'", "`", ",", ",@"].contains(&covered) {
                continue;
            }
            let expected = datum_of(node, &symbols, &tree);
            prop_assert_eq!(read_one(covered, &mut symbols), expected);
        }
    }

    #[test]
    fn what_fits_is_on_one_line(datum in datum()) {
        let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
        let root = add(&datum, &mut symbols, &mut tree);
        let line = print(&tree, &symbols, root);
        let width = line.chars().count();
        prop_assert_eq!(pretty(&mut tree, &symbols, root, width, SOURCE), line + "\n");
    }
}
