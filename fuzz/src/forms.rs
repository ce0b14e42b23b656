//! What the reader makes of a text, to be compared with what it makes of another.

use rpl_lang::diagnostic::Severity;
use rpl_lang::pretty::print;
use rpl_lang::reader::read;
use rpl_lang::source::SourceId;
use rpl_lang::symbol::{Symbols, is_uninterned};
use rpl_lang::syntax::{NodeId, NodeKind, Tree};

/// The forms of a text without faults.
pub struct Forms {
    symbols: Symbols,
    tree: Tree,
    roots: Vec<NodeId>,
}

impl Forms {
    /// Those of a text; none if it has faults, each of which then lies within the text.
    pub fn of(text: &str) -> Option<Self> {
        let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
        let (roots, found) = read(text, SourceId(0), &mut symbols, &mut tree);
        for fault in &found {
            let (start, end) = (fault.span.start as usize, fault.span.end as usize);
            assert!(start <= end && text.is_char_boundary(start) && text.is_char_boundary(end), "{fault:?}");
        }
        found.iter().all(|fault| fault.severity != Severity::Error).then_some(Self { symbols, tree, roots })
    }

    /// Each form on a line.
    pub fn printed(&self) -> String {
        self.roots.iter().map(|&root| print(&self.tree, &self.symbols, root) + "\n").collect()
    }

    /// Whether a form has a name that no text can say.
    pub fn has_unsayable_name(&self) -> bool {
        self.tree.nodes.iter().any(|node| match node.kind {
            NodeKind::Symbol(name) | NodeKind::Keyword(name) | NodeKind::Qualified { written: name, .. } => {
                is_uninterned(self.symbols.name(name))
            }
            NodeKind::Int(_)
            | NodeKind::Float(_)
            | NodeKind::Str(_)
            | NodeKind::List { .. }
            | NodeKind::Vector { .. }
            | NodeKind::Object(_)
            | NodeKind::Hole => false,
        })
    }

    /// Whether both are the same data, wherever they stand.
    pub fn is_same(&self, other: &Self) -> bool {
        if self.roots.len() != other.roots.len() {
            return false;
        }
        let mut pairs: Vec<_> = self.roots.iter().copied().zip(other.roots.iter().copied()).collect();
        while let Some((mine, theirs)) = pairs.pop() {
            if !self.is_alike(mine, other, theirs) {
                return false;
            }
            let both = [(self, mine), (other, theirs)].map(|(forms, node)| match forms.tree.get(node).kind {
                NodeKind::List { .. } | NodeKind::Vector { .. } => forms.tree.elements(node).to_vec(),
                _ => Vec::new(),
            });
            let [mine, theirs] = both;
            pairs.extend(mine.into_iter().zip(theirs));
        }
        true
    }

    /// Whether two nodes are alike, but for their parts.
    fn is_alike(&self, mine: NodeId, other: &Self, theirs: NodeId) -> bool {
        let name = |symbol| self.symbols.name(symbol);
        let their_name = |symbol| other.symbols.name(symbol);
        match (&self.tree.get(mine).kind, &other.tree.get(theirs).kind) {
            (NodeKind::Symbol(a), NodeKind::Symbol(b)) | (NodeKind::Keyword(a), NodeKind::Keyword(b)) => {
                name(*a) == their_name(*b)
            }
            (NodeKind::Qualified { written: a, .. }, NodeKind::Qualified { written: b, .. }) => {
                name(*a) == their_name(*b)
            }
            (NodeKind::Float(a), NodeKind::Float(b)) => a.to_bits() == b.to_bits(),
            (NodeKind::List { len: a, dotted: c, .. }, NodeKind::List { len: b, dotted: d, .. }) => (a, c) == (b, d),
            (NodeKind::Vector { len: a, .. }, NodeKind::Vector { len: b, .. }) => a == b,
            (a, b) => a == b,
        }
    }
}
