//! Small maps, brute force, and what must not depend on how it is computed.

use super::bound::{HEADINGS, costs};
use super::scan::Scan;
use super::trial::{TrialGround, TrialSensor, Verdict};
use super::*;
use crate::geometry::{Point, Pose};
use crate::localization::error::ModelError;
use crate::localization::scan_parameters::BeamParameters;
use crate::occupancy::{Cell, DistanceField, OccupancyGrid};
use crate::sensors::LaserScanner;
use rpl_random::Stream;

const CLEARANCE_M: f64 = 0.2;

fn beam(max_range_m: f64) -> BeamParameters {
    BeamParameters {
        max_range_m,
        mount_radius_m: 0.0,
        cone_deg: 0,
        wall_depth_m: 0.0,
        sigma_m: 0.08,
        sigma_per_m: 0.02,
        hit: 0.75,
        uniform: 0.1,
        short: 0.1,
        short_mean_m: 2.0,
        missed: 0.05,
        fades: true,
    }
}

fn laser(range_m: f64) -> TrialSensor {
    TrialSensor::laser(&LaserScanner { readings: 360, resolution_deg: 1.0, range_m })
}

/// A walled room in cells of 5 cm, with what stands in it: from and to, in metres.
fn room(length_m: f64, width_m: f64, things: &[[f64; 4]]) -> OccupancyGrid {
    let (columns, rows) = ((length_m / 0.05) as usize, (width_m / 0.05) as usize);
    let mut map = OccupancyGrid::filled(Point::origin(), 0.05, columns, rows, Cell::Free);
    for (column, row) in (0..columns).flat_map(|column| (0..rows).map(move |row| (column, row))) {
        let at = map.centre(column, row);
        let is_edge = column < 2 || row < 2 || column + 2 >= columns || row + 2 >= rows;
        let is_thing = |[x0, y0, x1, y1]: &[f64; 4]| (*x0..*x1).contains(&at.x) && (*y0..*y1).contains(&at.y);
        if is_edge || things.iter().any(is_thing) {
            map.set(column, row, Cell::Occupied);
        }
    }
    map
}

/// Nothing in it is like anything else.
fn furnished() -> OccupancyGrid {
    room(9.0, 6.0, &[[1.5, 0.0, 2.0, 2.0], [5.0, 3.5, 6.5, 6.0], [7.5, 1.0, 8.0, 1.5], [0.0, 4.5, 0.7, 6.0]])
}

fn locator(map: &OccupancyGrid, max_range_m: f64) -> ScanLocator {
    ScanLocator::new(map, &beam(max_range_m), CLEARANCE_M).expect("there is room")
}

/// Scans from random poses, a third of whose beams end at people.
fn among_people(map: &OccupancyGrid, count: usize, seed: u64) -> Vec<trial::TrialScan> {
    let (ground, mut stream) = (TrialGround::new(map.clone(), CLEARANCE_M + 0.05), Stream::new(seed, "scans"));
    (0..count).map(|_| ground.draw(&laser(8.0), 1.0 / 3.0, &mut stream)).collect()
}

#[test]
fn bounds_are_bounds() {
    let map = furnished();
    for (cone_deg, seed) in [(0, 77_101), (15, 77_102)] {
        let locator =
            ScanLocator::new(&map, &BeamParameters { cone_deg, ..beam(8.0) }, CLEARANCE_M).expect("there is room");
        for scan in among_people(&map, 3, seed) {
            let scan = Scan::new(&scan.beams, &locator.scale, &locator.judge);
            for group in 0..locator.blocks.group_count() {
                let of_group =
                    costs(&locator.blocks.group_intervals.of(group), &scan.searched, u16::MAX).expect("no limit");
                for block in locator.blocks.in_group(group) {
                    let of_block =
                        costs(&locator.blocks.intervals.of(block), &scan.searched, u16::MAX).expect("no limit");
                    for heading in 0..HEADINGS {
                        assert!(of_group[heading] <= of_block[heading]);
                        for place in locator.blocks.in_block(block) {
                            let expected = &locator.blocks.expected[place];
                            let cost = |beam: &bound::SearchBeam| {
                                let step = expected[(heading + beam.direction) % HEADINGS];
                                u16::from(beam.cost(step, step))
                            };
                            let exact: u16 = scan.searched.iter().map(cost).sum();
                            assert!(of_block[heading] <= exact, "block {block} heading {heading}");
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn what_is_expected_from_a_place_is_what_rays_meet() {
    let map = furnished();
    let (locator, distances) = (locator(&map, 8.0), DistanceField::new(&map));
    let mut far = 0;
    for (place, expected) in locator.blocks.places.iter().zip(&locator.blocks.expected).step_by(37) {
        for (direction, &step) in expected.iter().enumerate() {
            let (sin, cos) = libm::sincos((2.0 * direction as f64).to_radians());
            let off_m = (distances.cast_m(*place, (cos, sin), 8.0) - locator.scale.range_m(step)).abs();
            far += usize::from(off_m > 0.15);
        }
    }
    // At edges a ray may pass what a sheared one meets.
    assert!(far < 60, "{far}");
}

#[test]
fn people_cost_nothing() {
    let map = furnished();
    let locator = locator(&map, 8.0);
    for scan in among_people(&map, 25, 77_103) {
        let located = locator.locate(&scan.beams);
        let verdict = Verdict::of(&located, scan.robot_in_map);
        assert!(verdict.is_named && verdict.of_right > 0.3, "{:?}: {verdict:?}", scan.robot_in_map);
        assert!(verdict.probability < 0.99 || verdict.is_right, "{:?}: {verdict:?}", scan.robot_in_map);
    }
}

#[test]
fn without_people_the_pose_is_exact_and_sure() {
    let map = furnished();
    let (locator, ground) = (locator(&map, 8.0), TrialGround::new(map.clone(), CLEARANCE_M + 0.05));
    let mut stream = Stream::new(77_104, "scans");
    for _ in 0..25 {
        let scan = ground.draw(&laser(8.0), 0.0, &mut stream);
        let located = locator.locate(&scan.beams);
        let first = located.poses.first().expect("it is somewhere");
        assert!(first.probability > 0.9, "{located:?}");
        assert!(first.pose_in_map.distance_m(scan.robot_in_map) < 0.1, "{:?} {first:?}", scan.robot_in_map);
    }
}

#[test]
fn a_symmetric_room_has_two_poses_of_about_a_half() {
    let map = room(6.0, 4.0, &[]);
    let (locator, ground) = (locator(&map, 8.0), TrialGround::new(map.clone(), CLEARANCE_M + 0.05));
    let mut stream = Stream::new(77_105, "scans");
    for _ in 0..10 {
        let scan = ground.draw(&laser(8.0), 0.0, &mut stream);
        let at = scan.robot_in_map;
        let half_turned = Pose::new(6.0 - at.x_m, 4.0 - at.y_m, at.heading_rad + std::f64::consts::PI);
        if at.distance_m(half_turned) < 1.0 {
            continue;
        }
        let located = locator.locate(&scan.beams);
        for pose in [at, half_turned] {
            let share = Verdict::of(&located, pose).of_right;
            assert!((0.3..0.7).contains(&share), "{pose:?} {located:?}");
        }
    }
}

#[test]
fn where_nothing_is_in_reach_it_is_anywhere() {
    let locator = locator(&room(30.0, 30.0, &[]), 3.5);
    let silent = |bearing_deg: i32| RangeBeam { bearing_rad: f64::from(bearing_deg).to_radians(), range_m: 3.5 };
    let located = locator.locate(&(0..360).map(silent).collect::<Vec<_>>());
    assert!(located.poses.len() <= MOST_POSES);
    assert!(located.elsewhere > 0.9, "{} {}", located.elsewhere, located.poses.len());
    assert!(located.poses.iter().all(|likely| likely.probability < 0.01));
    let nothing = locator.locate(&[RangeBeam { bearing_rad: 0.0, range_m: f64::NAN }]);
    assert_eq!((nothing.poses.len(), nothing.elsewhere), (0, 1.0));
}

#[test]
fn a_scan_that_looks_through_all_walls_is_from_nowhere() {
    let locator = locator(&room(5.0, 5.0, &[[2.4, 0.0, 2.6, 4.0]]), 8.0);
    let far = |bearing_deg: i32| RangeBeam { bearing_rad: f64::from(bearing_deg).to_radians(), range_m: 7.5 };
    let located = locator.locate(&(0..360).map(far).collect::<Vec<_>>());
    assert!(located.nowhere > 0.99, "{located:?}");
}

#[test]
fn probabilities_sum_to_one_and_poses_are_apart() {
    let map = furnished();
    let locator = locator(&map, 8.0);
    for scan in among_people(&map, 10, 77_107) {
        let located = locator.locate(&scan.beams);
        let sum: f64 = located.poses.iter().map(|likely| likely.probability).sum();
        assert!((sum + located.elsewhere + located.nowhere - 1.0).abs() < 1e-9, "{sum}");
        assert!(located.poses.windows(2).all(|pair| pair[0].probability >= pair[1].probability));
    }
}

#[test]
fn threads_do_not_matter() {
    let map = furnished();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let locator = locator(&map, 8.0);
            among_people(&map, 5, 77_108).iter().map(|scan| locator.locate(&scan.beams)).collect::<Vec<_>>()
        })
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn the_tables_grow_with_the_area_and_the_answer_does_not() {
    let [small, large] = [room(10.0, 10.0, &[]), room(40.0, 40.0, &[])].map(|map| locator(&map, 3.5));
    let times = large.blocks.expected.len() as f64 / small.blocks.expected.len() as f64;
    assert!((14.0..20.0).contains(&times), "{times}");
    let silent = |bearing_deg: i32| RangeBeam { bearing_rad: f64::from(bearing_deg).to_radians(), range_m: 3.5 };
    let beams: Vec<RangeBeam> = (0..360).map(silent).collect();
    for locator in [&small, &large] {
        let scan = Scan::new(&beams, &locator.scale, &locator.judge);
        assert!(locator.candidates(&scan).some.len() <= search::MOST_CANDIDATES);
        assert!(locator.locate(&beams).poses.len() <= MOST_POSES);
    }
}

#[test]
fn a_robot_that_fits_nowhere_is_an_error() {
    assert_eq!(ScanLocator::new(&room(0.3, 0.3, &[]), &beam(8.0), 0.5).err(), Some(ModelError::NoFreeCell));
}
