//! Arenas over many seeds: what must be true of every one of them.

use super::route::Step;
use super::*;
use crate::feature::{Feature, Side};
use crate::topological::{Direction, State, Turn};
use rpl_robot::geometry::Point;
use rpl_robot::planning::{CostGrid, CostToGo, Inflation};
use rpl_robot::world::{Axis, SolidOrigin};
use std::sync::Arc;

/// The larger of the two robots.
const ROBOT_RADIUS_M: f64 = 0.265;

const SETTINGS: [ArenaSettings; 3] =
    [ArenaSettings::CALM, ArenaSettings::CROWDED, ArenaSettings { walls_mm: 300, ..ArenaSettings::CROWDED }];

#[test]
fn an_arena_is_a_function_of_its_seed() {
    assert_eq!(Arena::draw(7, &ArenaSettings::CALM), Arena::draw(7, &ArenaSettings::CALM));
    assert_ne!(Arena::draw(7, &ArenaSettings::CALM).text, Arena::draw(8, &ArenaSettings::CALM).text);
}

#[test]
fn boxes_and_people_change_nothing_else() {
    let (calm, crowded) = (Arena::draw(7, &ArenaSettings::CALM), Arena::draw(7, &ArenaSettings::CROWDED));
    assert_eq!((calm.instructions, calm.hallways), (crowded.instructions, crowded.hallways));
    assert_eq!(calm.world.walls, crowded.world.walls);
    assert!(calm.world.objects.len() < crowded.world.objects.len());
    assert_eq!((calm.world.crowd, crowded.world.crowd), (0, 6));
}

fn ways_to(world: &World, goal: Point) -> CostToGo {
    let floor = world.floor(0.05, |door| world.doors[door].open);
    CostToGo::new(Arc::new(CostGrid::new(&floor, Inflation::of_robot(ROBOT_RADIUS_M))), goal)
}

#[test]
fn the_robot_has_room_at_the_start_and_a_way_into_the_goal_room() {
    for seed in 0..40 {
        for settings in &SETTINGS {
            let arena = Arena::draw(seed, settings);
            let world = &arena.world;
            assert!(world.room_at_start(ROBOT_RADIUS_M).is_ok(), "{seed}");
            assert!(arena.start_room.contains(world.start_in_map.point()), "{seed}");
            assert!(!arena.is_goal(world.start_in_map), "{seed}");
            let ways = ways_to(world, arena.goal_room.centre());
            assert!(ways.cost_m(world.start_in_map.point()).is_some(), "{seed} {settings:?}\n{}", arena.text);
        }
    }
}

/// What a beam from the middle of a hallway to a side hits first: the distance beyond the face of the wall.
fn depth_m(arena: &Arena, hallway: &Hallway, side: Side, along_mm: Millimetres) -> f64 {
    let (low_mm, high_mm) = hallway.across_mm;
    let is_up = hallway.side_towards(true) == side;
    let face_mm = if is_up { high_mm } else { low_mm };
    let sign = if is_up { 1.0 } else { -1.0 };
    let solids = arena.world.solids();
    let is_hit = |depth_m: f64| {
        let (along_m, across_m) = (along_mm as f64 / 1000.0, face_mm as f64 / 1000.0 + sign * depth_m);
        let at = match hallway.axis {
            Axis::X => Point::new(along_m, across_m),
            Axis::Y => Point::new(across_m, along_m),
        };
        solids.iter().any(|solid| match solid.origin {
            SolidOrigin::Door(index) if arena.world.doors[index].open => false,
            SolidOrigin::Door(_) | SolidOrigin::Wall | SolidOrigin::Object(_) => solid.outline.contains(at),
        })
    };
    (0..200).map(|step| f64::from(step) * 0.01 + 0.005).find(|&depth_m| is_hit(depth_m)).unwrap_or(2.0)
}

#[test]
fn the_truth_about_the_sides_is_what_stands_there() {
    for seed in 0..12 {
        let arena = Arena::draw(seed, &ArenaSettings::CALM);
        for hallway in &arena.hallways {
            for side in Side::ALL {
                let mut walls_from_mm = hallway.along_mm.0;
                for found in hallway.side(side) {
                    let depth_m = depth_m(&arena, hallway, side, found.middle_mm());
                    let is_as_said = match found.feature {
                        Feature::ClosedDoor => (0.03..0.10).contains(&depth_m),
                        Feature::OpenDoor | Feature::Hallway | Feature::Foyer => depth_m > 1.0,
                        Feature::Wall => false,
                    };
                    assert!(is_as_said, "{seed}: {found:?} {depth_m}\n{}", arena.text);
                    let width_mm = found.to_mm - found.from_mm;
                    let is_as_wide = match found.feature {
                        Feature::ClosedDoor | Feature::OpenDoor => (900..=1000).contains(&width_mm),
                        Feature::Hallway => (2000..=2500).contains(&width_mm),
                        Feature::Foyer => width_mm >= 3500,
                        Feature::Wall => false,
                    };
                    assert!(is_as_wide, "{seed}: {found:?}");
                    // Wall all the way to the next one.
                    for step in 1..10 {
                        let along_mm = walls_from_mm + (found.from_mm - walls_from_mm) * step / 10;
                        let is_wall =
                            found.from_mm - walls_from_mm < 20 || self::depth_m(&arena, hallway, side, along_mm) < 0.02;
                        assert!(is_wall, "{seed}: before {found:?} at {along_mm}\n{}", arena.text);
                    }
                    walls_from_mm = found.to_mm;
                }
            }
        }
    }
}

#[test]
fn a_hallway_looks_the_other_way_round_from_its_other_end() {
    for seed in 0..10 {
        for hallway in Arena::draw(seed, &ArenaSettings::CALM).hallways {
            let (from_mm, to_mm) = hallway.along_mm;
            let length_m = (to_mm - from_mm) as f64 / 1000.0;
            for side in Side::ALL {
                let there = hallway.seen_from(side, from_mm, true);
                let mut back = hallway.seen_from(side.other(), to_mm, false);
                back.reverse();
                assert_eq!(there.len(), back.len());
                for ((is, from_m, _), (is_too, _, to_m)) in there.into_iter().zip(back) {
                    assert!(is == is_too && (from_m + to_m - length_m).abs() < 1e-9);
                }
            }
        }
    }
}

#[test]
fn the_instructions_lead_into_the_goal_room_and_a_fault_leads_where_it_is_said_to() {
    let mut findings = [0, 0];
    for seed in 0..200 {
        let (plan, route) = plan_and_route(seed, &ArenaSettings::CALM);
        assert!((3..=6).contains(&route.instructions.len()), "{seed}");
        let mut at = route.standpoints[0];
        for (instruction, standpoint) in route.instructions.iter().skip(1).zip(&route.standpoints) {
            assert_eq!(at, *standpoint, "{seed}");
            match plan.step(at, *instruction) {
                Step::To(next) => at = next,
                Step::Into(room) => assert_eq!(room, route.goal_room, "{seed}"),
                other => panic!("{seed}: {instruction} comes to {other:?}"),
            }
        }
        let arena = Arena::draw_with_fault(seed, &ArenaSettings::CALM);
        let Some(fault) = arena.fault else { panic!("{seed}: no fault") };
        assert_ne!(fault.given, fault.right);
        assert_eq!(arena.right_instructions(), route.instructions);
        assert_eq!(arena.instructions[fault.number - 1], fault.given);
        findings[usize::from(fault.is_detectable())] += 1;
    }
    assert!(findings[1] > 2 * findings[0] && findings[0] > 0, "{findings:?}");
}

#[test]
fn single_hallways_have_more_than_ten_openings_on_their_sides() {
    let counts: Vec<usize> = (0..50)
        .flat_map(|seed| SingleHallway::draw(seed, &ArenaSettings::CALM).hallway.sides)
        .map(|side| side.iter().filter(|found| Feature::OPENINGS.contains(&found.feature)).count())
        .collect();
    let long = counts.iter().filter(|count| **count >= 10).count();
    assert!(long * 2 > counts.len(), "{counts:?}");
}

#[test]
fn on_the_map_of_an_arena_one_passes_what_is_beside_its_hallways() {
    for seed in 0..20 {
        let arena = Arena::draw(seed, &ArenaSettings::CALM);
        let map = arena.topological_map();
        for hallway in &arena.hallways {
            let heading = match hallway.axis {
                Axis::X => Direction::East,
                Axis::Y => Direction::North,
            };
            let truth: Vec<Vec<Feature>> =
                Side::ALL.map(|side| hallway.side(side).iter().map(|found| found.feature).collect()).to_vec();
            // Each hallway is a line of nodes from one without another behind it.
            let is_line = map.states().any(|first| {
                let is_first = map.ahead(State { heading: heading.turned(Turn::Around), ..first }).is_none();
                let line: Vec<State> = std::iter::successors(Some(first), |state| map.ahead(*state)).collect();
                let passed = Side::ALL.map(|side| {
                    let seen = line.iter().map(|state| map.feature(*state, side));
                    seen.filter(|feature| *feature != Feature::Wall).collect::<Vec<_>>()
                });
                first.heading == heading && is_first && passed.to_vec() == truth
            });
            assert!(is_line, "{seed}: {hallway:?}");
        }
    }
}
