//! Quotes in what is quoted already: `'(kitchen 'hall)` has the list `(quote hall)` in it.

use super::known::Check;
use crate::bars::read_name;
use crate::compile::special_forms;
use crate::diagnostic::Diagnostic;
use crate::lexer::{Prefix, Token};
use crate::source::{SourceId, Span};
use std::collections::BTreeSet;

pub(super) fn find(check: &Check<'_>, found: &mut Vec<Diagnostic>) {
    let text = check.subject.text;
    let definitions = text.definitions.iter().map(|definition| definition.span);
    let forms = text.forms.iter().chain(&text.tests).map(|form| form.span);
    let sources: BTreeSet<SourceId> = definitions.chain(forms).map(|span| span.source).collect();
    let heads: BTreeSet<&str> = special_forms().flat_map(|form| form.names).copied().collect();
    for source in sources.into_iter().filter(|&source| source.0 >= check.subject.program.library_sources) {
        Search { check, heads: &heads, open: Vec::new() }.tokens(&check.tokens(source), found);
    }
}

/// A list that is not closed yet.
#[derive(Clone, Copy)]
struct OpenList {
    /// Whether it stands in a list or vector that is quoted.
    is_data: bool,
    /// Whether it, or one around it, is a plan as data, in which quotes have their meaning.
    is_plan: bool,
    is_empty: bool,
    /// Whether it is commented out.
    is_ignored: bool,
}

struct Search<'c, 'a> {
    check: &'c Check<'a>,
    /// Names of special forms.
    heads: &'c BTreeSet<&'static str>,
    open: Vec<OpenList>,
}

impl Search<'_, '_> {
    fn tokens(&mut self, tokens: &[(Token, Span)], found: &mut Vec<Diagnostic>) {
        let outside = OpenList { is_data: false, is_plan: false, is_empty: false, is_ignored: false };
        let (mut mark, mut ignored) = (None, false);
        for (at, &(token, span)) in tokens.iter().enumerate() {
            let around = self.open.last().copied().unwrap_or(outside);
            match token {
                Token::DatumComment => {
                    ignored = true;
                    continue;
                }
                Token::Prefix(prefix) => {
                    let is_datum = around.is_data && !around.is_plan && !around.is_ignored && !ignored;
                    if prefix == Prefix::Quote && is_datum && mark.is_none() {
                        found.push(self.quoted_again(span, tokens.get(at + 1)));
                    }
                    mark = mark.or(Some(prefix));
                    continue;
                }
                Token::Open => {
                    if let Some(list) = self.open.last_mut() {
                        list.is_empty = false;
                    }
                    self.open.push(opened(around, mark, ignored));
                }
                Token::Close => drop(self.open.pop()),
                Token::Symbol | Token::Keyword if around.is_empty && around.is_data && mark.is_none() => {
                    let is_plan = token == Token::Keyword || self.begins_plan(span);
                    if let Some(list) = self.open.last_mut() {
                        (list.is_empty, list.is_plan) = (false, around.is_plan || is_plan);
                    }
                }
                Token::Symbol
                | Token::Keyword
                | Token::Int(_)
                | Token::Float(_)
                | Token::Str
                | Token::Dot
                | Token::LineComment
                | Token::BlockComment
                | Token::Unterminated
                | Token::Error => {
                    if let Some(list) = self.open.last_mut() {
                        list.is_empty = false;
                    }
                }
            }
            (mark, ignored) = (None, false);
        }
    }

    /// Whether a list with this head is a form, or a pattern of one.
    fn begins_plan(&self, head: Span) -> bool {
        let (check, program) = (self.check, self.check.subject.program);
        let name = read_name(program.sources.text_of(head));
        let is_function = || {
            check
                .subject
                .symbols
                .find(&name)
                .is_some_and(|symbol| program.macros.contains_key(&symbol) || program.names.contains_key(&symbol))
        };
        name.starts_with('?') || self.heads.contains(&*name) || check.natives.contains_key(&*name) || is_function()
    }

    fn quoted_again(&self, quote: Span, datum: Option<&(Token, Span)>) -> Diagnostic {
        let atom = datum.filter(|(token, _)| matches!(token, Token::Symbol | Token::Keyword));
        let shown = atom.map_or("…", |&(_, span)| self.check.subject.program.sources.text_of(span));
        let message = format!("in a quoted list `'{shown}` is the list `(quote {shown})`");
        let span = Span { end: atom.map_or(quote.end, |(_, span)| span.end), ..quote };
        let help =
            format!("write `{shown}`: nothing in a quoted list is evaluated; to fill values in, write `(list …)`");
        self.check.warning("quote-in-data", span, message, "quoted already").help(help)
    }
}

fn opened(around: OpenList, mark: Option<Prefix>, ignored: bool) -> OpenList {
    let is_ignored = around.is_ignored || ignored;
    let fresh = OpenList { is_data: false, is_plan: false, is_empty: true, is_ignored };
    match mark {
        // A quoted list in a list that is quoted is told, and not what stands in it.
        Some(Prefix::Quote | Prefix::Vector) if !around.is_data => OpenList { is_data: true, ..fresh },
        Some(Prefix::Quote) => fresh,
        Some(Prefix::Quasiquote | Prefix::Unquote | Prefix::UnquoteSplicing | Prefix::Function) => fresh,
        Some(Prefix::Vector) | None => OpenList { is_data: around.is_data, is_plan: around.is_plan, ..fresh },
    }
}
