//! The plans that come with the program are formatted, and the formatter keeps whatever the
//! documents show.

use rpl_lang::formatter::format;
use rpl_lang::indentation::layout;
use rpl_lang::layout::Style;
use rpl_lang::lexer::lex;
use rpl_lang::pretty::print;
use rpl_lang::reader::read;
use rpl_lang::source::SourceId;
use rpl_lang::symbol::Symbols;
use rpl_lang::syntax::Tree;
use rpl_tests::repository::{files_below, root};
use std::fs;

/// The data of a text and its comments; none if it has faults.
fn content(text: &str) -> Option<(String, Vec<String>)> {
    let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
    let (roots, faults) = read(text, SourceId(0), &mut symbols, &mut tree);
    let data = roots.iter().map(|&root| print(&tree, &symbols, root) + "\n").collect();
    let (tokens, _) = lex(text, SourceId(0));
    let comments = tokens.iter().filter(|(token, _)| token.is_comment());
    let comments =
        comments.map(|(_, span)| text[span.start as usize..span.end as usize].trim_end().to_string()).collect();
    faults.is_empty().then_some((data, comments))
}

#[test]
fn the_plans_that_come_with_the_program_are_formatted() {
    let libraries = [
        "stdlib/src/prelude/constructs.rpl",
        "stdlib/src/prelude/functions.rpl",
        "stdlib/src/prelude/revision.rpl",
        "stdlib/src/prelude/rules.rpl",
        "stdlib/src/prelude/foresight.rpl",
        "robot/src/office/plans.rpl",
        "robot/src/office/rules.rpl",
    ];
    let mut plans = libraries.map(|library| root().join(library)).to_vec();
    plans.extend(files_below(&root().join("examples"), &["rpl"]));
    assert!(plans.len() > 10);
    for plan in plans {
        let text = fs::read_to_string(&plan).expect("the plan can be read");
        let formatted = format(&text, SourceId(0)).expect("the plan has no faults");
        assert_eq!(formatted, text, "`rpl fmt {}` would change it", plan.to_string_lossy());
    }
}

#[test]
fn formatting_keeps_data_and_comments_of_every_plan_in_the_documents() {
    let mut documents = vec![root().join("README.md")];
    documents.extend(files_below(&root().join("docs"), &["md"]));
    let mut count = 0;
    for document in documents {
        let text = fs::read_to_string(&document).expect("the document can be read");
        for block in text.split("```").filter_map(|block| block.strip_prefix("lisp")) {
            let Some((_, plan)) = block.split_once('\n') else { continue };
            let Some(before) = content(plan) else { continue };
            let once = format(plan, SourceId(0)).expect("the plan has no faults");
            assert_eq!(content(&once), Some(before), "{plan}");
            assert_eq!(format(&once, SourceId(0)).as_ref(), Ok(&once), "{plan}");
            count += 1;
        }
    }
    assert!(count > 40, "only {count} plans");
}

#[test]
fn every_macro_of_the_prelude_that_takes_a_body_has_its_layout() {
    let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
    let (roots, _) = read(rpl_stdlib::PRELUDE, SourceId(0), &mut symbols, &mut tree);
    let mut count = 0;
    for root in roots {
        let text = |node| print(&tree, &symbols, node);
        let [head, name, parameters, ..] = tree.items(root) else { continue };
        if text(*head) != "defmacro" {
            continue;
        }
        let words: Vec<String> = tree.items(*parameters).iter().map(|&word| text(word)).collect();
        if let [before @ .., rest, body] = words.as_slice()
            && rest == "&rest"
            && body == "body"
        {
            let style = layout(&text(*name)).map(|layout| layout.style);
            assert_eq!(style, Some(Style::Body(before.len())), "`{}`", text(*name));
            count += 1;
        }
    }
    assert!(count > 10);
}
