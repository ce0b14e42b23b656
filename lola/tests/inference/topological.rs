//! Localization on a complete map.

use proptest::prelude::*;
use rpl_lola::feature::{Feature, Percept, Side};
use rpl_lola::state_set::Matrix;
use rpl_lola::topological::{
    Action, BothSides, Direction, MapFault, Node, State, TopologicalLocalization, TopologicalMap, Turn, both_sides,
    drive, next_action,
};
use rpl_random::Stream;

use Direction::{East, North, South, West};
use Feature::{ClosedDoor, Foyer, Hallway, OpenDoor, Wall};

/// A node of a hallway from west to east, with what is on its north and on its south.
fn node(north: Feature, south: Feature) -> Node {
    Node { features: [Wall, north, Wall, south] }
}

/// A hallway from west to east.
fn hallway(nodes: &[(Feature, Feature)]) -> TopologicalMap {
    let nodes: Vec<Node> = nodes.iter().map(|&(north, south)| node(north, south)).collect();
    let edges: Vec<_> = (1..nodes.len()).map(|to| (to - 1, East, to)).collect();
    TopologicalMap::new(nodes, &edges).expect("a row of nodes")
}

/// Hallways in a grid of crossings, `size` each way, with `between` nodes between two of them.
fn office(size: usize, between: usize, seed: u64) -> TopologicalMap {
    let mut stream = Stream::new(seed, "office");
    let mut nodes = vec![Node { features: [Hallway; 4] }; size * size];
    let mut edges = Vec::new();
    let crossing = |x: usize, y: usize| y * size + x;
    for y in 0..size {
        for x in 0..size {
            for (to, direction) in [((x + 1, y), East), ((x, y + 1), North)] {
                if to.0 == size || to.1 == size {
                    // No hallway leads out of the office.
                    nodes[crossing(x, y)].features[direction as usize] = Wall;
                    continue;
                }
                let mut from = crossing(x, y);
                for _ in 0..between {
                    let mut side = || [Wall, ClosedDoor, OpenDoor, OpenDoor, Foyer][stream.index(5)];
                    let (left, right) = (side(), side());
                    let mut features = [Wall; 4];
                    features[direction.side(Side::Left) as usize] =
                        if left == Wall && right == Wall { OpenDoor } else { left };
                    features[direction.side(Side::Right) as usize] = right;
                    nodes.push(Node { features });
                    edges.push((from, direction, nodes.len() - 1));
                    from = nodes.len() - 1;
                }
                edges.push((from, direction, crossing(to.0, to.1)));
            }
        }
    }
    for x in 0..size {
        nodes[crossing(x, 0)].features[South as usize] = Wall;
        nodes[crossing(0, x)].features[West as usize] = Wall;
    }
    TopologicalMap::new(nodes, &edges).expect("a grid")
}

#[test]
fn maps_that_cannot_be_are_refused() {
    let nodes = || vec![node(Wall, Wall), node(Wall, Wall), node(Wall, Wall)];
    let fault = |edges: &[_]| TopologicalMap::new(nodes(), edges).expect_err("it is none");
    assert_eq!(fault(&[(0, East, 3)]), MapFault::NoSuchNode { edge: 0, node: 3, nodes: 3 });
    assert_eq!(fault(&[(0, East, 0)]), MapFault::Loop { edge: 0, node: 0 });
    let second = MapFault::SecondEdge { edge: 1, node: 1, direction: West };
    assert_eq!(fault(&[(0, East, 1), (2, East, 1)]), second);
    assert_eq!(second.to_string(), "edge 1 leaves node 1 to the West, as an edge before it does");
}

#[test]
fn what_one_sees_turns_with_the_heading() {
    let map = hallway(&[(Wall, Wall), (Hallway, ClosedDoor), (Wall, Wall)]);
    let (east, west) = (State { node: 1, heading: East }, State { node: 1, heading: West });
    assert_eq!((map.feature(east, Side::Left), map.feature(east, Side::Right)), (Hallway, ClosedDoor));
    assert_eq!((map.feature(west, Side::Left), map.feature(west, Side::Right)), (ClosedDoor, Hallway));
    assert_eq!(map.turned(east, Turn::Around), Some(west));
    assert_eq!(map.turned(east, Turn::Left), None);
    assert_eq!(map.states().count(), 6);
}

#[test]
fn percepts_of_both_sides_are_one() {
    let percept = |side, seen, middle_m: f64| Percept {
        number: 0,
        side,
        seen,
        from_m: middle_m - 0.5,
        to_m: middle_m + 0.5,
        depth_m: 1.0,
        marked: false,
    };
    let percepts = [
        percept(Side::Left, OpenDoor, 2.0),
        percept(Side::Right, ClosedDoor, 2.6),
        percept(Side::Left, OpenDoor, 5.0),
        percept(Side::Left, ClosedDoor, 5.9),
        percept(Side::Right, Hallway, 9.0),
    ];
    let pair = |left, right| BothSides { left, right };
    let expected = [pair(OpenDoor, ClosedDoor), pair(OpenDoor, Wall), pair(ClosedDoor, Wall), pair(Wall, Hallway)];
    assert_eq!(both_sides(&percepts), expected);
}

/// The certainties after percepts, by all walks along the hallway there are.
fn enumerated(map: &TopologicalMap, matrix: &Matrix, seen: &[BothSides]) -> Vec<(State, f64)> {
    let likelihood = |state: State, of: BothSides| {
        matrix.certainty(of.left, map.feature(state, Side::Left))
            * matrix.certainty(of.right, map.feature(state, Side::Right))
    };
    let nothing = BothSides { left: Wall, right: Wall };
    let mut walks: Vec<(State, f64)> = map.states().map(|state| (state, 1.0)).collect();
    for &of in seen {
        let walls = matrix.certainty(of.left, Wall) * matrix.certainty(of.right, Wall);
        walks = walks
            .iter()
            .flat_map(|&(state, weight)| {
                let mut to = vec![(state, weight * walls)];
                let mut missed = weight;
                let mut at = state;
                while let Some(next) = map.ahead(at) {
                    to.push((next, missed * likelihood(next, of)));
                    missed *= likelihood(next, nothing);
                    at = next;
                }
                to
            })
            .collect();
    }
    let sum: f64 = walks.iter().map(|(_, weight)| weight).sum();
    let of_state =
        |state: State| walks.iter().filter(|(at, _)| *at == state).map(|(_, weight)| weight).sum::<f64>() / sum;
    map.states().map(|state| (state, of_state(state))).collect()
}

proptest! {
    #[test]
    fn certainties_are_those_of_all_walks(
        features in prop::collection::vec((0usize..5, 0usize..5), 2..6),
        seen in prop::collection::vec((0usize..5, 0usize..5), 1..4),
    ) {
        let pair = |&(left, right): &(usize, usize)| (Feature::ALL[left], Feature::ALL[right]);
        let map = hallway(&features.iter().map(pair).collect::<Vec<_>>());
        let seen: Vec<BothSides> = seen.iter().map(pair).map(|(left, right)| BothSides { left, right }).collect();
        let mut localization = TopologicalLocalization::start(&map);
        seen.iter().for_each(|&of| localization.perceive(&map, &Matrix::SONAR, of));
        for (state, expected) in enumerated(&map, &Matrix::SONAR, &seen) {
            prop_assert!((localization.certainty(state) - expected).abs() < 1e-9);
        }
    }
}

#[test]
fn certainties_sum_to_one_whatever_happens() {
    let map = office(3, 2, 4);
    let mut stream = Stream::new(1, "whatever");
    let mut localization = TopologicalLocalization::start(&map);
    for _ in 0..2_000 {
        match stream.index(4) {
            0 => localization.turn(&map, Turn::ALL[stream.index(3)]),
            1 => localization.perceive_end(&map, &Matrix::DERVISH),
            _ => {
                let mut any = || Feature::ALL[stream.index(5)];
                let seen = BothSides { left: any(), right: any() };
                localization.perceive(&map, &Matrix::DERVISH, seen);
            }
        }
        let sum: f64 = map.states().map(|state| localization.certainty(state)).sum();
        assert!((sum - 1.0).abs() < 1e-9, "{sum}");
    }
}

#[test]
fn the_end_of_a_hallway_tells_where_one_is() {
    let map = hallway(&[(Wall, Wall), (OpenDoor, Wall), (OpenDoor, Wall), (OpenDoor, Wall), (Wall, Wall)]);
    let mut localization = TopologicalLocalization::start(&map);
    localization.perceive(&map, &Matrix::MARKED, BothSides { left: OpenDoor, right: Wall });
    assert!(localization.best(&map).is_some_and(|(_, certainty)| certainty < 0.5));
    localization.perceive_end(&map, &Matrix::MARKED);
    let (state, certainty) = localization.best(&map).expect("a state");
    assert_eq!(state, State { node: 4, heading: East });
    assert!(certainty > 0.9, "{certainty}");
}

#[test]
fn two_states_are_told_apart_by_going_where_they_differ() {
    // Two hallways that look alike from west to east, but for what comes last; the one ends before the other.
    let map = hallway(&[(Wall, Wall), (OpenDoor, Wall), (OpenDoor, Wall), (ClosedDoor, Wall)]);
    let first_or_second = [State { node: 0, heading: East }, State { node: 1, heading: East }];
    assert_eq!(next_action(&map, &first_or_second, None), Some(Action::GoOn));
    assert_eq!(next_action(&map, &[first_or_second[0]], Some(3)), Some(Action::GoOn));
    let looking_away = [State { node: 3, heading: West }];
    assert_eq!(next_action(&map, &looking_away, Some(3)), None, "it is there");
    let to_turn = [State { node: 1, heading: West }];
    assert_eq!(next_action(&map, &to_turn, Some(3)), Some(Action::Turn(Turn::Around)));
}

#[test]
fn a_crossing_is_where_all_remaining_states_can_turn() {
    // From either end of the hallway one comes to the crossing, and its north leads to the goal.
    let nodes = vec![
        node(Wall, Wall),
        node(Hallway, Wall),
        node(Wall, Wall),
        Node { features: [OpenDoor, Wall, OpenDoor, Wall] },
    ];
    let map = TopologicalMap::new(nodes, &[(0, East, 1), (1, East, 2), (1, North, 3)]).expect("a crossing");
    let at_crossing = [State { node: 1, heading: East }];
    assert_eq!(next_action(&map, &at_crossing, Some(3)), Some(Action::Turn(Turn::Left)));
    let from_ends = [State { node: 0, heading: East }, State { node: 2, heading: West }];
    assert_eq!(next_action(&map, &from_ends, None), Some(Action::GoOn), "the crossing is on the left of one of them");
}

/// Of a number of drives on a number of maps, in how many the right state is the likeliest after the last of eight
/// percepts, and in how many the robot is sure of a wrong one.
fn right_and_sure_but_wrong(matrix: &Matrix) -> (f64, f64) {
    const DRIVES: u64 = 300;
    let (mut right, mut wrong) = (0.0, 0.0);
    for seed in 0..DRIVES {
        let map = office(3, 3, seed);
        let steps = drive(&map, matrix, matrix, seed, 8);
        let last = steps.last().expect("eight steps");
        assert_eq!(steps.len(), 8);
        right += f64::from(u8::from(last.truth == last.believed));
        wrong += f64::from(u8::from(last.truth != last.believed && last.certainty >= 0.95));
    }
    (right / DRIVES as f64, wrong / DRIVES as f64)
}

#[test]
fn after_eight_percepts_the_robot_knows_where_it_is() {
    for (matrix, least, most) in [(Matrix::MARKED, 0.97, 0.01), (Matrix::SONAR, 0.97, 0.01)] {
        let (right, sure_but_wrong) = right_and_sure_but_wrong(&matrix);
        assert!(right >= least && sure_but_wrong <= most, "{right} {sure_but_wrong}");
    }
}
