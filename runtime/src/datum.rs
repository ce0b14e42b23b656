//! Syntax to values and back: what macros work on, and how data become plans.

use crate::heap::Heap;
use crate::value::Value;
use rpl_lang::source::Span;
use rpl_lang::symbol::Symbols;
use rpl_lang::syntax::{Kind, NodeId, Tree};
use std::collections::BTreeMap;

/// Which pair was made from which list, so that what a macro passes on keeps its place.
pub(crate) type Origins = BTreeMap<u32, NodeId>;

/// A node as a value.
pub(crate) fn to_value(heap: &mut Heap, symbols: &Symbols, tree: &Tree, node: NodeId, origins: &mut Origins) -> Value {
    stacker::maybe_grow(64 * 1024, 1024 * 1024, || match &tree.get(node).kind {
        Kind::Symbol(symbol) => match symbols.name(*symbol) {
            "nil" => Value::Nil,
            "t" => Value::True,
            _ => Value::Symbol(*symbol),
        },
        Kind::Keyword(symbol) => Value::Keyword(*symbol),
        Kind::Int(value) => Value::Int(*value),
        Kind::Float(value) => Value::Float(*value),
        Kind::Str(text) => heap.string(text),
        Kind::Object(_) | Kind::Hole => Value::Nil,
        Kind::List { dotted, .. } => {
            let items = tree.items(node);
            let mut values: Vec<Value> = Vec::with_capacity(items.len());
            for &item in items {
                values.push(to_value(heap, symbols, tree, item, origins));
            }
            let tail = if *dotted { values.pop().unwrap_or_default() } else { Value::Nil };
            let list = heap.list_with_tail(&values, tail);
            if let Value::Cons(pair) = list {
                origins.insert(pair, node);
            }
            list
        }
    })
}

/// A value as a node. Lists that came from the text keep their nodes if they are unchanged;
/// everything new stands at `span`. Objects without a text form are collected in `objects`.
///
/// Gives none if the value is a circular list.
pub(crate) fn to_node(
    heap: &Heap,
    symbols: &mut Symbols,
    tree: &mut Tree,
    value: Value,
    span: Span,
    origins: &Origins,
    objects: &mut Vec<Value>,
) -> Option<NodeId> {
    let mut builder = Builder { heap, symbols, tree, span, origins, objects, nodes: 0 };
    builder.node(value)
}

struct Builder<'a> {
    heap: &'a Heap,
    symbols: &'a mut Symbols,
    tree: &'a mut Tree,
    span: Span,
    origins: &'a Origins,
    objects: &'a mut Vec<Value>,
    nodes: usize,
}

/// A datum with more nodes than this is taken for a circle.
const MAX_NODES: usize = 5_000_000;

impl Builder<'_> {
    fn node(&mut self, value: Value) -> Option<NodeId> {
        self.nodes += 1;
        if self.nodes > MAX_NODES {
            return None;
        }
        let span = self.span;
        let kind = match value {
            Value::Nil => Kind::Symbol(self.symbols.intern("nil")),
            Value::True => Kind::Symbol(self.symbols.intern("t")),
            Value::Int(value) => Kind::Int(value),
            Value::Float(value) => Kind::Float(value),
            Value::Symbol(symbol) => Kind::Symbol(symbol),
            Value::Keyword(symbol) => Kind::Keyword(symbol),
            Value::Str(text) => Kind::Str(self.heap.strings[text].clone()),
            Value::Cons(pair) => return stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.list(pair)),
            object => {
                self.objects.push(object);
                Kind::Object(self.objects.len() as u32 - 1)
            }
        };
        Some(self.tree.atom(kind, span))
    }

    fn list(&mut self, first: u32) -> Option<NodeId> {
        let origin = self.origins.get(&first).copied();
        let mut items = Vec::new();
        let mut at = Value::Cons(first);
        let mut dotted = false;
        loop {
            match at {
                Value::Nil => break,
                Value::Cons(pair) => {
                    let (car, cdr) = self.heap.pair(pair);
                    items.push(self.node(car)?);
                    at = cdr;
                }
                tail => {
                    items.push(self.node(tail)?);
                    dotted = true;
                    break;
                }
            }
        }
        let span = origin.map_or(self.span, |origin| self.tree.span(origin));
        Some(self.tree.list_with_tail(&items, dotted, span))
    }
}
