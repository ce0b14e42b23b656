//! Syntax to text: on one line, or laid out over several.
//!
//! Both walk the datum with a stack of their own, so depth costs no Rust stack.

use crate::bars::{written_keyword, written_name};
use crate::indentation::{aligns, is_label, layout};
use crate::layout::Style;
use crate::number::format_float;
use crate::source::{SourceId, Span};
use crate::symbol::Symbols;
use crate::syntax::{NodeId, NodeKind, Tree, mark_of};
use crate::visible::quote_string;

/// The datum on one line, such that reading it gives the same datum – but for run-time objects and
/// names made by `gensym`, which no text can name.
pub fn print(tree: &Tree, symbols: &Symbols, node: NodeId) -> String {
    let mut printer = Printer::new(tree, symbols, usize::MAX);
    printer.run(node);
    printer.text
}

/// The datum laid out over lines of at most `width` characters, where that can be had, and ended
/// by a newline. Sets the span of every node under `root` to its place in that text, which is to
/// become `source`; a node that stands in several places gets the last. Cost: the size of the text times `width`.
pub fn pretty(tree: &mut Tree, symbols: &Symbols, root: NodeId, width: usize, source: SourceId) -> String {
    let mut printer = Printer::new(tree, symbols, width);
    printer.run(root);
    let Printer { mut text, places, .. } = printer;
    for (node, start, end) in places {
        tree.nodes[node.0 as usize].span = Span { source, start, end };
    }
    text.push('\n');
    text
}

/// How the items of a list that does not fit on its line are laid out.
#[derive(Clone, Copy)]
struct Wrap {
    /// Items on the first line, head included.
    on_first_line: usize,
    /// Column of the others.
    indent: usize,
    /// Whether as many items stand on a line as fit; else each begins one.
    fill: bool,
}

enum PrintStep {
    /// Write a node; `closers` closers follow it on its line.
    Node { node: NodeId, closers: usize },
    /// Go on with a list at its `next` item.
    Items { list: NodeId, next: usize, wrap: Option<Wrap>, closers: usize },
    /// The node that started here is written.
    End { node: NodeId, start: u32 },
}

struct Printer<'a> {
    tree: &'a Tree,
    symbols: &'a Symbols,
    width: usize,
    text: String,
    /// Characters on the present line.
    column: usize,
    places: Vec<(NodeId, u32, u32)>,
    steps: Vec<PrintStep>,
}

impl<'a> Printer<'a> {
    fn new(tree: &'a Tree, symbols: &'a Symbols, width: usize) -> Self {
        Self { tree, symbols, width, text: String::new(), column: 0, places: Vec::new(), steps: Vec::new() }
    }

    fn run(&mut self, root: NodeId) {
        self.steps.push(PrintStep::Node { node: root, closers: 0 });
        while let Some(step) = self.steps.pop() {
            match step {
                PrintStep::Node { node, closers } => self.node(node, closers),
                PrintStep::Items { list, next, wrap, closers } => self.item(list, next, wrap, closers),
                PrintStep::End { node, start } => self.places.push((node, start, self.text.len() as u32)),
            }
        }
    }

    fn write(&mut self, text: &str) {
        self.text.push_str(text);
        self.column += text.chars().count();
    }

    fn new_line(&mut self, indent: usize) {
        self.text.push('\n');
        self.text.extend(std::iter::repeat_n(' ', indent));
        self.column = indent;
    }

    fn node(&mut self, node: NodeId, closers: usize) {
        let start = self.text.len() as u32;
        self.steps.push(PrintStep::End { node, start });
        if let Some((mark, datum)) = marked(self.tree, self.symbols, node) {
            self.write(mark);
            self.places.push((self.tree.items(node)[0], start, self.text.len() as u32));
            if mark == "," && atom_text(self.tree, self.symbols, datum).starts_with('@') {
                self.write(" ");
            }
            self.steps.push(PrintStep::Node { node: datum, closers });
        } else if let NodeKind::List { .. } | NodeKind::Vector { .. } = self.tree.get(node).kind {
            if let NodeKind::Vector { .. } = self.tree.get(node).kind {
                self.write("#");
            }
            self.write("(");
            let wrap = self.wrap(node, closers);
            self.steps.push(PrintStep::Items { list: node, next: 0, wrap, closers });
        } else {
            let text = atom_text(self.tree, self.symbols, node);
            self.write(&text);
        }
    }

    fn item(&mut self, list: NodeId, next: usize, wrap: Option<Wrap>, closers: usize) {
        let items = parts(self.tree, list);
        let Some(&item) = items.get(next) else { return self.write(")") };
        let is_last = next + 1 == items.len();
        if next > 0 {
            match wrap {
                Some(wrap) if self.breaks_before(items, next, wrap, closers) => self.new_line(wrap.indent),
                _ => self.write(" "),
            }
        }
        if is_last && matches!(self.tree.get(list).kind, NodeKind::List { dotted: true, .. }) {
            self.write(". ");
        }
        self.steps.push(PrintStep::Items { list, next: next + 1, wrap, closers });
        self.steps.push(PrintStep::Node { node: item, closers: if is_last { closers + 1 } else { 0 } });
    }

    fn breaks_before(&self, items: &[NodeId], next: usize, wrap: Wrap, closers: usize) -> bool {
        if next < wrap.on_first_line || self.follows_label(items, next) {
            return false;
        }
        let closers = if next + 1 == items.len() { closers + 1 } else { 0 };
        let room = self.width.saturating_sub(self.column + 1 + closers);
        !(wrap.fill && self.fits(items[next], room))
    }

    /// Whether the item is the value of a keyword, or the condition of a loop's `until` or `while`,
    /// on whose line it stays.
    fn follows_label(&self, items: &[NodeId], next: usize) -> bool {
        let head = self.tree.symbol(items[0]).map(|head| self.symbols.name(head));
        let is_label = |index: usize| match self.tree.get(items[index]).kind {
            NodeKind::Keyword(_) => true,
            NodeKind::Symbol(word) => is_label(head, self.symbols.name(word)),
            _ => false,
        };
        // A longer run of keywords is data, not arguments.
        let run = (1..next).rev().take(8).take_while(|&index| is_label(index)).count();
        run % 2 == 1 && !is_label(next)
    }

    /// None if the list or vector, whose `(` is written, fits on the present line.
    fn wrap(&self, list: NodeId, closers: usize) -> Option<Wrap> {
        let column = self.column;
        let room = self.width.saturating_sub(column).saturating_sub(closers);
        let written = if let NodeKind::Vector { .. } = self.tree.get(list).kind { 2 } else { 1 };
        if self.width == usize::MAX || self.fits(list, room.saturating_add(written)) {
            return None;
        }
        let items = parts(self.tree, list);
        let &first = items.first()?;
        let head = match self.tree.get(first).kind {
            NodeKind::Symbol(written) | NodeKind::Qualified { written, .. } => {
                Some(self.symbols.name(written).to_string())
            }
            NodeKind::Keyword(symbol) => Some(format!(":{}", self.symbols.name(symbol))),
            _ => None,
        };
        let style = head.as_deref().and_then(layout).map(|layout| layout.style);
        let is_flat = items.iter().all(|&item| match self.tree.get(item).kind {
            NodeKind::List { len, .. } | NodeKind::Vector { len, .. } => len == 0,
            NodeKind::Keyword(_) => false,
            _ => true,
        });
        let is_data = self.text.ends_with("'(") || self.text.ends_with("#(");
        let (on_first_line, indent) = match (&head, style) {
            (_, Some(Style::Body(distinguished))) => (1 + distinguished, column + 1),
            (_, Some(Style::Forms)) => (1, column + 1),
            (Some(_), style) if style.is_some() || !is_data => {
                let width = atom_text(self.tree, self.symbols, first).chars().count();
                let argument = column + width + 1;
                if aligns(argument, self.width) { (2, argument) } else { (1, column + 1) }
            }
            _ => (1, column),
        };
        // Deep data would otherwise be mostly indentation, of a size quadratic in its depth.
        let indent = indent.min(self.width / 5 * 4).max(1);
        Some(Wrap { on_first_line, indent, fill: is_flat && style.is_none() })
    }

    /// Whether the node takes at most `room` characters on one line. Cost: O(room).
    fn fits(&self, node: NodeId, room: usize) -> bool {
        let mut used = 0;
        let mut waiting = vec![node];
        while let Some(node) = waiting.pop() {
            used += match (marked(self.tree, self.symbols, node), &self.tree.get(node).kind) {
                (Some((mark, datum)), _) => {
                    waiting.push(datum);
                    mark.len()
                }
                (None, &NodeKind::List { dotted, .. }) => {
                    let items = self.tree.items(node);
                    // The parentheses, the spaces between, the dot with its space.
                    let around = 2 + items.len().saturating_sub(1) + if dotted { 2 } else { 0 };
                    if used + around > room {
                        return false;
                    }
                    waiting.extend(items);
                    around
                }
                (None, NodeKind::Vector { .. }) => {
                    let items = self.tree.elements(node);
                    let around = 3 + items.len().saturating_sub(1);
                    if used + around > room {
                        return false;
                    }
                    waiting.extend(items);
                    around
                }
                // At most four bytes a character.
                (None, NodeKind::Str(value)) if value.len() / 4 > room => return false,
                (None, _) => atom_text(self.tree, self.symbols, node).chars().count(),
            };
            if used > room {
                return false;
            }
        }
        true
    }
}

/// What stands between the parentheses of a list or vector.
fn parts(tree: &Tree, node: NodeId) -> &[NodeId] {
    match tree.get(node).kind {
        NodeKind::Vector { .. } => tree.elements(node),
        _ => tree.items(node),
    }
}

/// `'x` and its kin: the mark and the datum of `(quote x)`.
fn marked(tree: &Tree, symbols: &Symbols, node: NodeId) -> Option<(&'static str, NodeId)> {
    let &[head, datum] = tree.proper_list(node)? else { return None };
    Some((mark_of(symbols.name(tree.plain_symbol(head)?))?, datum))
}

/// What an atom is written as; nothing for a list or vector.
fn atom_text(tree: &Tree, symbols: &Symbols, node: NodeId) -> String {
    match &tree.get(node).kind {
        NodeKind::Symbol(written) | NodeKind::Qualified { written, .. } => {
            written_name(symbols.name(*written)).into_owned()
        }
        NodeKind::Keyword(symbol) => written_keyword(symbols.name(*symbol)),
        NodeKind::Int(value) => value.to_string(),
        NodeKind::Float(value) => format_float(*value),
        NodeKind::Str(value) => quote_string(value),
        NodeKind::Object(number) => format!("#<object {number}>"),
        NodeKind::Hole => "nil".to_string(),
        NodeKind::List { .. } | NodeKind::Vector { .. } => String::new(),
    }
}
