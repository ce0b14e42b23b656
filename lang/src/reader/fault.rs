//! What can be wrong with the order of tokens, and how it is told.

use crate::diagnostic::Diagnostic;
use crate::lexer::{Prefix, Token};
use crate::source::{LINE_ENDS, SourceId, Span, holds_code, line_starts};
use chumsky::span::SimpleSpan;

/// One error of the grammar.
#[derive(Clone, Debug)]
pub(super) enum Fault {
    /// Required of an error type by the parser library; the grammar takes every lexeme, so it is
    /// never told.
    Unexpected(SimpleSpan),
    /// Lists of one form without their `)`, the inner ones innermost first; the form was given up
    /// at `end`.
    Unclosed {
        outermost: SimpleSpan,
        inner: Vec<SimpleSpan>,
        end: usize,
    },
    /// Closers in a row that close nothing.
    Stray {
        at: SimpleSpan,
        count: usize,
    },
    BarePrefix {
        prefix: Prefix,
        at: SimpleSpan,
        end: usize,
    },
    BareComment {
        at: SimpleSpan,
        end: usize,
    },
    DotFirst(SimpleSpan),
    DotLast(SimpleSpan),
    DotTwice(SimpleSpan),
    DotBeforeSeveral(SimpleSpan),
    DotOutside(SimpleSpan),
    DotInVector(SimpleSpan),
}

impl Fault {
    /// Whether more text could have mended it; `last` is the end of the last token, `len` that of
    /// the text.
    pub(super) fn waits_at_end(&self, last: usize, len: usize) -> bool {
        match self {
            Fault::Unclosed { end, .. } => *end == len,
            Fault::BarePrefix { end, .. } | Fault::BareComment { end, .. } => *end == last,
            _ => false,
        }
    }

    /// The error with its places.
    pub(super) fn explain(&self, places: &Places<'_>) -> Diagnostic {
        let error =
            |code, at: SimpleSpan, message: &str, label: &str| Diagnostic::error(code, places.span(at), message, label);
        match self {
            Fault::Unexpected(at) => error("unreadable", *at, "this cannot be read", "here"),
            Fault::Unclosed { outermost, inner, end } => unclosed(*outermost, inner, *end, places),
            Fault::Stray { at, count: 1 } => {
                error("stray-close", *at, "this `)` closes nothing", "no list is open here")
                    .help("remove it, or look above for a `)` that closes too early")
            }
            Fault::Stray { at, count } => {
                error("stray-close", *at, &format!("these {count} `)` close nothing"), "no list is open here")
                    .help("remove them, or look above for a `)` that closes too early")
            }
            Fault::BarePrefix { prefix, at, .. } => {
                let error = bare_prefix(*prefix, places.span(*at));
                match places.text_between_quotes(*at).filter(|_| *prefix == Prefix::Quote) {
                    Some(text) => error.help(format!("a text stands between double quotes: `\"{text}\"`")),
                    None => error.help("write the datum after it, or remove the mark"),
                }
            }
            Fault::BareComment { at, .. } => {
                error("bare-prefix", *at, "nothing follows `#;`", "comments out the next datum, and there is none")
                    .help("for a comment up to the end of the line write `;`")
            }
            Fault::DotFirst(at) => {
                error("misplaced-dot", *at, "a dot at the start of a list", "nothing stands before it").help(PAIR_HELP)
            }
            Fault::DotLast(at) => {
                error("misplaced-dot", *at, "nothing follows this dot", "the tail is missing").help(PAIR_HELP)
            }
            Fault::DotTwice(at) => {
                error("misplaced-dot", *at, "a second dot in one list", "one too many").help(PAIR_HELP)
            }
            Fault::DotBeforeSeveral(at) => {
                error("misplaced-dot", *at, "more than one datum follows this dot", "takes one datum").help(PAIR_HELP)
            }
            Fault::DotInVector(at) => {
                error("misplaced-dot", *at, "a vector has no tail after a dot", "a dot stands in it")
                    .help("a vector is written `#(a b)`; remove the dot, or write a list without the `#`")
            }
            Fault::DotOutside(at) => {
                error("misplaced-dot", *at, "a dot outside a list", "no list is open here").help(PAIR_HELP)
            }
        }
    }
}

const PAIR_HELP: &str = "a dotted pair is written `(a . b)`: one datum at least before the dot, exactly one after it";

fn bare_prefix(prefix: Prefix, span: Span) -> Diagnostic {
    let (mark, verb) = match prefix {
        Prefix::Quote => ("'", "quotes"),
        Prefix::Quasiquote => ("`", "quotes"),
        Prefix::Unquote => (",", "inserts"),
        Prefix::UnquoteSplicing => (",@", "inserts the elements of"),
        Prefix::Function => ("#'", "names"),
        Prefix::Vector => ("#", "makes a vector of"),
    };
    let message = format!("nothing follows `{mark}`");
    Diagnostic::error("bare-prefix", span, message, format!("{verb} the next datum, and there is none"))
}

fn unclosed(outermost: SimpleSpan, inner: &[SimpleSpan], end: usize, places: &Places<'_>) -> Diagnostic {
    let (line, column) = places.line_column(outermost.start);
    let (end_line, _) = places.line_column(end);
    let message = format!("this `(` opened at {line}:{column} is never closed");
    let missing = inner.len() + 1;
    let closers = if missing > 3 { format!("{missing} `)`") } else { format!("`{}`", ")".repeat(missing)) };
    let where_to = if end == places.text.len() {
        "before the end of the text".to_string()
    } else {
        format!("before the `(` at {}:1, which starts a new form", end_line)
    };
    let mut error = Diagnostic::error("unclosed-list", places.span(outermost), message, "never closed")
        .help(format!("add {closers} {where_to}"));
    for &opener in inner.iter().rev().take(3) {
        error = error.related(places.span(opener), "nor is this one");
    }
    if let Some(comment) = places.comment_with_closers(outermost.start, end) {
        error = error.related(comment, "`;` begins a comment, and this `)` stands in it: forms need no separator");
    }
    let suspect = places.outdented(outermost.start, end).filter(|at| *at != outermost && !inner.contains(at));
    if let Some(suspect) = suspect {
        error = error.related(places.span(suspect), "going by the indentation, a `)` is missing in this list");
    }
    if let Some(string) = places.string_of_code(outermost.start, end) {
        error = error.related(string, "this string holds what looks like code; perhaps its closing quote is missing");
    }
    error
}

/// Where things are in a text with an error.
pub(super) struct Places<'a> {
    text: &'a str,
    source: SourceId,
    tokens: &'a [(Token, Span)],
    /// First bytes of the lines.
    lines: Vec<usize>,
}

impl<'a> Places<'a> {
    pub(super) fn new(text: &'a str, source: SourceId, tokens: &'a [(Token, Span)]) -> Self {
        let lines = line_starts(text).collect();
        Self { text, source, tokens, lines }
    }

    fn span(&self, span: SimpleSpan) -> Span {
        Span { source: self.source, start: span.start as u32, end: span.end as u32 }
    }

    /// Line and column from 1, the column in characters.
    fn line_column(&self, at: usize) -> (usize, usize) {
        let (line, byte) = self.line_and_byte(at);
        (line, self.text[at - byte..at].chars().count() + 1)
    }

    /// Line from 1, and byte within it: unlike the column it costs no walk along the line.
    fn line_and_byte(&self, at: usize) -> (usize, usize) {
        let line = self.lines.partition_point(|&start| start <= at);
        (line, at - self.lines[line - 1])
    }

    /// The opening quote of the first string between two places with a line that begins with `(`.
    fn string_of_code(&self, from: usize, to: usize) -> Option<Span> {
        let first = self.tokens.partition_point(|(_, span)| (span.start as usize) < from);
        let within = self.tokens[first..].iter().take_while(|(_, span)| (span.start as usize) < to);
        let mut strings = within.filter(|(token, _)| *token == Token::Str).map(|&(_, span)| span);
        let found = strings.find(|span| holds_code(&self.text[span.start as usize..span.end as usize]))?;
        Some(Span { end: found.start + 1, ..found })
    }

    /// A comment behind something in its line that closes a list, as if `;` ended a statement.
    fn comment_with_closers(&self, from: usize, to: usize) -> Option<Span> {
        let first = self.tokens.partition_point(|(_, span)| (span.start as usize) < from);
        let between = self.tokens[first..].iter().take_while(|(_, span)| (span.start as usize) < to);
        let mut comments = between.filter(|(token, _)| *token == Token::LineComment).map(|&(_, span)| span);
        comments.find(|span| {
            let text = &self.text[span.start as usize..span.end as usize];
            let line = self.text[..span.start as usize].rsplit(LINE_ENDS).next().unwrap_or_default();
            let (opened, closed) = (text.matches('(').count(), text.matches(')').count());
            !line.trim().is_empty() && closed > opened
        })
    }

    /// What stands in the same line between a quote and the one before it: `hello` of `'hello'`.
    fn text_between_quotes(&self, at: SimpleSpan) -> Option<&str> {
        let line = self.text[..at.start].rsplit(LINE_ENDS).next()?;
        let (_, text) = line.rsplit_once('\'')?;
        let is_text = !text.is_empty() && !text.contains(['(', ')', '"']) && !text.ends_with(char::is_whitespace);
        is_text.then_some(text)
    }

    /// The innermost list between two places that is still open where a later line begins no
    /// deeper than its opener: by its indentation that line lies outside.
    fn outdented(&self, from: usize, to: usize) -> Option<SimpleSpan> {
        let first = self.tokens.partition_point(|(_, span)| (span.start as usize) < from);
        let mut open: Vec<(SimpleSpan, (usize, usize))> = Vec::new();
        let mut line_before = 0;
        for &(token, span) in &self.tokens[first..] {
            let start = span.start as usize;
            if start >= to {
                break;
            }
            if token.is_comment() {
                continue;
            }
            let place = self.line_and_byte(start);
            if let Some(&(opener, (_, column))) = open.last()
                && place.0 > line_before
                && place.1 <= column
                && token != Token::Close
            {
                return Some(opener);
            }
            line_before = place.0;
            match token {
                Token::Open => open.push((SimpleSpan::from(start..span.end as usize), place)),
                Token::Close => drop(open.pop()),
                _ => {}
            }
        }
        None
    }
}
