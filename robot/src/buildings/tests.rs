use super::draft::{cuts, mostly_short};
use super::*;
use crate::description::RobotDescription;
use crate::geometry::Point;
use crate::office::{OfficeModel, OfficeSettings};
use crate::world::{Object, Rect};
use std::sync::Arc;

const RADIUS_M: f64 = 0.265;

fn building(kind: BuildingKind, seed: u64, furniture: Furniture) -> Building {
    Building::draw(kind, seed, RADIUS_M, furniture).unwrap_or_else(|error| panic!("{error}"))
}

/// Of all kinds, some drawn from each of these seeds.
fn some(seeds: std::ops::Range<u64>) -> impl Iterator<Item = (BuildingKind, u64)> {
    seeds.flat_map(|seed| BuildingKind::ALL.map(|kind| (kind, seed)))
}

#[test]
fn a_robot_gets_to_all_places_of_every_building_by_its_map() {
    let settings = OfficeSettings::of(RobotDescription::papers());
    for (kind, seed) in some(1..4) {
        let Building { mapped, real } = building(kind, seed, Furniture::AsMapped);
        assert_eq!(mapped.places.len(), 3);
        real.room_at_start(RADIUS_M).unwrap_or_else(|taken| panic!("{}: {taken}", real.name));
        let concerns = OfficeModel::survey(&Arc::new(mapped), &settings);
        let of_ways: Vec<_> = concerns
            .iter()
            .filter(|concern| concern.table.is_none_or(|(table, _)| table == "place"))
            // The edge of a lot is open.
            .filter(|concern| !["start", "size"].contains(&concern.key))
            .collect();
        assert!(of_ways.is_empty(), "{}: {of_ways:?}", real.name);
    }
}

#[test]
fn every_building_is_a_world_that_could_be_a_file() {
    for (kind, seed) in some(1..51) {
        let draft = kind.draft(&mut Stream::new(seed, "building"), RADIUS_M);
        let world = draft.world("drawn", &draft.furniture);
        let Rect { min, max } = world.bounds();
        assert!(
            (8.0..=200.0).contains(&(max.x - min.x)) && (8.0..=200.0).contains(&(max.y - min.y)),
            "{kind:?} {seed}"
        );
        for wall in &world.walls {
            assert!(wall.line.len() >= 2 && wall.line.iter().all(|&at| world.bounds().contains(at)), "{kind:?} {seed}");
        }
        for door in &world.doors {
            let stands = world.walls.iter().any(|wall| {
                wall.line.windows(2).any(|ends| door.opening_in(ends[0], ends[1], wall.thickness_m).is_some())
            });
            assert!(stands, "{kind:?} {seed}: {door:?}");
            let room = world.room(&door.room).unwrap_or_else(|error| panic!("{error}")).rect;
            assert!((door.at - door.at.sup(&room.min).inf(&room.max)).norm() < 0.5, "{kind:?} {seed}: {door:?}");
            assert!((0.8..=1.2).contains(&door.width_m), "{door:?}");
        }
        for (index, object) in world.objects.iter().enumerate() {
            let bounds = object.outline().bounds();
            assert!(world.bounds().contains(bounds.min) && world.bounds().contains(bounds.max), "{kind:?} {seed}");
            assert!(world.objects[..index].iter().all(|other| other.name != object.name), "{kind:?} {seed}");
        }
        assert_eq!(kind.has_doors(), !world.doors.is_empty(), "{kind:?} {seed}");
    }
}

#[test]
fn the_same_seed_draws_the_same_building_and_others_draw_others() {
    for kind in BuildingKind::ALL {
        let first = building(kind, 11, Furniture::Rearranged);
        assert_eq!(first, building(kind, 11, Furniture::Rearranged));
        assert_ne!(first.mapped, building(kind, 12, Furniture::Rearranged).mapped);
    }
}

#[test]
fn what_becomes_of_the_furniture_changes_nothing_else() {
    let (mut moved, mut gone, mut new, mut pieces) = (0, 0, 0, 0);
    for seed in 1..16 {
        let as_mapped = building(BuildingKind::Flats, seed, Furniture::AsMapped);
        let Building { mapped, real } = building(BuildingKind::Flats, seed, Furniture::Rearranged);
        assert_eq!(mapped, as_mapped.mapped);
        assert_eq!((&real.walls, &real.doors, &real.places), (&mapped.walls, &mapped.doors, &mapped.places));
        for object in &mapped.objects {
            pieces += 1;
            match real.objects.iter().find(|there| there.name == object.name) {
                None => gone += 1,
                Some(there) if there.mapped => assert_eq!(there, object),
                Some(there) => {
                    moved += 1;
                    let way_m = (middle(there) - middle(object)).norm();
                    assert!((0.49..2.01).contains(&way_m), "{way_m}");
                }
            }
        }
        let is_new = |object: &&Object| mapped.objects.iter().all(|known| known.name != object.name);
        new += real.objects.iter().filter(is_new).count();
        assert!(real.objects.iter().filter(is_new).all(|object| !object.mapped));
    }
    assert!(moved > pieces / 5 && gone > pieces / 20 && new >= 15, "{moved} moved, {gone} gone, {new} new of {pieces}");
}

fn middle(object: &Object) -> Point {
    object.outline().bounds().centre()
}

#[test]
fn half_a_turn_brings_the_rooms_of_twins_onto_each_other() {
    let draft = BuildingKind::Twins.draft(&mut Stream::new(3, "building"), RADIUS_M);
    let middle = Point::from(draft.size_m / 2.0);
    let turned = |at: Point| middle + (middle - at);
    for door in &draft.doors {
        assert!(draft.doors.iter().any(|other| (other.at - turned(door.at)).norm() < 1e-9), "{door:?}");
    }
    let images = draft.furniture.iter().filter(|piece| piece.name.ends_with("-twin")).count();
    let apart = draft.furniture.len() - 2 * images;
    assert!((1..=3).contains(&apart), "{apart} things tell the two ends apart");
}

#[test]
fn a_lot_is_open_to_its_edge_and_a_hall_is_not() {
    let mut open = 0;
    for seed in 1..21 {
        let walled_m = |kind: BuildingKind| {
            let draft = kind.draft(&mut Stream::new(seed, "building"), RADIUS_M);
            let length_m: f64 =
                draft.walls.iter().flat_map(|wall| wall.line.windows(2)).map(|ends| (ends[1] - ends[0]).norm()).sum();
            length_m / (2.0 * (draft.outline().max - draft.outline().min).sum())
        };
        assert!((walled_m(BuildingKind::Halls) - 1.0).abs() < 1e-9);
        open += usize::from(walled_m(BuildingKind::Lots) < 0.99);
    }
    assert!(open > 15, "{open} of 20 lots have gaps");
}

#[test]
fn spots_are_where_the_robot_fits() {
    let building = building(BuildingKind::Offices, 5, Furniture::Rearranged);
    let spots = building.spots(12, RADIUS_M, &mut Stream::new(5, "spots"));
    assert_eq!(spots.len(), 12);
    for spot in spots {
        let mut there = building.real.clone();
        there.start_in_map = spot;
        there.room_at_start(RADIUS_M).unwrap_or_else(|taken| panic!("{taken}"));
    }
}

#[test]
fn a_recorded_plan_is_driven_on_as_it_is_and_gets_furniture_to_be_moved() {
    let cave = building(BuildingKind::Caves, 2, Furniture::AsMapped);
    let grid = cave.mapped.recorded.unwrap_or_else(|| panic!("a cave is recorded"));
    let plan = World::from_map("plan", grid, RADIUS_M).unwrap_or_else(|error| panic!("{error}"));
    let on = |furniture| Building::on_plan(&plan, 4, RADIUS_M, furniture).unwrap_or_else(|error| panic!("{error}"));
    let as_mapped = on(Furniture::AsMapped);
    assert!(as_mapped.mapped.objects.is_empty() && as_mapped.mapped.recorded == plan.recorded);
    assert_ne!(as_mapped.mapped.start_in_map, plan.start_in_map);
    let rearranged = on(Furniture::Rearranged);
    assert!(!rearranged.mapped.objects.is_empty() && rearranged.mapped.objects != rearranged.real.objects);
}

#[test]
fn a_robot_that_fits_nowhere_gets_no_building() {
    let error = Building::draw(BuildingKind::Flats, 1, 9.0, Furniture::AsMapped);
    assert!(error.is_err_and(|error| error.to_string().contains("9 m around its middle")));
}

#[test]
fn lengths_and_cuts_stay_within_their_bounds() {
    let mut stream = Stream::new(1, "lengths");
    let lengths: Vec<f64> = (0..1000).map(|_| mostly_short(&mut stream, 10.0, 100.0)).collect();
    assert!(lengths.iter().all(|length_m| (10.0..=100.0).contains(length_m)));
    let short = lengths.iter().filter(|length_m| **length_m < 60.0).count();
    assert!(short > 800, "{short} of 1000 below 60 m");
    for _ in 0..100 {
        let mut ends = vec![2.0];
        ends.extend(cuts(&mut stream, 2.0, 30.0, (2.5, 7.0)));
        ends.push(30.0);
        assert!(ends.windows(2).all(|pair| pair[1] - pair[0] >= 2.5), "{ends:?}");
    }
}
