//! Topological maps: nodes, and the hallways between them.

use crate::feature::{Feature, Side};
use serde::{Deserialize, Serialize};

/// The four directions hallways run in; which of them is north does not matter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Direction {
    /// Along +x.
    East,
    /// Along +y.
    North,
    /// Along −x.
    West,
    /// Along −y.
    South,
}

/// A turn on the spot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Turn {
    /// By 90° to the left.
    Left,
    /// By 90° to the right.
    Right,
    /// By 180°.
    Around,
}

impl Turn {
    /// All of them.
    pub const ALL: [Turn; 3] = [Turn::Left, Turn::Right, Turn::Around];
}

impl Direction {
    /// All of them, counterclockwise.
    pub const ALL: [Direction; 4] = [Direction::East, Direction::North, Direction::West, Direction::South];

    /// Where one looks after a turn.
    #[must_use]
    pub fn turned(self, turn: Turn) -> Self {
        let quarters = match turn {
            Turn::Left => 1,
            Turn::Around => 2,
            Turn::Right => 3,
        };
        Self::ALL[(self as usize + quarters) % 4]
    }

    /// What is on a side of one who looks there.
    #[must_use]
    pub fn side(self, side: Side) -> Self {
        match side {
            Side::Left => self.turned(Turn::Left),
            Side::Right => self.turned(Turn::Right),
        }
    }
}

/// A place of hallways where there is something on one side or both, where they meet, or where one ends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Node {
    /// What is perceived of each direction by one who drives past it, in the order of [`Direction::ALL`].
    /// Along a hallway that is not asked.
    pub features: [Feature; 4],
}

/// Where the robot is: the node it passed last, or stands at, and where it is heading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct State {
    /// By its place in the map.
    pub node: usize,
    /// Of driving.
    pub heading: Direction,
}

/// Nodes, and for each the next one in each direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TopologicalMap {
    /// They are known by their places here.
    pub nodes: Vec<Node>,
    /// `next[node][direction]`; there and back are one edge.
    next: Vec<[Option<usize>; 4]>,
}

/// What is wrong with the description of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MapFault {
    /// An edge names a node that is not there.
    #[error("edge {edge} leads to node {node}, but there are {nodes} nodes, counted from 0")]
    NoSuchNode {
        /// Counted from 0.
        edge: usize,
        /// That it names.
        node: usize,
        /// How many there are.
        nodes: usize,
    },
    /// Two edges leave a node in one direction.
    #[error("edge {edge} leaves node {node} to the {direction:?}, as an edge before it does")]
    SecondEdge {
        /// Counted from 0.
        edge: usize,
        /// That it leaves, from either end.
        node: usize,
        /// In which direction.
        direction: Direction,
    },
    /// An edge leads from a node to itself.
    #[error("edge {edge} leads from node {node} to itself")]
    Loop {
        /// Counted from 0.
        edge: usize,
        /// Which.
        node: usize,
    },
}

impl TopologicalMap {
    /// A map of nodes and of edges, each from a node in a direction to the next one.
    ///
    /// # Errors
    /// The first edge that cannot be.
    pub fn new(nodes: Vec<Node>, edges: &[(usize, Direction, usize)]) -> Result<Self, MapFault> {
        let mut next = vec![[None; 4]; nodes.len()];
        for (edge, &(from, direction, to)) in edges.iter().enumerate() {
            if let Some(&node) = [from, to].iter().find(|&&node| node >= nodes.len()) {
                return Err(MapFault::NoSuchNode { edge, node, nodes: nodes.len() });
            }
            if from == to {
                return Err(MapFault::Loop { edge, node: from });
            }
            for (node, direction, other) in [(from, direction, to), (to, direction.turned(Turn::Around), from)] {
                if next[node][direction as usize].replace(other).is_some() {
                    return Err(MapFault::SecondEdge { edge, node, direction });
                }
            }
        }
        Ok(Self { nodes, next })
    }

    /// The state after the next node is passed; none at the end of a hallway.
    pub fn ahead(&self, state: State) -> Option<State> {
        let node = self.next[state.node][state.heading as usize]?;
        Some(State { node, ..state })
    }

    /// The state after a turn at a node; none if no hallway leads there.
    pub fn turned(&self, state: State, turn: Turn) -> Option<State> {
        let turned = State { heading: state.heading.turned(turn), ..state };
        self.ahead(turned).map(|_| turned)
    }

    /// What is on a side of one who passes a node.
    pub fn feature(&self, state: State, side: Side) -> Feature {
        self.nodes[state.node].features[state.heading.side(side) as usize]
    }

    /// Every state there is: at each node, both directions of the hallways through it.
    pub fn states(&self) -> impl Iterator<Item = State> + '_ {
        let of_node = |node: usize| Direction::ALL.into_iter().map(move |heading| State { node, heading });
        (0..self.nodes.len()).flat_map(of_node).filter(|&state| self.is_along_hallway(state))
    }

    fn is_along_hallway(&self, State { node, heading }: State) -> bool {
        [heading, heading.turned(Turn::Around)].iter().any(|&along| self.next[node][along as usize].is_some())
    }
}
