//! Syntax as an arena: nodes with spans, children as ranges; dropping or walking it needs no
//! recursion, however deep the text nests.

use crate::source::Span;
use crate::symbol::{Qualifier, Symbol, Symbols};
use std::sync::Arc;

/// Number of a node in a [`Tree`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(pub u32);

/// A datum and where it was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// What it is.
    pub kind: NodeKind,
    /// Where it stands; for a node made by a macro, where the macro was called.
    pub span: Span,
}

/// The kinds of datum. `nil` and `t` are symbols here; `()` is an empty list.
#[derive(Clone, Debug, PartialEq)]
pub enum NodeKind {
    /// A name, folded to lower case.
    Symbol(Symbol),
    /// `library:car` or `global:car`: a name that says where it is looked up.
    Qualified {
        /// As it is written.
        written: Symbol,
        /// Where it is looked up.
        qualifier: Qualifier,
        /// The name that is looked up.
        name: Symbol,
    },
    /// `:goal`; the name is kept without the colon.
    Keyword(Symbol),
    /// A 64-bit integer.
    Int(i64),
    /// A float, units already converted to SI.
    Float(f64),
    /// A string, escapes resolved.
    Str(Arc<str>),
    /// A list: `len` children from `start` in [`Tree::children`]; with `dotted` the last child is
    /// the tail after the dot. `'x` is the list `(quote x)`, likewise `quasiquote unquote
    /// unquote-splicing`; `#'f` is `f`.
    List {
        /// Index of the first child in [`Tree::children`].
        start: u32,
        /// How many children, the dotted tail included.
        len: u32,
        /// Whether a dot stands before the last child.
        dotted: bool,
    },
    /// A vector, `#(…)`: `len` children from `start` in [`Tree::children`].
    Vector {
        /// Index of the first child in [`Tree::children`].
        start: u32,
        /// How many children.
        len: u32,
    },
    /// A run-time object inside a datum that is compiled at run time; an index the caller knows.
    Object(u32),
    /// Where a datum should stand and cannot be read: its fault is reported, and nothing more is
    /// said of it.
    Hole,
}

impl NodeKind {
    /// A symbol as a node: with or without a qualifier.
    pub fn of_symbol(symbols: &mut Symbols, written: Symbol) -> Self {
        let Some((qualifier, name)) = Qualifier::split(symbols.name(written)) else {
            return NodeKind::Symbol(written);
        };
        let name = name.to_string();
        NodeKind::Qualified { written, qualifier, name: symbols.intern(&name) }
    }
}

/// The mark that stands for a list of this name and a datum: `'` for `quote`.
pub fn mark_of(name: &str) -> Option<&'static str> {
    match name {
        "quote" => Some("'"),
        "quasiquote" => Some("`"),
        "unquote" => Some(","),
        "unquote-splicing" => Some(",@"),
        _ => None,
    }
}

/// The arena.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tree {
    /// All nodes.
    pub nodes: Vec<Node>,
    /// Children of all lists and vectors, each one's in one run.
    pub children: Vec<NodeId>,
}

impl Tree {
    /// Adds a node without children.
    pub fn atom(&mut self, kind: NodeKind, span: Span) -> NodeId {
        self.nodes.push(Node { kind, span });
        NodeId(self.nodes.len() as u32 - 1)
    }

    /// Adds a proper list.
    pub fn list(&mut self, items: &[NodeId], span: Span) -> NodeId {
        self.list_with_tail(items, false, span)
    }

    /// Adds a list; with `dotted`, the last item is the tail after the dot.
    pub fn list_with_tail(&mut self, items: &[NodeId], dotted: bool, span: Span) -> NodeId {
        let start = self.children.len() as u32;
        self.children.extend_from_slice(items);
        self.atom(NodeKind::List { start, len: items.len() as u32, dotted }, span)
    }

    /// Adds a vector.
    pub fn vector(&mut self, items: &[NodeId], span: Span) -> NodeId {
        let start = self.children.len() as u32;
        self.children.extend_from_slice(items);
        self.atom(NodeKind::Vector { start, len: items.len() as u32 }, span)
    }

    /// The node.
    pub fn get(&self, id: NodeId) -> &Node {
        &self.nodes[id.0 as usize]
    }

    /// Where the node stands.
    pub fn span(&self, id: NodeId) -> Span {
        self.get(id).span
    }

    /// The children of a list, the dotted tail included; what is no list has none.
    pub fn items(&self, id: NodeId) -> &[NodeId] {
        match self.get(id).kind {
            NodeKind::List { start, len, .. } => &self.children[start as usize..(start + len) as usize],
            _ => &[],
        }
    }

    /// The elements of a vector; what is no vector has none.
    pub fn elements(&self, id: NodeId) -> &[NodeId] {
        match self.get(id).kind {
            NodeKind::Vector { start, len } => &self.children[start as usize..(start + len) as usize],
            _ => &[],
        }
    }

    /// The children, if the node is a proper list.
    pub fn proper_list(&self, id: NodeId) -> Option<&[NodeId]> {
        match self.get(id).kind {
            NodeKind::List { dotted: false, .. } => Some(self.items(id)),
            _ => None,
        }
    }

    /// The symbol, if the node is one; of one with a qualifier, the name behind that.
    pub fn symbol(&self, id: NodeId) -> Option<Symbol> {
        self.name(id).map(|(_, name)| name)
    }

    /// The symbol and the qualifier in front of it, if it has one.
    pub fn name(&self, id: NodeId) -> Option<(Option<Qualifier>, Symbol)> {
        match self.get(id).kind {
            NodeKind::Symbol(name) => Some((None, name)),
            NodeKind::Qualified { qualifier, name, .. } => Some((Some(qualifier), name)),
            _ => None,
        }
    }

    /// The symbol, if the node is one without a qualifier: what can be bound.
    pub fn plain_symbol(&self, id: NodeId) -> Option<Symbol> {
        match self.get(id).kind {
            NodeKind::Symbol(name) => Some(name),
            _ => None,
        }
    }

    /// The symbol a proper, non-empty list starts with.
    pub fn head(&self, id: NodeId) -> Option<Symbol> {
        self.proper_list(id).and_then(|items| items.first()).and_then(|&first| self.symbol(first))
    }
}
