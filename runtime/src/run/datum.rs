//! Syntax to values and back: what macros work on, and how data become plans.
//!
//! Both ways keep a stack of their own, so depth costs no Rust stack.

use crate::state::heap::Heap;
use crate::state::value::{TaskRef, Value};
use rpl_lang::source::Span;
use rpl_lang::symbol::{Symbol, Symbols};
use rpl_lang::syntax::{NodeId, NodeKind, Tree};
use std::collections::{BTreeMap, BTreeSet};

/// Where the values that a macro is given stand in the text, so that what it passes on keeps its place.
#[derive(Default)]
pub(crate) struct Origins {
    /// The list that was made from a list of the text, by its first pair.
    lists: BTreeMap<u32, NodeId>,
    /// Symbols of the text that came back in their list.
    kept: Vec<NodeId>,
    /// Symbols that came back elsewhere.
    loose: Vec<NodeId>,
}

impl Origins {
    /// The list of the text that a pair is of, and the first pair of that list.
    fn list_around(&self, tree: &Tree, pair: u32) -> Option<(u32, NodeId)> {
        let (&first, &list) = self.lists.range(..=pair).next_back()?;
        (((pair - first) as usize) < tree.items(list).len()).then_some((first, list))
    }

    /// Gives a symbol that a macro has taken out of its list, such as the name in the header of a loop, its place in
    /// the call, if it stands there once.
    pub(crate) fn place_loose(mut self, tree: &mut Tree, call: NodeId) {
        if self.loose.is_empty() {
            return;
        }
        self.kept.sort_unstable();
        let mut places: BTreeMap<Symbol, Vec<NodeId>> =
            self.loose.iter().filter_map(|&node| Some((tree.plain_symbol(node)?, Vec::new()))).collect();
        let mut waiting = tree.items(call)[1..].to_vec();
        while let Some(node) = waiting.pop() {
            let found = tree.plain_symbol(node).and_then(|name| places.get_mut(&name));
            if let Some(found) = found.filter(|found| found.len() < 2)
                && self.kept.binary_search(&node).is_err()
            {
                found.push(node);
            }
            waiting.extend(tree.items(node).iter().chain(tree.elements(node)));
        }
        for node in self.loose {
            let places = tree.plain_symbol(node).and_then(|name| places.get(&name));
            if let Some([place]) = places.map(Vec::as_slice) {
                tree.nodes[node.0 as usize].span = tree.span(*place);
            }
        }
    }
}

/// What macros have in place of an object in a datum: the name of a task that there never is.
fn stand_in(object: u32) -> TaskRef {
    TaskRef { index: object, generation: u32::MAX }
}

/// What is left to do of a node on its way to a value.
enum Visit {
    Node(NodeId),
    End(NodeId),
}

/// A node as a value.
pub(crate) fn to_value(heap: &mut Heap, symbols: &Symbols, tree: &Tree, node: NodeId, origins: &mut Origins) -> Value {
    let mut values = Vec::new();
    let mut steps = vec![Visit::Node(node)];
    while let Some(step) = steps.pop() {
        let node = match step {
            Visit::End(node) => {
                if let NodeKind::Vector { len, .. } = tree.get(node).kind {
                    let items = values.split_off(values.len() - len as usize);
                    values.push(heap.vector(items));
                    continue;
                }
                let items = values.split_off(values.len() - tree.items(node).len());
                values.push(list_of(heap, tree, node, items, origins));
                continue;
            }
            Visit::Node(node) => node,
        };
        values.push(match &tree.get(node).kind {
            NodeKind::List { .. } => {
                steps.push(Visit::End(node));
                steps.extend(tree.items(node).iter().rev().map(|&item| Visit::Node(item)));
                continue;
            }
            NodeKind::Vector { .. } => {
                steps.push(Visit::End(node));
                steps.extend(tree.elements(node).iter().rev().map(|&item| Visit::Node(item)));
                continue;
            }
            NodeKind::Symbol(symbol) => match symbols.name(*symbol) {
                "nil" => Value::Nil,
                "t" => Value::True,
                _ => Value::Symbol(*symbol),
            },
            NodeKind::Qualified { written, .. } => Value::Symbol(*written),
            NodeKind::Keyword(symbol) => Value::Keyword(*symbol),
            NodeKind::Int(value) => Value::Int(*value),
            NodeKind::Float(value) => Value::Float(*value),
            NodeKind::Str(text) => heap.string(text),
            NodeKind::Object(number) => Value::Task(stand_in(*number)),
            NodeKind::Hole => Value::Nil,
        });
    }
    values.pop().unwrap_or_default()
}

fn list_of(heap: &mut Heap, tree: &Tree, node: NodeId, mut items: Vec<Value>, origins: &mut Origins) -> Value {
    let dotted = matches!(tree.get(node).kind, NodeKind::List { dotted: true, .. });
    let tail = if dotted { items.pop().unwrap_or_default() } else { Value::Nil };
    let list = heap.list_with_tail(&items, tail);
    if let Value::Cons(pair) = list {
        origins.lists.insert(pair, node);
    }
    list
}

/// Nodes that a datum may become.
pub(crate) const MAX_NODES: usize = 1_000_000;

/// This many bytes of a text or a name count as a node: it is written once more with the datum.
const BYTES_OF_A_NODE: usize = 64;

/// Why a value cannot be a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unfit {
    /// A list or vector in it runs into itself.
    Circle,
    /// It has more nodes than may be made. A list that shares its parts can be far larger than the
    /// memory it takes.
    TooLarge,
}

/// A value as a node. What came from the text keeps its place in lists of the text;
/// everything new stands at `span`. Objects without a text form are collected in `objects`.
///
/// # Errors
/// If the value is circular, or has more than `most` nodes; long texts count for several.
#[allow(clippy::too_many_arguments, reason = "what a node is made of, and where it goes")]
pub(crate) fn to_node(
    heap: &Heap,
    symbols: &mut Symbols,
    tree: &mut Tree,
    value: Value,
    span: Span,
    mut origins: Option<&mut Origins>,
    objects: &mut Vec<Value>,
    most: usize,
) -> Result<NodeId, Unfit> {
    if !matches!(value, Value::Cons(_) | Value::Vector(_)) {
        let node = leaf(heap, symbols, tree, value, span, objects);
        if let Some(origins) = origins {
            origins.loose.push(node);
        }
        return Ok(node);
    }
    let mut builder = NodeBuilder { heap, open: Vec::new(), nodes: Vec::new(), on_path: BTreeSet::new() };
    builder.open(value)?;
    let mut count = 0;
    loop {
        count += 1;
        if count > most {
            return Err(Unfit::TooLarge);
        }
        match builder.next()? {
            Some(Walked::Item(item @ (Value::Cons(_) | Value::Vector(_)), _)) => builder.open(item)?,
            Some(Walked::Item(atom, pair)) => {
                count += text_bytes(heap, symbols, atom) / BYTES_OF_A_NODE;
                let node = leaf(heap, symbols, tree, atom, span, objects);
                builder.nodes.push(node);
                if let Some(origins) = origins.as_deref_mut() {
                    builder.place(tree, origins, node, pair);
                }
            }
            Some(Walked::End { dotted }) => {
                let Some((first, items)) = builder.close() else { continue };
                let node = match first {
                    Value::Cons(first) => {
                        let text = origins.as_deref().and_then(|origins| origins.lists.get(&first));
                        let place = text.map_or(span, |&text| tree.span(text));
                        tree.list_with_tail(&items, dotted, place)
                    }
                    _ => tree.vector(&items, span),
                };
                builder.nodes.push(node);
            }
            None => return builder.nodes.pop().ok_or(Unfit::Circle),
        }
    }
}

/// Bytes of the text or name of a value.
fn text_bytes(heap: &Heap, symbols: &Symbols, value: Value) -> usize {
    match value {
        Value::Str(text) => heap.strings[text].text.len(),
        Value::Symbol(name) | Value::Keyword(name) => symbols.name(name).len(),
        Value::Nil
        | Value::True
        | Value::Int(_)
        | Value::Float(_)
        | Value::Cons(_)
        | Value::Vector(_)
        | Value::Cell(_)
        | Value::Function(_)
        | Value::Closure(_)
        | Value::Native(_)
        | Value::Fluent(_)
        | Value::Task(_)
        | Value::Valve(_)
        | Value::Failure(_)
        | Value::Table(_)
        | Value::Behaviour(_)
        | Value::Unbound => 0,
    }
}

/// A node that is no list.
fn leaf(
    heap: &Heap,
    symbols: &mut Symbols,
    tree: &mut Tree,
    value: Value,
    span: Span,
    objects: &mut Vec<Value>,
) -> NodeId {
    let kind = match value {
        Value::Nil => NodeKind::Symbol(symbols.intern("nil")),
        Value::True => NodeKind::Symbol(symbols.intern("t")),
        Value::Int(value) => NodeKind::Int(value),
        Value::Float(value) => NodeKind::Float(value),
        Value::Symbol(symbol) => NodeKind::of_symbol(symbols, symbol),
        Value::Keyword(symbol) => NodeKind::Keyword(symbol),
        Value::Str(text) => NodeKind::Str(heap.strings[text].text.clone()),
        Value::Task(task) if task == stand_in(task.index) => NodeKind::Object(task.index),
        Value::Cons(_)
        | Value::Vector(_)
        | Value::Cell(_)
        | Value::Function(_)
        | Value::Closure(_)
        | Value::Native(_)
        | Value::Fluent(_)
        | Value::Task(_)
        | Value::Valve(_)
        | Value::Failure(_)
        | Value::Table(_)
        | Value::Behaviour(_)
        | Value::Unbound => {
            objects.push(value);
            NodeKind::Object(objects.len() as u32 - 1)
        }
    };
    tree.atom(kind, span)
}

/// A list or vector that is being walked.
struct Walk {
    /// The whole.
    whole: Value,
    /// Of a list, what follows the pairs walked so far; no value behind a tail that is an item too.
    at: Value,
    /// Of a vector, how many elements were walked.
    passed: usize,
    /// Nodes that were made before its first item's.
    before: usize,
    /// The list of the text that its last pair was of, and the first pair of that list.
    text: Option<(u32, NodeId)>,
}

/// What a walk comes to.
enum Walked {
    /// A value, and the pair whose first half it is.
    Item(Value, Option<u32>),
    End {
        /// Whether the last item was the tail of a list.
        dotted: bool,
    },
}

struct NodeBuilder<'h> {
    heap: &'h Heap,
    open: Vec<Walk>,
    /// Items of what is open.
    nodes: Vec<NodeId>,
    /// Pairs walked of the open lists, and the open vectors: to come to one again is to go in a circle.
    on_path: BTreeSet<(bool, u32)>,
}

impl NodeBuilder<'_> {
    fn open(&mut self, whole: Value) -> Result<(), Unfit> {
        if let Value::Vector(vector) = whole
            && !self.on_path.insert((true, vector))
        {
            return Err(Unfit::Circle);
        }
        self.open.push(Walk { whole, at: whole, passed: 0, before: self.nodes.len(), text: None });
        Ok(())
    }

    /// The next step of the innermost walk; none if nothing is open.
    fn next(&mut self) -> Result<Option<Walked>, Unfit> {
        let Some(walk) = self.open.last_mut() else { return Ok(None) };
        Ok(Some(match (walk.whole, walk.at) {
            (Value::Vector(vector), _) => match self.heap.vectors[vector].elements().get(walk.passed) {
                Some(&element) => {
                    walk.passed += 1;
                    Walked::Item(element, None)
                }
                None => Walked::End { dotted: false },
            },
            (_, Value::Cons(pair)) => {
                if !self.on_path.insert((false, pair)) {
                    return Err(Unfit::Circle);
                }
                let (car, cdr) = self.heap.pair(pair);
                walk.at = cdr;
                Walked::Item(car, Some(pair))
            }
            (_, Value::Nil) => Walked::End { dotted: false },
            (_, Value::Unbound) => Walked::End { dotted: true },
            (_, tail) => {
                walk.at = Value::Unbound;
                Walked::Item(tail, None)
            }
        }))
    }

    /// Gives what is no list, and was just made, its place in the text, if it is still where it stood there.
    fn place(&mut self, tree: &mut Tree, origins: &mut Origins, node: NodeId, pair: Option<u32>) {
        let text = pair.and_then(|pair| {
            let walk = self.open.last_mut()?;
            let is_in = |&(first, list): &(u32, NodeId)| {
                pair.checked_sub(first).is_some_and(|at| (at as usize) < tree.items(list).len())
            };
            walk.text = walk.text.filter(is_in).or_else(|| origins.list_around(tree, pair));
            let (first, list) = walk.text?;
            let stood = tree.items(list)[(pair - first) as usize];
            (tree.get(stood).kind == tree.get(node).kind).then_some(stood)
        });
        let is_symbol = tree.plain_symbol(node).is_some();
        match text {
            Some(stood) => {
                tree.nodes[node.0 as usize].span = tree.span(stood);
                origins.kept.extend(is_symbol.then_some(stood));
            }
            None => origins.loose.extend(is_symbol.then_some(node)),
        }
    }

    /// Ends the innermost walk; gives the whole and its items.
    fn close(&mut self) -> Option<(Value, Vec<NodeId>)> {
        let walk = self.open.pop()?;
        if let Value::Vector(vector) = walk.whole {
            self.on_path.remove(&(true, vector));
        }
        let mut at = walk.whole;
        while let Value::Cons(pair) = at {
            self.on_path.remove(&(false, pair));
            at = self.heap.pair(pair).1;
        }
        Some((walk.whole, self.nodes.split_off(walk.before)))
    }
}
