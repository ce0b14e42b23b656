//! Where the next line of an unfinished text begins, for an editor that asks for it.

use crate::bars::read_name;
use crate::indentation::layout_of;
use crate::layout::{ItemShape, Layout};
use crate::lexer::{Prefix, Token, lex};
use crate::source::SourceId;

/// The column in which the next line of a text begins: where the formatter would leave it. None at
/// top level, and within a string or a comment, where every space is the author's.
pub fn next_line_column(text: &str) -> Option<usize> {
    let (tokens, _) = lex(text, SourceId(0));
    let mut open: Vec<OpenForm> = Vec::new();
    let mut mark = None;
    for (token, span) in tokens {
        let (start, end) = (span.start as usize, span.end as usize);
        match token {
            Token::LineComment | Token::BlockComment | Token::DatumComment | Token::Dot => {}
            Token::Unterminated => return None,
            Token::Close => drop(open.pop()),
            Token::Prefix(prefix) => {
                if mark.is_none() {
                    begin_item(&mut open, text, start, end, false);
                }
                mark = Some(match prefix {
                    Prefix::Quote | Prefix::Vector => ItemShape::Quoted,
                    Prefix::Quasiquote | Prefix::Unquote | Prefix::UnquoteSplicing | Prefix::Function => {
                        ItemShape::Form
                    }
                });
            }
            Token::Open => {
                let shape = mark.take().unwrap_or_else(|| begin_item(&mut open, text, start, end, false));
                open.push(OpenForm { start, shape, head: None, items: 0, argument: None });
            }
            Token::Symbol | Token::Keyword | Token::Int(_) | Token::Float(_) | Token::Str | Token::Error => {
                if mark.take().is_none() {
                    begin_item(&mut open, text, start, end, token != Token::Str);
                }
            }
        }
    }
    let list = open.last()?;
    Some(list.layout().column(list.items.max(1), column(text, list.start), list.argument))
}

/// A list that is not closed yet.
struct OpenForm {
    /// The byte of its `(`.
    start: usize,
    shape: ItemShape,
    /// What it begins with, if that is an atom.
    head: Option<String>,
    items: usize,
    /// Column of the first argument, if it stands on the line of the head.
    argument: Option<usize>,
}

impl OpenForm {
    fn layout(&self) -> Layout {
        layout_of(self.head.as_deref(), self.shape, |_| None)
    }
}

/// Counts an item of the innermost list; tells what it is if it is a list itself.
fn begin_item(open: &mut [OpenForm], text: &str, start: usize, end: usize, is_name: bool) -> ItemShape {
    let Some(list) = open.last_mut() else { return ItemShape::Form };
    let at = list.items;
    list.items += 1;
    if at == 0 && is_name {
        list.head = Some(read_name(&text[start..end]).into_owned());
    }
    if at == 1 && !text[list.start..start].contains('\n') {
        list.argument = Some(column(text, start));
    }
    list.layout().shape(at)
}

fn column(text: &str, at: usize) -> usize {
    let line_start = text[..at].rfind('\n').map_or(0, |newline| newline + 1);
    text[line_start..at].chars().count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formatter::format;

    #[test]
    fn the_next_line_begins_where_the_formatter_leaves_it() {
        for text in [
            "(def-plan greet (who)",
            "(def-plan greet",
            "(def-plan greet (who)\n  (print who)",
            "(def-plan greet (who)\n  (let ((a 1)",
            "(let ((cups 1)\n      (tables 2))",
            "(par (wait-time 1)",
            "(par",
            "(list 'tea",
            "(list",
            "(setf (value level)",
            "(with-failure-handling",
            "(with-failure-handling\n    ((blocked (f)",
            "(with-failure-handling\n    ((blocked (f) (retry))",
            "(if (> level 1)",
            "(cond ((> level 1)",
            "'(tea coffee",
            "(case cup\n  (tea",
            "(with-valve wheels",
            "(list #'car ; what\n      `(a ,b)",
            "(dolist (cup '(tea coffee))",
        ] {
            let at = next_line_column(text).unwrap_or_else(|| panic!("a list is open in {text}"));
            let closers = "))))))))";
            let closed = (0..8).map(|count| format!("{text}\n{}x{}\n", " ".repeat(at), &closers[..count]));
            let whole = closed.into_iter().find(|text| format(text, SourceId(0)).is_ok()).expect("it can be closed");
            assert_eq!(format(&whole, SourceId(0)).as_deref(), Ok(whole.as_str()), "{text}");
        }
    }

    #[test]
    fn at_top_level_and_in_strings_and_comments_nothing_is_indented() {
        for text in ["", "(list 1)", "(print \"two", "#| a comment", "tea"] {
            assert_eq!(next_line_column(text), None, "{text}");
        }
    }
}
