//! Names that the text binds elsewhere than where they are used: where they are known, and a `)` that closes too early.

use super::compiler::Compiler;
use crate::lexer::{Token, lex};
use crate::name_places::find_name;
use crate::source::{SourceId, Span};
use crate::symbol::Symbol;
use std::collections::{BTreeMap, BTreeSet};

/// Names of one text that are looked for so; each costs a walk over the words of the text.
const MOST_LOOKED_FOR: usize = 50;

/// Where unknown names are bound, and what was told of that.
pub(super) struct BoundElsewhere {
    places: BTreeMap<Symbol, Vec<Span>>,
    /// The words of the text that was looked at last, without comments.
    words: Option<(SourceId, Vec<(Token, Span)>)>,
    looked_for: usize,
    /// Parentheses that were told to close too early.
    told: BTreeSet<Span>,
}

/// The form in which a name is known, and of which its use is no part.
struct Scope {
    /// Where the name is bound.
    binding: Span,
    open: Span,
    close: Span,
    head: Option<Span>,
    /// Whether nothing stands behind what binds the name but a documentation.
    is_empty: bool,
    /// The word before the name, if it stands in the form itself.
    before: Option<Span>,
}

impl Compiler<'_> {
    /// Where these names are bound as variables, parameters and tags.
    pub(super) fn bound_elsewhere(&self, names: &[Symbol]) -> BoundElsewhere {
        let unknown: BTreeSet<Symbol> = names.iter().copied().collect();
        let mut places: BTreeMap<Symbol, Vec<Span>> = BTreeMap::new();
        for variable in self.variables.iter().filter(|variable| unknown.contains(&variable.name)) {
            places.entry(variable.name).or_default().push(variable.span);
        }
        BoundElsewhere { places, words: None, looked_for: 0, told: BTreeSet::new() }
    }

    /// Tells, and gives true, if the text binds an unknown name, and the use lies outside.
    pub(super) fn is_out_of_scope(&mut self, name: Symbol, used: Span, bound: &mut BoundElsewhere) -> bool {
        let Some(scope) = self.scope_of(name, used, bound) else { return false };
        let sources = &self.program.sources;
        let text = self.symbols.name(name).to_string();
        let head = scope.head.map_or("", |head| sources.text_of(head)).to_string();
        let is_tag = scope.before.is_some_and(|before| matches!(sources.text_of(before), ":tag" | "process"));
        let is_definition = head.starts_with("def");
        let defined = scope.head.filter(|_| is_definition).and_then(|head| {
            let words = bound.words.as_ref().map(|(_, words)| words.as_slice()).unwrap_or_default();
            words.get(words.partition_point(|(_, span)| span.start <= head.start))
        });
        let defined = defined.map(|&(_, span)| sources.text_of(span).to_string());
        let is_head = sources.get(used.source).text[..used.start as usize].ends_with('(');
        if is_tag {
            let (line, column) = sources.line_column(scope.open);
            let message = format!("the tag `{text}` is known only in its own form, which begins at {line}:{column}");
            let error = self.error("unbound-name", used, message, "not known here");
            error.related.push((scope.binding, "the tag".into()));
            error.help = Some("put both into one form: `(seq FORM...)`; a plan of your own is such a form, too".into());
        } else if scope.is_empty && !is_head {
            if bound.told.insert(scope.close) {
                let what = defined.unwrap_or(head);
                let message = format!("`{what}` ends here and has no forms: this `)` closes too early");
                let error = self.error("closed-too-early", scope.close, message, "ends here");
                error.related.push((used, format!("`{text}` is not known any more")));
                error.help = Some("remove it; the `)` stands behind the last form that belongs to it".into());
            }
        } else if scope.head.is_some_and(|head| head.start == scope.binding.start) {
            let message = format!("`{text}` is not known yet: the names of one `let` do not see each other");
            let error = self.error("unbound-name", used, message, "not known here");
            error.related.push((scope.binding, "bound here".into()));
            error.help = Some("`let*` binds names one after the other".into());
        } else if let Some(defined) = defined {
            if is_head {
                return false;
            }
            let message = format!("`{text}` is known only in `{defined}`");
            let error = self.error("unbound-name", used, message, "not known here");
            error.related.push((scope.binding, "bound here".into()));
            error.help =
                Some(format!("hand its value over as an argument; if the name itself is meant, quote it: `'{text}`"));
        } else {
            let (line, column) = sources.line_column(scope.close);
            let message = format!("`{text}` is known only up to the `)` at {line}:{column}");
            let error = self.error("unbound-name", used, message, "not known here");
            error.related.push((scope.close, format!("`{text}` is known up to here")));
            error.help = Some(format!("what uses `{text}` stands before that `)`"));
        }
        true
    }

    fn scope_of(&self, name: Symbol, used: Span, bound: &mut BoundElsewhere) -> Option<Scope> {
        let sources = &self.program.sources;
        let places = bound.places.get(&name)?.iter().filter(|place| place.source == used.source);
        let before = places.clone().filter(|place| place.start < used.start).max_by_key(|place| place.start);
        let place = *before.or_else(|| places.min_by_key(|place| place.start))?;
        bound.looked_for += 1;
        if bound.looked_for > MOST_LOOKED_FOR {
            return None;
        }
        let binding = find_name(sources, place, self.symbols.name(name))?;
        if bound.words.as_ref().is_none_or(|(source, _)| *source != used.source) {
            let (mut words, _) = lex(&sources.get(used.source).text, used.source);
            words.retain(|(token, _)| !token.is_comment());
            bound.words = Some((used.source, words));
        }
        scope(&bound.words.as_ref()?.1, binding, used)
    }
}

/// The outermost form around a binding that its use is no part of.
fn scope(words: &[(Token, Span)], binding: Span, used: Span) -> Option<Scope> {
    let lies_in = |inner: Span, start: u32, end: u32| start <= inner.start && inner.end <= end;
    let (mut open, mut found) = (Vec::new(), None);
    for (at, &(token, span)) in words.iter().enumerate() {
        match token {
            Token::Open => open.push(at),
            Token::Close => {
                let Some(opener) = open.pop() else { continue };
                let start = words[opener].1.start;
                if lies_in(binding, start, span.end) && !lies_in(used, start, span.end) {
                    found = Some((opener, at));
                }
            }
            _ => {}
        }
    }
    let (opener, closer) = found?;
    let inside = &words[opener + 1..closer];
    // What stands directly in the form, by where it begins and ends.
    let (mut depth, mut start, mut is_behind, mut is_empty) = (0_u32, 0, false, true);
    for &(token, span) in inside {
        match token {
            Token::Open => depth += 1,
            Token::Close => depth -= 1,
            _ => {}
        }
        if token == Token::Open && depth == 1 || token != Token::Close && depth == 0 {
            start = span.start;
        }
        if depth == 0 {
            if is_behind {
                is_empty &= token == Token::Str;
            }
            is_behind |= lies_in(binding, start, span.end);
        }
    }
    let at = inside.iter().position(|(_, span)| span.start == binding.start)?;
    let before = inside[..at].last().filter(|(token, _)| *token != Token::Open).map(|&(_, span)| span);
    let head = inside.first().filter(|(token, _)| *token == Token::Symbol).map(|&(_, span)| span);
    let (open, close) = (words[opener].1, words[closer].1);
    Some(Scope { binding, open, close, head, is_empty: is_empty && head.is_some(), before })
}
