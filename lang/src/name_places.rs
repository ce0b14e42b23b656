//! Where names stand in the text of a form. What a macro has copied has the place of the whole call; the
//! name in it is looked for.

use crate::bars::read_name;
use crate::lexer::{Token, lex};
use crate::source::{Sources, Span};
use std::collections::BTreeMap;

/// Where a name, folded, first stands in the text of the span. Cost: linear in the span.
pub(crate) fn find_name(sources: &Sources, within: Span, name: &str) -> Option<Span> {
    NamePlaces::default().find(sources, within, name)
}

/// The names of the span that was asked about last, with the first place of each: many names that are
/// looked for in one call cost as much as one.
#[derive(Debug, Default)]
pub(crate) struct NamePlaces {
    within: Option<Span>,
    first: BTreeMap<String, Span>,
}

impl NamePlaces {
    /// Where a name, folded, first stands in the text of the span.
    pub(crate) fn find(&mut self, sources: &Sources, within: Span, name: &str) -> Option<Span> {
        if self.within != Some(within) {
            self.within = Some(within);
            self.first.clear();
            let (tokens, _) = lex(sources.text_of(within), within.source);
            for (_, span) in tokens.into_iter().filter(|(token, _)| *token == Token::Symbol) {
                let span = Span { start: within.start + span.start, end: within.start + span.end, ..within };
                self.first.entry(read_name(sources.text_of(span)).into_owned()).or_insert(span);
            }
        }
        self.first.get(name).copied()
    }
}
