//! A text of several lines as it is edited: those behind the first begin with a margin as wide as
//! the prompt, where they are marked as its continuation, and with the indentation of the language.

use rpl_lang::continuation::next_line_column;
use rpl_lang::lexer::{Token, lex};
use rpl_lang::reader::{Completeness, completeness};
use rpl_lang::source::SourceId;
use std::borrow::Cow;

/// What a line that goes on shows in its margin.
const MARK: &str = "...> ";

/// The margin in the text that is edited: the mark is as wide.
const MARGIN: &str = "     ";

/// What Enter puts behind a text that is not complete; none if it is complete, or a command.
pub fn continuation(text: &str, is_at: usize) -> Option<String> {
    if is_command(text) || completeness(text) == Completeness::Complete {
        return None;
    }
    Some(match next_line_column(&without_margins(text.get(..is_at)?)) {
        Some(column) => format!("\n{MARGIN}{}", " ".repeat(column)),
        // Within a string every space counts.
        None => "\n".to_string(),
    })
}

/// Whether a line is one for the prompt itself.
pub fn is_command(text: &str) -> bool {
    text.trim_start().starts_with(':')
}

/// Whether nothing but indentation stands before the cursor on a line behind the first.
pub fn is_in_indentation(text: &str, cursor: usize) -> bool {
    let start = line_starts(text).into_iter().rfind(|&start| start <= cursor);
    let before = start.and_then(|start| text.get(start..cursor));
    before.is_some_and(|before| !before.is_empty() && before.chars().all(|c| c == ' '))
}

/// The text without the margins: where all lines have one, which pasted lines may lack.
pub fn without_margins(text: &str) -> Cow<'_, str> {
    let starts = line_starts(text);
    let has_margin = |&start: &usize| {
        text[start..].starts_with(MARGIN) || text[start..].lines().next().is_none_or(|line| line.trim().is_empty())
    };
    if starts.is_empty() || !starts.iter().all(has_margin) {
        return Cow::Borrowed(text);
    }
    let mut done = String::with_capacity(text.len());
    let mut end = 0;
    for start in starts {
        done.push_str(&text[end..start]);
        // A line of nothing but spaces may be shorter.
        end = start + text[start..].chars().take(MARGIN.len()).take_while(|&c| c == ' ').count();
    }
    done.push_str(&text[end..]);
    Cow::Owned(done)
}

/// What stands between two words, with every margin replaced by the mark, which is as wide; `colour`
/// dims it.
pub fn marked(between: &str, colour: bool) -> String {
    let mark = if colour { format!("\n\x1b[2m{MARK}\x1b[0m") } else { format!("\n{MARK}") };
    between.replace(&format!("\n{MARGIN}"), &mark)
}

/// Where the lines behind the first begin, those left out that begin within a string or a comment.
fn line_starts(text: &str) -> Vec<usize> {
    let (tokens, _) = lex(text, SourceId(0));
    let spans_lines = |token| matches!(token, Token::Str | Token::BlockComment | Token::Unterminated);
    let within: Vec<(usize, usize)> = tokens
        .into_iter()
        .filter(|&(token, _)| spans_lines(token))
        .map(|(_, span)| (span.start as usize, span.end as usize))
        .collect();
    let starts = text.match_indices('\n').map(|(at, _)| at + 1);
    starts.filter(|&start| !within.iter().any(|&(from, to)| from < start && start < to.max(from + 1))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_goes_on_with_the_indentation_of_the_language() {
        assert_eq!(continuation("(def-plan greet (who)", 21).as_deref(), Some("\n       "));
        let two = "(def-plan greet (who)\n       (print who)";
        assert_eq!(continuation(two, two.len()).as_deref(), Some("\n       "));
        let aligned = "(list 'tea";
        assert_eq!(continuation(aligned, aligned.len()).as_deref(), Some("\n           "));
        assert_eq!(continuation("(print \"two", 11).as_deref(), Some("\n"));
        assert_eq!(continuation("(list 1)", 8), None);
        assert_eq!(continuation(":step (list", 11), None);
    }

    #[test]
    fn what_is_handed_in_has_no_margin_and_strings_keep_their_spaces() {
        let typed = "(list \"one\n        two\"\n           'tea)";
        assert_eq!(without_margins(typed), "(list \"one\n        two\"\n      'tea)");
        let pasted = "(list 1\n 2)";
        assert_eq!(without_margins(pasted), pasted);
    }

    #[test]
    fn a_mark_is_as_wide_as_the_margin() {
        assert_eq!(MARK.len(), MARGIN.len());
        assert_eq!(marked("\n      ", false), "\n...>  ");
        assert_eq!(marked(" ", true), " ");
    }

    #[test]
    fn indentation_is_what_stands_before_the_first_word() {
        let text = "(list 1\n       ";
        assert!(is_in_indentation(text, text.len()));
        assert!(!is_in_indentation("(list 1\n  2", 11));
        assert!(!is_in_indentation("(list", 5));
        assert!(!is_in_indentation("(list \"a\n  ", 12), "in a string every space counts");
    }
}
