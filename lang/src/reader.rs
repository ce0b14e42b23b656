//! Tokens to syntax, with recovery: a tree always results, and every independent error is told.

use crate::bars::{begins_definition, read_name};
use crate::brackets::lex_in_pairs;
use crate::diagnostic::Diagnostic;
use crate::lexer::{Prefix, Token, lex, unescape};
use crate::nesting::Nesting;
use crate::source::{LINE_ENDS, SourceId, Span};
use crate::symbol::Symbols;
use crate::syntax::{NodeId, NodeKind, Tree};
use chumsky::error::{Error, LabelError};
use chumsky::input::{Input, InputRef, MapExtra, MappedInput};
use chumsky::inspector::SimpleState;
use chumsky::prelude::*;
use chumsky::util::MaybeRef;

mod fault;
use fault::{Fault, Places};

/// Deeper texts are refused before the grammar, which recurses, sees them. A level takes just under
/// 1 KB of Rust stack at `opt-level = 1`, so the deepest text half the stack of a thread (2 MB); at
/// `opt-level = 0` it would be 7 KB.
pub const MAX_DEPTH: usize = 1000;

/// Errors told of one text; the rest is counted.
pub const MAX_ERRORS: usize = 20;

/// Reads a text: its data in order, added to `tree`, and what is wrong with it, in order of place.
/// Wherever a datum cannot be read, a hole stands in its place. Cost: linear.
///
/// A `(` in the first column means that the list above was never closed, if the parentheses of the
/// text do not balance or if a definition begins there: definitions stand at top level.
pub fn read(text: &str, source: SourceId, symbols: &mut Symbols, tree: &mut Tree) -> (Vec<NodeId>, Vec<Diagnostic>) {
    let (tokens, mut found) = lex_in_pairs(text, source);
    let lexemes = prepare(text, &tokens, &mut found);
    let end = SimpleSpan::from(text.len()..text.len());
    let mut builder = SimpleState(TreeBuilder { text, source, symbols, tree, unclosed: Vec::new(), given_up_at: 0 });
    let (roots, faults) =
        grammar().parse_with_state(lexemes.as_slice().split_token_span(end), &mut builder).into_output_errors();
    // Within an unterminated string or comment the missing closers may well be there.
    let cut_short = tokens.last().is_some_and(|&(token, _)| token == Token::Unterminated);
    let last = lexemes.last().map_or(0, |(_, span)| span.end);
    let mut reportable = faults.iter().filter(|fault| !(cut_short && fault.waits_at_end(last, text.len()))).peekable();
    if reportable.peek().is_some() {
        let places = Places::new(text, source, &tokens);
        found.extend(reportable.map(|fault| fault.explain(&places)));
    }
    found.sort_by_key(|diagnostic| (diagnostic.span.start, diagnostic.span.end));
    (roots.unwrap_or_default(), limit(found))
}

/// Whether a text can be read as it stands, for a prompt that asks for more lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Completeness {
    /// Nothing is open, or more text could not mend it; there may be errors.
    Complete,
    /// A list, string, block comment or mark waits for its end.
    Incomplete,
}

/// Whether more text may make a datum of this one.
pub fn completeness(text: &str) -> Completeness {
    let (tokens, _) = lex(text, SourceId(0));
    let unterminated = tokens.last().is_some_and(|&(token, _)| token == Token::Unterminated);
    let nesting = Nesting::of(tokens.iter().map(|&(token, _)| token));
    let is_open = unterminated || nesting.depth() > 0;
    let is_beyond_mending = nesting.has_stray() || nesting.depth() > MAX_DEPTH;
    if is_open && !is_beyond_mending { Completeness::Incomplete } else { Completeness::Complete }
}

/// What the grammar is written over.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Lexeme {
    Atom(Token),
    Open,
    Close,
    Prefix(Prefix),
    DatumComment,
    Dot,
    /// Before a `(` in the first column: whatever list is open was never closed.
    Margin,
}

fn prepare(text: &str, tokens: &[(Token, Span)], found: &mut Vec<Diagnostic>) -> Vec<(Lexeme, SimpleSpan)> {
    let balanced = Nesting::of(tokens.iter().map(|&(token, _)| token)).is_balanced();
    let mut lexemes = Vec::with_capacity(tokens.len());
    let mut nesting = Nesting::default();
    let mut form_start = 0;
    let mut too_deep = false;
    for (index, &(token, span)) in tokens.iter().enumerate() {
        let Some(lexeme) = lexeme(token) else { continue };
        let at = SimpleSpan::from(span.start as usize..span.end as usize);
        let at_margin = token == Token::Open && is_first_in_line(text, span) && nesting.in_list();
        if at_margin && (!balanced || is_definition(text, tokens.get(index + 1))) {
            nesting.clear();
            lexemes.push((Lexeme::Margin, SimpleSpan::from(at.start..at.start)));
        }
        if nesting.depth() == 0 {
            (form_start, too_deep) = (lexemes.len(), false);
        }
        nesting.step(token);
        if nesting.depth() > MAX_DEPTH && !too_deep {
            too_deep = true;
            lexemes.truncate(form_start);
            found.push(too_deep_error(span));
        }
        if !too_deep {
            lexemes.push((lexeme, at));
        }
    }
    lexemes
}

fn lexeme(token: Token) -> Option<Lexeme> {
    Some(match token {
        Token::Open => Lexeme::Open,
        Token::Close => Lexeme::Close,
        Token::Prefix(prefix) => Lexeme::Prefix(prefix),
        Token::DatumComment => Lexeme::DatumComment,
        Token::Dot => Lexeme::Dot,
        Token::Str | Token::Symbol | Token::Keyword | Token::Int(_) | Token::Float(_) | Token::Error => {
            Lexeme::Atom(token)
        }
        Token::LineComment | Token::BlockComment | Token::Unterminated => return None,
    })
}

fn is_first_in_line(text: &str, span: Span) -> bool {
    text[..span.start as usize].ends_with(LINE_ENDS)
}

fn is_definition(text: &str, head: Option<&(Token, Span)>) -> bool {
    matches!(head, Some(&(Token::Symbol, span)) if begins_definition(&text[span.start as usize..span.end as usize]))
}

fn too_deep_error(span: Span) -> Diagnostic {
    let message = format!("this is nested more than {MAX_DEPTH} levels deep");
    Diagnostic::error("too-deep", span, message, format!("level {}", MAX_DEPTH + 1))
        .help("give inner parts a name of their own, with `defun`, `def-plan` or `defvar`")
}

fn limit(mut found: Vec<Diagnostic>) -> Vec<Diagnostic> {
    if found.len() > MAX_ERRORS {
        let more = found.len() - MAX_ERRORS;
        let first = &found[MAX_ERRORS];
        let message = format!("and {more} more {}", if more == 1 { "error" } else { "errors" });
        let rest = Diagnostic::error("more-errors", first.span, message, "the next one is here");
        found.truncate(MAX_ERRORS);
        found.push(rest);
    }
    found
}

/// Builds nodes while the grammar runs. The grammar never goes back over a lexeme it took, so
/// nothing is built twice.
struct TreeBuilder<'b> {
    text: &'b str,
    source: SourceId,
    symbols: &'b mut Symbols,
    tree: &'b mut Tree,
    /// Openers of the lists of this form that were never closed, innermost first.
    unclosed: Vec<SimpleSpan>,
    /// Where those lists were given up.
    given_up_at: usize,
}

impl TreeBuilder<'_> {
    fn span(&self, span: SimpleSpan) -> Span {
        Span { source: self.source, start: span.start as u32, end: span.end as u32 }
    }

    fn named(&mut self, name: &str, span: SimpleSpan) -> NodeId {
        let symbol = self.symbols.intern(name);
        self.tree.atom(NodeKind::Symbol(symbol), self.span(span))
    }

    fn hole(&mut self, span: SimpleSpan) -> NodeId {
        self.tree.atom(NodeKind::Hole, self.span(span))
    }

    fn atom(&mut self, token: Token, span: SimpleSpan) -> NodeId {
        let text = &self.text[span.start..span.end];
        let kind = match token {
            Token::Int(value) => NodeKind::Int(value),
            Token::Float(value) => NodeKind::Float(value),
            Token::Str => NodeKind::Str(unescape(&text[1..text.len() - 1], '"').0.into()),
            Token::Keyword => NodeKind::Keyword(self.symbols.intern(&read_name(&text[1..]))),
            Token::Symbol => {
                let written = self.symbols.intern(&read_name(text));
                NodeKind::of_symbol(self.symbols, written)
            }
            _ => NodeKind::Hole,
        };
        self.tree.atom(kind, self.span(span))
    }

    fn prefixed(&mut self, prefix: Prefix, mark: SimpleSpan, datum: NodeId, faults: &mut impl FnMut(Fault)) -> NodeId {
        let name = match prefix {
            Prefix::Function => return datum,
            Prefix::Vector => return self.vector(mark, datum, faults),
            Prefix::Quote => "quote",
            Prefix::Quasiquote => "quasiquote",
            Prefix::Unquote => "unquote",
            Prefix::UnquoteSplicing => "unquote-splicing",
        };
        let head = self.named(name, mark);
        let span = self.span(mark).to(self.tree.span(datum));
        self.tree.list(&[head, datum], span)
    }

    /// The list behind a mark as a vector; its nodes stay where they are.
    fn vector(&mut self, mark: SimpleSpan, list: NodeId, faults: &mut impl FnMut(Fault)) -> NodeId {
        let span = self.span(mark).to(self.tree.span(list));
        let node = &mut self.tree.nodes[list.0 as usize];
        if let NodeKind::List { start, len, dotted } = node.kind {
            node.kind = NodeKind::Vector { start, len };
            if dotted {
                faults(Fault::DotInVector(SimpleSpan::from(mark.start..span.end as usize)));
            }
        }
        node.span = span;
        list
    }

    fn close(&mut self, opener: SimpleSpan, closer: Closer) {
        self.given_up_at = match closer {
            Closer::Paren => return,
            Closer::Margin(at) => at,
            Closer::End => self.text.len(),
        };
        self.unclosed.push(opener);
    }

    fn take_unclosed(&mut self) -> Option<Fault> {
        let outermost = self.unclosed.pop()?;
        let inner = std::mem::take(&mut self.unclosed);
        Some(Fault::Unclosed { outermost, inner, end: self.given_up_at })
    }

    fn list(&mut self, elements: &[Element], span: SimpleSpan, faults: &mut impl FnMut(Fault)) -> NodeId {
        let mut items = Vec::with_capacity(elements.len());
        let mut dot: Option<(SimpleSpan, usize)> = None;
        for element in elements {
            match *element {
                Element::Datum(id) => items.push(id),
                Element::Comment => {}
                Element::Dot(at) if items.is_empty() => faults(Fault::DotFirst(at)),
                Element::Dot(at) if dot.is_some() => faults(Fault::DotTwice(at)),
                Element::Dot(at) => dot = Some((at, items.len())),
            }
        }
        let dotted = match dot {
            None => false,
            Some((_, before)) if items.len() == before + 1 => true,
            Some((at, before)) => {
                faults(if items.len() == before { Fault::DotLast(at) } else { Fault::DotBeforeSeveral(at) });
                false
            }
        };
        let span = self.span(span);
        self.tree.list_with_tail(&items, dotted, span)
    }
}

/// What ends a list.
#[derive(Clone, Copy)]
enum Closer {
    Paren,
    Margin(usize),
    End,
}

/// What stands in a list.
#[derive(Clone, Copy)]
enum Element {
    Datum(NodeId),
    Dot(SimpleSpan),
    Comment,
}

type Lexemes<'t> = MappedInput<'t, Lexeme, SimpleSpan, &'t [(Lexeme, SimpleSpan)]>;
type LexemeContext<'t, 'p, 'b> = MapExtra<'t, 'p, Lexemes<'t>, Extra<'b>>;
type Extra<'b> = extra::Full<Fault, SimpleState<TreeBuilder<'b>>, ()>;

impl<'t> Error<'t, Lexemes<'t>> for Fault {}

impl<'t, L> LabelError<'t, Lexemes<'t>, L> for Fault {
    fn expected_found<E: IntoIterator<Item = L>>(_: E, _: Option<MaybeRef<'t, Lexeme>>, span: SimpleSpan) -> Self {
        Fault::Unexpected(span)
    }
}

/// What stands in a list, as far as it goes. Its next lexeme tells what an element is, so that nothing is tried in vain.
fn elements<'t, 'b: 't>(
    datum: impl Parser<'t, Lexemes<'t>, NodeId, Extra<'b>>,
    comment: impl Parser<'t, Lexemes<'t>, (), Extra<'b>>,
) -> impl Parser<'t, Lexemes<'t>, Vec<Element>, Extra<'b>> {
    custom(move |input: &mut InputRef<'t, '_, Lexemes<'t>, Extra<'b>>| {
        let mut elements = Vec::new();
        loop {
            let before = input.cursor();
            elements.push(match input.peek() {
                Some(Lexeme::Atom(token)) => {
                    input.skip();
                    let span = input.span_since(&before);
                    Element::Datum(input.state().atom(token, span))
                }
                Some(Lexeme::Open | Lexeme::Prefix(_)) => Element::Datum(input.parse(&datum)?),
                Some(Lexeme::DatumComment) => {
                    input.parse(&comment)?;
                    Element::Comment
                }
                Some(Lexeme::Dot) => {
                    input.skip();
                    Element::Dot(input.span_since(&before))
                }
                Some(Lexeme::Close | Lexeme::Margin) | None => return Ok(elements),
            });
        }
    })
}

/// Every rule succeeds once it has taken a lexeme, and `emit`s what is wrong: so the whole text is
/// always read, in one pass and without going back.
fn grammar<'t, 'b: 't>() -> impl Parser<'t, Lexemes<'t>, Vec<NodeId>, Extra<'b>> {
    let mut datum = Recursive::declare();
    let mut comment = Recursive::declare();

    let atom = select_ref! { Lexeme::Atom(token) => *token }
        .map_with(|token, e: &mut LexemeContext<'t, '_, 'b>| {
            let span = e.span();
            e.state().atom(token, span)
        })
        .boxed();

    let mark = select_ref! { Lexeme::Prefix(prefix) => *prefix }.map_with(|prefix, e| (prefix, e.span()));
    let prefixed = mark
        .then_ignore(comment.clone().repeated())
        .then(datum.clone().or_not())
        .validate(|((prefix, at), datum): ((_, SimpleSpan), _), e: &mut LexemeContext<'t, '_, 'b>, emitter| {
            let datum = datum.unwrap_or_else(|| {
                let span: SimpleSpan = e.span();
                emitter.emit(Fault::BarePrefix { prefix, at, end: span.end });
                e.state().hole(at)
            });
            e.state().prefixed(prefix, at, datum, &mut |fault| emitter.emit(fault))
        })
        .boxed();

    let margin_ahead = just(Lexeme::Margin).map_with(|_, e| -> SimpleSpan { e.span() }).rewind();
    let closer = choice((
        just(Lexeme::Close).to(Closer::Paren),
        margin_ahead.map(|at| Closer::Margin(at.start)),
        end().to(Closer::End),
    ));
    let list = just(Lexeme::Open)
        .map_with(|_, e| -> SimpleSpan { e.span() })
        .then(elements(datum.clone(), comment.clone()))
        .then(closer)
        .validate(|((opener, elements), closer), e: &mut LexemeContext<'t, '_, 'b>, emitter| {
            let span = e.span();
            e.state().close(opener, closer);
            e.state().list(&elements, span, &mut |fault| emitter.emit(fault))
        })
        .boxed();

    datum.define(choice((list, atom, prefixed)));
    comment.define(
        just(Lexeme::DatumComment)
            .map_with(|_, e| -> SimpleSpan { e.span() })
            .then_ignore(comment.clone().repeated())
            .then(datum.clone().or_not())
            .validate(|(at, datum), e, emitter| {
                if datum.is_none() {
                    let span: SimpleSpan = e.span();
                    emitter.emit(Fault::BareComment { at, end: span.end });
                }
            }),
    );

    let stray = just(Lexeme::Close).repeated().at_least(1).count().validate(|count, e, emitter| {
        let span: SimpleSpan = e.span();
        // Closers that do not stand side by side are marked at the first.
        let at = if span.end - span.start == count { span } else { SimpleSpan::from(span.start..span.start + 1) };
        emitter.emit(Fault::Stray { at, count });
        None
    });
    let dot = just(Lexeme::Dot).validate(|_, e, emitter| {
        emitter.emit(Fault::DotOutside(e.span()));
        None
    });
    let margin = just(Lexeme::Margin).to(None);
    let form = choice((datum.map(Some), comment.to(None), stray, dot, margin)).validate(|form, e, emitter| {
        if let Some(fault) = e.state().take_unclosed() {
            emitter.emit(fault);
        }
        form
    });
    form.repeated().collect::<Vec<_>>().map(|forms| forms.into_iter().flatten().collect()).then_ignore(end())
}
