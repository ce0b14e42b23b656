//! A text as it was written: every token, comments included, and the line breaks between them.

use crate::lexer::{Prefix, Token};
use crate::source::Span;

/// The kinds of piece a text is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ConcreteKind {
    /// A name, a number, a string, a dot.
    Atom,
    /// Children in parentheses.
    List,
    /// `'` and its kin: comments, then the datum. `#;` is one of them.
    Marked(DatumMark),
    /// `; …`
    LineComment,
    /// `#| … |#`
    BlockComment,
}

/// What stands before a datum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum DatumMark {
    Prefix(Prefix),
    DatumComment,
}

/// A piece of text.
#[derive(Debug)]
pub(super) struct ConcreteNode {
    pub(super) piece: ConcreteKind,
    /// The bytes of its first token; of a list, the `(`.
    pub(super) start: usize,
    pub(super) end: usize,
    pub(super) children: Vec<usize>,
    /// Line ends between it and what stands before it.
    pub(super) lines_before: usize,
    /// Whether it can stand on one line as the author wrote it.
    pub(super) is_flat: bool,
    /// Characters it then takes.
    pub(super) width: usize,
    /// Whether a comment ends its last line, which then comes behind its closers.
    pub(super) has_trailing: bool,
}

impl ConcreteNode {
    /// Whether it says nothing to the reader of plans.
    pub(super) fn is_comment(&self) -> bool {
        match self.piece {
            ConcreteKind::LineComment | ConcreteKind::BlockComment | ConcreteKind::Marked(DatumMark::DatumComment) => {
                true
            }
            ConcreteKind::Atom | ConcreteKind::List | ConcreteKind::Marked(DatumMark::Prefix(_)) => false,
        }
    }
}

/// All pieces of a text without faults; the last one is the list of those at top level.
pub(super) struct Concrete<'t> {
    pub(super) text: &'t str,
    pub(super) nodes: Vec<ConcreteNode>,
    open: Vec<ConcreteNode>,
}

impl<'t> Concrete<'t> {
    /// Puts the tokens of a text together that was read without faults.
    pub(super) fn new(text: &'t str, tokens: &[(Token, Span)]) -> Self {
        let mut concrete = Self { text, nodes: Vec::with_capacity(tokens.len()), open: vec![list(0, 0, 0)] };
        let mut before = 0;
        for &(token, span) in tokens {
            let (start, end) = (span.start as usize, span.end as usize);
            let lines = text[before..start].matches('\n').count();
            before = end;
            concrete.token(token, start, end, lines);
        }
        while let Some(node) = concrete.open.pop() {
            concrete.close(node);
        }
        concrete
    }

    /// The list of what stands at top level.
    pub(super) fn root(&self) -> &ConcreteNode {
        &self.nodes[self.nodes.len() - 1]
    }

    /// What a token says.
    pub(super) fn text(&self, node: &ConcreteNode) -> &'t str {
        &self.text[node.start..node.end]
    }

    /// The data among the children, comments left out.
    pub(super) fn data<'a>(&'a self, node: &'a ConcreteNode) -> impl Iterator<Item = &'a ConcreteNode> {
        node.children.iter().map(|&child| &self.nodes[child]).filter(|child| !child.is_comment())
    }

    fn token(&mut self, token: Token, start: usize, end: usize, lines_before: usize) {
        let mark = |mark| ConcreteNode { piece: ConcreteKind::Marked(mark), ..list(start, end, lines_before) };
        match token {
            Token::Open => self.open.push(list(start, end, lines_before)),
            Token::Close => {
                if let Some(node) = self.open.pop() {
                    self.close(node);
                }
            }
            Token::Prefix(prefix) => self.open.push(mark(DatumMark::Prefix(prefix))),
            Token::DatumComment => self.open.push(mark(DatumMark::DatumComment)),
            Token::LineComment => self.leaf(ConcreteKind::LineComment, start, end, lines_before),
            Token::BlockComment => self.leaf(ConcreteKind::BlockComment, start, end, lines_before),
            Token::Str
            | Token::Symbol
            | Token::Keyword
            | Token::Int(_)
            | Token::Float(_)
            | Token::Dot
            | Token::Unterminated
            | Token::Error => self.leaf(ConcreteKind::Atom, start, end, lines_before),
        }
    }

    fn leaf(&mut self, piece: ConcreteKind, start: usize, end: usize, lines_before: usize) {
        let text = &self.text[start..end];
        let is_flat = piece != ConcreteKind::LineComment && !text.contains('\n');
        let width = text.chars().count();
        self.add(ConcreteNode {
            piece,
            start,
            end,
            children: Vec::new(),
            lines_before,
            is_flat,
            width,
            has_trailing: false,
        });
    }

    /// A list whose closer came, or a mark whose datum did.
    fn close(&mut self, mut node: ConcreteNode) {
        let mut children: Vec<&ConcreteNode> = node.children.iter().map(|&child| &self.nodes[child]).collect();
        // Closers go in front of a trailing comment, so a list before one can stand on one line.
        let is_trailing = |last: &&ConcreteNode| last.piece == ConcreteKind::LineComment && last.lines_before == 0;
        let trailing = children.pop_if(|last| node.piece == ConcreteKind::List && is_trailing(last));
        let Some((last, before)) = children.split_last() else { return self.add(node) };
        let are_flat = children.iter().all(|child| child.is_flat) && before.iter().all(|child| !child.has_trailing);
        let in_a_row = children.iter().skip(1).all(|child| child.lines_before == 0);
        let widths: usize = children.iter().map(|child| child.width).sum();
        node.has_trailing = trailing.is_some() || last.has_trailing;
        (node.is_flat, node.width) = match node.piece {
            ConcreteKind::Marked(_) => (are_flat && before.is_empty(), node.end - node.start + widths),
            _ => (are_flat && in_a_row && !(trailing.is_some() && last.has_trailing), 2 + widths + before.len()),
        };
        self.add(node);
    }

    /// Adds a node to what is open; a mark is complete with its datum.
    fn add(&mut self, node: ConcreteNode) {
        let is_datum = !node.is_comment();
        self.nodes.push(node);
        let index = self.nodes.len() - 1;
        if let Some(parent) = self.open.last_mut() {
            parent.children.push(index);
            let is_mark = matches!(parent.piece, ConcreteKind::Marked(_));
            if is_mark
                && is_datum
                && let Some(marked) = self.open.pop()
            {
                self.close(marked);
            }
        }
    }
}

fn list(start: usize, end: usize, lines_before: usize) -> ConcreteNode {
    ConcreteNode {
        piece: ConcreteKind::List,
        start,
        end,
        children: Vec::new(),
        lines_before,
        is_flat: true,
        width: 2,
        has_trailing: false,
    }
}
