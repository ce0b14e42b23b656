//! Arenas over many seeds: what must be true of every one of them.

use super::route::Step;
use super::*;
use crate::feature::{Feature, Side};
use rpl_robot::geometry::Point;
use rpl_robot::planning::{CostGrid, CostToGo, Inflation};
use std::sync::Arc;

/// The larger of the two robots.
const ROBOT_RADIUS_M: f64 = 0.265;

const SETTINGS: [ArenaSettings; 3] =
    [ArenaSettings::CALM, ArenaSettings::CROWDED, ArenaSettings { walls_mm: 300, ..ArenaSettings::CROWDED }];

/// What the world says is at a point beside a hallway, by walking through the wall there.
fn is_open(world: &World, at: Point) -> bool {
    !world.solids().iter().any(|solid| solid.outline.contains(at) && is_there(world, solid.origin))
}

fn is_there(world: &World, origin: rpl_robot::world::SolidOrigin) -> bool {
    match origin {
        rpl_robot::world::SolidOrigin::Door(index) => !world.doors[index].open,
        rpl_robot::world::SolidOrigin::Wall | rpl_robot::world::SolidOrigin::Object(_) => true,
    }
}

fn ways_to(world: &World, goal: Point) -> CostToGo {
    let floor = world.floor(0.05, |door| world.doors[door].open);
    CostToGo::new(Arc::new(CostGrid::new(&floor, Inflation::of_robot(ROBOT_RADIUS_M))), goal)
}

#[test]
fn an_arena_is_a_function_of_its_seed() {
    assert_eq!(Arena::draw(7, &ArenaSettings::CALM), Arena::draw(7, &ArenaSettings::CALM));
    assert_ne!(Arena::draw(7, &ArenaSettings::CALM).text, Arena::draw(8, &ArenaSettings::CALM).text);
}

#[test]
fn the_robot_has_room_at_the_start_and_a_way_into_the_goal_room() {
    for seed in 0..60 {
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
