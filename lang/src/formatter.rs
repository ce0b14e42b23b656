//! Lays plan text out anew: [`crate::indentation`] says how, the author says where lines break.
//!
//! Atoms, comments and line breaks stay as they are written; indentation and spaces are set, blank
//! lines in a row become one, closing parentheses go to the end of the line before. What one line
//! holds is broken only if it is too long; lines are never joined. Formatting a formatted text
//! changes nothing, and what is read does not change either.

mod concrete;
mod lines;

use crate::bars::read_name;
use crate::diagnostic::{Diagnostic, Severity};
use crate::indentation::{aligns, is_label, layout_of};
use crate::layout::{ItemShape, Layout, Style, WIDTH};
use crate::lexer::{Prefix, lex};
use crate::reader::read;
use crate::source::SourceId;
use crate::stack::deep;
use crate::symbol::{Symbols, base_name};
use crate::syntax::Tree;
use concrete::{Concrete, ConcreteKind, ConcreteNode, DatumMark};
use lines::Lines;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Breaking a long line can make a comment or a list stand elsewhere and so leave another line to
/// break; texts are at rest after two rounds, made-up ones after a few more.
const MOST_ROUNDS: usize = 8;

/// The text laid out anew, until laying it out changes nothing; its lines end in line feeds. Cost: linear, but for the
/// indentation of very deep texts.
///
/// # Errors
/// The faults of a text that cannot be read.
pub fn format(text: &str, source: SourceId) -> Result<String, Vec<Diagnostic>> {
    let (_, found) = read(text, source, &mut Symbols::default(), &mut Tree::default());
    if found.iter().any(|finding| finding.severity == Severity::Error) {
        return Err(found);
    }
    let mut laid_out = lay_out(&with_line_feeds(text), source);
    for _ in 1..MOST_ROUNDS {
        let again = lay_out(&laid_out, source);
        if again == laid_out {
            break;
        }
        laid_out = again;
    }
    Ok(laid_out)
}

/// Line feeds in the place of all other line ends, also within strings and comments: a string reads
/// the same with either.
fn with_line_feeds(text: &str) -> Cow<'_, str> {
    match text.contains('\r') {
        true => Cow::Owned(text.replace("\r\n", "\n").replace('\r', "\n")),
        false => Cow::Borrowed(text),
    }
}

fn lay_out(text: &str, source: SourceId) -> String {
    let (tokens, _) = lex(text, source);
    let concrete = Concrete::new(text, &tokens);
    let mut formatter = Formatter { bodies: bodies(&concrete), concrete: &concrete, lines: Lines::default() };
    formatter.top_level();
    formatter.lines.finish()
}

/// The macros a text defines that take a body, with how many parameters stand before it.
fn bodies(concrete: &Concrete<'_>) -> BTreeMap<String, usize> {
    let mut bodies = BTreeMap::new();
    for form in concrete.data(concrete.root()) {
        let mut items = concrete.data(form);
        let head = items.next().map(|head| concrete.text(head));
        if head.is_some_and(|head| base_name(&read_name(head)) == "defmacro")
            && let (Some(name), Some(parameters)) = (items.next(), items.next())
            && let Some(before) = parameters_before_body(concrete, parameters)
        {
            bodies.insert(read_name(concrete.text(name)).into_owned(), before);
        }
    }
    bodies
}

fn parameters_before_body(concrete: &Concrete<'_>, parameters: &ConcreteNode) -> Option<usize> {
    let words: Vec<_> = concrete.data(parameters).map(|node| read_name(concrete.text(node))).collect();
    let at = words.iter().position(|word| matches!(word.as_ref(), "&body" | "&rest"))?;
    let takes_body = words[at] == "&body" || matches!(words.get(at + 1)?.as_ref(), "body" | "forms");
    takes_body.then(|| words[..at].iter().filter(|word| !word.starts_with('&')).count())
}

struct Formatter<'a> {
    concrete: &'a Concrete<'a>,
    bodies: BTreeMap<String, usize>,
    lines: Lines,
}

/// A list on its way to paper.
struct OpenList<'a> {
    layout: Layout,
    head: Option<String>,
    /// Data, comments left out.
    items: Vec<&'a ConcreteNode>,
    /// Column of the `(`.
    column: usize,
    /// Column of the first argument, once it stands on the head's line.
    argument: Option<usize>,
    /// Items that stay on the first line, the head included, when the formatter breaks it.
    on_first_line: usize,
    /// The author wrote it on one line, and it does not fit there.
    is_too_long: bool,
    /// Nothing but short atoms: as many on a line as fit.
    fills: bool,
}

impl<'a> Formatter<'a> {
    fn node(&self, index: usize) -> &'a ConcreteNode {
        &self.concrete.nodes[index]
    }

    fn top_level(&mut self) {
        let mut after_datum = false;
        for &index in &self.concrete.root().children {
            let node = self.node(index);
            if node.lines_before > 0 || after_datum && !node.is_comment() || self.lines.must_break() {
                self.lines.new_line(0, node.lines_before > 1);
            } else {
                self.lines.space();
            }
            self.piece(node, ItemShape::Form, 0);
            after_datum = !node.is_comment();
        }
    }

    /// Writes a piece where the line ends now; `closers` closers follow it on its line.
    fn piece(&mut self, node: &'a ConcreteNode, shape: ItemShape, closers: usize) {
        match node.piece {
            ConcreteKind::Atom | ConcreteKind::BlockComment => self.lines.write(self.concrete.text(node)),
            ConcreteKind::LineComment => self.lines.comment(self.concrete.text(node).trim_end()),
            ConcreteKind::Marked(mark) => self.marked(node, mark, shape, closers),
            ConcreteKind::List => deep(|| self.list(node, shape, closers)),
        }
    }

    fn marked(&mut self, node: &'a ConcreteNode, mark: DatumMark, shape: ItemShape, closers: usize) {
        self.lines.write(self.concrete.text(node));
        let column = self.lines.column();
        let shape = match mark {
            DatumMark::Prefix(Prefix::Quote | Prefix::Vector) => ItemShape::Quoted,
            DatumMark::DatumComment => shape,
            DatumMark::Prefix(_) => ItemShape::Form,
        };
        for (at, &index) in node.children.iter().enumerate() {
            let child = self.node(index);
            // `, @x` must not become `,@x`.
            let is_splice = mark == DatumMark::Prefix(Prefix::Unquote) && self.concrete.text(child).starts_with('@');
            if self.lines.must_break() {
                self.lines.new_line(column, false);
            } else if at > 0 || is_splice {
                self.lines.space();
            }
            self.piece(child, shape, closers);
        }
    }

    fn list(&mut self, node: &'a ConcreteNode, shape: ItemShape, closers: usize) {
        let mut list = self.open(node, shape, closers);
        self.lines.write("(");
        let mut at = 0;
        for (place, &index) in node.children.iter().enumerate() {
            let child = self.node(index);
            let is_last = place + 1 == node.children.len();
            let closers = if is_last { closers + 1 } else { 0 };
            if place > 0 {
                let is_own_line = child.lines_before > 0 || self.lines.must_break();
                if is_own_line || self.overflows(&list, child, at, closers) {
                    self.lines.new_line(list.indent(at), child.lines_before > 1);
                } else {
                    self.lines.space();
                    if at == 1 && !child.is_comment() {
                        list.argument = Some(self.lines.column());
                    }
                }
            }
            self.piece(child, list.layout.shape(at), closers);
            at += usize::from(!child.is_comment());
        }
        if self.lines.ends_in_comment() {
            self.lines.new_line(list.indent(at.max(1)), false);
        }
        self.lines.write(")");
    }

    /// Whether the child, which the author put on the present line, must begin one of its own.
    fn overflows(&self, list: &OpenList<'_>, child: &ConcreteNode, at: usize, closers: usize) -> bool {
        if child.is_comment() || at < list.on_first_line || self.follows_label(list, at) {
            return false;
        }
        if list.is_too_long && !list.fills {
            return true;
        }
        let mut end = self.lines.column() + 1 + child.width + closers;
        if self.is_label(list, at) {
            end += list.items.get(at + 1).map_or(0, |value| 1 + value.width);
        }
        child.is_flat && end > WIDTH && list.indent(at) <= self.lines.column()
    }

    fn is_label(&self, list: &OpenList<'_>, at: usize) -> bool {
        let word = list.items.get(at).map(|item| read_name(self.concrete.text(item)));
        word.is_some_and(|word| is_label(list.head.as_deref(), &word))
    }

    /// Whether the item is the value of a keyword or the condition of an `until`, on whose line it
    /// stays.
    fn follows_label(&self, list: &OpenList<'_>, at: usize) -> bool {
        let run = (1..at).rev().take(8).take_while(|&before| self.is_label(list, before)).count();
        run % 2 == 1 && !self.is_label(list, at)
    }

    fn open(&self, node: &'a ConcreteNode, shape: ItemShape, closers: usize) -> OpenList<'a> {
        let items: Vec<&ConcreteNode> = self.concrete.data(node).collect();
        let column = self.lines.column();
        let written =
            items.first().filter(|head| head.piece == ConcreteKind::Atom).map(|head| self.concrete.text(head));
        let written = written.filter(|head| !head.starts_with('"'));
        let head = written.map(|head| read_name(head).into_owned());
        let layout = layout_of(head.as_deref(), shape, |head| self.bodies.get(head).copied());
        let argument_column = column + 2 + written.map_or(0, |head| head.chars().count());
        let on_first_line = match layout.style {
            Style::Body(distinguished) => 1 + distinguished,
            Style::Call if aligns(argument_column, WIDTH) => 2,
            Style::Call | Style::Forms | Style::Data => 1,
        };
        let is_call = matches!(layout.style, Style::Call | Style::Data);
        let mut list = OpenList {
            layout,
            head,
            column,
            argument: None,
            on_first_line,
            is_too_long: node.is_flat && column + node.width + closers > WIDTH,
            fills: is_call && items.iter().all(|item| item.piece == ConcreteKind::Atom),
            items,
        };
        // `(loop while E` is one line.
        if list.head.as_deref().map(base_name) == Some("loop") && self.is_label(&list, 1) {
            list.on_first_line = 3;
        }
        list
    }
}

impl OpenList<'_> {
    /// The column of the item at a position that begins a line.
    fn indent(&self, at: usize) -> usize {
        self.layout.column(at, self.column, self.argument)
    }
}
